"""Our own segmenter: finds furniture by its shape, without trained weights."""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.surfels import Surfels, surfels
from openrooms_usd.scan.points.thinning import thin
from openrooms_usd.scan.registration.surroundings import walls_of
from openrooms_usd.scan.results import FoundOpening, FoundRoom
from openrooms_usd.scan.segmentation.contract import Segments
from openrooms_usd.scan.segmentation.grouping import grouped
from openrooms_usd.scan.segmentation.naming import UNNAMED, named
from openrooms_usd.scan.segmentation.shape import SegmentShape, shape_of

Rows = NDArray[np.intp]

_THINNING_M: Final = 0.02
_NEIGHBOURS: Final = 4
_SPACING_SAMPLE: Final = 20_000
# Points belong to the surfel that is nearest, up to this distance, metres.
_OF_SURFEL_M: Final = 0.07
# Pieces of fewer surfels are outliers.
_MIN_SURFELS: Final = 20
# Smaller things are clutter; larger ones are not furniture, but walls that the layout lacks.
_MIN_SIDE_M: Final = 0.25
_MIN_VOLUME_M3: Final = 0.015
_MAX_SIDE_M: Final = 4.5
_MAX_AREA_M2: Final = 9.0
# Upright sheets are curtains, leaves of doors, and pieces of wall: thinner than the one and taller
# than the other, metres; what is thinner still is one at any height.
_SHEET_M: Final = 0.18
_TALL_M: Final = 1.2
_THIN_M: Final = 0.08
# What begins higher hangs, or stands on another piece where some surfels of that are at most so far
# below, metres. Small things on others are clutter, cubic metres.
_HANGS_M: Final = 0.3
_BELOW_M: Final = 0.12
_MIN_SURFELS_BELOW: Final = 6
_MIN_VOLUME_ON_TOP_M3: Final = 0.03
# What ends this near to the ceiling is a part of the building or a curtain, metres.
_BELOW_CEILING_M: Final = 0.15

# Surfels this near to a wall are the wall's; those that face it a little farther, too: walls are
# straight, real ones bulge, and scans drift. Metres.
_WALL_M: Final = 0.04
_FACING_WALL_M: Final = 0.1
_FACING_COS: Final = 0.85
# Lower surfels are the floor's; level ones a little higher, too: rugs, and floors that drift bent.
_FLOOR_M: Final = 0.04
_LEVEL_FLOOR_M: Final = 0.1
_LEVEL_COS: Final = 0.85
# Surfels this near to the ceiling are the ceiling's, metres; without one, furniture ends here.
_CEILING_M: Final = 0.12
_TALLEST_M: Final = 2.3
# Frames, sills, leaves and curtains reach this far into the room, and beyond the sides of their
# opening, metres.
_BEFORE_OPENING_M: Final = 0.25
_BESIDE_OPENING_M: Final = 0.15


class ShapeSegmenter:
    """Pieces of furniture around their tops and fronts, named where their shape is telling."""

    def segment(self, cloud: Cloud, rooms: Sequence[FoundRoom]) -> Segments:
        """Find the furniture of a scan; see `openrooms_usd.scan.segmentation.contract`."""
        thinned = thin(Cloud(cloud.points), _THINNING_M)
        everything, spacing = surfels(thinned), _spacing(thinned.points)
        rows = np.flatnonzero(contents(everything, rooms))
        found = _furniture(cloud, everything.take(rows), rooms, spacing)
        piece, words = np.zeros(len(everything), dtype=np.int32), {}
        for number, (own, word) in enumerate(found, 1):
            piece[rows[own]], words[number] = number, word
        distance, nearest = KDTree(everything.points).query(
            cloud.points, distance_upper_bound=max(_OF_SURFEL_M, spacing)
        )
        instance = np.append(piece, 0)[np.where(np.isfinite(distance), nearest, len(piece))]
        return Segments(instance.astype(np.int32), words)


def _furniture(
    cloud: Cloud, pieces: Surfels, rooms: Sequence[FoundRoom], spacing: float
) -> Iterator[tuple[Rows, str]]:
    """The surfels of each piece of furniture and its name, the largest first."""
    walls, of_surfel = walls_of(rooms), grouped(pieces, spacing)
    bright = _brightness(cloud, pieces)
    ceiling = min((room.ceiling for room in rooms if room.ceiling is not None), default=np.inf)
    sizes = np.bincount(of_surfel) if len(of_surfel) else np.zeros(0, dtype=np.int64)
    kept = np.zeros(len(pieces), dtype=np.bool_)
    for number in sorted(range(len(sizes)), key=lambda n: -int(sizes[n])):
        if sizes[number] < _MIN_SURFELS:
            return
        rows = np.flatnonzero(of_surfel == number)
        points, normals = pieces.points[rows], pieces.normals[rows]
        shape = shape_of(points, normals, walls, float(np.median(bright[rows])))
        word = named(shape)
        if word != UNNAMED or _is_thing(shape, ceiling, points, pieces.points[kept]):
            kept[rows] = True
            yield rows, word


def _spacing(points: Array) -> float:
    """The usual distance between neighbours, metres: to the fourth nearest on a grid."""
    some = points[:: max(len(points) // _SPACING_SAMPLE, 1)]
    if len(points) <= _NEIGHBOURS:
        return _THINNING_M
    distance: Array = np.asarray(KDTree(points).query(some, _NEIGHBOURS + 1)[0])
    return float(np.median(distance[:, -1]))


def _brightness(cloud: Cloud, pieces: Surfels) -> Array:
    """(M,) of the nearest point's colour, from 0 to 1; NaN without colours."""
    if cloud.colors is None or not len(pieces):
        return np.full(len(pieces), np.nan)
    _, nearest = KDTree(cloud.points).query(pieces.points)
    return np.asarray(cloud.colors[nearest].mean(axis=1) / 255.0)


def _is_thing(shape: SegmentShape, ceiling: float, points: Array, others: Array) -> bool:
    """Whether a piece without a name may be furniture, by its size and its place."""
    long, short, height = shape.size.tolist()
    top, volume = shape.bottom + height, long * short * height
    if (long < _MIN_SIDE_M and height < _MIN_SIDE_M) or volume < _MIN_VOLUME_M3:
        return False
    if long > _MAX_SIDE_M or long * short > _MAX_AREA_M2 or top > ceiling - _BELOW_CEILING_M:
        return False
    if short < _THIN_M or (short < _SHEET_M and height > _TALL_M):
        return False
    if shape.lowest < _HANGS_M:
        return True
    low, high = points.min(axis=0), points.max(axis=0)
    below = (others[:, :2] > low[:2]).all(axis=1) & (others[:, :2] < high[:2]).all(axis=1)
    below &= np.abs(others[:, 2] - shape.lowest) < _BELOW_M
    return volume > _MIN_VOLUME_ON_TOP_M3 and int(below.sum()) >= _MIN_SURFELS_BELOW


def contents(pieces: Surfels, rooms: Sequence[FoundRoom]) -> Mask:
    """(M,) whether surfels belong to things that stand in a room.

    Args:
        pieces: In the level frame: floor at z = 0.
        rooms: In the same frame.
    """
    kept = np.zeros(len(pieces), dtype=np.bool_)
    for room in rooms:
        kept |= _inside(pieces, room)
    level = np.abs(pieces.normals[:, 2]) > _LEVEL_COS
    height = pieces.points[:, 2]
    return np.asarray(kept & (height > np.where(level, _LEVEL_FLOOR_M, _FLOOR_M)))


def _inside(pieces: Surfels, room: FoundRoom) -> Mask:
    """(M,) whether surfels lie in a room, off its walls, its ceiling and its openings."""
    import shapely

    corners = room.corners[:, :2]
    kept: Mask = shapely.contains_xy(shapely.Polygon(corners), pieces.points[:, :2])
    top = _TALLEST_M if room.ceiling is None else room.ceiling - _CEILING_M
    kept &= pieces.points[:, 2] < top
    for number, (start, end) in enumerate(zip(corners, np.roll(corners, -1, axis=0), strict=True)):
        kept &= ~_of_wall(pieces, start, end, [o for o in room.openings if o.wall == number])
    return kept


def _of_wall(pieces: Surfels, start: Array, end: Array, openings: Sequence[FoundOpening]) -> Mask:
    """(M,) whether surfels are a wall's, or those of its openings."""
    length = float(np.linalg.norm(end - start))
    along = (end - start) / max(length, 1e-9)
    inward = np.array([-along[1], along[0]])
    station = (pieces.points[:, :2] - start) @ along
    depth = (pieces.points[:, :2] - start) @ inward
    facing = np.abs(pieces.normals[:, :2] @ inward) > _FACING_COS
    walled = (station > 0.0) & (station < length)
    walled &= depth < np.where(facing, _FACING_WALL_M, _WALL_M)
    for opening in openings:
        across = (opening.corners[:, :2] - start) @ along
        low, high = opening.corners[:, 2].min(), opening.corners[:, 2].max()
        before = (station > across.min() - _BESIDE_OPENING_M) & (depth < _BEFORE_OPENING_M)
        before &= (station < across.max() + _BESIDE_OPENING_M) & (pieces.points[:, 2] > low)
        walled |= before & (pieces.points[:, 2] < high + _BESIDE_OPENING_M)
    return np.asarray(walled)
