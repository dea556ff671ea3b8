"""Plane fits to the nearest points, for sparse scans.

A window of fixed size that holds enough points of a sparse scan holds both faces of a thin wall,
too. The nearest points are of one face as long as they are closer to each other than the faces;
where noise is as large as their distance, more of them are needed. So each place takes, of fits to
few and to many points around it and its neighbours, the one whose direction is the surest.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.points.principal import least_principal_axes, moments

Array = NDArray[np.float64]


# Points of a fit: a point and its four neighbours on a grid; three rows of three; and more.
_POINTS: Final = (5, 9, 17)
_PARAMETERS: Final = 3  # of a plane
# Fits of so many points around a place are its candidates.
_AROUND: Final = 7
# Largest radius of those, and largest residual, which would else pass outliers for surfaces.
_MAX_RADIUS_M: Final = 0.35
_MAX_OFF_PLANE_M: Final = 0.03
# Points of a surface agree: of the fits of one size this part is parallel, within 25 degrees. Of
# stray points few do.
_AGREEING_SHARE: Final = 0.7
_AGREEING_COS: Final = 0.906


@dataclass(frozen=True, eq=False)
class NearestPlanes:
    """Plane fits at M places.

    Attributes:
        normals: (M, 3) unit.
        rough: (M,) root mean squared residuals, metres.
        spacing: (M,) usual distance of the points, metres.
        flat: (M,) whether the points lie near each other and on a plane.
    """

    normals: Array
    rough: Array
    spacing: Array
    flat: NDArray[np.bool_]


def nearest_planes(points: Array, places: Array) -> NearestPlanes:
    """Fit planes to the nearest points of places.

    Args:
        points: (N, 3) metres, evenly thinned.
        places: (M, 3) among them.
    """
    from scipy.spatial import KDTree

    if len(points) < max(_POINTS):
        none = np.zeros(len(places))
        return NearestPlanes(np.tile([0.0, 0.0, 1.0], (len(places), 1)), none, none, none > 0.0)
    tree = KDTree(points)
    distance, rows = (np.asarray(found) for found in tree.query(places, k=_AROUND))
    asked, at = np.unique(rows, return_inverse=True)
    reach, around = (np.asarray(found) for found in tree.query(points[asked], k=max(_POINTS)))
    fits = [_fits(points[around[:, :count]], reach[:, count - 1]) for count in _POINTS]
    choice = at.reshape(rows.shape)
    middle, normals, rough, turn = (
        np.concatenate([part[choice] for part in parts], axis=1)
        for parts in zip(*fits, strict=True)
    )
    off = np.maximum(rough, np.abs(((places[:, None] - middle) * normals).sum(axis=2)))
    near = off < _MAX_OFF_PLANE_M
    best = np.where(near, turn, np.inf).argmin(axis=1)
    each = np.arange(len(places))
    chosen = normals[each, best]
    parallel = near & (np.abs((normals * chosen[:, None]).sum(axis=2)) > _AGREEING_COS)
    agreeing = parallel.reshape(len(places), len(_POINTS), _AROUND).mean(axis=2).max(axis=1)
    radius = distance[:, -1]
    flat = (radius < _MAX_RADIUS_M) & near[each, best] & (agreeing > _AGREEING_SHARE)
    return NearestPlanes(chosen, off[each, best], radius * np.sqrt(np.pi / _AROUND), flat)


def _fits(points: Array, reach: Array) -> tuple[Array, Array, Array, Array]:
    """Centroids (F, 3), normals (F, 3), residuals (F,) and turns (F,) of fits to (F, K, 3) points.

    A turn is the standard error of the normal's direction, up to a constant factor.
    """
    count = points.shape[1]
    middle = points.mean(axis=1)
    away = (points - middle[:, None]).reshape(-1, 3)
    total = np.column_stack(moments(away)).reshape(*points.shape[:2], 10).sum(axis=1)
    normals, rough = least_principal_axes(total)
    rough = rough * np.sqrt(count / (count - _PARAMETERS))
    return middle, normals, rough, rough / (np.maximum(reach, 1e-9) * np.sqrt(count))
