"""Distances between points and small discs, and what they ask of a pose.

They are along the normal where there is surface and towards its edge beyond it; the kernel is that
of Geman and McClure.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.registration.template import directions, turn_of

Array = NDArray[np.float64]


class System(NamedTuple):
    """Normal equations about a pose.

    Attributes:
        matrix: (7, 7).
        vector: (7,) half the gradient of the energy.
        energy: Of all terms, with their robust kernels.
    """

    matrix: Array
    vector: Array
    energy: float


class Pairs(NamedTuple):
    """Points of a template against discs.

    Attributes:
        across: (N, 3) unit, normal to the disc.
        height: (N,) along it, metres.
        along: (N, 3) unit, in the disc; 0 where the point is above it.
        beyond: (N,) from its edge, metres.
        lever: (N, 3) of the template's points about its origin, turned.
        local: (N, 3) the same, not turned.
        turn: (3, 3) about the vertical.
    """

    across: Array
    height: Array
    along: Array
    beyond: Array
    lever: Array
    local: Array
    turn: Array

    def robust(self, weights: Array, width: float) -> System:
        """Their equations under a kernel of some width, metres, with weights (N,)."""
        squared = self.height**2 + self.beyond**2
        kernel = width**2 / (width**2 + squared)
        w = weights * kernel**2
        J, K = self._slopes(self.across), self._slopes(self.along)
        return System(
            (J * w[:, None]).T @ J + (K * w[:, None]).T @ K,
            J.T @ (w * self.height) + K.T @ (w * self.beyond),
            float(weights @ (squared * kernel)),
        )

    def _slopes(self, u: Array) -> Array:
        turning = u[:, 1] * self.lever[:, 0] - u[:, 0] * self.lever[:, 1]
        return np.column_stack([u, turning, (u @ self.turn) * self.local])


def paired(
    points: Array, normals: Array, targets: Array, radius: float, parameters: Array
) -> Pairs:
    """Pairs of a template's points and points of the scan.

    Args:
        points: (N, 3) of the template, in its own frame.
        normals: (N, 3) unit, there.
        targets: (N, 3) points of the scan.
        radius: Of the discs, metres.
        parameters: (7,) where the template is.
    """
    turn = turn_of(parameters)
    local = points * np.exp(parameters[4:])
    lever = local @ turn.T
    n = directions(normals, parameters)
    e = lever + parameters[:3] - targets
    height = np.einsum("ij,ij->i", e, n)
    tangent = e - height[:, None] * n
    length = np.sqrt(np.einsum("ij,ij->i", tangent, tangent))
    beyond = np.maximum(length - radius, 0.0)
    along = tangent * (beyond > 0.0)[:, None] / np.maximum(length, 1e-12)[:, None]
    return Pairs(n, height, along, beyond, lever, local, turn)
