"""Moves cameras so that depth maps lie on a room's geometry."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from openrooms_usd.appearance.motions import descended, distinct, motion, moved
from openrooms_usd.appearance.views import Geometry, Photograph, Size, scaled
from openrooms_usd.arrays import Array
from openrooms_usd.geometry.pinhole import pixel_directions

# Depth that is nearer to the geometry than this lies on it.
ON_M: Final = 0.05
# Depth maps are read at so many columns.
_WIDTH: Final = 80
# A depth that steps more among neighbours is an edge, which is not compared, relative.
_STEP_SHARE: Final = 0.05
_LIMITS_M: Final = (0.2, 8.0)
# The search: where it starts, every how many pixels, how far points may be from surfaces.
_STARTS_M: Final = (-0.6, -0.3, 0.0, 0.3, 0.6)
_STARTS_DEG: Final = (-15.0, -7.5, 0.0, 7.5, 15.0)
_SEARCHED_EVERY: Final = 3
_START_M: Final = 0.3
_COARSE_M: Final = (0.5, 0.35, 0.25, 0.15, 0.1)
_FINE_M: Final = (0.15, 0.08, 0.05)
_STEPS: Final = 4
_KEPT: Final = (12, 3)
# Noise of depth, and how many points tell as much as one.
_NOISE_M: Final = 0.02
_ALIKE_POINTS: Final = 50.0
# Shares of points nearer to each other than this are equal: then the smaller motion is chosen.
_EQUAL_SHARE: Final = 0.02


@dataclass(frozen=True, eq=False)
class Range:
    """A depth map as points.

    Attributes:
        pose: (4, 4) world_from_camera as it is said.
        K: (3, 3) pixels.
        depth: (H, W) metres; 0 where it is unknown or at an edge.
    """

    pose: Array
    K: Array
    depth: Array

    @property
    def size(self) -> Size:
        """Width and height."""
        return self.depth.shape[1], self.depth.shape[0]

    def thinned(self, every: int) -> "Range":
        """Every so many columns and rows."""
        start = every // 2
        K = self.K.copy()
        # The kept pixels' centres are those of pixels so many times as large.
        K[:2, 2] = (K[:2, 2] - (start + 0.5)) / every + 0.5
        K[[0, 1], [0, 1]] /= every
        return Range(self.pose, K, self.depth[start::every, start::every])


def range_of(photograph: Photograph) -> Range | None:
    """A photograph's depth map at few columns; None without one, or where nothing is known."""
    from scipy.ndimage import maximum_filter, minimum_filter

    depth = photograph.depth
    if depth is None:
        return None
    low, high = minimum_filter(depth, 3), maximum_filter(depth, 3)
    usable = (low > _LIMITS_M[0]) & (high < _LIMITS_M[1]) & (high - low < _STEP_SHARE * high)
    K = scaled(photograph.K, depth.shape[1] / photograph.pixels.shape[1])
    whole = Range(photograph.world_from_camera, K, np.where(usable, depth, 0.0))
    few = whole.thinned(max(1, depth.shape[1] // _WIDTH))
    return few if few.depth.any() else None


def search(ranges: Sequence[Range], geometry: Geometry, pivot: Array) -> Array:
    """The motion (4, 4) of all cameras that lays depth on geometry, from a wide search.

    Args:
        ranges: The depth maps.
        geometry: The room.
        pivot: (3,) what turns leave where it is.
    """
    few = [one.thinned(_SEARCHED_EVERY) for one in ranges]

    def best(motions: Sequence[Array], limit: float, count: int) -> list[Array]:
        shares = np.array([share_on(differences(few, geometry, one), limit) for one in motions])
        return distinct(motions, shares, pivot, count)

    starts = [
        motion([east, north, 0, 0, 0, np.radians(yaw)], pivot)
        for east, north, yaw in product(_STARTS_M, _STARTS_M, _STARTS_DEG)
    ]
    kept = best(starts, _START_M, _KEPT[0])
    fitted = [refine(few, geometry, one, pivot, _COARSE_M) for one in [*kept, np.eye(4)]]
    fine = [refine(ranges, geometry, one, pivot) for one in best(fitted, ON_M, _KEPT[1])]
    marks = np.array([share_on(differences(ranges, geometry, one)) for one in fine])
    good = [
        one for one, mark in zip(fine, marks, strict=True) if mark >= marks.max() - _EQUAL_SHARE
    ]
    return min(good, key=lambda one: float(np.linalg.norm(moved(pivot, one) - pivot)))


def refine(
    ranges: Sequence[Range],
    geometry: Geometry,
    start: Array,
    pivot: Array,
    limits: Sequence[float] = _FINE_M,
    origin: Array | None = None,
) -> Array:
    """One motion (4, 4) of all cameras, from one that is near: points to the planes they see.

    Args:
        ranges: The depth maps.
        geometry: The room.
        start: (4, 4) the motion to begin with.
        pivot: (3,) what small motions turn about.
        limits: Points farther from their planes say nothing, metres, one after the other.
        origin: (4, 4) the motion that it is drawn to; None if free.
    """
    now = start
    for limit in limits:

        def evidence(at: Array, limit: float = limit) -> tuple[Array, Array]:
            pairs = [_pairs(one, geometry, at) for one in ranges]
            here, there, normals = (np.concatenate(rows) for rows in zip(*pairs, strict=True))
            off = np.einsum("ij,ij->i", normals, here - there)
            # Tukey's.
            weight = np.square(np.maximum(1.0 - np.square(off / limit), 0.0))
            weight /= _ALIKE_POINTS * _NOISE_M**2
            J = np.column_stack([normals, np.cross(here - pivot, normals)])
            return (J * weight[:, None]).T @ J, -J.T @ (weight * off)

        now = descended(evidence, now, pivot, _STEPS, origin)
    return now


def differences(ranges: Sequence[Range], geometry: Geometry, moved: Array) -> list[Array]:
    """Depth of each map less what its camera sees of geometry after a motion (4, 4).

    Returns:
        For each map (N,) metres, of pixels in which its depth is known; infinite where the camera
        sees no geometry.
    """
    found = []
    for one in ranges:
        known = one.depth > 0.0
        seen = geometry(one.K, moved @ one.pose, one.size).depth[known]
        found.append(np.where(seen > 0.0, one.depth[known] - seen, np.inf))
    return found


def share_on(off: Sequence[Array], limit: float = ON_M) -> float:
    """Share of depth that lies on geometry, of that which has geometry before or behind it."""
    every = np.concatenate(list(off))
    met = np.isfinite(every)
    return float((np.abs(every[met]) < limit).mean()) if met.any() else 0.0


def _pairs(one: Range, geometry: Geometry, moved: Array) -> tuple[Array, Array, Array]:
    """Points of a depth map after a motion, what is seen in their pixels, and its normals."""
    at = moved @ one.pose
    seen = geometry(one.K, at, one.size)
    both = (one.depth > 0.0) & (seen.depth > 0.0)
    rays = pixel_directions(one.K, *one.size)[both] @ at[:3, :3].T
    here = one.depth[both][:, None] * rays + at[:3, 3]
    there = seen.depth[both][:, None] * rays + at[:3, 3]
    return here, there, seen.normal[both]
