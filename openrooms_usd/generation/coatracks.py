"""Hooks on walls: a rail for coats by the door, single ones for towels in bathrooms."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.furniture import Size, category
from openrooms_usd.generation.boxes import overlap
from openrooms_usd.generation.items import Item
from openrooms_usd.generation.kit import Kit
from openrooms_usd.generation.placement import Arrangement
from openrooms_usd.generation.shell import Side

# What hangs takes up so much below hooks, before the wall, and beyond both ends; metres.
_DROP_M, _DEPTH_M, _BEYOND_M = 1.25, 0.24, 0.13
# From the frame of a door to the hooks beside it, metres: least, and a range.
_BESIDE_DOOR_M, _NEAR_DOOR_M = 0.3, 1.1
# Between the single hooks of a row, metres.
_PITCH_M: Final = 0.24
_Z_M: Final = (1.6, 1.7)
_TRIES: Final = 24
_GAP_M: Final = 0.04


@dataclass(frozen=True)
class Hooks:
    """The hooks that a room may have.

    Attributes:
        chance: How often it has some.
        width: Least and greatest width of a rail, metres; single hooks where it is 0.
        count: Least and greatest number of single hooks.
    """

    chance: float
    width: tuple[float, float] = (0.0, 0.0)
    count: tuple[int, int] = (1, 1)


_RAIL: Final = (0.6, 1.1)
HOOKS: Final[Mapping[str, Hooks]] = {
    "bathroom": Hooks(0.9, count=(2, 4)),
    "hallway": Hooks(0.9, _RAIL),
    "closet": Hooks(0.5, _RAIL),
    "apartment": Hooks(0.8, _RAIL),
    "hotel": Hooks(0.6, (0.5, 0.7)),
    "classroom": Hooks(0.6, (0.9, 1.5)),
    "bedroom": Hooks(0.35, count=(1, 3)),
    "office": Hooks(0.5, count=(1, 3)),
    "living_room": Hooks(0.25, (0.5, 0.8)),
    "laundry_room": Hooks(0.5, count=(2, 3)),
    "kitchen": Hooks(0.35, count=(1, 2)),
    "garage": Hooks(0.3, (0.5, 0.8)),
    "stairs": Hooks(0.3, _RAIL),
    "gym": Hooks(0.4, (0.9, 1.5)),
    "conference_room": Hooks(0.3, (0.6, 0.9)),
}


def coat_racks(room: Arrangement, kit: Kit, room_type: str) -> list[Item]:
    """Hooks by a door, or on a wall that is free; nothing stands below them.

    Args:
        room: The furnished room; takes in the hooks with what may hang there.
        kit: Builds them.
        room_type: One of the 27.
    """
    wanted = HOOKS.get(room_type)
    if wanted is None or not kit.chance(wanted.chance):
        return []
    if wanted.width[1]:
        style, count = "plank", 1
        size = _usual("plank", kit.between(*wanted.width))
    else:
        style, count = "single", int(kit.rng.integers(wanted.count[0], wanted.count[1] + 1))
        size = _usual("single")
    z = round(float(kit.rng.uniform(*_Z_M)), 2)
    while count:
        whole = (size[0] + (count - 1) * _PITCH_M, size[1], size[2])
        for side, at in _places(room, kit, whole[0]):
            if _occupy(room, side, at, whole, z):
                offsets = _PITCH_M * (np.arange(count) - 0.5 * (count - 1))
                return [_hook(kit, side, at + float(dx), size, style, z) for dx in offsets]
        count -= 1
    return []


def _usual(style: str, width: float | None = None) -> Size:
    spec = category("coat_rack")
    usual = spec.styles[style].size or spec.size
    return (width or usual[0], usual[1], usual[2])


def _hook(kit: Kit, side: Side, at: float, size: Size, style: str, z: float) -> Item:
    x, y = side.point(at, 0.5 * size[1]).tolist()
    return kit.item("coat_rack", x, y, side.yaw, size=size, style=style, z=z, on="wall")


def _places(room: Arrangement, kit: Kit, width: float) -> Iterator[tuple[Side, float]]:
    """Places beside doors first, then anywhere."""
    sides, half = room.shell.sides, 0.5 * width + _BEYOND_M
    drawn: list[tuple[Side, float]] = []
    for _ in range(_TRIES if room.shell.doors else 0):
        gap = room.shell.doors[int(kit.rng.integers(len(room.shell.doors)))]
        away = 0.5 * gap.width + _BESIDE_DOOR_M + half + float(kit.rng.uniform(0, _NEAR_DOOR_M))
        drawn.append((sides[gap.side], gap.at + away * (1.0 if kit.chance(0.5) else -1.0)))
    lengths = np.array([side.length for side in sides])
    for _ in range(_TRIES):
        side = sides[int(kit.rng.choice(len(sides), p=lengths / lengths.sum()))]
        drawn.append((side, float(kit.rng.uniform(0.0, side.length))))
    yield from ((side, at) for side, at in drawn if half < at < side.length - half)


def _occupy(room: Arrangement, side: Side, at: float, size: Size, z: float) -> bool:
    """Take a place on a wall with what hangs there, if all of it is free."""
    rack = side.keep(at, size[0], size[1], z, z + size[2])
    hung = side.keep(at, size[0] + 2 * _BEYOND_M, _DEPTH_M, z - _DROP_M, z + size[2])
    shell = room.shell
    blocked = overlap(rack, shell.attached).any() or overlap(hung, shell.kept, _GAP_M).any()
    blocked |= overlap(hung, shell.walls, -0.002).any()
    if len(room.solids):
        blocked |= overlap(hung, room.solids, _GAP_M).any()
    if len(room.zones):
        blocked |= overlap(hung, room.zones).any()
    return not blocked and room.take(np.array([rack, hung]))
