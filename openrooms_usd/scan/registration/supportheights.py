"""Support hypotheses of an object: the floor, a horizontal layer below it, or another object."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.planindex import PlanIndex
from openrooms_usd.scan.registration.evidence import Evidence

# An object whose points end this low may stand on the floor with an occluded foot, metres.
_HIDDEN_FOOT_M: Final = 0.18
# An object whose points begin above this cannot stand on the floor, metres.
_MAX_HIDDEN_M: Final = 0.6
# Largest gap between an object and its support, and margin around the object's outline, metres.
_SUPPORT_GAP_M: Final = 0.07
_OUTSIDE_OUTLINE_M: Final = 0.05
# Least vertical component of normals, and least points, of a horizontal layer.
_LEVEL_COS: Final = 0.8
_MIN_LAYER_POINTS: Final = 15
# Lower supports than this are the floor, metres.
_MIN_SUPPORT_HEIGHT_M: Final = 0.06
# Up to this part of an object's points may be a neighbour's with wrong labels.
_NEIGHBOUR_SHARE: Final = 0.1
# The top of an object below is this quantile of its heights.
_TOP_QUANTILE: Final = 0.95


def supports(
    cloud: Cloud, plan: PlanIndex, rows: NDArray[np.intp], evidence: Evidence, bottom: float | None
) -> tuple[float | None, ...]:
    """Heights on which an object may stand, the likeliest first; None: it hangs, or is unknown.

    Args:
        cloud: Level, floor at z = 0.
        plan: Of its points.
        rows: The points of the object.
        evidence: The same without outliers.
        bottom: Its lowest height by a hint; None: there is none.
    """
    low, high = np.quantile(evidence.points, [0.02, 0.98], axis=0)
    below = _below(plan, rows, low, high, low[2])
    layers = _layers(cloud, plan, rows, evidence, low, high)
    if (low[2] if bottom is None else min(bottom, low[2])) >= _HIDDEN_FOOT_M:
        return (*layers, 0.0) if low[2] < _MAX_HIDDEN_M else layers
    # Without a hint of the size, an occluded foot cannot be distinguished from a support.
    others = () if bottom is None else (*layers, _top_below(cloud, below, low))
    return (
        0.0,
        *[height for height in others if height is not None and height > _MIN_SUPPORT_HEIGHT_M][:1],
    )


def _layers(
    cloud: Cloud,
    plan: PlanIndex,
    rows: NDArray[np.intp],
    evidence: Evidence,
    low: Array,
    high: Array,
) -> tuple[float | None, ...]:
    """Layers below the lowest points, and below the rest where these may be outliers."""
    found: list[float | None] = []
    for end in (low[2], *_above_gap(evidence.points[:, 2])):
        below = _below(plan, rows, low, high, end)
        found.append(_layer(cloud, below, end))
    return tuple(height for k, height in enumerate(found) if k == 0 or height is not None)


def _above_gap(heights: Array) -> list[float]:
    """The lowest height above a gap that separates a few lowest points from the rest."""
    lowest = np.sort(heights)[: 2 + int(_NEIGHBOUR_SHARE * len(heights))]
    row = int(np.diff(lowest).argmax())
    return [float(lowest[row + 1])] if lowest[row + 1] - lowest[row] > _SUPPORT_GAP_M else []


def _below(
    plan: PlanIndex, rows: NDArray[np.intp], low: Array, high: Array, end: float
) -> NDArray[np.intp]:
    """Other points within an object's outline and below its end, up to the largest gap."""
    least, most = low[:2] - _OUTSIDE_OUTLINE_M, high[:2] + _OUTSIDE_OUTLINE_M
    near = plan.rows(least, most)
    points = plan.points[near]
    below = (points[:, 2] < end + _SUPPORT_GAP_M) & (points[:, :2] > least).all(axis=1)
    below &= (points[:, :2] < most).all(axis=1)
    return np.setdiff1d(near[below], rows, assume_unique=True)


def _layer(cloud: Cloud, below: NDArray[np.intp], end: float) -> float | None:
    """The height of a horizontal layer where an object ends."""
    rows = below[cloud.points[below, 2] > end - _SUPPORT_GAP_M]
    if cloud.normals is not None:
        rows = rows[cloud.normals[rows, 2] > _LEVEL_COS]
    heights = cloud.points[rows, 2]
    if len(heights) < _MIN_LAYER_POINTS:
        return None
    counts, edges = np.histogram(
        heights, np.arange(end - _SUPPORT_GAP_M, end + _SUPPORT_GAP_M, 0.01)
    )
    middle = float(edges[counts.argmax()] + 0.005)
    return float(np.median(heights[np.abs(heights - middle) < 0.02]))


def _top_below(cloud: Cloud, below: NDArray[np.intp], low: Array) -> float | None:
    """The top of another object below one, of which only the sides may be visible."""
    if cloud.instance is None:
        return None
    number, counts = np.unique(cloud.instance[below], return_counts=True)
    for instance in number[(number > 0) & (counts >= _MIN_LAYER_POINTS)]:
        heights = cloud.points[below[cloud.instance[below] == instance], 2]
        top = float(np.quantile(heights, _TOP_QUANTILE))
        if abs(top - low[2]) < _SUPPORT_GAP_M and heights.min() < low[2] - _SUPPORT_GAP_M:
            return top
    return None
