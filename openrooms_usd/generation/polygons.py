"""Floor plans: rectangles, and rectangles with corners cut out, cut off or pulled aslant."""

from collections.abc import Callable
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array

# No arm of a room is narrower than this, metres.
MIN_ARM_WIDTH_M: Final = 1.7
_MAX_TRIES: Final = 12

Points = list[tuple[float, float]]


def floor_plan(
    rng: np.random.Generator, area: float, aspect: tuple[float, float], shapes: dict[str, float]
) -> Array:
    """Draw a polygon.

    Args:
        rng: Draws it.
        area: Square metres.
        aspect: Range of the longer side over the shorter one.
        shapes: How often each of `SHAPES` is drawn.

    Returns:
        (N, 2) corners, counter-clockwise, to the centimetre, its bounding box beginning in the
        origin. Its area is the wanted one but for rounding.
    """
    names = list(shapes)
    weights = np.array([shapes[name] for name in names])
    for attempt in range(_MAX_TRIES):
        ratio = float(rng.uniform(*aspect))
        name = names[int(rng.choice(len(names), p=weights / weights.sum()))]
        if attempt == _MAX_TRIES - 1:
            name = "rectangle"
        corners = np.array(SHAPES[name](rng, ratio))
        scale = np.sqrt(area / _area(corners))
        if _arm(name, corners, scale) >= min(MIN_ARM_WIDTH_M, 0.8 * float(np.sqrt(area / ratio))):
            break
    return _turned(rng, corners * scale)


def _rectangle(rng: np.random.Generator, ratio: float) -> Points:
    return [(0.0, 0.0), (ratio, 0.0), (ratio, 1.0), (0.0, 1.0)]


def _ell(rng: np.random.Generator, ratio: float) -> Points:
    """One corner is missing."""
    x, y = ratio * rng.uniform(0.45, 0.7), rng.uniform(0.45, 0.7)
    return [(0.0, 0.0), (ratio, 0.0), (ratio, y), (x, y), (x, 1.0), (0.0, 1.0)]


def _tee(rng: np.random.Generator, ratio: float) -> Points:
    """Two corners of one side are missing."""
    a, b, y = ratio * rng.uniform(0.15, 0.3), ratio * rng.uniform(0.7, 0.85), rng.uniform(0.5, 0.7)
    return [(0.0, 0.0), (ratio, 0.0), (ratio, y), (b, y), (b, 1.0), (a, 1.0), (a, y), (0.0, y)]


def _you(rng: np.random.Generator, ratio: float) -> Points:
    """A piece is missing in the middle of one side."""
    a, b, y = ratio * rng.uniform(0.34, 0.4), ratio * rng.uniform(0.58, 0.66), rng.uniform(0.6, 0.8)
    return [(0.0, 0.0), (ratio, 0.0), (ratio, 1.0), (b, 1.0), (b, y), (a, y), (a, 1.0), (0.0, 1.0)]


def _chamfer(rng: np.random.Generator, ratio: float) -> Points:
    """One corner is cut off."""
    x, y = ratio - rng.uniform(0.2, 0.35), rng.uniform(0.65, 0.8)
    return [(0.0, 0.0), (ratio, 0.0), (ratio, y), (x, 1.0), (0.0, 1.0)]


def _slant(rng: np.random.Generator, ratio: float) -> Points:
    """One wall runs aslant."""
    return [(0.0, 0.0), (ratio, 0.0), (ratio * rng.uniform(0.78, 0.92), 1.0), (0.0, 1.0)]


SHAPES: Final[dict[str, Callable[[np.random.Generator, float], Points]]] = {
    "rectangle": _rectangle,
    "L": _ell,
    "T": _tee,
    "U": _you,
    "chamfer": _chamfer,
    "slant": _slant,
}


def _area(corners: Array) -> float:
    x, y = corners.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def _arm(name: str, corners: Array, scale: float) -> float:
    """Width of the narrowest arm, metres."""
    width, depth = (float(side) * scale for side in corners.max(axis=0))
    if name in ("rectangle", "chamfer", "slant"):
        return float(min(0.75 * width, depth))
    steps = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1) * scale
    if name == "T":
        return float(min(corners[2, 1] * scale, steps[4]))
    if name == "U":
        return float(min(steps[2], steps[6], corners[4, 1] * scale))
    return float(min(steps[1], steps[4]))


def _turned(rng: np.random.Generator, corners: Array) -> Array:
    """Mirror a polygon and turn it by quarters, and move it to the origin."""
    if rng.random() < 0.5:
        corners = (corners * [-1.0, 1.0])[::-1]
    if rng.random() < 0.5:
        corners = corners[:, ::-1][::-1]
    corners = corners - corners.min(axis=0)
    return np.asarray(corners.round(2) + 0.0)
