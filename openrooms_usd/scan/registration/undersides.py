"""What an object of a scan may stand on: the floor, level points below it, or another object."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.registration.evidence import Evidence

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# What ends so near above the floor may stand on it, metres: its foot may be hidden.
_HIDDEN_FOOT_M: Final = 0.18
# So much of what stands on the floor may be hidden at most.
_MAX_HIDDEN_SHARE: Final = 0.6
# What something may stand on is so far from where it seems to end and outside its outline, metres.
_SUPPORT_GAP_M: Final = 0.07
_OUTSIDE_OUTLINE_M: Final = 0.05
# Cosine of what is level, and points that are a layer.
_LEVEL_COS: Final = 0.8
_MIN_LAYER_POINTS: Final = 15
# Lower than this nothing but the floor carries, metres.
_MIN_SUPPORT_HEIGHT_M: Final = 0.06
# Of the points of an object so many may be a neighbour's, in a blob of wrong labels.
_NEIGHBOUR_SHARE: Final = 0.1
# What lies below an object ends at this quantile of its heights.
_TOP_QUANTILE: Final = 0.95


def supports(
    cloud: Cloud, rows: NDArray[np.intp], evidence: Evidence, bottom: float | None
) -> tuple[float | None, ...]:
    """Heights on which an object may stand, the likeliest first; None: it hangs, or is unknown.

    Args:
        cloud: Level, floor at z = 0.
        rows: The points of the object.
        evidence: The same without strays.
        bottom: Where it ends by what is known before; None: nothing is.
    """
    low, high = np.quantile(evidence.points, [0.02, 0.98], axis=0)
    below = _below(cloud, rows, low, high, low[2])
    layers = _layers(cloud, rows, evidence, low, high)
    if (low[2] if bottom is None else min(bottom, low[2])) >= _HIDDEN_FOOT_M:
        return (*layers, 0.0) if low[2] < _MAX_HIDDEN_SHARE else layers
    # Only who says what size to expect can tell a thing on another from one whose foot is hidden.
    others = () if bottom is None else (*layers, _stack(cloud, below, low))
    return (
        0.0,
        *[height for height in others if height is not None and height > _MIN_SUPPORT_HEIGHT_M][:1],
    )


def _layers(
    cloud: Cloud, rows: NDArray[np.intp], evidence: Evidence, low: Array, high: Array
) -> tuple[float | None, ...]:
    """What may carry the lowest points, and the rest where these are another thing's."""
    found: list[float | None] = []
    for end in (low[2], *_gone_on(evidence.points[:, 2])):
        below = _below(cloud, rows, low, high, end)
        found.append(_layer(cloud, below, end))
    return tuple(height for k, height in enumerate(found) if k == 0 or height is not None)


def _gone_on(heights: Array) -> list[float]:
    """The height above which points go on, where a few end below a gap."""
    lowest = np.sort(heights)[: 2 + int(_NEIGHBOUR_SHARE * len(heights))]
    row = int(np.diff(lowest).argmax())
    return [float(lowest[row + 1])] if lowest[row + 1] - lowest[row] > _SUPPORT_GAP_M else []


def _below(
    cloud: Cloud, rows: NDArray[np.intp], low: Array, high: Array, end: float
) -> NDArray[np.intp]:
    """The points of others that lie about where an object ends, or lower, within its outline."""
    points = cloud.points
    below = points[:, 2] < end + _SUPPORT_GAP_M
    for k in range(2):
        below &= (points[:, k] > low[k] - _OUTSIDE_OUTLINE_M) & (
            points[:, k] < high[k] + _OUTSIDE_OUTLINE_M
        )
    below[rows] = False
    return np.flatnonzero(below)


def _layer(cloud: Cloud, below: NDArray[np.intp], end: float) -> float | None:
    """The height of level points where an object ends."""
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


def _stack(cloud: Cloud, below: NDArray[np.intp], low: Array) -> float | None:
    """Where another object ends below one; its top may be hidden by what stands on it."""
    if cloud.instance is None:
        return None
    number, counts = np.unique(cloud.instance[below], return_counts=True)
    for instance in number[(number > 0) & (counts >= _MIN_LAYER_POINTS)]:
        heights = cloud.points[below[cloud.instance[below] == instance], 2]
        top = float(np.quantile(heights, _TOP_QUANTILE))
        if abs(top - low[2]) < _SUPPORT_GAP_M and heights.min() < low[2] - _SUPPORT_GAP_M:
            return top
    return None
