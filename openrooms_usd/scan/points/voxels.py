"""A sparse voxel grid that accumulates weighted observations in bounded memory."""

from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Bytes, Floats, Ints
from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.thinning import groups, majority

Columns = dict[str, NDArray[Any]]

# A key packs three cell indices of 21 bits; the origin is in the middle of their range.
_CELL_BITS: Final = 21
_ORIGIN_CELL: Final = 1 << (_CELL_BITS - 1)
_MASK: Final = (1 << _CELL_BITS) - 1
# Memory of a voxel: a row of `Table`, in so many copies while rows are merged.
_ROW_BYTES: Final = 88
_MERGE_COPIES: Final = 4
# The grid has a corner at the origin: however large voxels are, at least eight remain.
_OCTANTS: Final = 8


@dataclass(frozen=True, eq=False)
class Samples:
    """Points of one observation.

    Attributes:
        points: (N, 3) metres.
        weights: (N,) inverse variances, per square metre.
        views: (N, 3) unit directions from the point to the sensor.
        label: (N,) classes; 0 where there is none.
        instance: (N,) instance numbers; 0 where there is none.
        colors: (N, 3) from 0 to 255.
    """

    points: Array
    weights: Array
    views: Array
    label: NDArray[np.integer[Any]] | None = None
    instance: NDArray[np.integer[Any]] | None = None
    colors: Bytes | None = None


@dataclass(frozen=True, eq=False)
class Table:
    """A row a voxel, ascending by key; sums are weighted.

    Attributes:
        key: (M,) its packed cell indices.
        origin: (3,) of the positions, metres.
        weight: (M,) the sum of the observations' weights.
        place: (M, 3) the sum of positions.
        views: (M, 3) the sum of directions to the sensors.
        color: (M, 3) the sum of colours.
        color_weight: (M,) the weight of those observations that had colours.
        label: (M,) the class with the most votes.
        label_votes: (M,) its lead over the second, in votes.
        instance: (M,) the instance with the most votes.
        instance_votes: (M,) its lead over the second, in votes.
        seen: (M,) the number of observations.
    """

    key: Ints
    origin: Array
    weight: Array
    place: Array
    views: Floats
    color: Floats
    color_weight: Floats
    label: NDArray[np.int32]
    label_votes: Floats
    instance: NDArray[np.int32]
    instance_votes: Floats
    seen: NDArray[np.int32]

    def points(self) -> Array:
        """(M, 3) weighted means."""
        return self.place / self.weight[:, None] + self.origin

    def colors_seen(self) -> Bytes:
        """(M, 3) weighted means; black where no observation had colours."""
        weight = np.where(self.color_weight > 0.0, self.color_weight, 1.0)
        return np.rint(self.color / weight[:, None]).clip(0.0, 255.0).astype(np.uint8)


_SUMS: Final = ("weight", "place", "views", "color", "color_weight", "seen")
_VOTES: Final = ("label", "instance")
_COLUMNS: Final = tuple(field.name for field in fields(Table) if field.name != "origin")


class VoxelSums:
    """Accumulates observations; the voxel size doubles where memory would run out.

    Args:
        voxel: Initial edge length, metres.
        memory: Limit of all rows while they are merged, bytes. One observation comes on top.
    """

    def __init__(self, voxel: float, memory: int) -> None:
        self.voxel = voxel
        self.has_colors = self.has_label = self.has_instance = False
        self._most = max(memory // (_ROW_BYTES * _MERGE_COPIES), _OCTANTS)
        self._origin: Array | None = None
        self._rows: list[Columns] = [_no_rows()]

    def add(self, samples: Samples) -> None:
        """Add one observation, which counts once a voxel, however many points it has there.

        Raises:
            InputError: It lies a million voxels away from the first one.
        """
        self.has_colors |= samples.colors is not None
        self.has_label |= samples.label is not None
        self.has_instance |= samples.instance is not None
        if len(samples.points) == 0:
            return
        if self._origin is None:
            self._origin = np.rint(samples.points.mean(axis=0))
        self._rows.append(_observed(samples, self._origin, self.voxel))
        if sum(len(rows["key"]) for rows in self._rows[1:]) > self._most // _MERGE_COPIES:
            self._merge()

    def merged(self) -> Table:
        """All voxels so far."""
        self._merge()
        origin = np.zeros(3) if self._origin is None else self._origin
        return Table(origin=origin, **self._rows[0])

    def _merge(self) -> None:
        if len(self._rows) > 1:
            joined = {
                name: np.concatenate([rows[name] for rows in self._rows]) for name in _COLUMNS
            }
            self._rows = [_by_key(joined)]
        while len(self._rows[0]["key"]) > self._most:
            self.voxel *= 2.0
            coarse = dict(self._rows[0])
            coarse["key"] = _coarser(coarse["key"])
            self._rows = [_by_key(coarse)]


def _no_rows() -> Columns:
    kinds = {"key": "i8", "weight": "f8", "place": "f8", "label": "i4", "instance": "i4"}
    kinds["seen"] = "i4"
    wide = ("place", "views", "color")
    return {n: np.zeros((0, 3) if n in wide else 0, kinds.get(n, "f4")) for n in _COLUMNS}


def _observed(samples: Samples, origin: Array, voxel: float) -> Columns:
    """The rows of one observation: mean of each voxel's points, times their mean weight."""
    local = samples.points - origin
    group, first = groups(keys := _keys(local, voxel))
    count: Array = np.bincount(group).astype(np.float64)
    total = np.bincount(group, samples.weights)
    weight = total / count

    def mean(values: NDArray[Any], weights: Array | float, norm: NDArray[Any]) -> Array:
        sums = [np.bincount(group, weights * values[:, axis]) for axis in range(3)]
        return np.asarray(np.column_stack(sums) / norm[:, None] * weight[:, None])

    empty = np.zeros((len(first), 3), np.float32)
    colors = samples.colors
    rows: Columns = {
        "key": keys[first],
        "weight": weight,
        "place": mean(local, samples.weights, total),
        "views": mean(samples.views, 1.0, count).astype(np.float32),
        "color": empty if colors is None else mean(colors, 1.0, count).astype(np.float32),
        "color_weight": (weight if colors is not None else 0.0 * weight).astype(np.float32),
        "seen": np.ones(len(first), np.int32),
    }
    for name in _VOTES:
        given = getattr(samples, name)
        best = majority(group, given.astype(np.int32)) if given is not None else 0
        rows[name] = np.broadcast_to(best, len(first)).astype(np.int32)
        rows[f"{name}_votes"] = (rows[name] != 0).astype(np.float32)
    return rows


def _keys(local: Array, voxel: float) -> Ints:
    cells = np.floor(local / voxel) + _ORIGIN_CELL
    if cells.min() < 0 or cells.max() > _MASK:
        raise InputError(
            f"the camera's path reaches more than {_ORIGIN_CELL * voxel / 1000:.0f} km",
            remedy="check the unit of the poses: metres are expected",
        )
    x, y, z = (cells[:, axis].astype(np.int64) for axis in range(3))
    return np.asarray((x << 2 * _CELL_BITS) | (y << _CELL_BITS) | z)


def _coarser(key: Ints) -> Ints:
    """The keys of voxels of twice the size."""
    halves = [((key >> shift & _MASK) >> 1) + _ORIGIN_CELL // 2 << shift for shift in (42, 21, 0)]
    return np.asarray(halves[0] | halves[1] | halves[2])


def _by_key(rows: Columns) -> Columns:
    """Rows of equal keys merged, ascending by key."""
    order = np.argsort(rows["key"], kind="stable")
    ordered = rows["key"][order]
    starts = np.flatnonzero(np.concatenate([[True], ordered[1:] != ordered[:-1]])[: len(ordered)])
    if len(starts) == 0:
        return rows
    merged: Columns = {"key": ordered[starts]}
    for name in _SUMS:
        merged[name] = np.add.reduceat(rows[name][order], starts, axis=0)
    owner = np.empty(len(order), np.int64)
    owner[order] = np.repeat(np.arange(len(starts)), np.diff(starts, append=len(order)))
    for name in _VOTES:
        votes = rows[f"{name}_votes"]
        merged[name], merged[f"{name}_votes"] = _majorities(owner, rows[name], votes, len(starts))
    return merged


def _majorities(
    owner: Ints, numbers: NDArray[np.int32], votes: Floats, count: int
) -> tuple[NDArray[np.int32], Floats]:
    """The number that leads in each voxel, and by how many votes.

    A number with more than half of all votes leads in the end, in whatever order they come (Misra
    and Gries, "Finding repeated elements", 1982).
    """
    best, lead = np.zeros(count, np.int32), np.zeros(count, np.float32)
    rows = np.flatnonzero(numbers)
    if len(rows) == 0:
        return best, lead
    low = int(numbers[rows].min())
    span = int(numbers[rows].max()) - low + 1
    pairs, place = np.unique(owner[rows] * span + (numbers[rows] - low), return_inverse=True)
    total = np.bincount(place.reshape(-1), votes[rows])
    voxel = pairs // span
    order = np.lexsort((pairs, -total, voxel))
    voxel, total, pairs = voxel[order], total[order], pairs[order]
    leads = np.flatnonzero(np.concatenate([[True], voxel[1:] != voxel[:-1]]))
    follows = np.minimum(leads + 1, len(voxel) - 1)
    second = np.where(voxel[follows] == voxel[leads], total[follows], 0.0)
    second[follows == leads] = 0.0
    best[voxel[leads]] = pairs[leads] % span + low
    lead[voxel[leads]] = total[leads] - second
    return best, lead
