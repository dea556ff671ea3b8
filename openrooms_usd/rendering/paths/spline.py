"""Smooth curves through values at given times."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from openrooms_usd.arrays import Array


def interpolated(times: ArrayLike, values: ArrayLike, at: ArrayLike) -> Array:
    """A curve through values whose velocity is continuous.

    Cubic Hermite pieces; the velocity at a value is that of the parabola through it and its two
    neighbours, so that parabolas, and straight walks at even speed, come out as they are.

    Args:
        times: (N,) rising.
        values: (N, D).
        at: (M,) times; before the first and after the last the curve stands still.

    Returns:
        (M, D).
    """
    t, x = np.asarray(times, dtype=np.float64), np.asarray(values, dtype=np.float64)
    if len(t) == 1:
        return np.repeat(x, len(np.atleast_1d(at)), axis=0)
    velocity = _velocities(t, x)
    now = np.clip(np.asarray(at, dtype=np.float64), t[0], t[-1])
    piece = np.clip(np.searchsorted(t, now, side="right") - 1, 0, len(t) - 2)
    span = (t[piece + 1] - t[piece])[:, None]
    s = ((now - t[piece]) / span[:, 0])[:, None]
    stay, go = (1 + 2 * s) * (1 - s) ** 2, s**2 * (3 - 2 * s)
    leave, arrive = s * (1 - s) ** 2, s**2 * (s - 1)
    return np.asarray(
        stay * x[piece]
        + go * x[piece + 1]
        + span * (leave * velocity[piece] + arrive * velocity[piece + 1])
    )


def _velocities(t: Array, x: Array) -> Array:
    """(N, D) of the parabola through each value and its neighbours; at the ends through three."""
    step = np.diff(t)[:, None]
    slope = np.diff(x, axis=0) / step
    if len(t) == 2:
        return np.repeat(slope, 2, axis=0)
    inner = (slope[:-1] * step[1:] + slope[1:] * step[:-1]) / (step[:-1] + step[1:])
    return np.concatenate([2 * slope[:1] - inner[:1], inner, 2 * slope[-1:] - inner[-1:]])


def eased(share: NDArray[Any]) -> Array:
    """[0, 1] to itself, with no velocity at both ends: how a walk begins and stops."""
    return np.asarray(share**2 * (3.0 - 2.0 * share))
