"""Standing on something: is its top level and free where a thing shall stand."""

import numpy as np

from openrooms_usd.furniture import Size
from openrooms_usd.generation.boxes import Array, Pose, box
from openrooms_usd.generation.shapes import Foot, Shape

# What rises less than this above a top is no obstacle on it, metres.
_ROUNDING = 1e-4


def level_top(support: Shape, size: Size, foot: Foot, pose: Pose, slack: float) -> float | None:
    """Height of a support's top above its base where an item shall stand.

    Args:
        support: What carries it.
        size: Of the item, metres: nothing of the support may rise into its box.
        foot: What the item stands on, in its own frame.
        pose: Of the item, in the support's frame.
        slack: How far below its middle the top may fall away under the foot, metres.

    Returns:
        None where the top is not level, too small or not free.
    """
    x, y, yaw = pose
    middle = float(support.tops(np.array([x]), np.array([y]))[0])
    if middle == -np.inf:
        return None  # beside it, or over a hole
    below = support.tops(*_grid(foot, pose))
    half = (0.5 * size[0], 0.5 * size[1])
    above = support.tops(*_grid((-half[0], -half[1], *half), pose))
    # Thin rims slip through a grid, but not their corners.
    highest = support.highest(box(x, y, size[0], size[1], 0.0, 0.0, yaw))
    if max(below.max(), above.max(), highest) > middle + _ROUNDING:
        return None
    return None if below.min() < middle - slack else middle


def above_foot(foot: Foot, x: float, y: float, yaw: float) -> tuple[float, float]:
    """Where an item stands whose foot has its middle at a place; to the millimetre."""
    u, v = 0.5 * (foot[0] + foot[2]), 0.5 * (foot[1] + foot[3])
    c, s = float(np.cos(np.radians(yaw))), float(np.sin(np.radians(yaw)))
    return round(x - c * u + s * v, 3), round(y - s * u - c * v, 3)


def _grid(area: Foot, pose: Pose) -> tuple[Array, Array]:
    """Places on a 5 by 5 grid over an area of an item that stands at a pose."""
    x, y, yaw = pose
    u, v = np.meshgrid(np.linspace(area[0], area[2], 5), np.linspace(area[1], area[3], 5))
    c, s = np.cos(np.radians(yaw)), np.sin(np.radians(yaw))
    return x + c * u.ravel() - s * v.ravel(), y + s * u.ravel() + c * v.ravel()
