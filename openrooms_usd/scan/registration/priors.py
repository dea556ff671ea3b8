"""What is known of a pose before it is fitted."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.registration.discs import System

Array = NDArray[np.float64]

# Logarithms of scale that are as good as equal.
_EQUAL_SCALE_LOG: Final = 0.003
# No scale is more than so many deviations from what is known.
_MAX_SCALE_SIGMAS: Final = 2.5
_EVEN: Final = np.eye(3) - 1.0 / 3.0


@dataclass(frozen=True, eq=False)
class PoseHypothesis:
    """What is known before.

    Attributes:
        parameters: (7,) of the template.
        deviation: (7,) how far from them the truth may be.
        plain: (3,) the last three parameters at the CAD's own size in metres.
        stretch: How much the axes may be stretched against each other, logarithms of scale.
    """

    parameters: Array
    deviation: Array
    plain: Array
    stretch: float = np.inf

    def rows(self, parameters: Array) -> System:
        """Its normal equations about some parameters."""
        off = parameters - self.parameters
        off[3] = wrapped(float(off[3]))
        weight = self.deviation**-2.0
        # A CAD is rather scaled than stretched.
        stretch = _EVEN @ (parameters[4:] - self.plain)
        matrix = np.diag(weight)
        matrix[4:, 4:] += _EVEN / self.stretch**2
        vector = weight * off
        vector[4:] += stretch / self.stretch**2
        energy = float(weight @ off**2 + stretch @ stretch / self.stretch**2)
        return System(matrix, vector, energy)

    def bounded(self, parameters: Array) -> Array:
        """The parameters with a scale within sane limits of what is known."""
        reach = _MAX_SCALE_SIGMAS * self.deviation[4:]
        scale = np.clip(parameters[4:], self.parameters[4:] - reach, self.parameters[4:] + reach)
        return np.concatenate([parameters[:4], scale])

    def at(self, scale: Array) -> "PoseHypothesis":
        """The same, but the last three parameters are known."""
        parameters = np.concatenate([self.parameters[:4], scale])
        return PoseHypothesis(
            parameters,
            np.concatenate([self.deviation[:4], np.full(3, _EQUAL_SCALE_LOG)]),
            self.plain,
            self.stretch,
        )


def wrapped(angle: float) -> float:
    """An angle between -pi and pi, radians."""
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)
