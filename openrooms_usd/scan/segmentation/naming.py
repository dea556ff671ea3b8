"""Names pieces of furniture by shape and size: a name only where the evidence is good.

The lengths are those of furniture as it is made (as the library's own ranges are): seats are 40 to
50 cm high and beds and tables hardly vary, because people do not. What fits no row stays a thing
of its size without a name.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from openrooms_usd.arrays import Ints
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.thinning import groups, majority
from openrooms_usd.scan.segmentation.shape import SegmentShape

UNNAMED: Final = "object"

Range = tuple[float, float]
_AT_WALL_M: Final = 0.25
_TOUCHES_M: Final = 0.15


class _Row(NamedTuple):
    """What a category looks like; lengths in metres.

    Attributes:
        word: The category.
        long: Its longer level side.
        short: Its shorter one.
        height: From the floor to its highest point.
        shows: What else must be seen.
    """

    word: str
    long: Range
    short: Range
    height: Range
    shows: Callable[[SegmentShape], bool]


def named(shape: SegmentShape) -> str:
    """The category of a piece; `UNNAMED` where nothing is likely enough."""
    measured = (shape.long, shape.short, shape.height)
    for row in _ROWS:
        ranges = (row.long, row.short, row.height)
        fits = all(low <= v <= high for v, (low, high) in zip(measured, ranges, strict=True))
        if fits and row.shows(shape):
            return row.word
    return UNNAMED


def _stands(shape: SegmentShape) -> bool:
    return shape.bottom == 0.0


def _seats(shape: SegmentShape, share: float) -> bool:
    return shape.seat[1] >= share


def _backed(shape: SegmentShape, part: float, wide: float) -> bool:
    found = shape.backed
    return found[0] >= part and found[1] >= wide


def _sofa(shape: SegmentShape) -> bool:
    return (
        _stands(shape)
        and _seats(shape, 0.12)
        and _backed(shape, 0.6, 0.75)
        and shape.backed[2] > 0.0
        and shape.closed(0.1, shape.seat[0]) > 0.35
    )


def _armchair(shape: SegmentShape) -> bool:
    return (
        _stands(shape)
        and _seats(shape, 0.25)
        and _backed(shape, 0.55, 0.7)
        and shape.closed(0.1, shape.seat[0]) > 0.55
    )


def _toilet(shape: SegmentShape) -> bool:
    at_its_end = shape.backed[2] == 0.0
    return (
        _stands(shape)
        and _seats(shape, 0.3)
        and _backed(shape, 0.7, 0.7)
        and at_its_end
        and _solid_below(shape)
        and shape.to_wall < _TOUCHES_M
        and not shape.brightness < 0.5
    )


def _solid_below(shape: SegmentShape) -> bool:
    return shape.closed(0.1, shape.seat[0] - 0.05) > 0.75


def _chair(shape: SegmentShape) -> bool:
    square = shape.long < 1.4 * shape.short
    narrow = shape.short < 0.5
    return (
        _stands(shape)
        and square
        and _seats(shape, 0.2)
        and _backed(shape, 0.7, 0.75)
        and not (narrow and _solid_below(shape))
    )


def _bed(shape: SegmentShape) -> bool:
    height, share = shape.top
    if not _stands(shape) or share < 0.5:
        return False
    wide = shape.short > 1.1 and shape.closed(0.1, height) > 0.6
    return 0.25 <= height <= (0.85 if wide else 0.65)


def _table(shape: SegmentShape) -> bool:
    height, share = shape.top
    return (
        _stands(shape)
        and 0.62 <= height <= 0.82
        and share >= 0.55
        and shape.height - height < 0.12
        and shape.closed(0.1, height - 0.12) < 0.5
    )


def _low_table(shape: SegmentShape) -> bool:
    height, share = shape.top
    return (
        _stands(shape)
        and share >= 0.6
        and shape.height - height < 0.08
        and shape.closed(0.08, height - 0.08) < 0.5
        and shape.to_wall > _AT_WALL_M
    )


def _desk(shape: SegmentShape) -> bool:
    return _table(shape) and shape.to_wall < _AT_WALL_M


def _cabinet(shape: SegmentShape) -> bool:
    # Desks are as high, and what stands below them closes their sides.
    like_desk = 0.66 < shape.height < 0.82
    return (
        _stands(shape)
        and shape.to_wall < _AT_WALL_M
        and shape.closed(0.15, shape.height - 0.08) > (0.85 if like_desk else 0.6)
    )


def _bookshelf(shape: SegmentShape) -> bool:
    boards = [height for height, share in shape.layers if share > 0.25]
    return _stands(shape) and shape.to_wall < _AT_WALL_M and len(boards) >= 3


# The first that fits.
_ROWS: Final = (
    _Row("sofa", (1.2, 3.6), (0.65, 1.15), (0.55, 1.2), _sofa),
    _Row("bed", (1.75, 2.4), (0.8, 2.3), (0.3, 1.5), _bed),
    _Row("sofa", (1.2, 3.6), (0.65, 2.6), (0.55, 1.2), _sofa),
    _Row("armchair", (0.65, 1.15), (0.6, 1.1), (0.6, 1.25), _armchair),
    _Row("toilet", (0.5, 0.85), (0.3, 0.5), (0.6, 1.0), _toilet),
    _Row("chair", (0.38, 0.8), (0.33, 0.75), (0.65, 1.25), _chair),
    _Row("desk", (0.9, 2.2), (0.45, 0.9), (0.62, 0.85), _desk),
    _Row("table", (0.6, 3.5), (0.5, 1.6), (0.62, 0.85), _table),
    _Row("coffee_table", (0.6, 1.6), (0.4, 1.1), (0.3, 0.55), _low_table),
    _Row("bookshelf", (0.5, 6.0), (0.15, 0.5), (0.8, 2.5), _bookshelf),
    _Row("wardrobe", (0.95, 4.0), (0.45, 0.75), (1.6, 2.6), _cabinet),
    _Row("cabinet", (0.7, 4.0), (0.3, 0.65), (0.55, 1.3), _cabinet),
)


# Clouds whose points are labelled, in words or by class, but not told apart into things.

# Parts of one label that are farther apart than this are different things, metres. Parts with fewer
# points of the thinned cloud are ignored.
_APART_M: Final = 0.1
_THINNING_M: Final = 0.03
_MIN_PLACES: Final = 30
# Classes of NYU40 that are the room's, and the class of what has none.
SHELL_CLASSES: Final = {"wall": 1, "floor": 2, "door": 8, "window": 9, "ceiling": 22}
_OTHER_PROP: Final = 40


def with_labels(cloud: Cloud, labels: Sequence[str]) -> Cloud:
    """A cloud whose points have a word each.

    Points of the room itself (wall, floor, ceiling, door, window) get that class. What else has a
    word belongs to a thing: to that of its number where the cloud has numbers, else to a connected
    part of its word. A thing has the word that most of its points have.
    """
    plain = [label.strip().lower().replace("_", " ") for label in labels]
    names, of_point = np.unique(np.array(plain), return_inverse=True)
    room = np.array([SHELL_CLASSES.get(str(name), 0) for name in names], dtype=np.int32)
    thing = np.array([bool(name) and str(name) not in SHELL_CLASSES for name in names])
    label = np.where(thing, _OTHER_PROP, room).astype(np.int32)[of_point]
    instance = cloud.instance
    if instance is None or not instance.any():
        instance = things_of(cloud, np.where(thing[of_point], of_point + 1, 0))
    rows = np.flatnonzero(instance > 0)
    group, first = groups(instance[rows].astype(np.int64))
    best = majority(group, of_point[rows].astype(np.int32))
    numbers = instance[rows][first].tolist()
    words = {
        number: (str(names[row]),)
        for number, row in zip(numbers, best.tolist(), strict=True)
        if names[row]
    }
    return replace(cloud, label=label, instance=instance, words=words)


def things_of(cloud: Cloud, kind: Ints) -> NDArray[np.int32]:
    """(N,) numbers of things, from 1: connected parts of points of one kind; 0 where there is none.

    Args:
        cloud: N points, metres.
        kind: (N,) of each point; 0 where it belongs to no thing.
    """
    found, count = np.zeros(len(cloud), dtype=np.int32), 0
    for number in np.unique(kind[kind > 0]):
        rows = np.flatnonzero(kind == number)
        cells = np.floor(cloud.points[rows] / _THINNING_M).astype(np.int64)
        places, place = np.unique(cells, axis=0, return_inverse=True)
        pairs = KDTree(places * _THINNING_M).query_pairs(_APART_M, output_type="ndarray")
        graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(places),) * 2)
        _, part = connected_components(graph, directed=False)
        large = np.flatnonzero(np.bincount(part) >= _MIN_PLACES)
        order = np.zeros(int(part.max()) + 1, dtype=np.int32)
        order[large] = np.arange(len(large)) + count + 1
        found[rows] = order[part][place.reshape(-1)]
        count += len(large)
    return found
