"""The outline of one room of a level scan: a cut of the plan, made plain, fitted to its walls."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.rooms.cells import Cells, inside_by_cut
from openrooms_usd.scan.rooms.costs import Cost
from openrooms_usd.scan.rooms.outline import Outline, outline_of, simplified
from openrooms_usd.scan.rooms.piers import with_piers
from openrooms_usd.scan.rooms.planmap import PIXEL
from openrooms_usd.scan.rooms.refit import refitted
from openrooms_usd.scan.rooms.spaces import Spaces
from openrooms_usd.scan.rooms.walls import Walls

Array = NDArray[np.float64]

# What a square metre of another room that lies inside is worth, in metres of missing wall; and of
# what was not seen at all.
_OTHER_ROOM_WORTH: Final = -1.0
_UNSEEN_WORTH: Final = -0.05
_CUT_PASSES: Final = 2


@dataclass(frozen=True, eq=False)
class Plan:
    """What is known of all rooms.

    Attributes:
        walls: The evidence of walls.
        spaces: The map of what was seen.
        cells: The plan, cut by the lines on which walls may stand.
        directions: In which walls run, degrees modulo 90.
        simplicity: What a corner must save in missing wall, metres.
        own: What a square metre of the room itself is worth, in metres of missing wall.
        sensor_origins: (E, 2) where the scanner stood.
        kept: (H, 2) places that every room must hold.
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
        """The outline of the space with a number from 1: of two guesses the cheaper one."""
        shown = self._worth(number, self.spaces.shown)
        cost = Cost(
            self.walls, self.spaces.centres(), shown, self.spaces.standing.ravel(),
            self.simplicity, self.directions, self._stood(number),
        )  # fmt: skip
        middle = self.spaces.middles[number - 1]
        # What hides behind furniture belongs to the room, what is seen past it perhaps not.
        worths = (self._worth(number, self.spaces.seen), shown)
        cuts = [self._cut(worth, middle) for worth in worths]
        guesses: list[Outline] = []
        for outline in cuts[: 1 if cuts[0].same(cuts[1]) else 2]:
            for _ in range(_CUT_PASSES):
                plain = simplified(outline, cost)
                outline = with_piers(plain, self.spaces, self.walls.thickness, cost)
                outline = refitted(outline, self.walls, self.directions)
            guesses.append(outline)
        return min(guesses, key=cost)

    def _cut(self, worth: Array, middle: Array) -> Outline:
        """The border of the cells that are inside, around a place."""
        import shapely

        cells, owner = self.cells, self._owner
        known = owner >= 0
        gain = np.bincount(owner[known], worth[known], len(cells)).astype(np.float64)
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
        """(X * Y,) the cell in which each pixel lies; -1 in none."""
        return self.cells.owners(self.spaces.centres())

    def _worth(self, number: int, shown: NDArray[np.bool_]) -> Array:
        """(X * Y,) what each pixel is worth inside a room, if it was shown."""
        rooms = self.spaces.rooms.ravel()
        empty = np.where(self.spaces.seen.ravel(), 0.0, _UNSEEN_WORTH)
        other = np.where(rooms == 0, empty, _OTHER_ROOM_WORTH)
        return np.where(rooms == number, self.own * shown.ravel(), other) * PIXEL**2

    def _stood(self, number: int) -> Array:
        """(S, 2) places where people stood within a room."""
        within = self.sensor_origins[self.spaces.numbers(self.sensor_origins) == number]
        return np.concatenate([within, self.kept])
