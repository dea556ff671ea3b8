"""The outline of one room of a level scan: minimum cut, simplification, piers, line fits."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.rooms.cells import Cells, inside_by_cut
from openrooms_usd.scan.rooms.costs import Cost
from openrooms_usd.scan.rooms.occupancy import PIXEL_M
from openrooms_usd.scan.rooms.outline import Outline, outline_of, simplified
from openrooms_usd.scan.rooms.piers import with_piers
from openrooms_usd.scan.rooms.refit import refitted
from openrooms_usd.scan.rooms.spaces import Spaces
from openrooms_usd.scan.rooms.walls import Walls

Array = NDArray[np.float64]

# Gain of a square metre inside that belongs to another room, or that was not scanned, in metres of
# missing wall.
_OTHER_ROOM_GAIN: Final = -1.0
_UNSEEN_GAIN: Final = -0.05
_CUT_PASSES: Final = 2


@dataclass(frozen=True, eq=False)
class Plan:
    """What the outlines of all rooms are computed from.

    Attributes:
        walls: The surfels of walls.
        spaces: The map of the plan.
        cells: Of the arrangement of line hypotheses.
        directions: Of walls, degrees modulo 90.
        simplicity: Penalty of a corner, metres of missing wall.
        own: Gain of a square metre of the room itself, in metres of missing wall.
        sensor_origins: (E, 2) metres.
        kept: (H, 2) places that every room must contain.
    """

    walls: Walls
    spaces: Spaces
    cells: Cells
    directions: tuple[float, ...]
    simplicity: float
    own: float
    sensor_origins: Array
    kept: Array

    def outline(self, number: int) -> Outline:
        """The outline of the space with a number from 1: the cheaper of two hypotheses."""
        scanned = self._gain(number, self.spaces.scanned)
        cost = Cost(
            self.walls, self.spaces.centres(), scanned, self.spaces.standing.ravel(),
            self.simplicity, self.directions, self._sensors_in(number),
        )  # fmt: skip
        middle = self.spaces.middles[number - 1]
        # Space hidden by furniture belongs to the room; free space without surfels perhaps not.
        gains = (self._gain(number, self.spaces.seen), scanned)
        cuts = [self._cut(gain, middle) for gain in gains]
        guesses: list[Outline] = []
        for outline in cuts[: 1 if cuts[0].same(cuts[1]) else 2]:
            for _ in range(_CUT_PASSES):
                plain = simplified(outline, cost)
                outline = with_piers(plain, self.spaces, self.walls.thickness, cost)
                outline = refitted(outline, self.walls, self.directions)
            guesses.append(outline)
        return min(guesses, key=cost)

    def _cut(self, pixel_gain: Array, middle: Array) -> Outline:
        """The border of the inside cells that are connected with a place."""
        import shapely

        cells, owner = self.cells, self._owner
        known = owner >= 0
        gain = np.bincount(owner[known], pixel_gain[known], len(cells)).astype(np.float64)
        inner = np.zeros(len(cells), bool)
        inner[cells.owners(middle[None])[0]] = True
        kept = cells.owners(self.kept)
        inner[kept[kept >= 0]] = True
        inside = inside_by_cut(cells, gain, inner, cells.rim & ~inner)
        parts = shapely.get_parts(shapely.union_all(cells.shapes[inside]))
        shape = parts[shapely.contains_xy(parts, *middle).argmax()]
        ring = shapely.orient_polygons(shapely.Polygon(shape.exterior)).exterior
        return outline_of(shapely.get_coordinates(ring)[:-1])

    @cached_property
    def _owner(self) -> NDArray[np.int64]:
        """(X * Y,) the cell of each pixel; -1 outside all."""
        return self.cells.owners(self.spaces.centres())

    def _gain(self, number: int, counted: NDArray[np.bool_]) -> Array:
        """(X * Y,) gain of each pixel inside a room; its own pixels only where they are counted."""
        rooms = self.spaces.rooms.ravel()
        empty = np.where(self.spaces.seen.ravel(), 0.0, _UNSEEN_GAIN)
        other = np.where(rooms == 0, empty, _OTHER_ROOM_GAIN)
        own = self.own * (counted & self.spaces.indoors).ravel()
        return np.where(rooms == number, own, other) * PIXEL_M**2

    def _sensors_in(self, number: int) -> Array:
        """(S, 2) sensor origins in a room, and the places that it must contain."""
        within = self.sensor_origins[self.spaces.numbers(self.sensor_origins) == number]
        return np.concatenate([within, self.kept])
