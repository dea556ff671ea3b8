"""What stands near the windows of a room that lies somewhere: plants, houses, sills.

::

    /World/Outside              Xform, in the frame of the scene of the panorama
        Materials               Scope
        Plants                  abstract: one prim for each kind and look, for instances
        House_0                 Xform, like window_0: Meshes below it
        Tree_3                  Xform, an instance of its kind, like Bush_1, Hedge_2

Nothing of it collides or moves, and none of it is furniture: it is lit by what the panorama shines,
and is seen in pictures.
"""

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.codedigest import code_digest
from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.description.lights import OutsideEnvironment
from openrooms_usd.draws import generator
from openrooms_usd.library.pictures import write_png
from openrooms_usd.library.surroundings.outside.foliage import PLANTS, Grown, lobe
from openrooms_usd.library.surroundings.outside.ledges import (
    LOOKS,
    NET,
    NET_PASSES,
    flower_places,
    ledges,
)
from openrooms_usd.library.surroundings.outside.near import Window
from openrooms_usd.library.surroundings.outside.panorama import HEIGHT
from openrooms_usd.library.surroundings.outside.site import Site
from openrooms_usd.library.surroundings.outside.solid import WOOD, Look, Part, Placed, Solid
from openrooms_usd.stages.alignment.surroundings import Surroundings, surroundings
from openrooms_usd.stages.base import StageContext
from openrooms_usd.usd.light.lights import Portal
from openrooms_usd.usd.places.frames import author_matrix
from openrooms_usd.usd.semantics import label
from openrooms_usd.usd.shading.materials import PreviewSurface, Texture, define_preview_surface
from openrooms_usd.usd.shapes.meshes import define_mesh

# How often there are flowers at the windows of a room in an upper storey, and screens at any.
_FLOWERS_SHARE, _SCREENS_SHARE = 0.3, 0.2
# What is as thin as a thread mirrors nothing to speak of.
_NET_IOR: Final = 1.02
_GREY: Final = np.full(3, 0.12)
_MATERIALS: Final = f"{names.OUTSIDE}/Materials"
_PLANTS: Final = f"{names.OUTSIDE}/Plants"


def site_of(context: StageContext, environment: OutsideEnvironment, ways: Sequence[Portal]) -> Site:
    """Where the room stands in its scene; without an outline where nothing shall be near.

    Args:
        context: Of the lights stage.
        environment: What lies outside.
        ways: The outer faces of what the room is looked out of.
    """
    seed = context.room.seed if environment.seed is None else environment.seed
    walls = surroundings(context.stage).walls if environment.near and ways else np.zeros((0, 2, 2))
    outline = tuple((float(x), float(y)) for x, y in np.round(walls[:, 0], 3)) or None
    places = tuple(map(_plan, ways)) if outline else ()
    return Site(environment.scene, seed, environment.storey, environment.facing, outline, places)


def _plan(window: Portal) -> Window:
    x, y, _ = np.round(window.world_from_portal[:3, 3], 3).tolist()
    out_x, out_y, _ = np.round(window.world_from_portal[:3, 2], 6).tolist()
    return Window(x, y, out_x, out_y)


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
    solid = site.near(HEIGHT)
    frame = site.world_from_scene(HEIGHT, room.floor)
    author_matrix(UsdGeom.Xform.Define(stage, names.OUTSIDE).GetPrim(), frame)
    scene_from_world = np.asarray(np.linalg.inv(frame), dtype=np.float64)
    for name, portal in windows.items():
        _add_ledges(solid, name, portal, scene_from_world, room, site)
    materials = dict(_materials(context, solid.looks))
    worn = sorted({(placed.kind, placed.look) for placed in solid.placed})
    _author_kinds(stage, worn, materials, site.seed)
    for part in solid.parts:
        _author_part(stage, part, materials)
    for placed in solid.placed:
        _author_placed(stage, placed)


def _add_ledges(
    solid: Solid,
    name: str,
    portal: Portal,
    to_scene: NDArray[np.float64],
    room: Surroundings,
    site: Site,
) -> None:
    face = to_scene @ portal.world_from_portal
    sill = float(portal.world_from_portal[2, 3]) - 0.5 * portal.height - room.floor
    rng, high = generator(site.seed, "outside", "windows"), site.storey > 0
    flowers, screen = high and rng.random() < _FLOWERS_SHARE, rng.random() < _SCREENS_SHARE
    made = ledges(portal.width, portal.height, sill, high=high, flowers=flowers, screen=screen)
    for ledge in made:
        look = Look(_GREY, NET_PASSES) if ledge.look == NET else Look(np.array(LOOKS[ledge.look]))
        solid.looks.setdefault(ledge.look, look)
        mesh = ledge.mesh.transformed(face)
        solid.parts.append(Part(name, ledge.name, ledge.category, mesh, ledge.look))
        if ledge.name == "Box":
            leaves = next((look for look in solid.looks if look.startswith("Leaves")), None)
            for number, place in enumerate(flower_places(portal.width, portal.height)):
                if leaves:
                    solid.placed.append(
                        Placed(f"{name}_flowers_{number}", "bush", "flowers", face @ place, leaves)
                    )


def _materials(
    context: StageContext, looks: Mapping[str, Look]
) -> Iterator[tuple[str, UsdShade.Material]]:
    UsdGeom.Scope.Define(context.stage, _MATERIALS)
    for name, look in looks.items():
        color = _color(context, name, look)
        ior = 1.0 if look.passes is None else _NET_IOR
        surface = PreviewSurface(base_color=color, roughness=1.0, ior=ior, pane=look.passes)
        material = define_preview_surface(context.stage, f"{_MATERIALS}/{name}", surface)
        material.GetPrim().SetAssetInfoByKey(names.LICENCE_KEY, names.LICENCE)
        yield name, material


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


def _author_kinds(
    stage: Usd.Stage,
    worn: Iterable[tuple[str, str]],
    materials: Mapping[str, UsdShade.Material],
    seed: int,
) -> None:
    """Plants that instances show: each kind's shape once, and a copy for each look of its leaves.

    The bindings stand in the copies, since not all programs hand an instance's down to its meshes.
    """
    stage.CreateClassPrim(_PLANTS)
    define_mesh(stage, f"{_PLANTS}/Lobe/Leaves", lobe(_foliage(seed, "lobe")), double_sided=True)
    grown: dict[str, Grown] = {}
    for kind, look in worn:
        shape, path = f"{_PLANTS}/{kind.capitalize()}", _plant(kind, look)
        if kind not in grown:
            grown[kind] = _author_shape(stage, shape, kind, seed)
        UsdGeom.Xform.Define(stage, path)
        if grown[kind].leaves is not None:
            _author_copy(stage, f"{path}/Leaves", f"{shape}/Leaves", materials[look])
        if grown[kind].wood is not None:
            _author_copy(stage, f"{path}/Stem", f"{shape}/Stem", materials[WOOD])
        if len(grown[kind].lobes):
            _author_copy(
                stage, f"{_plant('lobe', look)}/Leaves", f"{_PLANTS}/Lobe/Leaves", materials[look]
            )
        for number, matrix in enumerate(grown[kind].lobes):
            _author_instance(stage, f"{path}/Lobe_{number}", _plant("lobe", look), matrix)


def _plant(kind: str, look: str) -> str:
    return f"{_PLANTS}/{kind.capitalize()}_{look}"


def _author_shape(stage: Usd.Stage, path: str, kind: str, seed: int) -> Grown:
    grown = PLANTS[kind](_foliage(seed, kind))
    if grown.leaves is not None:
        define_mesh(stage, f"{path}/Leaves", grown.leaves, double_sided=True)
    if grown.wood is not None:
        define_mesh(stage, f"{path}/Stem", grown.wood)
    return grown


def _author_copy(stage: Usd.Stage, path: str, shape: str, material: UsdShade.Material) -> None:
    prim = stage.DefinePrim(path)
    prim.GetReferences().AddInternalReference(shape)
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)


def _foliage(seed: int, kind: str) -> np.random.Generator:
    return generator(seed, "outside", "foliage", kind)


def _author_instance(
    stage: Usd.Stage, path: str, shown: str, matrix: NDArray[np.float64]
) -> Usd.Prim:
    prim = UsdGeom.Xform.Define(stage, path).GetPrim()
    prim.GetReferences().AddInternalReference(shown)
    prim.SetInstanceable(True)
    author_matrix(prim, matrix)
    return prim


def _author_part(stage: Usd.Stage, part: Part, materials: Mapping[str, UsdShade.Material]) -> None:
    thing = UsdGeom.Xform.Define(stage, f"{names.OUTSIDE}/{part.thing}").GetPrim()
    path, sheet = thing.GetPath().AppendChild(part.name), part.look == NET
    prim = define_mesh(stage, path, part.mesh, double_sided=sheet).GetPrim()
    label(prim, part.category)
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(materials[part.look])


def _author_placed(stage: Usd.Stage, placed: Placed) -> None:
    shown = _plant(placed.kind, placed.look)
    prim = _author_instance(stage, f"{names.OUTSIDE}/{placed.name}", shown, placed.matrix)
    label(prim, placed.category)
