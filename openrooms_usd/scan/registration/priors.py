"""Gaussian priors of a pose."""

from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.scan.registration.template import directions, turn_of

# Point-to-disc residuals and their normal equations.
#
# A residual is point-to-plane above the disc and point-to-edge beside it, with the robust kernel of
# Geman and McClure.


class System(NamedTuple):
    """Normal equations of a Gauss-Newton step of one pose, or of B.

    Attributes:
        matrix: (..., 7, 7).
        vector: (..., 7) half the gradient of the energy.
    """

    matrix: Array
    vector: Array


class Pairs(NamedTuple):
    """Correspondences of template points and discs, for each of B poses.

    Attributes:
        across: (B, N, 3) unit, normal to the disc.
        height: (B, N) signed point-to-plane distance, metres.
        along: (B, N, 3) unit, in the disc's plane; 0 where the point is above the disc.
        beyond: (B, N) distance from its edge in the plane, metres.
        lever: (B, N, 3) the template's points about its origin, rotated.
        local: (B, N, 3) the same, not rotated.
        turn: (B, 3, 3) about the vertical.
    """

    across: Array
    height: Array
    along: Array
    beyond: Array
    lever: Array
    local: Array
    turn: Array

    def energy(self, weights: Array, width: float) -> Array:
        """(B,) the energies alone, with weights (B, N) and a kernel of some width, metres."""
        squared = self.height**2 + self.beyond**2
        return np.asarray((weights * squared * (width**2 / (width**2 + squared))).sum(axis=-1))

    def robust(self, weights: Array, width: float) -> System:
        """Normal equations with weights (B, N) and a kernel of some width, metres."""
        squared = self.height**2 + self.beyond**2
        w = weights * (width**2 / (width**2 + squared)) ** 2
        J, K = self._slopes(self.across), self._slopes(self.along)
        J_w, K_w = ((slopes * w[..., None]).swapaxes(-1, -2) for slopes in (J, K))
        vector = J_w @ self.height[..., None] + K_w @ self.beyond[..., None]
        return System(J_w @ J + K_w @ K, vector[..., 0])

    def _slopes(self, u: Array) -> Array:
        turning = u[..., 1] * self.lever[..., 0] - u[..., 0] * self.lever[..., 1]
        return np.concatenate([u, turning[..., None], (u @ self.turn) * self.local], axis=-1)


def paired(
    points: Array, normals: Array, targets: Array, radius: float, parameters: Array
) -> Pairs:
    """Correspondences of template points and scan points, which become discs.

    Args:
        points: (B, N, 3) of the template, in its own frame.
        normals: (B, N, 3) unit, there.
        targets: (B, N, 3) points of the scan, or (N, 3) for all.
        radius: Of the discs, metres.
        parameters: (B, 7) poses of the template.
    """
    turn = turn_of(parameters)
    local = points * np.exp(parameters[:, None, 4:])
    lever = local @ turn.swapaxes(-1, -2)
    n = directions(normals, parameters)
    e = lever + parameters[:, None, :3] - targets
    height = np.einsum("...i,...i->...", e, n)
    tangent = e - height[..., None] * n
    length = np.sqrt(np.einsum("...i,...i->...", tangent, tangent))
    beyond = np.maximum(length - radius, 0.0)
    along = tangent * ((beyond > 0.0) / np.maximum(length, 1e-12))[..., None]
    return Pairs(n, height, along, beyond, lever, local, turn)


# Standard deviation of a log scale that is known.
_EQUAL_SCALE_LOG: Final = 0.003
# The same of a heading, radians.
_EQUAL_HEADING_RAD: Final = 0.001
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

    def energy(self, parameters: Array) -> float:
        """Twice the negative logarithm of its density at some parameters, up to a constant."""
        off, stretch = self._off(parameters)
        return float(self.deviation**-2.0 @ off**2 + stretch @ stretch / self.stretch**2)

    def system(self, parameters: Array) -> System:
        """Its normal equations at some parameters."""
        off, stretch = self._off(parameters)
        weight = self.deviation**-2.0
        # Isotropic scale is likelier than anisotropic.
        matrix = np.diag(weight)
        matrix[4:, 4:] += _ANISOTROPIC / self.stretch**2
        vector = weight * off
        vector[4:] += stretch / self.stretch**2
        return System(matrix, vector)

    def _off(self, parameters: Array) -> tuple[Array, Array]:
        """(7,) parameters less the mean, and (3,) the anisotropic part of the log scales."""
        off = parameters - self.parameters
        off[3] = wrapped(float(off[3]))
        return off, _ANISOTROPIC @ (parameters[4:] - self.plain)

    def bounded(self, parameters: Array) -> Array:
        """The parameters with scales clipped around the mean."""
        reach = _MAX_SCALE_SIGMAS * self.deviation[4:]
        scale = np.clip(parameters[4:], self.parameters[4:] - reach, self.parameters[4:] + reach)
        if self.limits is not None:
            scale = np.clip(scale, *self.limits)
        return np.concatenate([parameters[:4], scale])

    def headed(self, yaw: float) -> "PoseHypothesis":
        """The same prior with a known heading, radians."""
        turned = np.where(np.arange(7) == 3, yaw, self.parameters)
        return replace(
            self,
            parameters=turned,
            deviation=np.where(np.arange(7) == 3, _EQUAL_HEADING_RAD, self.deviation),
        )

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
