"""The outline of one room of a level scan: minimum cut, simplification, piers, line fits.

The minimum cut charges for the missed side and may leave a pier out; full-height wall inside the
outline then shows where it is.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.scan.rooms.cells import FloorCells, inside_by_cut
from openrooms_usd.scan.rooms.directions import unseen_wall_cost
from openrooms_usd.scan.rooms.outline import Outline, outline_of, simplified
from openrooms_usd.scan.rooms.spaces import PIXEL_M, Spaces
from openrooms_usd.scan.rooms.walls import FACES_ACROSS_COS, Line, Walls, line_fit, profile

# Gain of a square metre inside that belongs to another room, or that was not scanned, in metres of
# missing wall.
_OTHER_ROOM_GAIN: Final = -1.0
_UNSEEN_GAIN: Final = -0.05
_CUT_PASSES: Final = 2
# Of a metre of wall inside, away from the outline, in metres of missing wall.
_WALL_INSIDE_COST: Final = 2.5
# Walls shorter than the first are likely window reveals or drift, and cost the second more, metres.
_SHORT_WALL_COSTS_M: Final = ((0.2, 0.4), (0.08, 2.0))
# A wall of which less than this share was scanned is assumed, and costs this much more, metres. So
# walls continue straight where nothing was scanned.
_ASSUMED_SHARE: Final = 0.2
_ASSUMED_WALL_COST_M: Final = 0.3
# If all sensors are outside, metres of missing wall; in proportion if some are.
_SENSORS_OUTSIDE_COST_M: Final = 30.0
_MAX_DEPTH_M: Final = 2.0
# A freestanding wall has surfels, of its back or the floor, in more than this part of its pier.
_MAX_SCANNED_SHARE: Final = 0.3
_MIN_WALL_M: Final = 0.1
_MIN_EVIDENCE_PIXELS: Final = 0.25  # of a pixel's width


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
        self,
        walls: Walls,
        centres: Array,
        gain: Array,
        standing: Array,
        simplicity: float,
        directions: tuple[float, ...] = (),
        sensors: Array | None = None,
    ) -> None:
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
    cells: FloorCells
    directions: tuple[float, ...]
    simplicity: float
    own: float
    sensor_origins: Array
    kept: Array

    def outline(self, number: int) -> Outline:
        """The outline of the space with a number from 1: the cheaper of two hypotheses."""
        scanned = self._gain(number, self.spaces.scanned)
        cost = Cost(
            self.walls,
            self.spaces.centres(),
            scanned,
            self.spaces.standing.ravel(),
            self.simplicity,
            self.directions,
            self._sensors_in(number),
        )
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
    def _owner(self) -> Ints:
        """(X * Y,) the cell of each pixel; -1 outside all."""
        return self.cells.owners(self.spaces.centres())

    def _gain(self, number: int, counted: Mask) -> Array:
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


def with_piers(
    outline: Outline, spaces: Spaces, away: float, cost: Callable[[Outline], float]
) -> Outline:
    """Add rectangular piers around full-height wall inside, where that lowers the cost.

    Args:
        outline: The room so far.
        spaces: The map of the plan.
        away: Wall nearer to the outline than this is the outline's own, metres.
        cost: Of an outline.
    """
    for places in _standing_inside(outline, spaces, away):
        tries = [_pier(outline, wall, places) for wall in range(len(outline))]
        valid = [other for other in tries if other is not None and other.valid()]
        valid = [other for other in valid if _is_solid(outline, other, spaces, away)]
        if valid:
            best = min(valid, key=cost)
            outline = best if cost(best) < cost(outline) else outline
    return outline


def _standing_inside(outline: Outline, spaces: Spaces, away: float) -> list[Array]:
    """(P, 2) the pixels of each connected component of wall inside an outline."""
    import shapely
    from scipy import ndimage

    inner = shapely.Polygon(outline.corners()).buffer(-away, join_style="mitre")
    shapely.prepare(inner)
    inside = shapely.contains_xy(inner, spaces.centres()).reshape(spaces.standing.shape)
    strong = inside & (spaces.standing > _MIN_EVIDENCE_PIXELS * PIXEL_M)
    groups, count = ndimage.label(strong, np.ones((3, 3)))
    centres = spaces.centres()
    found = [groups.ravel() == number for number in range(1, count + 1)]
    weights = spaces.standing.ravel()
    return [centres[rows] for rows in found if weights[rows].sum() > _MIN_WALL_M]


def _is_solid(outline: Outline, other: Outline, spaces: Spaces, away: float) -> bool:
    """Whether the area that an outline cuts off has few surfels: else the wall is freestanding."""
    import shapely

    whole, rest = (shapely.Polygon(shape.corners()) for shape in (outline, other))
    within = shapely.contains_xy(whole.difference(rest).buffer(-away), spaces.centres())
    return not within.any() or float(spaces.scanned.ravel()[within].mean()) < _MAX_SCANNED_SHARE


def _pier(outline: Outline, wall: int, places: Array) -> Outline | None:
    """The outline with a rectangle around some places cut off at one of its walls."""
    corners = outline.corners()
    start, end = corners[wall], corners[(wall + 1) % len(outline)]
    normal = outline.normals[wall]
    along = np.array([-normal[1], normal[0]])
    depth = outline.offsets[wall] - places @ normal
    place = places @ along
    a, b, deep = place.min(), place.max(), float(depth.max())
    if deep > _MAX_DEPTH_M or a < start @ along - PIXEL_M or b > end @ along + PIXEL_M:
        return None
    normals = np.array([normal, along, normal, -along, normal])
    offset = outline.offsets[wall]
    offsets = np.array([offset, a, offset - deep, -b, offset])
    order = np.arange(len(outline))
    before, after = order < wall, order > wall
    return Outline(
        np.concatenate([outline.normals[before], normals, outline.normals[after]]),
        np.concatenate([outline.offsets[before], offsets, outline.offsets[after]]),
    )


# Robust line fits of walls; corners are their intersections.

# Largest distance of a wall's surfels from its initial line, metres.
_SEARCH_M: Final = 0.08
# Annealing: widths of the kernel, one after the other, metres.
_REACHES_M: Final = (0.08, 0.06, 0.045)
_REWEIGHTING_ROUNDS: Final = 8
_COLUMN_M: Final = 0.1  # of the columns that have equal weight
_MIN_WEIGHT: Final = 20.0
# Shorter walls keep their initial direction, metres.
_MIN_TURNING_WALL_M: Final = 0.6
# So do walls of which a smaller part was scanned: outliers and furniture would turn them.
_MIN_SEEN_SHARE: Final = 0.25
# Walls within this angle of a prevailing direction snap to it, degrees.
_SNAP_DEG: Final = 1.5


@dataclass(frozen=True, eq=False)
class _Evidence:
    """The surfels near one wall, weighted such that every ten centimetres of it count alike.

    Attributes:
        points: (P, 2) metres.
        weight: (P,) of each.
        whole: Length of the wall, metres.
        length: Length of it that has surfels, metres.
    """

    points: Array
    weight: Array
    whole: float
    length: float


def refitted(outline: Outline, walls: Walls, directions: tuple[float, ...]) -> Outline:
    """Fit every wall's line to the vertical surfels near it.

    Fits are iteratively reweighted least squares. Walls within 1.5 degrees of a prevailing
    direction share the mean direction of all these.

    Args:
        outline: Its walls are within 8 cm of the truth.
        walls: The surfels of walls.
        directions: Degrees modulo 90.

    Returns:
        The outline; the one that was given where the fits do not bound a simple polygon.
    """
    normals, offsets = outline.normals.copy(), outline.offsets.copy()
    starts = outline.corners()
    ends = np.roll(starts, -1, axis=0)
    evidence = [_near(walls, *wall) for wall in zip(normals, offsets, starts, ends, strict=True)]
    for i, seen in enumerate(evidence):
        if seen is not None and seen.length > max(
            _MIN_TURNING_WALL_M, _MIN_SEEN_SHARE * seen.whole
        ):
            normals[i] = _turned(seen, normals[i], float(offsets[i]))
    lengths = np.array([0.0 if seen is None else seen.length for seen in evidence])
    normals = _snapped(normals, lengths, directions)
    for i, seen in enumerate(evidence):
        if seen is not None:
            offsets[i] = _shifted(seen, normals[i])
        else:
            offsets[i] = (starts[i] + ends[i]) @ normals[i] / 2.0
    moved = Outline(normals, offsets)
    return moved if moved.valid() else outline


def _near(walls: Walls, normal: Array, offset: float, start: Array, end: Array) -> _Evidence | None:
    along = np.array([-normal[1], normal[0]])
    a, b = float(start @ along), float(end @ along)
    trim = min(0.08, 0.2 * (b - a))
    place = walls.points @ along
    near = (
        (np.abs(walls.normals @ normal) > FACES_ACROSS_COS)
        & (place > a + trim)
        & (place < b - trim)
    )
    near &= np.abs(walls.points @ normal - offset) < _SEARCH_M
    weight = (walls.weight * walls.share)[near]
    if weight.sum() < _MIN_WEIGHT:
        return None
    column = ((place[near] - a) / _COLUMN_M).astype(int)
    total = np.bincount(column, weight)
    weight = weight / np.maximum(total[column], 0.25 * total.max())
    return _Evidence(walls.points[near], weight, b - a, _COLUMN_M * float((total > 0.0).sum()))


def _turned(seen: _Evidence, normal: Array, offset: float) -> Array:
    """(2,) the normal of the fitted line; the kernel is narrowed step by step."""
    fitted, shift = normal, offset
    for reach in _REACHES_M:
        across = seen.points @ fitted
        shift = _mode(across, seen.weight, shift, reach)
        kernel = seen.weight * _tukey((across - shift) / reach)
        if kernel.sum() > 0.0:
            fitted, shift = line_fit(seen.points, kernel, normal)
    return fitted


def _shifted(seen: _Evidence, normal: Array) -> float:
    across = seen.points @ normal
    place = float(np.average(across, weights=seen.weight))
    for reach in _REACHES_M:
        place = _mode(across, seen.weight, place, reach)
    return place


def _mode(offsets: Array, weight: Array, place: float, reach: float) -> float:
    """Mean shift of an offset over the weighted offsets around it."""
    for _ in range(_REWEIGHTING_ROUNDS):
        kernel = weight * _tukey((offsets - place) / reach)
        if kernel.sum() <= 0.0:
            break
        place = float((kernel * offsets).sum() / kernel.sum())
    return place


def _tukey(ratio: Array) -> Array:
    """Tukey's biweight."""
    return np.clip(1.0 - ratio**2, 0.0, None) ** 2


def _snapped(normals: Array, lengths: Array, directions: tuple[float, ...]) -> Array:
    """(N, 2) normals; those near the same direction become their mean."""
    angles = np.rad2deg(np.arctan2(normals[:, 1], normals[:, 0]))
    free = np.ones(len(angles), bool)
    for direction in directions:
        off = (angles - direction + 45.0) % 90.0 - 45.0
        near = free & (np.abs(off) < _SNAP_DEG)
        # The longer a wall, the smaller the error of its direction.
        weight = np.where(lengths > _MIN_TURNING_WALL_M, lengths, 0.0) ** 2
        total = float(weight[near].sum())
        mean = float((weight * off)[near].sum()) / total if total > 0.0 else 0.0
        angles = np.where(near, angles - off + mean, angles)
        free &= ~near
    return np.column_stack([np.cos(np.deg2rad(angles)), np.sin(np.deg2rad(angles))])
