"""What stands near the windows of a room that lies somewhere: land, plants, houses, sills.

::

    /World/Outside              Xform, in the frame of the scene of the panorama
        Materials               Scope
        Plants                  Scope: abstract prims, one for each kind, for instances
        Land                    Xform, like House_0, window_0: Meshes below it
        Tree_3                  Xform, an instance of its kind, like Bush_1, Hedge_2

Nothing of it collides or moves, and none of it is furniture: it is lit by what the panorama shines,
and is seen in pictures.
"""

import hashlib
from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.codedigest import code_digest
from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.description.lights import OutsideEnvironment
from openrooms_usd.draws import generator
from openrooms_usd.geometry.faces import prism
from openrooms_usd.geometry.polygons import grown as widened
from openrooms_usd.library.outside.foliage import PLANTS
from openrooms_usd.library.outside.ledges import LOOKS, flower_places, ledges
from openrooms_usd.library.outside.panorama import HEIGHT
from openrooms_usd.library.outside.site import Site
from openrooms_usd.library.outside.solid import WOOD, Look, Part, Placed, Solid
from openrooms_usd.library.pictures import write_png
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.surroundings import Surroundings, surroundings
from openrooms_usd.usd.materials import PreviewSurface, Texture, define_preview_surface
from openrooms_usd.usd.meshes import define_mesh
from openrooms_usd.usd.portals import Portal
from openrooms_usd.usd.semantics import label
from openrooms_usd.usd.transforms import author_matrix

# How often there are flowers at the windows of a room in an upper storey.
_FLOWERS_SHARE: Final = 0.3
# The upper storeys of a room's own house begin above its ceiling by so much, metres.
_SLAB_M: Final = 0.35
_WALL_M: Final = 0.15
_MATERIALS: Final = f"{names.OUTSIDE}/Materials"
_PLANTS: Final = f"{names.OUTSIDE}/Plants"


def site_of(context: StageContext, environment: OutsideEnvironment) -> Site:
    """Where the room stands in its scene; without an outline where nothing shall be near."""
    seed = context.room.seed if environment.seed is None else environment.seed
    walls = surroundings(context.stage).walls if environment.near else np.zeros((0, 2, 2))
    outline = tuple((float(x), float(y)) for x, y in np.round(walls[:, 0], 3)) or None
    return Site(environment.scene, seed, environment.storey, environment.facing, outline)


def author_nearby(context: StageContext, site: Site, windows: Mapping[str, Portal]) -> None:
    """Write what is near, but for a site without an outline.

    Args:
        context: Of the lights stage.
        site: Where the room stands.
        windows: The outer faces of its windows, in the frame of the world, by name.
    """
    if site.outline is None:
        return
    stage, room = context.stage, surroundings(context.stage)
    near, solid = site.near(HEIGHT)
    frame = site.world_from_scene(HEIGHT, room.floor)
    author_matrix(UsdGeom.Xform.Define(stage, names.OUTSIDE).GetPrim(), frame)
    scene_from_world: NDArray[np.float64] = np.linalg.inv(frame)
    for name, portal in windows.items():
        _add_ledges(solid, name, portal, scene_from_world, room, site)
    if site.storey == 0 and room.ceiling is not None:
        _add_own(solid, site, room.ceiling, near.own + frame[2, 3], scene_from_world)
    materials = dict(_materials(context, solid.looks))
    kinds = sorted({placed.kind for placed in solid.placed})
    for kind in kinds:
        _author_kind(stage, kind, materials[WOOD], site.seed)
    for part in solid.parts:
        _author_part(stage, part, materials)
    for placed in solid.placed:
        _author_placed(stage, placed, materials)


def _add_ledges(
    solid: Solid, name: str, portal: Portal, to_scene: NDArray[np.float64], room: Surroundings,
    site: Site,
) -> None:  # fmt: skip
    face = to_scene @ portal.world_from_portal
    sill = float(portal.world_from_portal[2, 3]) - 0.5 * portal.height - room.floor
    rng = generator(site.seed, "outside", "flowers")
    flowers = site.storey > 0 and rng.random() < _FLOWERS_SHARE
    for ledge in ledges(portal.width, portal.height, sill, high=site.storey > 0, flowers=flowers):
        solid.looks.setdefault(ledge.look, Look(np.array(LOOKS[ledge.look])))
        mesh = ledge.mesh.transformed(face)
        solid.parts.append(Part(name, ledge.name, ledge.category, mesh, ledge.look))
        if ledge.name == "Box":
            leaves = next((look for look in solid.looks if look.startswith("Leaves")), None)
            for number, place in enumerate(flower_places(portal.width, portal.height)):
                if leaves:
                    solid.placed.append(
                        Placed(f"{name}_flowers_{number}", "bush", "flowers", face @ place, leaves)
                    )


def _add_own(
    solid: Solid, site: Site, ceiling: float, top: float, to_scene: NDArray[np.float64]
) -> None:
    """The storeys above the room, which shade the land and plants."""
    assert site.outline is not None
    bottom = ceiling + _SLAB_M
    if top - bottom < 1.0:
        return
    corners = widened(np.array(site.outline), _WALL_M, 4.0)
    mesh = prism(corners, bottom, top)
    solid.looks.setdefault("Stone", Look(np.array(LOOKS["Stone"])))
    solid.parts.append(Part("Own", "Above", "house", mesh.transformed(to_scene), "Stone"))


def _materials(
    context: StageContext, looks: Mapping[str, Look]
) -> Iterator[tuple[str, UsdShade.Material]]:
    UsdGeom.Scope.Define(context.stage, _MATERIALS)
    for name, look in looks.items():
        color = _color(context, name, look)
        surface = PreviewSurface(base_color=color, roughness=1.0, ior=1.0)
        yield name, define_preview_surface(context.stage, f"{_MATERIALS}/{name}", surface)


def _color(context: StageContext, name: str, look: Look) -> tuple[float, float, float] | Texture:
    if look.albedo.ndim == 1:
        red, green, blue = map(float, look.albedo)
        return red, green, blue
    pixels = np.round(255.0 * srgb_from_linear(np.clip(look.albedo, 0.0, 1.0))).astype(np.uint8)
    digest = hashlib.sha256(code_digest(__name__).encode() + pixels.tobytes()).hexdigest()[:8]
    file = f"{name.lower()}_{digest}.png"
    target = context.keep(file)
    if not target.is_file():
        write_png(target, pixels, is_color=True)
    return Texture(context.asset(file), color_space="sRGB")


def _author_kind(stage: Usd.Stage, kind: str, wood: UsdShade.Material, seed: int) -> None:
    """A plant that instances show; its leaves wear what the instance does."""
    stage.CreateClassPrim(f"{_PLANTS}")
    path = f"{_PLANTS}/{kind.capitalize()}"
    UsdGeom.Xform.Define(stage, path)
    grown = PLANTS[kind](generator(seed, "outside", "foliage", kind))
    define_mesh(stage, f"{path}/Leaves", grown.leaves, double_sided=True)
    if grown.wood is not None:
        stem = define_mesh(stage, f"{path}/Stem", grown.wood).GetPrim()
        UsdShade.MaterialBindingAPI.Apply(stem).Bind(wood)


def _author_part(stage: Usd.Stage, part: Part, materials: Mapping[str, UsdShade.Material]) -> None:
    thing = UsdGeom.Xform.Define(stage, f"{names.OUTSIDE}/{part.thing}").GetPrim()
    prim = define_mesh(stage, thing.GetPath().AppendChild(part.name), part.mesh).GetPrim()
    label(prim, part.category)
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(materials[part.look])


def _author_placed(
    stage: Usd.Stage, placed: Placed, materials: Mapping[str, UsdShade.Material]
) -> None:
    prim = UsdGeom.Xform.Define(stage, f"{names.OUTSIDE}/{placed.name}").GetPrim()
    prim.GetReferences().AddInternalReference(f"{_PLANTS}/{placed.kind.capitalize()}")
    prim.SetInstanceable(True)
    author_matrix(prim, placed.matrix)
    label(prim, placed.category)
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(materials[placed.look])
