"""Daylight of the lights step: sky and land of a moment, and the portals where it comes in."""

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.codedigest import code_digest, library_versions
from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.description.lights import OutsideEnvironment, SkyEnvironment
from openrooms_usd.draws import generator
from openrooms_usd.library.pictures import write_exr, write_png
from openrooms_usd.library.surroundings.environments import horizontal_illuminance
from openrooms_usd.library.surroundings.outside import outside_panorama
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
from openrooms_usd.library.surroundings.outside.solid import (
    WOOD,
    PlacedSolid,
    Reflectance,
    Solid,
    SolidPart,
)
from openrooms_usd.library.surroundings.sky import Air, daylight
from openrooms_usd.library.surroundings.skycache import cached_picture
from openrooms_usd.library.surroundings.sunlight import sun_position
from openrooms_usd.steps.alignment.surroundings import RoomGeometry, surroundings
from openrooms_usd.steps.base import StepContext
from openrooms_usd.usd.light.lights import Portal, connect_portals, define_dome, define_portal
from openrooms_usd.usd.places.frames import TIME, author_matrix, local_to_world
from openrooms_usd.usd.places.partitions import is_partition
from openrooms_usd.usd.semantics import label, read_label
from openrooms_usd.usd.shading.materials import PreviewSurface, Texture, define_preview_surface
from openrooms_usd.usd.shapes.meshes import define_mesh

# A leaf that is open by less than this is closed, and lets no light through.
_SHUT: Final = np.radians(0.5)
# An opening's frame (x along the wall, y outwards, z up) in the portal's (x, y up, z outwards).
_PORTAL_AXES: Final = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])


def author_sky(context: StepContext, environment: SkyEnvironment) -> None:
    """Write a dome with sun, sky and land in nits; its file is named by all that determines it.

    Where the room lies somewhere, what is near its windows is written too.

    Raises:
        OutputError: A picture cannot be written.
    """
    key, kind, site = f"{code_digest(__name__)} {environment.model_dump_json()}", "sky", None
    if isinstance(environment, OutsideEnvironment):
        windows = {Path(portal.path).name: portal for portal in portals(context.stage, "window")}
        kind, site = "outside", site_of(context, environment, portals(context.stage))
        key = f"{key} {site}"
        author_nearby(context, site, windows)
    file = f"{kind}_{_sum(key)[:8]}.exr"
    target = context.keep(file)
    if not target.is_file():
        entry = _sum(" ".join([kind, key, *library_versions(__name__)]))
        # 32 bits: the sun is too bright for 16.
        cached_picture(entry, target, lambda path: write_exr(path, _nits(environment, site)))
    dome = define_dome(context.stage, names.ENVIRONMENT, texture=context.asset(file))
    dome.GetPrim().SetAssetInfoByKey(names.LICENCE_KEY, names.LICENCE)


def _sum(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _nits(environment: SkyEnvironment, site: Site | None) -> NDArray[np.float32]:
    position = sun_position(environment.moment, environment.latitude, environment.longitude)
    air = Air(environment.turbidity, environment.ground, environment.overcast)
    if isinstance(environment, OutsideEnvironment) and site is not None:
        return outside_panorama(
            position,
            air,
            site,
            clouds=environment.clouds,
            north=environment.north,
            illuminance=environment.illuminance,
        )
    nits = daylight(position, air, north=environment.north)
    if environment.illuminance is None:
        return nits
    return np.asarray(
        nits * (environment.illuminance / horizontal_illuminance(nits)), dtype=np.float32
    )


def author_portals(context: StepContext) -> None:
    """Write a portal for every opening that light can pass, on the outer side of its wall.

    On the outer side, because from there the walls' thickness hides least of what lies inside, and
    because the reveals, too, are then inside.
    """
    found = portals(context.stage)
    if found:
        UsdGeom.Scope.Define(context.stage, names.PORTALS)
    prims = [define_portal(context.stage, portal).GetPrim() for portal in found]
    connect_portals(context.stage.OverridePrim(names.ENVIRONMENT), prims)


def portals(stage: Usd.Stage, kind: str = "") -> list[Portal]:
    """The outer faces of openings that light can pass.

    Args:
        stage: The composed room.
        kind: Of the openings; all by default.
    """
    cache = UsdGeom.XformCache(TIME)
    openings = stage.GetPrimAtPath(names.OPENINGS)
    # Inactive openings too: the wall keeps their holes.
    ways = [prim for prim in openings.GetAllChildren() if _is_way(prim)] if openings else []
    return [_portal(way, cache) for way in ways if kind in ("", read_label(way, names.CATEGORY))]


def _is_way(opening: Usd.Prim) -> bool:
    """Whether light can come in: the opening leads outside, has a size and no closed leaf."""
    hallway = opening.GetStage().GetPrimAtPath(f"{names.BEYOND}/{opening.GetName()}")
    if hallway and hallway.IsActive():
        return False
    walls = opening.GetRelationship(names.OPENING_WALL).GetTargets()
    if walls and is_partition(opening.GetStage().GetPrimAtPath(walls[0])):
        return False
    if not UsdGeom.Xformable(opening) or not all(size > 0.0 for size in _size(opening)):
        return False
    style = opening.GetAttribute(names.OPENING_STYLE)
    if style and style.Get(TIME) in names.SEE_THROUGH:
        return True
    leaves = [opening.GetChild(names.leaf(number)) for number in range(2)]
    # The first leaf belongs to every door, the second to wide ones.
    return not _is_shut(leaves[0]) or bool(leaves[1] and not _is_shut(leaves[1]))


def _is_shut(leaf: Usd.Prim) -> bool:
    """Whether a leaf is there and closed."""
    if not (_is_shown(leaf) and _is_shown(leaf.GetChild("Panel"))):
        return False
    turn = UsdGeom.Xformable(leaf).GetLocalTransformation(TIME).ExtractRotation()
    return bool(np.radians(abs(turn.GetAngle())) <= _SHUT)


def _is_shown(prim: Usd.Prim) -> bool:
    """Whether there is such a prim, active and visible."""
    imageable = UsdGeom.Imageable(prim)
    if not imageable or not prim.IsActive():
        return False
    return bool(imageable.ComputeVisibility(TIME) != UsdGeom.Tokens.invisible)


def _size(opening: Usd.Prim) -> tuple[float, float]:
    """Width and height, metres; 0 where it has none."""
    attributes = map(opening.GetAttribute, (names.OPENING_WIDTH, names.OPENING_HEIGHT))
    width, height = (float(a.Get(TIME) or 0.0) if a else 0.0 for a in attributes)
    return width, height


def _portal(opening: Usd.Prim, cache: UsdGeom.XformCache) -> Portal:
    world = local_to_world(opening, cache)
    outer = world.copy()
    outer[:3, 3] += world[:3, 1] * _depth(opening, world, cache)
    outer[:3, :3] = world[:3, :3] @ _PORTAL_AXES.T
    return Portal(f"{names.PORTALS}/{opening.GetName()}", outer, *_size(opening))


def _depth(opening: Usd.Prim, world: np.ndarray, cache: UsdGeom.XformCache) -> float:
    """How thick the opening's wall is, metres; 0 when it has none."""
    walls = opening.GetRelationship(names.OPENING_WALL).GetTargets()
    prim = opening.GetStage().GetPrimAtPath(walls[0]) if walls else None
    points = UsdGeom.PointBased(prim).GetPointsAttr().Get(TIME) if prim else None
    if not points:
        return 0.0
    to_opening = np.linalg.inv(world) @ local_to_world(prim, cache)
    across = np.asarray(points, dtype=np.float64) @ to_opening[1, :3] + to_opening[1, 3]
    return max(0.0, float(across.max()))


# What stands near the windows of a room that lies somewhere: plants, houses, sills.
#
#     /World/Outside              Xform, in the frame of the scene of the panorama
#         Materials               Scope
#         Plants                  abstract: one prim for each kind and look, for instances
#         House_0                 Xform, like window_0: Meshes below it
#         Tree_3                  Xform, an instance of its kind, like Bush_1, Hedge_2
#
# Nothing of it collides or moves, and none of it is furniture: it is lit by what the panorama
# shines, and is seen in pictures.

# How often there are flowers at the windows of a room in an upper storey, and screens at any.
_FLOWERS_SHARE, _SCREENS_SHARE = 0.3, 0.2
# What is as thin as a thread mirrors nothing to speak of.
_NET_IOR: Final = 1.02
_GREY: Final = np.full(3, 0.12)
_MATERIALS: Final = f"{names.OUTSIDE}/Materials"
_PLANTS: Final = f"{names.OUTSIDE}/Plants"


def site_of(context: StepContext, environment: OutsideEnvironment, ways: Sequence[Portal]) -> Site:
    """Where the room stands in its scene; without an outline where nothing shall be near.

    Args:
        context: Of the lights step.
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


def author_nearby(context: StepContext, site: Site, windows: Mapping[str, Portal]) -> None:
    """Write what is near, but for a site without an outline.

    Args:
        context: Of the lights step.
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
    room: RoomGeometry,
    site: Site,
) -> None:
    face = to_scene @ portal.world_from_portal
    sill = float(portal.world_from_portal[2, 3]) - 0.5 * portal.height - room.floor
    rng, high = generator(site.seed, "outside", "windows"), site.storey > 0
    flowers, screen = high and rng.random() < _FLOWERS_SHARE, rng.random() < _SCREENS_SHARE
    made = ledges(portal.width, portal.height, sill, high=high, flowers=flowers, screen=screen)
    for ledge in made:
        look = (
            Reflectance(_GREY, NET_PASSES)
            if ledge.look == NET
            else Reflectance(np.array(LOOKS[ledge.look]))
        )
        solid.looks.setdefault(ledge.look, look)
        mesh = ledge.mesh.transformed(face)
        solid.parts.append(SolidPart(name, ledge.name, ledge.category, mesh, ledge.look))
        if ledge.name == "Box":
            leaves = next((look for look in solid.looks if look.startswith("Leaves")), None)
            for number, place in enumerate(flower_places(portal.width, portal.height)):
                if leaves:
                    solid.placed.append(
                        PlacedSolid(
                            f"{name}_flowers_{number}", "bush", "flowers", face @ place, leaves
                        )
                    )


def _materials(
    context: StepContext, looks: Mapping[str, Reflectance]
) -> Iterator[tuple[str, UsdShade.Material]]:
    UsdGeom.Scope.Define(context.stage, _MATERIALS)
    for name, look in looks.items():
        color = _color(context, name, look)
        ior = 1.0 if look.passes is None else _NET_IOR
        surface = PreviewSurface(base_color=color, roughness=1.0, ior=ior, pane=look.passes)
        material = define_preview_surface(context.stage, f"{_MATERIALS}/{name}", surface)
        material.GetPrim().SetAssetInfoByKey(names.LICENCE_KEY, names.LICENCE)
        yield name, material


def _color(
    context: StepContext, name: str, look: Reflectance
) -> tuple[float, float, float] | Texture:
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


def _author_part(
    stage: Usd.Stage, part: SolidPart, materials: Mapping[str, UsdShade.Material]
) -> None:
    thing = UsdGeom.Xform.Define(stage, f"{names.OUTSIDE}/{part.thing}").GetPrim()
    path, sheet = thing.GetPath().AppendChild(part.name), part.look == NET
    prim = define_mesh(stage, path, part.mesh, double_sided=sheet).GetPrim()
    label(prim, part.category)
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(materials[part.look])


def _author_placed(stage: Usd.Stage, placed: PlacedSolid) -> None:
    shown = _plant(placed.kind, placed.look)
    prim = _author_instance(stage, f"{names.OUTSIDE}/{placed.name}", shown, placed.matrix)
    label(prim, placed.category)
