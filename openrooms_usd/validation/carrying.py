"""Whether something carries a thing: the floor, what stands below it, a wall, or the ceiling."""

from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.validation.roomview import RoomObject, RoomView

# So near to what carries it does a thing stand or hang, metres.
REACH_M: Final = 0.01
# Captures are as exact as this, and their things stand where they were measured, metres.
_MEASURED_M: Final = 0.05
# Wainscots and tiles are between a wall and what hangs on it; what yields sinks in so deep, metres.
_CLADDING_M: Final = 0.03
_SUNK_M: Final = 0.05
# Rays begin so far on this side of the surface, metres.
_BEFORE_M: Final = 0.002
_UP: Final = np.array([0.0, 0.0, 1.0])


def floating(room: RoomView) -> Iterator[RoomObject]:
    """The things of a room that nothing carries."""
    things = room.things
    boxes = np.array([[thing.low, thing.high] for thing in things]).reshape(-1, 2, 3)
    walls = _walls(room)
    for index, thing in enumerate(things):
        if _stands(room, thing) or _hangs(room, thing, walls):
            continue
        near = (boxes[:, 0] <= thing.high + REACH_M) & (boxes[:, 1] >= thing.low - _SUNK_M)
        near[:, 2] &= boxes[:, 0, 2] <= thing.high[2]
        others = (things[i] for i in np.flatnonzero(near.all(axis=1)) if i != index)
        if not any(_rests(thing, other.triangles) for other in others) and not _is_held(
            thing, room.fixed
        ):
            yield thing


def _stands(room: RoomView, thing: RoomObject) -> bool:
    reach = _MEASURED_M if thing.is_captured else REACH_M
    return room.floor is not None and float(thing.low[2]) <= room.floor + reach


def _walls(room: RoomView) -> list[Any]:
    import shapely

    walls: list[Any] = [shapely.Polygon(wall.outline) for wall in room.partitions]
    return walls + ([room.outline.boundary] if room.outline is not None else [])


def _hangs(room: RoomView, thing: RoomObject, walls: Sequence[Any]) -> bool:
    """Whether it hangs from the ceiling, or at a wall."""
    import shapely

    if room.ceiling is not None and float(thing.high[2]) >= room.ceiling - REACH_M:
        return True
    box = shapely.box(*thing.low[:2].tolist(), *thing.high[:2].tolist())
    close = [wall for wall in walls if shapely.distance(wall, box) <= _CLADDING_M]
    if not close:
        return False
    points = shapely.points(thing.points[:, :2])
    return any(bool((shapely.distance(wall, points) <= _CLADDING_M).any()) for wall in close)


def _rests(thing: RoomObject, below: Array) -> bool:
    """Whether a thing lies on some triangles (N, 3, 3), or hangs over them."""
    below = _within(below, thing.low - _SUNK_M, thing.high + REACH_M)
    if not len(below):
        return False
    low, high = below.min(axis=(0, 1)) - REACH_M, below.max(axis=(0, 1)) + _SUNK_M
    points = thing.points[((thing.points >= low) & (thing.points <= high)).all(axis=1)]
    under = _caster(below)
    if _meets(under, points + _BEFORE_M * _UP, -_UP, REACH_M + _BEFORE_M, faces=_UP):
        return True
    if _meets(under, points, _UP, _SUNK_M, faces=_UP):
        return True
    own = _caster(_within(thing.triangles, low, high))
    corners = below.reshape(-1, 3)
    return _meets(own, corners - _BEFORE_M * _UP, _UP, REACH_M + _BEFORE_M, faces=-_UP)


def _is_held(thing: RoomObject, fixed: Array) -> bool:
    """Whether a thing rests on the room's own surfaces, or hangs from one, such as a beam."""
    if _rests(thing, fixed):
        return True
    above = _within(fixed, thing.low, thing.high + REACH_M)
    start = thing.points - _BEFORE_M * _UP
    return bool(len(above)) and _meets(_caster(above), start, _UP, REACH_M + _BEFORE_M, faces=-_UP)


def _meets(caster: RayCaster, starts: Array, way: Array, reach: float, *, faces: Array) -> bool:
    """Whether a ray meets, first and within its reach, a surface that faces in a direction."""
    if not len(starts):
        return False
    hits = caster.first_hit(starts, np.broadcast_to(way, starts.shape))
    met = (hits.triangle >= 0) & (hits.distance <= reach)
    return bool((caster.normals_of(hits.triangle[met]) @ faces > 0.0).any())


def _within(triangles: Array, low: Array, high: Array) -> Array:
    """Those whose boxes meet a box."""
    if not len(triangles):
        return triangles
    meets = (triangles.min(axis=1) <= high) & (triangles.max(axis=1) >= low)
    return np.asarray(triangles[meets.all(axis=1)])


def _caster(triangles: Array) -> RayCaster:
    return RayCaster(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))
