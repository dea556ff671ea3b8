"""The boxes of boards behind fronts: sides, top, bottom, back, plinth, legs, shelves."""

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.boards import board, corners, round_leg, splayed
from openrooms_usd.furniture.joinery.cells import BOARD, HANDLE, SEAT, Cell, columns, rows
from openrooms_usd.furniture.joinery.pieces import Size

# The back panel: how far it lies before the rear edges, metres.
BACK: Final = 0.014
# Shelves behind doors stay this far behind the front edges, metres.
SETBACK: Final = 0.02


@dataclass
class Carcass:
    """A cabinet under construction: what is made so far, and where its boards stand.

    Attributes:
        width: Outer width, metres.
        front: Y of the front edges of its boards, metres.
        back: Y of its back, metres.
        low: Z of its lower side, metres.
        high: Z of its top, metres.
        made: Its parts and joints.
    """

    width: float
    front: float
    back: float
    low: float
    high: float
    made: Assembly = field(default_factory=Assembly)

    @property
    def face(self) -> float:
        """Y of the back of its fronts, metres."""
        return self.front - SEAT

    @property
    def inside(self) -> Cell:
        """The opening between the outer boards."""
        half = 0.5 * self.width - BOARD
        return -half, half, self.low + BOARD, self.high - BOARD

    @property
    def overlay(self) -> Cell:
        """The area that fronts before the boards cover: all of it."""
        half = 0.5 * self.width
        return -half, half, self.low, self.high

    def boards(self, *, top: bool = True) -> "Carcass":
        """Add sides, bottom, a thin back and, unless something else closes it, a top."""
        half, front, back, low, high = 0.5 * self.width, self.front, self.back, self.low, self.high
        inner = 0.5 * BOARD - half
        self.made.add(
            "frame",
            *(board((x, front, low), (x + BOARD, back, high)) for x in (-half, half - BOARD)),
            *(
                board((BOARD - half, front, z), (half - BOARD, back, z + BOARD))
                for z in ((low, high - BOARD) if top else (low,))
            ),
            board((inner, back - BACK, low + 0.009), (-inner, back - 0.006, high - 0.009)),
        )
        return self

    def plinth(self, recess: float = 0.035) -> None:
        """A base below, its front set back by ``recess`` metres for the toes."""
        half = 0.5 * self.width
        low, high = (0.012 - half, self.front + recess, 0.0), (half - 0.012, self.back, self.low)
        self.made.board("base", low, high)

    def legs(self) -> None:
        """Four turned legs that splay outwards."""
        middle = 0.5 * (self.front + self.back)
        x, y = 0.5 * self.width - 0.06, 0.5 * (self.back - self.front) - 0.05
        leg = round_leg(0.018, 0.011, self.low)
        for a, b in corners(x, y):
            foot = (a + np.sign(a) * 0.025, b + np.sign(b) * 0.02)
            self.made.add("leg", splayed(leg, foot, (a, b)).moved((0.0, middle, 0.0)))

    def divider(self, x: float, low: float, high: float) -> None:
        """An upright board in the middle of ``x``, metres."""
        self.made.board(
            "frame", (x - 0.5 * BOARD, self.front, low), (x + 0.5 * BOARD, self.back - BACK, high)
        )

    def shelf(self, cell: Cell, z: float, setback: float = SETBACK) -> None:
        """A shelf with its middle at the height ``z``, metres."""
        self.made.board(
            "shelf",
            (cell[0], self.front + setback, z - 0.5 * BOARD),
            (cell[1], self.back - BACK, z + 0.5 * BOARD),
        )

    def shelves(self, cell: Cell, pitch: float = 0.33, setback: float = 0.006) -> list[Cell]:
        """Shelves about ``pitch`` apart.

        Returns:
            The compartments between them, from below.
        """
        count = max(1, round((cell[3] - cell[2]) / pitch))
        parts = rows(cell, [1.0] * count)
        for part in parts[1:]:
            self.shelf(cell, part[2], setback)
        pad = 0.5 * BOARD
        return [
            (a, b, low + (pad if i else 0.0), high - (pad if i < count - 1 else 0.0))
            for i, (a, b, low, high) in enumerate(parts)
        ]

    def bays(self, count: int) -> list[Cell]:
        """Divide the inside by upright boards.

        Returns:
            The free openings between them, from the left.
        """
        parts = columns(self.inside, count)
        for part in parts[1:]:
            self.divider(part[0], part[2], part[3])
        pad = 0.5 * BOARD
        return [
            (a + (pad if i else 0.0), b - (pad if i < count - 1 else 0.0), low, high)
            for i, (a, b, low, high) in enumerate(parts)
        ]


def closed(size: Size, low: float, *, high: float | None = None) -> Carcass:
    """A carcass that leaves room for fronts and handles before it."""
    width, depth, height = size
    front = -0.5 * depth + HANDLE + BOARD + SEAT
    return Carcass(width, front, 0.5 * depth, low, high or height).boards()


def plinth_height(height: float) -> float:
    """How high the base of a cabinet of this height is, metres."""
    return 0.07 if height > 0.5 else 0.03
