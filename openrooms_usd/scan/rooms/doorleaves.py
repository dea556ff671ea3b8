"""Leaves of open doors, found by their labels: as high as walls, but no walls.

An open leaf is collinear with no wall.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.points.surfels import VOXEL_M, Surfels
from openrooms_usd.scan.rooms.directions import UPRIGHT_SINE, angle_between

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# NYU40.
_WALL_LABEL: Final = 1
_DOOR_LABEL: Final = 8
# Below this, skirting boards and thresholds are labelled door, too, metres.
_SKIRTING_M: Final = 0.1
# Radius of the neighbourhood whose principal axis is the direction of a leaf or wall, metres.
_DIRECTION_RADIUS_M: Final = 0.35
_MIN_PIECES: Final = 8
# A closed door continues a wall: within this angle, range and band, in so many columns. One that
# is parallel to the walls may stand in a deep frame.
_ALIKE_DEG: Final = 4.0
_WALL_ONWARD_M: Final = 1.5
_WALL_BAND_M: Final = 0.08
_FRAME_BAND_M: Final = 0.12
_MIN_COLUMNS: Final = 6


def open_leaves(pieces: Surfels, directions: tuple[float, ...]) -> Mask:
    """The surfels of open leaves: labelled door, and continuing no wall.

    Args:
        pieces: Surfels of a level scan; without labels no leaf is found.
        directions: Of walls, degrees modulo 90.
    """
    none = np.zeros(len(pieces), dtype=np.bool_)
    if pieces.label is None or not directions:
        return none
    standing = (np.abs(pieces.normals[:, 2]) < UPRIGHT_SINE) & (pieces.points[:, 2] > _SKIRTING_M)
    doors = np.flatnonzero(standing & (pieces.label == _DOOR_LABEL))
    walls = np.flatnonzero(standing & (pieces.label == _WALL_LABEL))
    if not len(doors) or not len(walls):
        return none
    places, column = _columns(pieces.points[doors, :2])
    angle = _normal_directions(places)
    off = np.min([angle_between(angle, direction) for direction in directions], axis=0)
    band = np.where(off > _ALIKE_DEG, _WALL_BAND_M, _FRAME_BAND_M)
    leaf = np.isfinite(angle) & ~_in_line(
        places, angle, band, _columns(pieces.points[walls, :2])[0]
    )
    none[doors[leaf[column]]] = True
    return none


def _columns(plan: Array) -> tuple[Array, NDArray[np.int64]]:
    """(C, 2) centroids of occupied cells of the plan, and (N,) the cell of each surfel."""
    cells = np.floor((plan - plan.min(axis=0)) / VOXEL_M).astype(np.int64)
    _, column = np.unique(cells @ [1 << 32, 1], return_inverse=True)
    count = np.bincount(column)
    return np.column_stack([np.bincount(column, axis) / count for axis in plan.T]), column


def _normal_directions(places: Array) -> Array:
    """(C,) normal directions of line fits around places, degrees; NaN where there is too little."""
    from scipy.spatial import KDTree

    near = KDTree(places).query_pairs(_DIRECTION_RADIUS_M, output_type="ndarray")
    pairs = np.concatenate([near, near[:, ::-1], np.repeat(np.arange(len(places))[:, None], 2, 1)])
    x, y = places[pairs[:, 1]].T
    count, sx, sy, xx, xy, yy = (
        np.bincount(pairs[:, 0], values, len(places)).astype(np.float64)
        for values in (np.ones(len(pairs)), x, y, x * x, x * y, y * y)
    )
    covariance = xy - sx * sy / count
    difference = (xx - sx * sx / count) - (yy - sy * sy / count)
    along = 0.5 * np.arctan2(2.0 * covariance, difference)
    return np.where(count >= _MIN_PIECES, np.rad2deg(along) + 90.0, np.nan)


def _in_line(places: Array, angles: Array, band: Array, walls: Array) -> Mask:
    """(N,) whether a wall is collinear with the leaf at each place."""
    from scipy.spatial import KDTree

    found = np.zeros(len(places), bool)
    runs = _normal_directions(walls)
    for row, near in enumerate(KDTree(walls).query_ball_point(places, _WALL_ONWARD_M)):
        turn = np.deg2rad(angles[row])
        away = np.abs((walls[near] - places[row]) @ np.array([np.cos(turn), np.sin(turn)]))
        alike = angle_between(runs[near], angles[row], 180.0) < _ALIKE_DEG
        found[row] = ((away < band[row]) & alike).sum() >= _MIN_COLUMNS
    return found
