"""Cleaning (invalid points, duplicates) and voxel-grid downsampling of clouds.

Both sort once: time is nearly linear in the points, memory a few columns of them.
"""

from dataclasses import dataclass, replace
from typing import Any, Final
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Floats, Ints, Mask
from openrooms_usd.scan.points.cloud import Cloud

# Larger coordinates occur in no map projection of the Earth, metres.
_MAX_COORDINATE_M: Final = 1e8
# Up to this part of the points is dropped for invalid normals; if more are, all normals go.
_MAX_LACKING_SHARE: Final = 0.01
# Shorter mean normals average opposite sides of a sheet.
_MIN_MEAN_NORMAL: Final = 1e-3
_MIN_NORMAL: Final = 1e-6
# Of an evened cloud: voxels that are wanted, least points for each on average, and most points of
# one; in how many steps their edge is searched; cells on either side of the origin.
_PIECES: Final = 30_000
_POINTS_EACH: Final = 1.5
_MOST_IN_VOXEL: Final = 10
_HALVINGS: Final = 12
_MOST_CELLS: Final = 1 << 19


@dataclass(frozen=True)
class Cleaned:
    """What was dropped.

    Attributes:
        broken: Points with a coordinate that is not finite or absurdly large.
        duplicates: Points with exactly the coordinates of an earlier one.
        normals: Points with an invalid normal.
        normals_dropped: Whether all normals were dropped for it, instead of these points.
    """

    broken: int
    duplicates: int
    normals: int = 0
    normals_dropped: bool = False

    def notes(self) -> tuple[str, ...]:
        """A sentence for each kind of dropped data."""
        normals = (
            "all normals were dropped" if self.normals_dropped else "their points were dropped"
        )
        counts = (
            (self.broken, "points without finite coordinates were dropped"),
            (self.duplicates, "duplicated points were dropped"),
            (self.normals, f"normals are broken: {normals}"),
        )
        return tuple(f"{count} {what}" for count, what in counts if count)


def clean(cloud: Cloud) -> tuple[Cloud, Cleaned]:
    """Drop points with invalid coordinates, and exact duplicates.

    Args:
        cloud: N points, in the order that the result keeps.

    Returns:
        The cloud, its normals of unit length, and the counts of what was dropped. Of duplicates
        the first stays, with its label.
    """
    placed = np.asarray((np.abs(cloud.points) <= _MAX_COORDINATE_M).all(axis=1))
    whole = cloud if placed.all() else cloud.take(placed)
    first = _first_of_equal(whole.points)
    single = whole if first.all() else whole.take(first)
    straight, broken, dropped = _unit_normals(single)
    return straight, Cleaned(
        broken=len(cloud) - len(whole),
        duplicates=len(whole) - len(single),
        normals=broken,
        normals_dropped=dropped,
    )


def thin(cloud: Cloud, voxel: float) -> Cloud:
    """Voxel-grid downsampling: one point for each occupied voxel, the mean of its points.

    The grid is aligned with the origin, so that a crop of a scan thins as the whole does. Normals,
    colours and confidences are means, labels and instances majorities (the lowest of ties).

    Args:
        cloud: N finite points.
        voxel: Edge length, metres.

    Returns:
        At most N points, in the order of their voxels (x, then y, then z).
    """
    if len(cloud) == 0:
        return cloud
    cells = np.floor(cloud.points / voxel)
    group, first = groups(_keys(cells))
    del cells
    counts = np.bincount(group).astype(np.float64)

    def mean(values: NDArray[Any]) -> Array:
        # Relative to one of the points: no digits are lost far from the origin.
        base = values[0].astype(np.float64)
        sums = [np.bincount(group, values[:, i] - base[i]) for i in range(values.shape[1])]
        means = base + np.column_stack(sums) / counts[:, None]
        return np.where(counts[:, None] == 1.0, values[first], means)

    def vote(values: NDArray[np.int32] | None) -> NDArray[np.int32] | None:
        return None if values is None else majority(group, values)

    colors, confidence, normals = cloud.colors, cloud.confidence, cloud.normals
    return replace(
        cloud,
        points=mean(cloud.points),
        normals=None if normals is None else _mean_normals(mean(normals), normals[first]),
        colors=None if colors is None else np.rint(mean(colors)).astype(np.uint8),
        label=vote(cloud.label),
        instance=vote(cloud.instance),
        confidence=None if confidence is None else mean(confidence[:, None])[:, 0].astype("f4"),
    )


def evened(cloud: Cloud) -> tuple[Ints, float]:
    """Choose points so that equal areas have about as many, however often they were scanned.

    What was chosen of a cloud is kept as long as the cloud is: several steps ask.

    Args:
        cloud: N finite points in any unit.

    Returns:
        (M,) rows, at most `_MOST_IN_VOXEL` of each voxel and none twice, and the voxels' edge: by
        it the scan falls into about `_PIECES`, or fewer where it has not points enough.
    """
    if cloud not in _EVENED:
        _EVENED[cloud] = _evened(cloud.points)
    return _EVENED[cloud]


_EVENED: Final[WeakKeyDictionary[Cloud, tuple[Ints, float]]] = WeakKeyDictionary()


def _evened(points: Array) -> tuple[Ints, float]:
    rows = np.flatnonzero(_first_of_equal(points))
    single = points[rows]
    some = single[:: max(len(single) // (_MOST_IN_VOXEL * _PIECES), 1)]
    origin, end = np.percentile(some, (5.0, 95.0), axis=0)
    size, whole = float((end - origin).max()), float(np.ptp(some, axis=0).max())
    if not whole > 0.0:
        return rows, 0.0

    def are_many(voxel: float) -> bool:
        counts = np.unique(_clipped_keys(some - origin, voxel), return_counts=True)[1]
        points = int(np.minimum(counts, _MOST_IN_VOXEL).sum())
        return len(counts) > min(_PIECES, int(points / _POINTS_EACH))

    size = size or 1e-9 * whole
    fine, coarse = size / 2000.0, size / 5.0
    # What most points span may be but a small thing.
    while coarse < whole and are_many(coarse):
        fine, coarse = coarse, 400.0 * coarse
    for _ in range(_HALVINGS):
        voxel = float(np.sqrt(fine * coarse))
        fine, coarse = (voxel, coarse) if are_many(voxel) else (fine, voxel)
    voxel = float(np.sqrt(fine * coarse))
    group, _ = groups(_clipped_keys(single - origin, voxel))
    order = np.argsort(group, kind="stable")
    counts = np.bincount(group)
    place = np.arange(len(single)) - np.repeat(np.cumsum(counts) - counts, counts)
    step = np.repeat(-(-counts // _MOST_IN_VOXEL), counts)
    return rows[np.sort(order[place % step == 0])], voxel


def _clipped_keys(offsets: Array, voxel: float) -> Ints:
    """(N,) the cell of each point; outliers far beyond the others share some."""
    cells = np.floor(offsets / voxel).clip(-_MOST_CELLS, _MOST_CELLS - 1).astype(np.int64)
    return np.asarray(cells @ (2 * _MOST_CELLS) ** np.arange(3))


def _keys(cells: Array) -> Ints:
    """(N,) sort keys of integer cells (N, 3): by x, then y, then z."""
    cells = cells - cells.min(axis=0)
    spans = [int(span) + 1 for span in cells.max(axis=0)]
    if spans[0] * spans[1] * spans[2] < 2**63:
        x, y, z = (cells[:, axis].astype(np.int64) for axis in range(3))
        return np.asarray((x * spans[1] + y) * spans[2] + z)
    # Far outliers would overflow the key: ranks of the occupied cells instead.
    key = _ranks(cells[:, 0])
    for axis in (1, 2):
        rank = _ranks(cells[:, axis])
        key = _ranks(key * (int(rank.max()) + 1) + rank)
    return key


def _ranks(values: NDArray[Any]) -> Ints:
    return np.unique(values, return_inverse=True)[1].astype(np.int64).reshape(-1)


def groups(keys: Ints) -> tuple[Ints, Ints]:
    """(N,) the group of each key, in the order of the keys, and (G,) the first row of each."""
    order = np.argsort(keys, kind="stable")
    ordered = keys[order]
    starts = np.concatenate([[True], ordered[1:] != ordered[:-1]])
    group = np.empty(len(keys), np.int64)
    group[order] = np.cumsum(starts) - 1
    return group, order[starts]


def majority(group: Ints, values: NDArray[np.int32]) -> NDArray[np.int32]:
    """(G,) the most frequent value of each group 0..G-1; the lowest of ties."""
    low = int(values.min())
    span = int(values.max()) - low + 1
    pairs, votes = np.unique(group * span + (values - np.int64(low)), return_counts=True)
    owner = pairs // span
    best = np.lexsort((pairs, -votes, owner))
    leads = np.concatenate([[True], owner[best][1:] != owner[best][:-1]])
    return np.asarray(pairs[best[leads]] % span + low, dtype=np.int32)


def _mean_normals(mean: Array, first: Floats) -> Floats:
    length = np.linalg.norm(mean, axis=1, keepdims=True)
    decided = length > _MIN_MEAN_NORMAL
    return np.where(decided, mean / np.where(decided, length, 1.0), first).astype(np.float32)


def _first_of_equal(points: Array) -> Mask:
    """(N,) whether no earlier point has exactly the same coordinates."""
    first = np.ones(len(points), bool)
    if len(points) < 2:
        return first
    mixed = _hashed(points)
    order = np.argsort(mixed, kind="stable")
    earlier, later = order[:-1], order[1:]
    near = mixed[earlier] == mixed[later]
    earlier, later = earlier[near], later[near]
    first[later[(points[earlier] == points[later]).all(axis=1)]] = False
    return first


def _hashed(points: Array) -> NDArray[np.uint64]:
    """(N,) a hash of each point's coordinates (Fibonacci hashing)."""
    mixed = np.zeros(len(points), np.uint64)
    for axis in range(3):
        bits = (points[:, axis] + 0.0).view(np.uint64)  # -0.0 becomes 0.0
        mixed ^= bits
        mixed *= np.uint64(0x9E3779B97F4A7C15)
        mixed ^= mixed >> np.uint64(29)
    return mixed


def _unit_normals(cloud: Cloud) -> tuple[Cloud, int, bool]:
    """Normals scaled to unit length; few invalid ones drop their points, many drop all normals."""
    if cloud.normals is None:
        return cloud, 0, False
    length = np.linalg.norm(cloud.normals, axis=1)
    good = np.isfinite(length) & (length > _MIN_NORMAL)
    broken = len(cloud) - int(good.sum())
    if broken > _MAX_LACKING_SHARE * len(cloud):
        return replace(cloud, normals=None), broken, True
    kept = cloud if broken == 0 else cloud.take(good)
    assert kept.normals is not None
    unit = kept.normals / length[good][:, None]
    return replace(kept, normals=unit.astype(np.float32)), broken, False
