"""What an outline of a room costs: one number for simplicity against fit."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.rooms.directions import dearness
from openrooms_usd.scan.rooms.outline import Outline
from openrooms_usd.scan.rooms.walls import Line, Walls, profile

Array = NDArray[np.float64]


# What a metre of wall that stands inside, away from the outline, costs, metres.
_WALL_INSIDE_COST: Final = 2.5
# Walls shorter than this are rather window reveals, or drift of the scan, and cost so much more,
# metres.
_SHORT_WALL_COSTS_M: Final = ((0.2, 0.4), (0.08, 2.0))
# What it costs if everybody who scanned the room stood outside, metres.
_SENSORS_OUTSIDE_COST_M: Final = 30.0


class Cost:
    """What an outline costs: missing wall, corners and walls inside, less what it holds.

    Args:
        walls: The evidence.
        centres: (P, 2) the middles of pixels.
        worth: (P,) what each is worth inside.
        standing: (P,) metres of wall as high as the room that stand there.
        simplicity: What a corner costs, metres.
        directions: In which walls run, degrees modulo 90.
        stood: (E, 2) where people stood while they scanned the room.
    """

    def __init__(
        self, walls: Walls, centres: Array, worth: Array, standing: Array, simplicity: float,
        directions: tuple[float, ...] = (), stood: Array | None = None,
    ) -> None:  # fmt: skip
        self._stood = np.zeros((0, 2)) if stood is None else stood
        self._walls, self._simplicity, self._directions = walls, simplicity, directions
        self._centres, self._worth = centres[worth != 0.0], worth[worth != 0.0]
        self._tall, self._standing = centres[standing > 0.0], standing[standing > 0.0]
        self._lines: dict[tuple[float, ...], Line] = {}

    def __call__(self, outline: Outline) -> float:
        """Metres."""
        import shapely

        corners = outline.corners()
        missing, dear = 0.0, dearness(outline.normals, self._directions)
        for i in range(len(outline)):
            line = self._line(outline.normals[i], float(outline.offsets[i]))
            a, b = corners[i] @ line.along, corners[(i + 1) % len(corners)] @ line.along
            missing += float(abs(b - a) - line.covered(a, b)) * float(dear[i])
            missing += sum(cost for length, cost in _SHORT_WALL_COSTS_M if abs(b - a) < length)
        polygon = shapely.Polygon(corners)
        shapely.prepare(polygon)
        held = self._worth[shapely.contains_xy(polygon, self._centres)].sum()
        if len(self._stood):
            missing += _SENSORS_OUTSIDE_COST_M * float(
                (~shapely.contains_xy(polygon, self._stood)).mean()
            )
        inner = polygon.buffer(-self._walls.thickness, join_style="mitre")
        shapely.prepare(inner)
        left = self._standing[shapely.contains_xy(inner, self._tall)].sum()
        return (
            missing
            + self._simplicity * len(outline)
            + _WALL_INSIDE_COST * float(left)
            - float(held)
        )

    def _line(self, normal: Array, offset: float) -> Line:
        key = (*normal.tolist(), offset)
        if key not in self._lines:
            self._lines[key] = profile(self._walls, normal, offset)
        return self._lines[key]
