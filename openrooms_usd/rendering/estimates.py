"""How far a picture is from the truth: against a reference, or told by its own two halves.

Two figures: the relative mean squared error, which few pixels may dominate, and the robust error,
the same with every pixel's part capped at 1.

The estimate takes what one half has more than the other for a sample of the error. A scale by the
picture itself would hide most of it: where one path has made a pixel a hundred times too bright,
the error is ten thousand, but 1 of the pixel as it is. So the scale is made of what is supported,
and of the rest spread to where it may as well be; where none of it was met the error is that it is
missing (`openrooms_usd.rendering.rare_light`). Last comes how much the estimate itself may be
wrong.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array
from openrooms_usd.rendering import rare_light

# Of pixels unlike a neighbour, so many are at an edge that their samples may have missed.
_EDGES_SHARE: Final = 0.02


@dataclass(frozen=True)
class ErrorEstimate:
    """The estimated errors of one image; None where it does not tell.

    Attributes:
        relative_mse: What `relative_mse` would be against the truth.
        robust: What `robust_error` would be.
    """

    relative_mse: float | None
    robust: float | None


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
    def error(self) -> float | None:
        """The estimated relative mean squared error of their mean; None where they do not tell."""
        return self.estimate.relative_mse

    @property
    def robust_error(self) -> float | None:
        """The estimated robust error of their mean; None where they do not tell."""
        return self.estimate.robust

    @cached_property
    def estimate(self) -> ErrorEstimate:
        """Both."""
        return estimate(self.a, self.b, *self.samples)


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


def estimate_of_ratio(
    picture: NDArray[Any], a: NDArray[Any], b: NDArray[Any], samples_a: int, samples_b: int
) -> ErrorEstimate:
    """The same of a ratio of two means, which differs from the mean of the halves' ratios.

    Both halves may be wrong alike. What the ratio of all samples differs from the mean of the
    halves' is about its bias (the jackknife, Quenouille 1949). A pixel that n samples show as all
    lit, all dark or facing no light may still be at an edge, with a chance of 1 / (n + 2)
    (Laplace's rule of succession). It then equals the neighbour that differs most. How many of the
    pixels beside an edge are candidates is measured (`benchmarks.light.honesty`).

    Args:
        picture: (height, width, components) of all samples.
        a: One half.
        b: The other.
        samples_a: Samples a pixel in ``a``.
        samples_b: Samples a pixel in ``b``.
    """
    whole = np.asarray(picture, dtype=np.float64)
    samples = samples_a + samples_b
    pooled = np.square(whole - (a * samples_a + b * samples_b) / samples)
    unlike = np.zeros_like(whole)
    height, width = whole.shape[:2]
    padded = np.pad(whole, ((1, 1), (1, 1), (0, 0)), mode="edge")
    for y, x in np.ndindex(3, 3):
        beside = padded[y : y + height, x : x + width]
        np.maximum(unlike, np.square(beside - whole), out=unlike)
    beyond = pooled + _EDGES_SHARE / (samples + 2) * unlike
    return estimate(a, b, samples_a, samples_b, beyond)


def estimate(
    a: NDArray[Any],
    b: NDArray[Any],
    samples_a: int = 1,
    samples_b: int = 1,
    beyond: NDArray[Any] | float = 0.0,
) -> ErrorEstimate:
    """The estimated errors of the mean of two independent halves.

    m is the mean of the two weighted by their samples, and v the `variance` of m. s is the
    supported part of m, e the rest as far as one half alone has met it, spread, and f the standard
    error of e. q is the mean over components of (v + (e + f)^2) / ((s + e)^2 + 0.01 M^2). M is the
    mean of m without the pixel that has most beyond its s. Estimated are the means over pixels of q
    and of the same with each component's part capped at 1, each with its own standard error added,
    sqrt(sum q^2) over the number of pixels.

    Args:
        a: (height, width, components) one half.
        b: The other.
        samples_a: Samples a pixel in ``a``.
        samples_b: Samples a pixel in ``b``.
        beyond: (height, width, components) squares that the halves cannot tell, part of v.

    Returns:
        Both errors. None where nothing was met at all, and where one pixel alone has met anything.
    """
    largest = max(float(np.abs(a).max(initial=0.0)), float(np.abs(b).max(initial=0.0)))
    if not 0.0 < largest < np.inf:
        return ErrorEstimate(None, None)
    # In single precision squares of small numbers would vanish.
    a, b = (np.asarray(half / largest, dtype=np.float32) for half in (a, b))
    found = variance(a, b, samples_a, samples_b) + np.asarray(beyond / largest**2, np.float32)
    mean = np.abs(a * samples_a + b * samples_b) / np.float32(samples_a + samples_b)
    a, b = np.abs(a), np.abs(b)
    supported = rare_light.supported(a, b, mean)
    chance = mean - supported
    expected, unsure = rare_light.spread(chance * rare_light.alone(a, b))
    brightness = mean.mean(axis=(0, 1)) - chance.max(axis=(0, 1)) / mean[..., 0].size
    squares = found + np.square(expected + unsure)
    scale = np.square(supported + expected) + 0.01 * np.square(brightness)
    parts = np.divide(squares, scale, out=np.where(squares > 0, np.inf, 0.0), where=scale > 0)
    squared, robust = _careful_mean(parts), _careful_mean(np.minimum(parts, 1.0))
    return ErrorEstimate(squared if np.isfinite(squared) else None, min(robust, 1.0))


def _careful_mean(parts: Array) -> float:
    """The mean of (height, width, components) with its standard error."""
    of_pixels = parts.mean(axis=-1, dtype=np.float64)
    return float(of_pixels.mean() + np.sqrt(np.square(of_pixels).sum()) / of_pixels.size)
