"""Gaussian priors of a pose."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.scan.registration.discs import System

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
