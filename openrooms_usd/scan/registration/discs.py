"""Point-to-disc residuals and their normal equations.

A residual is point-to-plane above the disc and point-to-edge beside it, with the robust kernel of
Geman and McClure.
"""

from typing import NamedTuple

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.scan.registration.template import directions, turn_of


class System(NamedTuple):
    """Normal equations of a Gauss-Newton step.

    Attributes:
        matrix: (7, 7).
        vector: (7,) half the gradient of the energy.
        energy: Sum of all terms, robust kernels included.
    """

    matrix: Array
    vector: Array
    energy: float


class Pairs(NamedTuple):
    """Correspondences of template points and discs.

    Attributes:
        across: (N, 3) unit, normal to the disc.
        height: (N,) signed point-to-plane distance, metres.
        along: (N, 3) unit, in the disc's plane; 0 where the point is above the disc.
        beyond: (N,) distance from its edge in the plane, metres.
        lever: (N, 3) the template's points about its origin, rotated.
        local: (N, 3) the same, not rotated.
        turn: (3, 3) about the vertical.
    """

    across: Array
    height: Array
    along: Array
    beyond: Array
    lever: Array
    local: Array
    turn: Array

    def energy(self, weights: Array, width: float) -> float:
        """The energy alone, with weights (N,) and a kernel of some width, metres."""
        squared = self.height**2 + self.beyond**2
        return float(weights @ (squared * (width**2 / (width**2 + squared))))

    def robust(self, weights: Array, width: float) -> System:
        """Normal equations with weights (N,) and a kernel of some width, metres."""
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
    """Correspondences of template points and scan points, which become discs.

    Args:
        points: (N, 3) of the template, in its own frame.
        normals: (N, 3) unit, there.
        targets: (N, 3) points of the scan.
        radius: Of the discs, metres.
        parameters: (7,) pose of the template.
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
