"""Gravity and the floor of a scan.

A scan whose poses drift bends its floor: places are off by centimetres where the scanner stood for
a while, and a plane through them leans. Normals do not suffer that much: each surface was seen from
many poses whose turns are off to all sides. So gravity is what level surfaces face and walls are
square to, and the floor's own plane is believed as far as it agrees.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.points.planes import Plane, fit_plane
from openrooms_usd.scan.points.surfels import VOXEL, Surfels

Array = NDArray[np.float64]

MIN_PIECES: Final = 200
# Normals this near to the vertical, degrees, are of floors, tops and ceilings.
LEVEL_DEG: Final = 8.0
UPRIGHT_DEG: Final = 15.0
# What is farther than this from level or upright says nothing of gravity, degrees: so many times
# the median, within limits.
_OUTLIER_MEDIANS: Final = 2.0
_OUTLIER_LIMITS_DEG: Final = (3.0, 10.0)
_REWEIGHTING_ROUNDS: Final = 8
# The floor's plane counts fully up to this angle to gravity, not at all from twice this, degrees;
_FLOOR_AGREES_DEG: Final = 0.1
# larger where gravity itself is less sure. Pieces share their points with those around them.
_GRAVITY_SIGMAS: Final = 2.0
_SHARED_PIECES: Final = 27.0
# The floor is the lowest level with this part of the largest one's area,
_MIN_FLOOR_SHARE: Final = 0.15
# and with this area, square metres;
_MIN_FLOOR_M2: Final = 0.15
# walls do not go on for this much below it, metres.
_WALLS_BELOW_M: Final = 0.35
# Less than this part of the normals' spread is noise of a single wall.
_ONE_WALL_SHARE: Final = 0.05
_HEIGHT_BIN_M: Final = 0.02
_SLAB_M: Final = 0.12
_LEVEL_TOLERANCE_M: Final = 0.03
# NYU40: the floor, which mats and carpets lie on; that much of it tells where it is.
_FLOOR_LABEL: Final = 2
_BARE_FLOOR_SHARE: Final = 0.1
_PIECE_M2: Final = VOXEL**2


@dataclass(frozen=True, eq=False)
class Ground:
    """The floor of a scan.

    Attributes:
        normal: (3,) unit, upwards.
        point: (3,) metres.
        residual: Root of the mean squared distance of the floor's pieces to it, metres; NaN where
            no floor was seen.
        seen: Whether the floor itself was seen; else it is at the walls' lowest points.
        trust: How far the floor's own plane agrees with gravity, from 0 (it is bent) to 1.
    """

    normal: Array
    point: Array
    residual: float
    seen: bool
    trust: float


def find_ground(pieces: Surfels, guess: Array, tilt: float) -> Ground:
    """Find gravity and the floor.

    Args:
        pieces: Near the origin.
        guess: (3,) unit, roughly upwards.
        tilt: How far off that may be, degrees.
    """
    up, sigma = _squared(pieces.normals, _gravity(pieces, guess, tilt))
    facing = np.abs(pieces.normals @ up)
    flat = pieces.take(facing > np.cos(np.deg2rad(LEVEL_DEG)))
    foot = _foot(pieces.points[facing < np.sin(np.deg2rad(UPRIGHT_DEG))] @ up)
    height = _floor_level(flat.points @ up, flat.label)
    if height is not None and height - foot < _WALLS_BELOW_M:
        slab = _bare(flat.take(np.abs(flat.points @ up - height) < _SLAB_M))
        plane = fit_plane(slab, up, _LEVEL_TOLERANCE_M, max_tilt=3.0)
        if plane is not None:
            return _between(slab, plane, up, max(_FLOOR_AGREES_DEG, _GRAVITY_SIGMAS * sigma))
    middle = np.median(pieces.points, axis=0)
    return Ground(up, middle + (foot - middle @ up) * up, float("nan"), False, 1.0)


def _bare(slab: Surfels) -> Array:
    """(P, 3) the pieces that are labelled floor, where there are enough; else all."""
    named = np.zeros(len(slab), bool) if slab.label is None else slab.label == _FLOOR_LABEL
    return slab.points[named] if named.mean() > _BARE_FLOOR_SHARE else slab.points


def _between(slab: Array, plane: Plane, up: Array, agrees: float) -> Ground:
    """The floor's plane as far as it is square to gravity, else a level one at its mean height."""
    off = np.rad2deg(np.arccos(min(1.0, float(plane.normal @ up))))
    trust = float(np.clip(2.0 - off / agrees, 0.0, 1.0))
    if trust == 1.0:
        return Ground(plane.normal, plane.point, plane.residual, True, trust)
    normal = trust * plane.normal + (1.0 - trust) * up
    normal /= np.linalg.norm(normal)
    middle = slab.mean(axis=0)
    raised = plane.heights(middle[None])[0] / (plane.normal @ up)
    point = middle - trust * raised * up
    return Ground(normal, point, float(np.std((slab - point) @ normal)), True, trust)


def _gravity(pieces: Surfels, guess: Array, tilt: float) -> Array:
    """(3,) the direction that most level surfaces face, or that all walls are upright to."""
    toward = pieces.normals * np.sign(pieces.normals @ guess)[:, None]
    near = toward @ guess > np.cos(np.deg2rad(tilt + 2.0))
    flat = toward[near]
    up = guess
    if len(flat) > _MIN_FLOOR_M2 / _PIECE_M2:
        some = flat[:: max(1, len(flat) // 1500)]
        up = some[(some @ some.T > np.cos(np.deg2rad(3.0))).sum(axis=1).argmax()]
        for width in (6.0, 4.0, 3.0, 3.0):
            up = flat[flat @ up > np.cos(np.deg2rad(width))].mean(axis=0)
            up = up / np.linalg.norm(up)
        return np.asarray(up)
    for width in (tilt, 8.0, 5.0, 5.0):
        walls = pieces.normals[np.abs(pieces.normals @ up) < np.sin(np.deg2rad(width))]
        if len(walls) < MIN_PIECES:
            break
        up = _square_to(walls, guess)
    return up


def _square_to(walls: Array, guess: Array) -> Array:
    """(3,) the direction that is upright to walls' normals (N, 3); one wall leaves it half open."""
    values, axes = np.linalg.eigh(walls.T @ walls / len(walls))
    free = axes[:, values < _ONE_WALL_SHARE]
    up = free @ (free.T @ guess) if free.shape[1] > 1 else free[:, 0] * np.sign(free[:, 0] @ guess)
    return np.asarray(up / np.linalg.norm(up))


def _squared(normals: Array, up: Array) -> tuple[Array, float]:
    """(3,) what level normals (N, 3) are along and upright ones square to, and its error, degrees.

    Reweighted least squares: the sum of the squared sines of level normals to it, and of the
    squared cosines of upright ones, is least for the first eigenvector of their difference.
    """
    off = np.rad2deg(np.arccos(np.minimum(np.abs(normals @ up), 1.0)))
    usual = float(np.median(off[off < UPRIGHT_DEG])) if (off < UPRIGHT_DEG).any() else 0.0
    width = np.sin(np.deg2rad(np.clip(_OUTLIER_MEDIANS * usual, *_OUTLIER_LIMITS_DEG)))
    kernel = np.zeros(len(normals))
    for _ in range(_REWEIGHTING_ROUNDS):
        cosine = normals @ up
        sine = np.sqrt(np.maximum(1.0 - cosine**2, 0.0))
        level, upright = (np.clip(1.0 - (v / width) ** 2, 0.0, None) ** 2 for v in (sine, cosine))
        kernel = level + upright
        if not level.any():
            break
        spread = (normals * (level - upright)[:, None]).T @ normals
        axis = np.linalg.eigh(spread)[1][:, 2]
        up = axis * np.sign(axis @ up)
    off = np.minimum(np.abs(normals @ up), np.linalg.norm(np.cross(normals, up), axis=1))
    mean = float((kernel * off**2).sum()) / max(float(kernel.sum()), 1e-9)
    return up, float(np.rad2deg(np.sqrt(mean * _SHARED_PIECES / max(float(kernel.sum()), 1.0))))


def _foot(heights: Array) -> float:
    """Where walls end below: the lowest height at which they are a tenth as dense as usual."""
    if len(heights) < MIN_PIECES:
        return float("inf")
    low = np.quantile(heights, 0.001)
    counts = np.bincount(((heights - low).clip(0.0) / 0.05).astype(int))
    dense = np.flatnonzero(counts >= 0.15 * np.quantile(counts[counts > 0], 0.8))
    return float(low + 0.05 * dense[0])


def _floor_level(heights: Array, label: NDArray[np.int32] | None) -> float | None:
    if not len(heights):
        return None
    weight = np.ones(len(heights))
    if label is not None:
        weight[label == _FLOOR_LABEL] = 4.0
    low = heights.min() - 5 * _HEIGHT_BIN_M
    counts = np.bincount(((heights - low) / _HEIGHT_BIN_M).astype(int), weight)
    area = np.convolve(np.append(counts, np.zeros(5)), np.ones(5), "same")
    strong = area > max(_MIN_FLOOR_SHARE * area.max(), _MIN_FLOOR_M2 / _PIECE_M2)
    if not strong.any():
        return None
    first = int(np.flatnonzero(strong)[0])
    peak = first + int(area[first : first + 8].argmax())
    return float(low + (peak + 0.5) * _HEIGHT_BIN_M)
