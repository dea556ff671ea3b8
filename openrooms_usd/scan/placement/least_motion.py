"""The least motion of many objects in the plan under soft linear constraints.

A quadratic program: minimise sum_i w_i |m_i|^2 / 2 under a . x >= b, where x are the total motions,
those of supports included. Its dual is a non-negative least squares problem (Lawson & Hanson 1974).
Constraints are soft (each is relaxed by its multiplier times its softness), so that infeasible ones
end in a compromise.
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
    """A constraint: the sum of direction_i . x_i must be at least a bound.

    Attributes:
        directions: Objects' rows, and for each (2,).
        bound: Metres.
        softness: Relaxation per multiplier; the smaller, the harder the constraint.
    """

    directions: Mapping[int, Array]
    bound: float
    softness: float


def least_motion(weights: Array, carried: Array, conditions: Sequence[Condition]) -> Array:
    """The own motion of each object, relative to its support's.

    Args:
        weights: (N,) positive.
        carried: (N, N) 1 where the object of the row moves with that of the column (itself too).
        conditions: The constraints.

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
    # The Jacobian by own motions: an object takes along all that it carries.
    own = np.einsum("kid,ij->kjd", rows, carried)
    rows = own.reshape(len(conditions), -1)
    softness = np.array([condition.softness for condition in conditions])
    bounds = np.array([condition.bound for condition in conditions])
    ease = np.repeat(1.0 / weights, 2)
    active, motion = bounds > 0.0, np.zeros(2 * count)
    # Few constraints are active: only violated ones enter the working set.
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
