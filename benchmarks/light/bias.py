"""How wrong pictures are: their noise and their bias, against a reference of two halves."""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array
from openrooms_usd.colorimetry import luminance
from openrooms_usd.rendering.estimates import robust_error

Pair = tuple[NDArray[Any], NDArray[Any]]

_WORST_SHARE: Final = 0.1


@dataclass(frozen=True)
class Bias:
    """What is wrong with the mean of a picture, however many samples it has.

    Attributes:
        total: Of the picture's mean, relative to the reference's.
        deviation: The standard error of that.
        worst: The mean relative bias of the worst tenth of the pixels. Which these are, and of
            which sign, is told by one half of all samples; how much it is, by the other: so noise
            does not count as bias.
        worst_deviation: The standard error of that.
    """

    total: float
    deviation: float
    worst: float
    worst_deviation: float

    @property
    def columns(self) -> dict[str, float]:
        """In percent, for a table."""
        return {
            "bias, %": 100 * self.total,
            "+-": 100 * self.deviation,
            "worst tenth, %": 100 * self.worst,
            "+- ": 100 * self.worst_deviation,
        }


def bias_of(found: Pair, truth: Pair, tile: int = 2) -> Bias:
    """The bias in luminance.

    Args:
        found: (H, W, 3) two independent estimates.
        truth: Two independent references.
        tile: Pixels are taken together in squares of so many by so many: a pixel of its own would
            need a longer reference.
    """
    measured, true = ([_tiles(luminance(x), tile) for x in pair] for pair in (found, truth))
    expected = (true[0] + true[1]) / 2.0
    mean = float(expected.mean())
    if mean <= 0.0:
        return Bias(0.0, 0.0, 0.0, 0.0)
    apart = [a - b for a, b in zip(measured, true, strict=True)]
    noise = (apart[0] - apart[1]) / 2.0
    scale = np.sqrt(expected**2 + 0.01 * mean**2)
    one, other = (difference / scale for difference in apart)
    worst = np.concatenate([_worst(one, other), _worst(other, one)])
    return Bias(
        total=float(np.mean(apart)) / mean,
        deviation=float(np.sqrt(np.mean(noise**2) / noise.size)) / mean,
        worst=float(worst.mean()),
        worst_deviation=float(worst.std() / np.sqrt(worst.size)),
    )


def _worst(chosen_by: Array, measured_by: Array) -> Array:
    """What is measured of the worst, its sign that of what they were chosen by."""
    order = np.argsort(-np.abs(chosen_by), kind="stable")
    worst = order[: max(1, int(_WORST_SHARE * order.size))]
    return np.asarray(np.sign(chosen_by[worst]) * measured_by[worst])


def _tiles(pixels: Array, tile: int) -> Array:
    """(N,) the means of whole tiles."""
    height, width = (size // tile * tile for size in pixels.shape)
    shape = height // tile, tile, width // tile, tile
    return np.asarray(pixels[:height, :width].reshape(shape).mean(axis=(1, 3))).ravel()


def mse_of(picture: NDArray[Any], truth: Pair) -> float:
    """The relative MSE without the reference's own noise: (x - a)(x - b) in place of a square."""
    x, a, b = (np.asarray(one, np.float64) for one in (picture, *truth))
    mean = (a + b) / 2.0
    scale = mean**2 + 0.01 * mean.mean(axis=(0, 1)) ** 2
    product = (x - a) * (x - b)
    return float(np.mean(np.divide(product, scale, out=np.zeros_like(x), where=scale > 0)))


def robust_of(picture: NDArray[Any], truth: Pair) -> float:
    """The robust error less what the reference itself has of it, a quarter of its halves'."""
    mean = (np.asarray(truth[0], np.float64) + truth[1]) / 2.0
    return max(0.0, robust_error(picture, mean) - robust_error(*truth) / 4.0)
