"""Walls moved to where their points lie: robust line fits, corners where they meet."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.rooms.outline import Outline
from openrooms_usd.scan.rooms.walls import FACES_ACROSS_COS, Walls, line_fit

Array = NDArray[np.float64]

# Where a wall's points may lie from its first place, metres.
_SEARCH_M: Final = 0.08
# The fit looks at what is within these distances, one after the other, metres.
_REACHES_M: Final = (0.08, 0.06, 0.045)
_REWEIGHTING_ROUNDS: Final = 8
_COLUMN_M: Final = 0.1  # of the columns that count alike, metres
_MIN_WEIGHT: Final = 20.0
# Shorter walls keep the direction of their first place, metres.
_MIN_TURNING_WALL_M: Final = 0.6
# Walls of which a smaller part was seen keep it as well: strays and furniture would turn them.
_MIN_SEEN_SHARE: Final = 0.25
# A wall turns to a prevailing direction that it misses by less, degrees.
_SNAP_DEG: Final = 1.5


@dataclass(frozen=True, eq=False)
class _Evidence:
    """The pieces near one wall, weighted so that every ten centimetres of it count alike.

    Attributes:
        points: (P, 2) metres.
        weight: (P,) of each.
        whole: How long the wall is, metres.
        length: Along how much of it the pieces stand, metres.
    """

    points: Array
    weight: Array
    whole: float
    length: float


def refitted(outline: Outline, walls: Walls, directions: tuple[float, ...]) -> Outline:
    """Move every wall to where its points lie, and turn it along them.

    Each is fitted by reweighted least squares to the upright pieces near it. Walls that miss a
    prevailing direction by less than 1.5 degrees share the mean direction of those that do.

    Args:
        outline: Its walls lie within 8 cm of their place.
        walls: The evidence.
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
    """(2,) the normal of the line through the pieces, fitted within ever smaller reaches."""
    fitted, shift = normal, offset
    for reach in _REACHES_M:
        across = seen.points @ fitted
        shift = _mode(across, seen.weight, shift, reach)
        kernel = seen.weight * _bell((across - shift) / reach)
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
    """The mean shift of a place to the middle of the weighted offsets around it."""
    for _ in range(_REWEIGHTING_ROUNDS):
        kernel = weight * _bell((offsets - place) / reach)
        if kernel.sum() <= 0.0:
            break
        place = float((kernel * offsets).sum() / kernel.sum())
    return place


def _bell(ratio: Array) -> Array:
    """Tukey's biweight."""
    return np.clip(1.0 - ratio**2, 0.0, None) ** 2


def _snapped(normals: Array, lengths: Array, directions: tuple[float, ...]) -> Array:
    """(N, 2) normals, those near a direction turned to the mean of those near it."""
    angles = np.rad2deg(np.arctan2(normals[:, 1], normals[:, 0]))
    free = np.ones(len(angles), bool)
    for direction in directions:
        off = (angles - direction + 45.0) % 90.0 - 45.0
        near = free & (np.abs(off) < _SNAP_DEG)
        # The error of a wall's direction falls with its length.
        weight = np.where(lengths > _MIN_TURNING_WALL_M, lengths, 0.0) ** 2
        total = float(weight[near].sum())
        mean = float((weight * off)[near].sum()) / total if total > 0.0 else 0.0
        angles = np.where(near, angles - off + mean, angles)
        free &= ~near
    return np.column_stack([np.cos(np.deg2rad(angles)), np.sin(np.deg2rad(angles))])
