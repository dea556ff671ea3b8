"""The least motion of many objects in the plan that meets linear conditions.

A quadratic program: minimise sum_i w_i |m_i|^2 / 2 under rows a . x >= b, where x are the objects'
places after everything that carries them has moved too. Its dual is a problem of non-negative
least squares (Lawson & Hanson 1974). Every condition gives way a little (its multiplier times its
softness), so that what cannot be met ends in the least bad compromise instead of in failure.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_MAX_REFINEMENTS: Final = 50
_BROKEN_M: Final = 1e-6


@dataclass(frozen=True, eq=False)
class Condition:
    """A row: the sum of direction_i . x_i must be at least a bound.

    Attributes:
        directions: Objects' rows, and for each (2,).
        bound: Metres.
        softness: How much it gives way; what must hold before others has less.
    """

    directions: Mapping[int, Array]
    bound: float
    softness: float


def least_motion(weights: Array, carried: Array, conditions: Sequence[Condition]) -> Array:
    """How far each object moves by itself, without what carries it.

    Args:
        weights: (N,) positive.
        carried: (N, N) 1 where the object of the row moves with that of the column (itself too).
        conditions: What must hold.

    Returns:
        (N, 2) metres.
    """
    count = len(weights)
    if not conditions:
        return np.zeros((count, 2))
    rows = np.zeros((len(conditions), count, 2))
    for row, condition in zip(rows, conditions, strict=True):
        for number, direction in condition.directions.items():
            row[number] += direction
    # What an object's own motion does to each row: it takes all along that it carries.
    own = np.einsum("kid,ij->kjd", rows, carried)
    rows = own.reshape(len(conditions), -1)
    softness = np.array([condition.softness for condition in conditions])
    bounds = np.array([condition.bound for condition in conditions])
    ease = np.repeat(1.0 / weights, 2)
    active, motion = bounds > 0.0, np.zeros(2 * count)
    # Few conditions matter, so the others are only looked at.
    for _ in range(_MAX_REFINEMENTS):
        motion = _solved(rows[active], bounds[active], softness[active], ease)
        broken = ~active & (rows @ motion < bounds - _BROKEN_M)
        if not broken.any():
            break
        active |= broken
    return motion.reshape(count, 2)


def _solved(rows: Array, bounds: Array, softness: Array, ease: Array) -> Array:
    """The least motion under rows . x >= bounds, by the dual."""
    from scipy.optimize import nnls

    if not len(rows):
        return np.zeros(len(ease))
    lower = np.linalg.cholesky((rows * ease) @ rows.T + np.diag(softness))
    pull = nnls(lower.T, np.linalg.solve(lower, bounds), maxiter=30 * len(rows))[0]
    return np.asarray((pull @ rows) * ease)
