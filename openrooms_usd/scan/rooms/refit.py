"""Robust line fits of walls; corners are their intersections."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.scan.rooms.outline import Outline
from openrooms_usd.scan.rooms.walls import FACES_ACROSS_COS, Walls, line_fit

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
