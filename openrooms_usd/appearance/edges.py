"""Edges of a photograph, edges of a render's geometry, and how many of them meet.

An edge of geometry meets one of the photograph that is near and has about its direction. Pictures
are full of edges, so that some meet by chance: the same count for a render that is shifted says how
many. The photograph's edges are ridges of the gradient (Canny, 1986).
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Mask

# A step of depth, relative; along a plane the second difference of 1 / depth is zero.
_DEPTH_STEP_SHARE: Final = 0.05
_CREASE_DEG: Final = 30.0
# Pixels of the photograph with the strongest gradients, among which ridges are looked for; weaker
# ones than this are noise, of a luma from 0 to 1 per pixel.
_STRONG_SHARE: Final = 0.12
_MIN_GRADIENT: Final = 0.01
_BLUR_PIXELS: Final = 1.2
# Directions are compared in so many bins of half a turn, each with its two neighbours.
BINS: Final = 12
# How far edges may be apart, of the picture's diagonal.
_NEAR_SHARE: Final = 0.01
# Matches by chance are measured by shifting the render by this part of the picture.
_SHIFT_SHARE: Final = 1.0 / 6.0
_LUMA: Final = (0.2126, 0.7152, 0.0722)


@dataclass(frozen=True, eq=False)
class EdgeMap:
    """Edges of a picture.

    Attributes:
        mask: (H, W) where edges are.
        bins: (H, W) their directions: which part of half a turn.
    """

    mask: Mask
    bins: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class EdgeMatch:
    """How many edges of a render meet an edge of the photograph.

    Attributes:
        share: Of the render's edges.
        chance: The same where the render is shifted.
        met: (H, W) which.
    """

    share: float
    chance: float
    met: Mask

    def as_dict(self) -> dict[str, float]:
        """With four digits."""
        return {"met": round(self.share, 4), "met_by_chance": round(self.chance, 4)}


def geometry_edges(depth: Array, normal: Array, instance: Array) -> EdgeMap:
    """Where a render's depth steps, its surfaces bend, or one object ends.

    Args:
        depth: (H, W) metres; 0 where there is nothing.
        normal: (H, W, 3) unit vectors.
        instance: (H, W) object numbers.
    """
    near = np.where(depth > 0.0, 1.0 / np.maximum(depth, 1e-6), 0.0)
    mask = np.zeros(depth.shape, bool)
    for axis in (0, 1):
        before, after = np.roll(near, 1, axis), np.roll(near, -1, axis)
        bend = np.abs(before - 2.0 * near + after)
        mask |= bend > _DEPTH_STEP_SHARE * np.maximum(np.maximum(before, after), near)
        turned = (normal * np.roll(normal, -1, axis)).sum(axis=-1)
        solid = (depth > 0.0) & (np.roll(depth, -1, axis) > 0.0)
        mask |= solid & (turned < np.cos(np.radians(_CREASE_DEG)))
        mask |= instance != np.roll(instance, -1, axis)
    mask &= _inside(mask.shape)
    return EdgeMap(mask, _directions_of(mask))


def photograph_edges(pixels: NDArray[np.uint8]) -> EdgeMap:
    """The ridges of a photograph's gradient.

    Args:
        pixels: (H, W, 3), sRGB.
    """
    from scipy.ndimage import gaussian_filter, map_coordinates

    luma = pixels.astype(np.float64) @ _LUMA / 255.0
    dy, dx = (gaussian_filter(luma, _BLUR_PIXELS, order=order) for order in ((1, 0), (0, 1)))
    strength = np.hypot(dx, dy)
    least = max(float(np.quantile(strength, 1.0 - _STRONG_SHARE)), _MIN_GRADIENT)
    rows, columns = np.indices(luma.shape, dtype=np.float64)
    unit = np.maximum(strength, 1e-12)
    step = np.array([dy / unit, dx / unit])
    beside = [
        map_coordinates(strength, [rows + s * step[0], columns + s * step[1]], order=1)
        for s in (-1.0, 1.0)
    ]
    ridge = (strength >= beside[0]) & (strength > beside[1]) & (strength >= least)
    return EdgeMap(ridge & _inside(ridge.shape), _bins(dx, dy))


def match_edges(rendered: EdgeMap, photographed: EdgeMap) -> EdgeMatch | None:
    """Count the edges of a render that meet one of the photograph.

    Returns:
        None where the render has no edge.
    """
    if not rendered.mask.any():
        return None
    height, width = rendered.mask.shape
    reach = _NEAR_SHARE * float(np.hypot(height, width))
    close = _within(photographed, reach)
    met = rendered.mask & np.take_along_axis(close, rendered.bins[None], axis=0)[0]
    shifts = [(sign * round(_SHIFT_SHARE * height), 0) for sign in (-1, 1)] + [
        (0, sign * round(_SHIFT_SHARE * width)) for sign in (-1, 1)
    ]
    chances = [_met_share(rendered, np.roll(close, shift, axis=(1, 2))) for shift in shifts]
    share = float(met.sum() / rendered.mask.sum())
    return EdgeMatch(share, float(np.mean(chances)), met)


def _met_share(rendered: EdgeMap, close: Mask) -> float:
    met = rendered.mask & np.take_along_axis(close, rendered.bins[None], axis=0)[0]
    return float(met.sum() / rendered.mask.sum())


def _within(edges: EdgeMap, reach: float) -> Mask:
    """(bins, H, W) whether an edge of about that direction is so near, in pixels."""
    from scipy.ndimage import distance_transform_edt

    found = np.zeros((BINS, *edges.mask.shape), bool)
    for number in range(BINS):
        off = (edges.bins - number) % BINS
        alike = edges.mask & ((off <= 1) | (off == BINS - 1))
        if alike.any():
            found[number] = distance_transform_edt(~alike) <= reach
    return found


def _directions_of(mask: Mask) -> NDArray[np.int64]:
    """The directions of lines in a mask, by the structure tensor of its gradient."""
    from scipy.ndimage import gaussian_filter

    drawn = gaussian_filter(mask.astype(np.float64), 1.0)
    dy, dx = np.gradient(drawn)
    xx, yy, xy = (gaussian_filter(v, 2.0) for v in (dx * dx, dy * dy, dx * dy))
    angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    return _bins(np.cos(angle), np.sin(angle))


def _bins(dx: Array, dy: Array) -> NDArray[np.int64]:
    angle = np.arctan2(dy, dx) % np.pi
    return np.asarray(np.floor(angle / np.pi * BINS).astype(np.int64) % BINS)


def _inside(shape: tuple[int, ...]) -> Mask:
    """All but the outermost two rows and columns, which have no neighbours."""
    mask = np.zeros(shape, bool)
    mask[2:-2, 2:-2] = True
    return mask
