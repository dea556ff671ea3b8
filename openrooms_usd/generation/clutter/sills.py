"""Sill boards of windows, on which plants and candles stand: surfaces of the room itself."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from openrooms_usd.building.windows import BOARD, NOSE, reveal_depth
from openrooms_usd.generation.clutter.levels import CELL_M, Level
from openrooms_usd.generation.clutter.spots import Spot
from openrooms_usd.generation.items import Item
from openrooms_usd.generation.shell import Gap, Shell

CARRIER: Final = "floor"
"""What carries things on sills by their description: the room, at a height that is said."""
# Windows that begin lower have no board that people use, nor do those out of reach; metres.
_LOWEST_M, _HIGHEST_M = 0.5, 1.75
# What stands there leaves most of the window free, metres.
_MAX_HEIGHT_M: Final = 0.4
_MAX_SHARE: Final = 0.5
# Between things and the sides of the reveal, and the frame; metres.
_BESIDE_M, _FRAME_GAP_M = 0.02, 0.002


def sills(shell: Shell, group: int) -> Iterator[Spot]:
    """The sill boards of a room.

    Args:
        shell: The room.
        group: The index of the group that takes what stands there.
    """
    for gap in shell.gaps:
        if gap.kind == "window" and _LOWEST_M <= gap.sill <= _HIGHEST_M:
            level = _board(shell, gap)
            if level.area > 0.0:
                yield Spot("window_sill", _window(shell, gap), group, level)


def _window(shell: Shell, gap: Gap) -> Item:
    """A window as an item whose origin is on the floor, in the inner face of its wall."""
    side = shell.sides[gap.side]
    x, y = side.point(gap.at, 0.0).tolist()
    size = gap.width, shell.thickness, gap.top - gap.sill
    return Item(CARRIER, "window", size, "", x, y, 0.0, side.yaw)


def _board(shell: Shell, gap: Gap) -> Level:
    """The upper side of a board, from its nose to the frame."""
    width = gap.width - 2 * _BESIDE_M
    depth = NOSE + reveal_depth(shell.thickness) - _FRAME_GAP_M
    cells = int(depth / CELL_M), max(int(width / CELL_M), 0)
    high = min(_MAX_HEIGHT_M, _MAX_SHARE * (gap.top - gap.sill))
    corner = np.array([-0.5 * cells[1] * CELL_M, -NOSE])
    return Level(gap.sill + BOARD, corner, np.full(cells, high), True)
