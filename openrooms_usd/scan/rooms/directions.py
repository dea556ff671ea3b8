"""The directions in which a room's walls run: one pair (Manhattan), several (Atlanta), or none."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.points.surfels import Surfels

Array = NDArray[np.float64]

# Normals of walls stand less than this off the horizontal, as a sine.
UPRIGHT: Final = 0.25
_BINS: Final = 360  # a quarter of a degree each, over 90 degrees
_WIDTH: Final = 1.5  # of the smoothing, degrees
_APART: Final = 12.0  # degrees
_SHARE: Final = 0.12  # of the strongest direction
# A direction prevails where it holds this many times the mean.
_PROMINENCE: Final = 2.0
_MOST: Final = 4
# Pieces that face a direction up to this angle, degrees, are projected on it, turned by up to so
# much in such steps, into bins of this width, metres.
_FACE: Final = 12.0
_TURNS: Final = np.linspace(-3.0, 3.0, 31)
_BIN: Final = 0.02
# Walls that turn off all directions by more than this, degrees, cost so much more where they were
# not seen.
_OFF: Final = 6.0
_OBLIQUE: Final = 0.5


def wall_directions(pieces: Surfels) -> tuple[float, ...]:
    """Find the walls' directions.

    Args:
        pieces: Of a scan whose Z axis is up.

    Returns:
        Angles of walls (or, which is the same, of their normals) in degrees modulo 90, strongest
        first. Empty where no direction prevails.
    """
    walls = pieces.take(np.abs(pieces.normals[:, 2]) < UPRIGHT)
    if not len(walls):
        return ()
    angles = np.rad2deg(np.arctan2(walls.normals[:, 1], walls.normals[:, 0])) % 90.0
    weight = 1.0 / (0.01 + walls.rough)
    counts = np.bincount((angles * _BINS / 90.0).astype(int) % _BINS, weight, _BINS)
    density = _smoothed(counts.astype(np.float64))
    found: list[float] = []
    for peak in np.argsort(-density):
        angle = (peak + 0.5) * 90.0 / _BINS
        if density[peak] < max(_PROMINENCE * density.mean(), _SHARE * density.max()):
            break
        local = density[peak] >= max(density[peak - 1], density[(peak + 1) % _BINS])
        if local and all(apart(angle, other) > _APART for other in found):
            found.append(_sharpest(_refined(angle, angles, weight), walls))
        if len(found) == _MOST:
            break
    return tuple(found)


def apart(a: float | Array, b: float | Array, period: float = 90.0) -> Array:
    """The angle between directions that repeat after a period, degrees."""
    half = period / 2.0
    return np.abs((np.asarray(a) - b + half) % period - half)


def dearness(normals: Array, directions: tuple[float, ...]) -> Array:
    """(N,) what a metre of wall costs that nobody saw: it more likely runs as the others do.

    Args:
        normals: (N, 2) of the walls.
        directions: Of those that were seen, degrees modulo 90; none: every wall costs the same.
    """
    if not directions:
        return np.ones(len(normals))
    angles = np.rad2deg(np.arctan2(normals[:, 1], normals[:, 0]))
    off = np.min([apart(angles, direction) for direction in directions], axis=0)
    return np.where(off > _OFF, 1.0 + _OBLIQUE, 1.0)


def _smoothed(counts: Array) -> Array:
    step = np.arange(_BINS)
    degrees = np.minimum(step, _BINS - step) * 90.0 / _BINS
    kernel = np.exp(-0.5 * (degrees / _WIDTH) ** 2)
    spectrum = np.fft.rfft(counts) * np.fft.rfft(kernel / kernel.sum())
    return np.asarray(np.fft.irfft(spectrum, _BINS))


def _refined(angle: float, angles: Array, weight: Array) -> float:
    """The mean shift of a direction to the middle of the normals around it."""
    for width in (4.0, 3.0, 2.0, 2.0, 2.0):
        off = (angles - angle + 45.0) % 90.0 - 45.0
        kernel = weight * np.clip(1.0 - (off / (2.0 * width)) ** 2, 0.0, None) ** 2
        angle += float((kernel * off).sum() / max(kernel.sum(), 1e-9))
    return angle % 90.0


def _sharpest(angle: float, walls: Surfels) -> float:
    """A direction turned to where the pieces that face it fall on the fewest lines.

    Normals of noisy pieces err towards the axes of their voxels, alike on all walls; the places of
    pieces along walls of metres do not.
    """
    scores = np.zeros(len(_TURNS))
    facing = np.rad2deg(np.arctan2(walls.normals[:, 1], walls.normals[:, 0]))
    for axis in (angle, angle + 90.0):
        plan = walls.points[apart(facing, axis, 180.0) < _FACE, :2]
        if len(plan):
            scores += [_concentration(plan, axis + turn) for turn in _TURNS]
    best = int(scores.argmax())
    if not 0 < best < len(_TURNS) - 1:
        return angle
    before, here, after = scores[best - 1 : best + 2]
    shift = 0.5 * (before - after) / min(before + after - 2.0 * here, -1e-9)
    return float(angle + _TURNS[best] + shift * (_TURNS[1] - _TURNS[0])) % 90.0


def _concentration(plan: Array, angle: float) -> float:
    """The sum of squared counts of places projected on a direction, in blurred bins."""
    turn = np.deg2rad(angle)
    place = plan @ np.array([np.cos(turn), np.sin(turn)])
    counts = np.bincount(((place - place.min()) / _BIN).astype(int))
    return float((np.convolve(counts, [1.0, 2.0, 3.0, 2.0, 1.0]) ** 2).sum())
