"""A ceiling that slopes, seen from below: how high it is over a place."""

from typing import Final

import numpy as np

from openrooms_usd.arrays import Array

# Faces whose heights differ by less are level, metres.
_LEVEL_M: Final = 1e-4
_EDGE_SHARE: Final = 1e-6


def sloping(triangles: Array) -> Array:
    """Those of (N, 3, 3) triangles that face down, Z up; none where all these are level."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    lower = triangles[np.cross(b - a, c - a)[:, 2] < -1e-12]
    heights = lower[:, :, 2]
    return lower if len(lower) and np.ptp(heights) > _LEVEL_M else lower[:0]


def heights_over(faces: Array, places: Array, otherwise: float) -> Array:
    """How high a ceiling is.

    Args:
        faces: (N, 3, 3) what `sloping` found.
        places: (K, 2) in the plan.
        otherwise: Where no face is.

    Returns:
        (K,) heights of the lowest faces.
    """
    found = np.full(len(places), np.inf)
    for a, b, c in faces:
        sides = np.column_stack([b - a, c - a])
        s, t = np.linalg.solve(sides[:2], (places - a[:2]).T)
        within = (s >= -_EDGE_SHARE) & (t >= -_EDGE_SHARE) & (s + t <= 1.0 + _EDGE_SHARE)
        found[within] = np.minimum(found, a[2] + s * sides[2, 0] + t * sides[2, 1])[within]
    return np.where(np.isfinite(found), found, otherwise)
