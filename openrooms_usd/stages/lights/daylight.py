"""Daylight of the lights stage: sky and land of a moment, and the portals where it comes in."""

import hashlib
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.codedigest import code_digest, library_versions
from openrooms_usd.description.lights import OutsideEnvironment, SkyEnvironment
from openrooms_usd.library.pictures import write_exr
from openrooms_usd.library.surroundings.environments import horizontal_illuminance
from openrooms_usd.library.surroundings.outside import outside_panorama
from openrooms_usd.library.surroundings.outside.site import Site
from openrooms_usd.library.surroundings.sky import Air, daylight
from openrooms_usd.library.surroundings.skycache import cached_picture
from openrooms_usd.library.surroundings.sunlight import sun_position
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.lights.nearby import author_nearby, site_of
from openrooms_usd.usd.light.lights import Portal, connect_portals, define_dome, define_portal
from openrooms_usd.usd.places.frames import TIME, local_to_world
from openrooms_usd.usd.places.partitions import is_partition
from openrooms_usd.usd.semantics import read_label

# A leaf that is open by less than this is closed, and lets no light through.
_SHUT: Final = np.radians(0.5)
# An opening's frame (x along the wall, y outwards, z up) in the portal's (x, y up, z outwards).
_PORTAL_AXES: Final = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])


def author_sky(context: StageContext, environment: SkyEnvironment) -> None:
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


def author_portals(context: StageContext) -> None:
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
