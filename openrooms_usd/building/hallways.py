"""A hallway behind a wall: a closed box with a door, a skirting and a lamp, as boxes.

Drawn in the frame of the wall: x to the right, seen from the room, y outwards from its inner edge,
z up from the floor.
"""

from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np

from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import box, cylinder, rounded_box

# Of its walls, floor and ceiling; metres.
SHEET_M: Final = 0.06
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
    w = SHEET_M
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
