"""The vertical surfels of a scan, and the cover of lines in the plan by walls."""

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.scan.points.surfels import Surfels
from openrooms_usd.scan.rooms.ceilings import NO_CEILINGS, Ceilings
from openrooms_usd.scan.rooms.directions import UPRIGHT_SINE

# Inliers of a line: within so many standard deviations, clipped to these limits, with normals
# within 20 degrees of the line's.
_REACH_SIGMAS: Final = 3.0
_REACH_LIMITS_M: Final = (0.06, 0.1)
_SLAB_REACHES: Final = 2.5
FACES_ACROSS_COS: Final = float(np.cos(np.deg2rad(20.0)))
COLUMN_M: Final = 0.05
_COURSE_M: Final = 0.1  # height of a bin
_WALL_TOP_M: Final = 0.5  # below the highest surfels, where furniture rarely reaches
_WALL_FOOT_M: Final = 0.1
# NYU40 classes: things on walls count as wall, unknown ones less, furniture hardly.
_ON_WALLS_LABELS: Final = (1, 8, 11, 19, 30)
_UNKNOWN_LABELS: Final = (0, 9, 38, 40)
_LABEL_WEIGHTS: Final = {"wall": 1.0, "unknown": 0.7, "furniture": 0.12}
# Fronts of furniture are evidence against a wall.
_FURNITURE_FRONT_WEIGHT: Final = -0.4


@dataclass(frozen=True, eq=False)
class Walls:
    """Vertical surfels of a level scan.

    Attributes:
        points: (M, 2) in the plan, metres.
        normals: (M, 2) unit; the sign is arbitrary.
        height: (M,) above the floor, metres.
        weight: (M,) as evidence of a wall, by the label.
        share: (M,) number of points, relative to the surfels around.
        top: Height up to which walls were scanned, metres.
        reach: Inlier distance of lines, metres.
        ceilings: Where they are lower, walls end there.
    """

    points: Array
    normals: Array
    height: Array
    weight: Array
    share: Array
    top: float
    reach: float
    ceilings: Ceilings = field(default_factory=lambda: NO_CEILINGS)

    def tops(self, places: Array, across: Array) -> Array:
        """(N,) the height up to which walls at places (N, 2) reach, given a direction across."""
        return np.asarray(
            np.minimum(np.min(self.ceilings.beside(places, across), axis=0), self.top)
        )

    @property
    def thickness(self) -> float:
        """Distance beyond which no surfel is a wall's own, metres."""
        return _SLAB_REACHES * self.reach

    @property
    def courses(self) -> int:
        """The number of height bins."""
        return max(int(np.ceil(self.top / _COURSE_M)), 4)


@dataclass(frozen=True, eq=False)
class Line:
    """A line in the plan: normal . p = offset.

    Attributes:
        normal: (2,) unit.
        offset: Metres.
        start: Where its first column begins, along the direction (-n_y, n_x), metres.
        cover: (U,) for columns of 5 cm along the line, the evidence of a wall, from 0 to 1.
        seen: (U,) the evidence of anything vertical, at whatever height, from 0 to 1.
    """

    normal: Array
    offset: float
    start: float
    cover: Array
    seen: Array

    @property
    def along(self) -> Array:
        """(2,) unit, along the line."""
        return np.array([-self.normal[1], self.normal[0]])

    def covered(self, a: float | Array, b: float | Array) -> Array:
        """Metres of wall between places along the line."""
        return _between(self.cover, self.start, a, b)

    def seen_length(self, a: float | Array, b: float | Array) -> Array:
        """Metres of anything vertical between places along the line."""
        return _between(self.seen, self.start, a, b)


def _between(values: Array, start: float, a: float | Array, b: float | Array) -> Array:
    total = np.concatenate([[0.0], np.cumsum(values) * COLUMN_M])
    ends = start + COLUMN_M * np.arange(len(total))
    return np.asarray(np.abs(np.interp(b, ends, total) - np.interp(a, ends, total)))


def upright(
    pieces: Surfels, ceilings: Ceilings = NO_CEILINGS, before_walls: Mask | None = None
) -> Walls:
    """The vertical surfels of a level scan, weighted as evidence of walls.

    Args:
        pieces: All surfels.
        ceilings: Where they are lower than walls elsewhere.
        before_walls: (M,) those of faces that stand before a wall; None: of none.
    """
    before = np.zeros(len(pieces), dtype=np.bool_) if before_walls is None else before_walls
    standing = np.abs(pieces.normals[:, 2]) < UPRIGHT_SINE
    chosen = standing & (pieces.points[:, 2] > _WALL_FOOT_M)
    walls = pieces.take(chosen)
    normals = unit(walls.normals[:, :2])
    height = walls.points[:, 2]
    weight = _label_weights(walls.label, len(walls))
    weight[before[chosen]] = _LABEL_WEIGHTS["furniture"]
    counts = np.bincount((height / _COURSE_M).astype(int), weight, 4)
    dense = np.flatnonzero(counts >= 0.25 * np.quantile(counts, 0.75))
    top = float((dense[-1] + 1) * _COURSE_M)
    kept = height < top
    noise = float(np.median(walls.rough)) if len(walls) else 0.0
    reach = float(np.clip(_REACH_SIGMAS * noise, *_REACH_LIMITS_M))
    return Walls(
        points=walls.points[kept, :2],
        normals=normals[kept],
        height=height[kept],
        weight=weight[kept],
        share=walls.share[kept],
        top=top,
        reach=reach,
        ceilings=ceilings,
    )


def _label_weights(label: NDArray[np.int32] | None, count: int) -> Array:
    if label is None or not np.isin(label, (*_ON_WALLS_LABELS,)).any():
        return np.full(count, _LABEL_WEIGHTS["wall"])
    return np.where(
        np.isin(label, _ON_WALLS_LABELS),
        _LABEL_WEIGHTS["wall"],
        np.where(
            np.isin(label, _UNKNOWN_LABELS), _LABEL_WEIGHTS["unknown"], _LABEL_WEIGHTS["furniture"]
        ),
    )


def on_line(
    walls: Walls,
    normal: Array,
    offset: float,
    rows: Ints | slice = slice(None),
    spread: float = 1.0,
) -> Mask:
    """The inliers of a line, by distance and normal.

    Args:
        walls: The vertical surfels.
        normal: (2,) unit, of the line.
        offset: Of the line, metres.
        rows: Only some of the surfels.
        spread: Largest distance, in units of their reach.
    """
    near = np.abs(walls.points[rows] @ normal - offset) < spread * walls.reach
    return np.asarray(near & (np.abs(walls.normals[rows] @ normal) > FACES_ACROSS_COS))


def line_fit(points: Array, weight: Array, toward: Array) -> tuple[Array, float]:
    """Total least squares: the line's normal (2,), on the side of ``toward``, and its offset."""
    middle = np.average(points, axis=0, weights=weight)
    away = points - middle
    normal = np.linalg.eigh((away * weight[:, None]).T @ away)[1][:, 0]
    normal = normal if normal @ toward >= 0.0 else -normal
    return normal, float(middle @ normal)


def profile(walls: Walls, normal: Array, offset: float) -> Line:
    """The cover of a line by walls."""
    on = on_line(walls, normal, offset)
    along = np.array([-normal[1], normal[0]])
    places = walls.points @ along
    start = float(np.floor(places.min() / COLUMN_M) - 2) * COLUMN_M if len(places) else 0.0
    count = int((places.max() - start) / COLUMN_M) + 3 if len(places) else 1
    column = ((places[on] - start) / COLUMN_M).astype(int)
    course = np.minimum((walls.height[on] / _COURSE_M).astype(int), walls.courses - 1)
    furniture = walls.weight[on] <= _LABEL_WEIGHTS["furniture"]
    weight = np.where(furniture, _FURNITURE_FRONT_WEIGHT, walls.weight[on])
    filled = np.zeros((count, walls.courses))
    np.add.at(filled, (column, course), weight * COLUMN_M / _COURSE_M)
    filled = np.clip(filled * 1.5, _FURNITURE_FRONT_WEIGHT, 1.0)
    above, everywhere = _shares(filled, _courses_at(walls, normal, offset, start, count))
    cover = np.minimum(1.0, 1.4 * (0.7 * above + 0.3 * everywhere))
    seen = np.minimum(1.0, 3.0 * np.maximum(everywhere, above))
    return Line(normal, offset, start, _closed(cover), _closed(seen))


def _courses_at(walls: Walls, normal: Array, offset: float, start: float, count: int) -> Ints:
    """(U,) the number of height bins below the ceiling in each column of a line."""
    along = np.array([-normal[1], normal[0]])
    places = offset * normal + (start + COLUMN_M * (np.arange(count) + 0.5))[:, None] * along
    courses = np.rint(walls.tops(places, normal) / _COURSE_M).astype(np.int64)
    return np.clip(courses, 4, walls.courses)


def _shares(filled: Array, courses: Ints) -> tuple[Array, Array]:
    """(U,) the mean of the highest bins below the ceiling, and of all of them."""
    total = np.pad(np.cumsum(filled, axis=1), ((0, 0), (1, 0)))
    column = np.arange(len(filled))
    band, foot = int(_WALL_TOP_M / _COURSE_M), int(_WALL_FOOT_M / _COURSE_M)
    low = np.maximum(courses - band, 0)
    above = (total[column, courses] - total[column, low]) / (courses - low)
    everywhere = (total[column, courses] - total[column, foot]) / (courses - foot)
    return above, everywhere


def _closed(values: Array) -> Array:
    """Morphological closing: gaps of two columns are filled."""
    wide = np.pad(values, 2, mode="edge")
    dilated = np.max([wide[i : i + len(wide) - 2] for i in range(3)], axis=0)
    return np.asarray(np.min([dilated[i : i + len(dilated) - 2] for i in range(3)], axis=0))
