"""What hangs before windows: curtains open, half or drawn, sheers, rollers and slats let down.

All windows of a room wear the same; how far blinds are let down differs a little from window to
window. By night most are closed.
"""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final

import numpy as np

from openrooms_usd.furniture import Size
from openrooms_usd.generation.boxes import overlap
from openrooms_usd.generation.items import Item
from openrooms_usd.generation.kit import Kit
from openrooms_usd.generation.placement import Arrangement
from openrooms_usd.generation.shell import Gap
from openrooms_usd.library.styles.assignment.weights import drawn

Weights = Mapping[str, float]

# How often rooms have each make: homes; where water is; where people work.
_HOME: Final[Weights] = MappingProxyType(
    {"drapes": 4.0, "drawn": 0.3, "sheer": 0.8, "sheers": 2.0, "layered": 0.7, "roller": 1.5,
     "venetian": 1.0}
)  # fmt: skip
_WET: Final[Weights] = MappingProxyType({"roller": 3.0, "venetian": 2.0, "sheers": 0.7})
_WORK: Final[Weights] = MappingProxyType({"venetian": 3.0, "roller": 2.5, "sheers": 0.3})
_WET_ROOMS: Final = frozenset({"bathroom", "kitchen", "laundry_room"})
_WORK_ROOMS: Final = frozenset(
    {
        "classroom", "computer_cluster", "conference_room", "copy_room", "gym", "library", "lobby",
        "mail_room", "office", "storage",
    }
)  # fmt: skip
_BLINDS: Final = frozenset({"roller", "venetian"})
# What becomes of those that hang on rods where they are closed.
_CLOSED: Final[Mapping[str, str]] = MappingProxyType(
    {"drapes": "drawn", "layered": "drawn", "sheers": "sheer"}
)
# Metres: how far curtains and blinds stand out; they hang clear of the sill before the window.
_CURTAIN_DEPTH_M, _BLIND_DEPTH_M = 0.2, 0.115
# Beyond the window: curtains to each side, blinds to each side, both above it.
_CURTAIN_BESIDE_M: Final = (0.16, 0.3)
_BLIND_BESIDE_M, _ABOVE_M = 0.1, 0.16
# How much wider they may become so that their brackets are clear of a casing of at most this depth;
# metres.
_WIDER_M: Final = (0.0, 0.07, 0.14)
_CASING_DEPTH_M: Final = 0.03
# What of a window blinds cover, and how much that differs within a room.
_LOWERED_SHARE, _LOWERED_SPREAD = (0.15, 0.9), 0.06
# Of blinds that are closed, the part that they cover.
_CLOSED_SHARE: Final = (0.9, 1.0)
_MIN_HEIGHT_M: Final = 0.42
# Where curtains end: on the floor, below the sill, or on it; metres.
_OFF_FLOOR_M, _BELOW_SILL_M, _ABOVE_SILL_M = 0.02, 0.12, 0.03
# Between what hangs and doors, and furniture, metres.
_DOOR_GAP_M, _THING_GAP_M = 0.02, 0.03


def curtains(
    room: Arrangement, kit: Kit, room_type: str, chance: float, closed: bool = False
) -> list[Item]:
    """Curtains or blinds of one make before the windows.

    Args:
        room: The furnished room.
        kit: Builds them.
        room_type: Its kind.
        chance: How often windows have any.
        closed: Whether they are drawn and let down.
    """
    # Who closes them has some.
    if not kit.chance(1.0 if closed and chance > 0.0 else chance):
        return []
    style = _make(kit, room_type)
    beside = kit.between(*_CURTAIN_BESIDE_M)
    lowered = kit.between(*(_CLOSED_SHARE if closed else _LOWERED_SHARE))
    style = _CLOSED.get(style, style) if closed else style
    made: list[Item] = []
    for gap in room.shell.gaps:
        if gap.kind != "window":
            continue
        top = min(gap.top + _ABOVE_M, room.shell.clear_height - 0.03)
        if style in _BLINDS:
            share = min(lowered + kit.between(-_LOWERED_SPREAD, _LOWERED_SPREAD), 1.0)
            ends = [min(gap.top - share * (gap.top - gap.sill), top - _MIN_HEIGHT_M)]
            widths, depth = [_BLIND_BESIDE_M], _BLIND_DEPTH_M
        else:
            ends = [_OFF_FLOOR_M, gap.sill - _BELOW_SILL_M, gap.sill + _ABOVE_SILL_M]
            widths, depth = [beside, _BLIND_BESIDE_M], _CURTAIN_DEPTH_M
        widths = [wide + more for wide in widths for more in _WIDER_M]
        sizes = [(gap.width + 2.0 * wide, depth, top - low) for wide in widths for low in ends]
        found = _hang_curtain(room, kit, gap, style, sizes, top)
        made += [found] if found else []
    return made


def _make(kit: Kit, room_type: str) -> str:
    weights = _WET if room_type in _WET_ROOMS else _WORK if room_type in _WORK_ROOMS else _HOME
    factors = kit.interior.furniture.get("curtain", {}) if kit.interior else {}
    return drawn(kit.rng, {name: w * factors.get(name, 1.0) for name, w in weights.items()})


def _hang_curtain(
    room: Arrangement, kit: Kit, gap: Gap, style: str, sizes: list[Size], top: float
) -> Item | None:
    """The first of some sizes that disturbs nothing, on the wall of a window."""
    side = room.shell.sides[gap.side]
    for width, depth, height in sizes:
        size = round(width, 2), depth, round(height, 2)
        if size[2] < _MIN_HEIGHT_M - 0.01:
            continue
        x, y = side.point(gap.at, 0.5 * depth).tolist()
        low = round(top - height, 2)
        item = kit.item("curtain", x, y, side.yaw, size=size, style=style, z=low, on="wall")
        clear = _is_free_before(room, item) and _misses_casing(room, kit, gap, item)
        if clear and room.add(item):
            return item
    return None


def _is_free_before(room: Arrangement, item: Item) -> bool:
    """Whether a curtain disturbs nothing but the window that it is for."""
    box = item.box[None]
    doors = room.shell.kept[room.shell.kept[:, 6] == 0.0]
    away = overlap(box, doors, _DOOR_GAP_M).any() or overlap(box, room.shell.walls, -0.002).any()
    return not away and not (len(room.solids) and overlap(box, room.solids, _THING_GAP_M).any())


def _misses_casing(room: Arrangement, kit: Kit, gap: Gap, item: Item) -> bool:
    """Whether nothing that reaches to the wall does so where the window has its casing."""
    parts = kit.slices(replace(item, x=0.0, y=0.0, yaw=0.0))
    casing = room.shell.casing
    if not casing:
        return True
    at_wall = parts[:, 1] + parts[:, 5] > 0.5 * item.size[1] - _CASING_DEPTH_M
    away = np.abs(parts[:, 0]) - parts[:, 4] > 0.5 * gap.width + casing
    away |= (parts[:, 6] > gap.top + casing) | (parts[:, 7] < gap.sill - casing)
    return bool((away | ~at_wall).all())
