"""Rotational symmetry of a CAD about its vertical."""

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from openrooms_usd.geometry.rotations import about_z
from openrooms_usd.scan.models.cad import CadModel, Symmetry, scattered

Array = NDArray[np.float64]

# Samples of the surface that rotated samples are compared with.
_DENSE_POINTS: Final = 16000
# A rotated surface is the same if this share of it is within this share of its size: about a
# centimetre of a chair, which scanners do not resolve.
_MIN_SAME_SHARE: Final = 0.985
_SAME_SIZE_SHARE: Final = 0.012
# Rotations such that only solids of revolution are symmetric under all, no polygons of up to eight
# corners.
_ODD_TURNS_RAD: Final = tuple(np.deg2rad([17.0, 31.0, 53.0, 72.0, 101.0, 127.0, 149.0]))


def symmetry_of(model: CadModel, upright: Array) -> Symmetry:
    """The symmetry of a CAD about the vertical through the middle of its box.

    Args:
        model: The CAD; what it states is not asked.
        upright: (3, 3) signed permutation to Z up.
    """
    low, high = np.sort(model.extent @ upright.T, axis=0)
    middle = 0.5 * (low + high)
    points = model.surface.points @ upright.T - middle
    whole, _, area = scattered(model.vertices[model.faces], _DENSE_POINTS)
    tree: KDTree[None] = KDTree(whole @ upright.T - middle)
    limit = max(
        _SAME_SIZE_SHARE * float(np.linalg.norm(high - low)),
        1.6 * float(np.sqrt(area / _DENSE_POINTS)),
    )

    def same(angle: float) -> bool:
        distance, _ = tree.query(points @ about_z(-angle), distance_upper_bound=limit)
        return bool(np.isfinite(distance).mean() >= _MIN_SAME_SHARE)

    if all(same(angle) for angle in _ODD_TURNS_RAD):
        return "inf"
    if not same(np.pi):
        return "none"
    return "4" if same(0.5 * np.pi) else "2"
