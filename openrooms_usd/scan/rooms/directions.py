"""Prevailing directions of walls: one pair (Manhattan world), several (Atlanta world), or none."""

from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.scan.points.surfels import Surfels

# Largest sine of the angle between a wall's normal and the horizontal.
UPRIGHT_SINE: Final = 0.25
_ANGLE_BINS: Final = 360  # a quarter of a degree each, over 90 degrees
_SMOOTHING_DEG: Final = 1.5
_MIN_SEPARATION_DEG: Final = 12.0
_MIN_STRENGTH_SHARE: Final = 0.12  # of the strongest direction
# A direction prevails where the histogram is this many times its mean.
_MIN_PROMINENCE: Final = 2.0
_MAX_DIRECTIONS: Final = 4
# Refinement: surfels that face a direction within this angle are projected on it, turned by each
# of these, into bins of this width.
_FACING_DEG: Final = 12.0
_TURNS_DEG: Final = np.linspace(-3.0, 3.0, 31)
_OFFSET_BIN_M: Final = 0.02
# Unseen walls farther than this from all directions, degrees, cost this share more.
_OBLIQUE_DEG: Final = 6.0
_OBLIQUE_COST: Final = 0.5


def wall_directions(pieces: Surfels) -> tuple[float, ...]:
    """Find the walls' directions.

    Args:
        pieces: Surfels of a scan whose Z axis is up.

    Returns:
        Angles of walls, and so of their normals, in degrees modulo 90, strongest first. Empty
        where no direction prevails.
    """
    walls = pieces.take(np.abs(pieces.normals[:, 2]) < UPRIGHT_SINE)
    if not len(walls):
        return ()
    angles = np.rad2deg(np.arctan2(walls.normals[:, 1], walls.normals[:, 0])) % 90.0
    weight = 1.0 / (0.01 + walls.rough)
    counts = np.bincount(
        (angles * _ANGLE_BINS / 90.0).astype(int) % _ANGLE_BINS, weight, _ANGLE_BINS
    )
    density = _smoothed(counts.astype(np.float64))
    found: list[float] = []
    for peak in np.argsort(-density):
        angle = (peak + 0.5) * 90.0 / _ANGLE_BINS
        if density[peak] < max(
            _MIN_PROMINENCE * density.mean(), _MIN_STRENGTH_SHARE * density.max()
        ):
            break
        local = density[peak] >= max(density[peak - 1], density[(peak + 1) % _ANGLE_BINS])
        if local and all(angle_between(angle, other) > _MIN_SEPARATION_DEG for other in found):
            found.append(_sharpest(_refined(angle, angles, weight), walls))
        if len(found) == _MAX_DIRECTIONS:
            break
    return tuple(found)


def angle_between(a: float | Array, b: float | Array, period: float = 90.0) -> Array:
    """The angle between directions modulo a period, degrees."""
    half = period / 2.0
    return np.abs((np.asarray(a) - b + half) % period - half)


def unseen_wall_cost(normals: Array, directions: tuple[float, ...]) -> Array:
    """(N,) the cost of a metre of unseen wall: lower along the prevailing directions.

    Args:
        normals: (N, 2) of the walls.
        directions: Prevailing ones, degrees modulo 90; none: every wall costs the same.
    """
    if not directions:
        return np.ones(len(normals))
    angles = np.rad2deg(np.arctan2(normals[:, 1], normals[:, 0]))
    off = np.min([angle_between(angles, direction) for direction in directions], axis=0)
    return np.where(off > _OBLIQUE_DEG, 1.0 + _OBLIQUE_COST, 1.0)


def _smoothed(counts: Array) -> Array:
    step = np.arange(_ANGLE_BINS)
    degrees = np.minimum(step, _ANGLE_BINS - step) * 90.0 / _ANGLE_BINS
    kernel = np.exp(-0.5 * (degrees / _SMOOTHING_DEG) ** 2)
    spectrum = np.fft.rfft(counts) * np.fft.rfft(kernel / kernel.sum())
    return np.asarray(np.fft.irfft(spectrum, _ANGLE_BINS))


def _refined(angle: float, angles: Array, weight: Array) -> float:
    """Mean shift of a direction over the normals around it."""
    for width in (4.0, 3.0, 2.0, 2.0, 2.0):
        off = (angles - angle + 45.0) % 90.0 - 45.0
        kernel = weight * np.clip(1.0 - (off / (2.0 * width)) ** 2, 0.0, None) ** 2
        angle += float((kernel * off).sum() / max(kernel.sum(), 1e-9))
    return angle % 90.0


def _sharpest(angle: float, walls: Surfels) -> float:
    """A direction refined to where the projections of its surfels are the most concentrated.

    Normals of noisy surfels are biased towards the voxels' axes, alike on all walls; positions
    along metres of wall are not.
    """
    scores = np.zeros(len(_TURNS_DEG))
    facing = np.rad2deg(np.arctan2(walls.normals[:, 1], walls.normals[:, 0]))
    for axis in (angle, angle + 90.0):
        plan = walls.points[angle_between(facing, axis, 180.0) < _FACING_DEG, :2]
        if len(plan):
            scores += [_concentration(plan, axis + turn) for turn in _TURNS_DEG]
    best = int(scores.argmax())
    if not 0 < best < len(_TURNS_DEG) - 1:
        return angle
    before, here, after = scores[best - 1 : best + 2]
    shift = 0.5 * (before - after) / min(before + after - 2.0 * here, -1e-9)
    return float(angle + _TURNS_DEG[best] + shift * (_TURNS_DEG[1] - _TURNS_DEG[0])) % 90.0


def _concentration(plan: Array, angle: float) -> float:
    """The sum of squares of the blurred histogram of points projected on a direction."""
    turn = np.deg2rad(angle)
    place = plan @ np.array([np.cos(turn), np.sin(turn)])
    counts = np.bincount(((place - place.min()) / _OFFSET_BIN_M).astype(int))
    return float((np.convolve(counts, [1.0, 2.0, 3.0, 2.0, 1.0]) ** 2).sum())
