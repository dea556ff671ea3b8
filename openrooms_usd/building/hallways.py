"""Hallways behind walls: where they have space, and each as a closed box with a door and a lamp.

Drawn in the frame of the wall: x to the right, seen from the room, y outwards from its inner edge,
z up from the floor.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.building.shell import Hole
from openrooms_usd.building.walls import Wall
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import box, cylinder, rounded_box

# Of its walls, floor and ceiling; metres.
_SHEET_M: Final = 0.06
# What is tried, the most liked first: how deep it is, and how far it goes to both sides of the
# opening's middle; metres.
_DEPTHS_M: Final = (1.7, 1.4, 1.15, 0.95, 0.8)
_HALF_LENGTHS_M: Final = (2.2, 1.6, 1.1, 0.75, 0.55)
# Between a window and another opening of its wall, and beside a hallway's own; metres.
_BESIDE_M: Final = 0.12
# Before windows nothing stands so near, metres.
_FREE_BEFORE_WINDOWS_M: Final = 3.0
_HEIGHT_M: Final = 2.5
# Above the opening, metres.
_HEADROOM_M: Final = 0.12
# A leaf that swings out needs its width and this, metres.
_LEAF_GAP_M: Final = 0.06
# A door in the wall across: its leaf, and the boards around it.
_DOOR_M: Final = (0.82, 2.03)
_CASING_M: Final = (0.07, 0.016)
_HANDLE_M: Final = 1.05
_SKIRTING_M: Final = (0.07, 0.014)
# The lamp's panel, and how far it stands off the ceiling.
_LAMP_M: Final = (0.34, 0.05)


class Hallway(NamedTuple):
    """The inner size of a hallway, metres.

    Attributes:
        left: Where it begins along the wall.
        right: Where it ends.
        near: Its nearest place: the outer face of the room's wall.
        far: Its farthest.
        height: Floor to ceiling.
        door: Where the door across stands, from 0 at the left to 1 at the right.
    """

    left: float
    right: float
    near: float
    far: float
    height: float
    door: float = 0.5


class Way(NamedTuple):
    """An opening, as the hallways behind a room see it.

    Attributes:
        wall: Its wall.
        hole: Its rectangle there.
        window: Whether people look out of it.
        leads: Whether a hallway is to be seen through it.
        leaf: Width of a door's leaf that swings out; metres.
    """

    wall: Wall
    hole: Hole
    window: bool
    leads: bool
    leaf: float = 0.0


def hallways_behind(corners: Array, ways: Sequence[Way]) -> list[Hallway | None]:
    """The hallway behind each opening of a room; None where none is wanted, or has space.

    Args:
        corners: (N, 2) the room's floor, counter-clockwise, metres.
        ways: All openings.
    """
    taken = [_zone(way) for way in ways if way.window and not way.wall.partition]
    found: list[Hallway | None] = []
    for way in ways:
        size = _fitted(way, ways, corners, taken) if way.leads else None
        taken += [_plan(way.wall, size)] if size else []
        found.append(size)
    return found


def _fitted(
    way: Way, ways: Iterable[Way], corners: Array, taken: Sequence[Array]
) -> Hallway | None:
    """The largest hallway that meets neither the room, nor a window's view, nor another."""
    import shapely

    wall, middle = way.wall, 0.5 * (way.hole.left + way.hole.right)
    outer = wall.outer or (0.0, wall.length)
    low, high = (max(outer[0], 0.0), min(outer[1], wall.length))
    for other in ways:
        if other.wall is not wall or other is way:
            continue
        if other.hole.right < middle:
            low = max(low, 0.5 * (other.hole.right + way.hole.left))
        if other.hole.left > middle:
            high = min(high, 0.5 * (other.hole.left + way.hole.right))
    # The wall itself is touched; what reaches further into the house is in the way.
    house = shapely.Polygon(corners).buffer(wall.thickness - 0.01, join_style="mitre")
    blocks = [house, *(shapely.Polygon(outline) for outline in taken)]
    least = way.leaf + _LEAF_GAP_M if way.leaf else 0.0
    near, height = wall.thickness, max(_HEIGHT_M, way.hole.top + _HEADROOM_M)
    for half in _HALF_LENGTHS_M:
        left = min(max(middle - half, low + _SHEET_M), way.hole.left - _BESIDE_M)
        right = max(min(middle + half, high - _SHEET_M), way.hole.right + _BESIDE_M)
        for depth in _DEPTHS_M:
            size = Hallway(left, right, near, near + depth, height)
            plan = shapely.Polygon(_plan(wall, size))
            if depth >= least and not any(
                plan.overlaps(o) or plan.covers(o) or o.covers(plan) for o in blocks
            ):
                return size
    return None


def _plan(wall: Wall, size: Hallway) -> Array:
    """(4, 2) what a hallway covers of the land, its walls included."""
    w = _SHEET_M
    ends = [
        (size.left - w, size.near),
        (size.right + w, size.near),
        (size.right + w, size.far + w),
        (size.left - w, size.far + w),
    ]
    return np.array([wall.to_plan(np.array(end)) for end in ends])


def _zone(way: Way) -> Array:
    """(4, 2) what stays free before a window."""
    near, far = way.wall.thickness, way.wall.thickness + _FREE_BEFORE_WINDOWS_M
    left, right = way.hole.left - _BESIDE_M, way.hole.right + _BESIDE_M
    ends = [(left, near), (right, near), (right, far), (left, far)]
    return np.array([way.wall.to_plan(np.array(end)) for end in ends])


def door_space(size: Hallway) -> tuple[float, float] | None:
    """Where the door across and its casing begin and end; None where there is no space for one."""
    wide = _DOOR_M[0] + 2.0 * _CASING_M[0]
    spare = size.right - size.left - wide
    if spare <= 0.1 or size.height <= _DOOR_M[1] + _CASING_M[0]:
        return None
    left = size.left + 0.05 + (spare - 0.1) * size.door
    return left, left + wide


def hallway(size: Hallway) -> Iterator[tuple[str, str, Mesh]]:
    """Its meshes: names, categories, and solids in the frame of the wall."""
    left, right, near, far, height, _ = size
    w = _SHEET_M
    yield "Floor", "floor", _block((left - w, near, -w), (right + w, far + w, 0.0))
    yield "Ceiling", "ceiling", _block((left - w, near, height), (right + w, far + w, height + w))
    yield "Wall_0", "wall", _block((left, far, 0.0), (right, far + w, height))
    yield "Wall_1", "wall", _block((left - w, near, 0.0), (left, far + w, height))
    yield "Wall_2", "wall", _block((right, near, 0.0), (right + w, far + w, height))
    middle = 0.5 * (left + right)
    tall, thick = _SKIRTING_M
    space = door_space(size)
    if space is None:
        ends = [(left, right)]
    else:
        yield "Door", "door", _door(0.5 * (space[0] + space[1]), far)
        ends = [(left, space[0]), (space[1], right)]
    boards = [_block((a, far - thick, 0.0), (b, far, tall)) for a, b in ends]
    yield "Skirting", "skirting", joined(boards)
    radius, drop = 0.5 * _LAMP_M[0], _LAMP_M[1]
    lamp = cylinder(radius, drop, segments=24)
    yield "Lamp", "ceiling_lamp", lamp.moved((middle, 0.5 * (near + far), height - drop))


def _block(low: tuple[float, float, float], high: tuple[float, float, float]) -> Mesh:
    a, b = np.array(low), np.array(high)
    x, y, z = (b - a).tolist()
    return box((x, y, z), tuple((0.5 * (a + b)).tolist()))


def _door(x: float, y: float) -> Mesh:
    """A shut door on a wall's face, with its casing and its handle."""
    (wide, tall), (board, deep) = _DOOR_M, _CASING_M
    half = 0.5 * wide
    leaf = _block((x - half, y - 0.6 * deep, 0.005), (x + half, y, tall))
    sides = [
        _block(
            (x + s * half - (board if s < 0 else 0.0), y - deep, 0.0),
            (x + s * half + (board if s > 0 else 0.0), y, tall),
        )
        for s in (-1, 1)
    ]
    lintel = _block((x - half - board, y - deep, tall), (x + half + board, y, tall + board))
    grip = rounded_box((0.12, 0.02, 0.02), 0.008, center=(x + half - 0.11, y - 0.06, _HANDLE_M))
    neck = rounded_box((0.02, 0.06, 0.02), 0.004, center=(x + half - 0.06, y - 0.03, _HANDLE_M))
    return joined([leaf, *sides, lintel, grip, neck])
