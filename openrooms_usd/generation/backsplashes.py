"""Tiles, stone or glass above worktops, between the windows of the wall."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from openrooms_usd.generation.groups.kitchen import LEVEL_M, WALL_LOW_M
from openrooms_usd.generation.items import Item
from openrooms_usd.generation.kit import Kit
from openrooms_usd.generation.placement import Arrangement
from openrooms_usd.generation.shell import Shell

# What is screwed on through tiles is flush to the wall, and may sink in by so much.
_THICK_M: Final = 0.004
# What windows keep for their casing and sill, metres.
_CASING_M: Final = 0.12
# No strip is narrower or lower, metres.
_LEAST_M: Final = 0.06

# First and last place along a wall, and the upper edge; metres.
_Strip = tuple[float, float, float]


def backsplashes(room: Arrangement, kit: Kit) -> list[Item]:
    """A strip above every worktop at a wall, up to wall cabinets or to the sill of a window."""
    tops = [item for _, items in room.items for item in items if item.category == "worktop"]
    return [item for top in tops for item in _above(room.shell, kit, top)]


def _above(shell: Shell, kit: Kit, top: Item) -> Iterator[Item]:
    index, at = _behind(shell, top)
    side, half = shell.sides[index], 0.5 * top.size[0]
    for first, last, high in _strips(shell, index, max(at - half, 0.0),
                                     min(at + half, side.length)):  # fmt: skip
        if last - first < _LEAST_M or high - LEVEL_M < _LEAST_M:
            continue
        size = (round(last - first, 3), _THICK_M, round(high - LEVEL_M, 3))
        x, y = side.point(0.5 * (first + last), 0.5 * _THICK_M).tolist()
        yield kit.item("backsplash", round(x, 4), round(y, 4), side.yaw, size=size, style="panel",
                       z=LEVEL_M, on="wall", optional=True)  # fmt: skip


def _behind(shell: Shell, top: Item) -> tuple[int, float]:
    """The wall at the back of a worktop, and where along it the worktop's middle is, metres."""
    back = np.array(top.at(0.0, 0.5 * top.size[1]))
    offsets = [back - side.start for side in shell.sides]
    away = [
        abs(offset @ side.inward) + 9.0 * abs(np.sin(np.radians(0.5 * (side.yaw - top.yaw))))
        for offset, side in zip(offsets, shell.sides, strict=True)
    ]
    index = int(np.argmin(away))
    return index, float(offsets[index] @ shell.sides[index].along)


def _strips(shell: Shell, index: int, first: float, last: float) -> Iterator[_Strip]:
    """The length cut at the windows of its wall."""
    windows = sorted(
        (gap for gap in shell.gaps if gap.side == index and gap.kind == "window"),
        key=lambda gap: gap.at,
    )
    for gap in windows:
        reach = 0.5 * gap.width + _CASING_M
        a, b = max(first, gap.at - reach), min(last, gap.at + reach)
        if b <= a or gap.sill - _CASING_M > WALL_LOW_M:
            continue
        yield first, a, WALL_LOW_M
        yield a, b, min(gap.sill - _CASING_M, WALL_LOW_M)
        first = b
    yield first, last, WALL_LOW_M
