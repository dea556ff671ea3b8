"""The cost of a room's outline: data terms and a penalty for corners, in metres of wall."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.rooms.directions import unseen_wall_cost
from openrooms_usd.scan.rooms.outline import Outline
from openrooms_usd.scan.rooms.walls import Line, Walls, profile

Array = NDArray[np.float64]


# Of a metre of wall inside, away from the outline, in metres of missing wall.
_WALL_INSIDE_COST: Final = 2.5
# Walls shorter than the first are likely window reveals or drift, and cost the second more, metres.
_SHORT_WALL_COSTS_M: Final = ((0.2, 0.4), (0.08, 2.0))
# A wall of which less than this part shows is assumed; it costs as much more, metres: rather than
# that walls step where nobody looked, they go straight on.
_ASSUMED_SHARE: Final = 0.2
_ASSUMED_WALL_COST_M: Final = 0.3
# If all sensors are outside, metres of missing wall; in proportion if some are.
_SENSORS_OUTSIDE_COST_M: Final = 30.0


class Cost:
    """The cost of an outline: missing wall, corners and walls inside, less gains of its pixels.

    Args:
        walls: The surfels of walls.
        centres: (P, 2) the middles of pixels.
        gain: (P,) of each pixel inside.
        standing: (P,) metres of full-height wall in each.
        simplicity: Penalty of a corner, metres.
        directions: Of walls, degrees modulo 90.
        sensors: (E, 2) sensor origins in the room.
    """

    def __init__(
        self, walls: Walls, centres: Array, gain: Array, standing: Array, simplicity: float,
        directions: tuple[float, ...] = (), sensors: Array | None = None,
    ) -> None:  # fmt: skip
        self._sensors = np.zeros((0, 2)) if sensors is None else sensors
        self._walls, self._simplicity, self._directions = walls, simplicity, directions
        self._centres, self._gain = centres[gain != 0.0], gain[gain != 0.0]
        self._tall, self._standing = centres[standing > 0.0], standing[standing > 0.0]
        self._lines: dict[tuple[float, ...], Line] = {}

    def __call__(self, outline: Outline) -> float:
        """Metres."""
        import shapely

        corners = outline.corners()
        missing, rate = 0.0, unseen_wall_cost(outline.normals, self._directions)
        for i in range(len(outline)):
            line = self._line(outline.normals[i], float(outline.offsets[i]))
            a, b = corners[i] @ line.along, corners[(i + 1) % len(corners)] @ line.along
            length, covered = float(abs(b - a)), float(line.covered(a, b))
            missing += (length - covered) * float(rate[i])
            missing += _ASSUMED_WALL_COST_M * (covered < _ASSUMED_SHARE * length)
            missing += sum(cost for short, cost in _SHORT_WALL_COSTS_M if length < short)
        polygon = shapely.Polygon(corners)
        shapely.prepare(polygon)
        won = self._gain[shapely.contains_xy(polygon, self._centres)].sum()
        if len(self._sensors):
            missing += _SENSORS_OUTSIDE_COST_M * float(
                (~shapely.contains_xy(polygon, self._sensors)).mean()
            )
        inner = polygon.buffer(-self._walls.thickness, join_style="mitre")
        shapely.prepare(inner)
        left = self._standing[shapely.contains_xy(inner, self._tall)].sum()
        return (
            missing + self._simplicity * len(outline) + _WALL_INSIDE_COST * float(left) - float(won)
        )

    def _line(self, normal: Array, offset: float) -> Line:
        key = (*normal.tolist(), offset)
        if key not in self._lines:
            self._lines[key] = profile(self._walls, normal, offset)
        return self._lines[key]
