"""Gaussian priors of a pose."""

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.scan.registration.template import directions, turn_of

# Point-to-disc residuals and their normal equations.
#
# A residual is point-to-plane above the disc and point-to-edge beside it, with the robust kernel of
# Geman and McClure.


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


# Standard deviation of a log scale that is known.
_EQUAL_SCALE_LOG: Final = 0.003
# Scales are clipped to so many standard deviations.
_MAX_SCALE_SIGMAS: Final = 2.5
_ANISOTROPIC: Final = np.eye(3) - 1.0 / 3.0


@dataclass(frozen=True, eq=False)
class PoseHypothesis:
    """A Gaussian prior of the seven parameters.

    Attributes:
        parameters: (7,) mean.
        deviation: (7,) standard deviations.
        plain: (3,) log scales of the CAD's own size in metres.
        stretch: Standard deviation of anisotropic log scale.
        limits: (2, 3) least and greatest log scales; None: any.
        to_scale: Whether the CAD's own size may be that of the object.
    """

    parameters: Array
    deviation: Array
    plain: Array
    stretch: float = np.inf
    limits: Array | None = None
    to_scale: bool = True

    def rows(self, parameters: Array) -> System:
        """Its normal equations at some parameters."""
        off = parameters - self.parameters
        off[3] = wrapped(float(off[3]))
        weight = self.deviation**-2.0
        # Isotropic scale is likelier than anisotropic.
        stretch = _ANISOTROPIC @ (parameters[4:] - self.plain)
        matrix = np.diag(weight)
        matrix[4:, 4:] += _ANISOTROPIC / self.stretch**2
        vector = weight * off
        vector[4:] += stretch / self.stretch**2
        energy = float(weight @ off**2 + stretch @ stretch / self.stretch**2)
        return System(matrix, vector, energy)

    def bounded(self, parameters: Array) -> Array:
        """The parameters with scales clipped around the mean."""
        reach = _MAX_SCALE_SIGMAS * self.deviation[4:]
        scale = np.clip(parameters[4:], self.parameters[4:] - reach, self.parameters[4:] + reach)
        if self.limits is not None:
            scale = np.clip(scale, *self.limits)
        return np.concatenate([parameters[:4], scale])

    def at(self, scale: Array) -> "PoseHypothesis":
        """The same prior with known scales."""
        parameters = np.concatenate([self.parameters[:4], scale])
        return PoseHypothesis(
            parameters,
            np.concatenate([self.deviation[:4], np.full(3, _EQUAL_SCALE_LOG)]),
            self.plain,
            self.stretch,
            self.limits,
        )


def wrapped(angle: float) -> float:
    """An angle between -pi and pi, radians."""
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)
