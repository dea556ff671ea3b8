"""How far a picture is from the truth: against a reference, or told by its own two halves."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Halves:
    """Two independent estimates of one image.

    Attributes:
        a: (height, width, components) one.
        b: The other.
        samples: Samples a pixel in each.
    """

    a: NDArray[Any]
    b: NDArray[Any]
    samples: tuple[int, int]

    @property
    def deviation(self) -> Array:
        """(height, width, components) the estimated standard error of their mean."""
        return np.asarray(np.sqrt(variance(self.a, self.b, *self.samples)))

    @property
    def error(self) -> float:
        """The `relative_error` of their mean."""
        return relative_error(self.a, self.b, *self.samples)


def relative_mse(picture: NDArray[Any], reference: NDArray[Any]) -> float:
    """The relative mean squared error of a picture.

    The mean over pixels of (x - ref)^2 / (ref^2 + 0.01 M^2) for each component, M the reference's
    mean in that component, and the mean of these.

    Args:
        picture: (height, width, components).
        reference: What it should be, of the same shape.
    """
    return float(np.mean(_relative_squares(picture, reference)))


def robust_error(picture: NDArray[Any], reference: NDArray[Any]) -> float:
    """The `relative_mse` with each pixel's part of it capped at 1: no single one dominates it.

    It lies between 0 and 1. Black where there is light costs at most 1, so much is a pixel worth
    that says nothing; one that is a thousand times too bright costs no more.

    Args:
        picture: (height, width, components).
        reference: What it should be, of the same shape.
    """
    return float(np.mean(np.minimum(_relative_squares(picture, reference), 1.0)))


def _relative_squares(picture: NDArray[Any], reference: NDArray[Any]) -> Array:
    """The squared error of each component of each pixel; 0 where the reference has no light."""
    x, ref = np.asarray(picture, np.float64), np.asarray(reference, np.float64)
    scale = ref**2 + 0.01 * ref.mean(axis=(0, 1)) ** 2
    return np.asarray(np.divide((x - ref) ** 2, scale, out=np.zeros_like(x), where=scale > 0))


def variance(a: NDArray[Any], b: NDArray[Any], samples_a: int = 1, samples_b: int = 1) -> Array:
    """The unbiased estimate of the variance of the mean of two independent halves.

    Args:
        a: One half.
        b: The other, of the same shape.
        samples_a: Samples a pixel in ``a``.
        samples_b: Samples a pixel in ``b``.
    """
    total = samples_a + samples_b
    return np.asarray((a - b) ** 2 * (samples_a * samples_b / total**2))


def relative_error(
    a: NDArray[Any], b: NDArray[Any], samples_a: int = 1, samples_b: int = 1
) -> float:
    """Estimated relative mean squared error of the mean of two independent halves.

    With m the mean of the two weighted by their samples, M its mean over the picture, and v the
    `variance` of m, (a - b)^2 n_a n_b / (n_a + n_b)^2, which for equal halves is (a - b)^2 / 4:
    the mean over pixels of v / (m^2 + 0.01 M^2) for each component, and the mean of these.

    Args:
        a: (height, width, components) one half.
        b: The other.
        samples_a: Samples a pixel in ``a``.
        samples_b: Samples a pixel in ``b``.
    """
    mean = (a * samples_a + b * samples_b) / (samples_a + samples_b)
    found = variance(a, b, samples_a, samples_b)
    scale = mean**2 + 0.01 * mean.mean(axis=(0, 1)) ** 2
    return float(np.mean(np.divide(found, scale, out=np.zeros_like(scale), where=scale > 0)))
