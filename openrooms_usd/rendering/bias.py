"""How far a method is from the truth beyond its noise, told by few independent unbiased paths.

Some pixels, spread over the picture and drawn by chance, are rendered again by following every path
to its end. The bias of the whole is the sum of the differences over the sum of that reference.

The worst tenth of pixels is harder: of numbers with noise the worst tenth is always bad. So the
pixels are put into groups, neighbours of alike brightness; every other pixel says in which tenth of
the groups the bias is worst and of which sign, and the others measure it there. Then the two halves
of the pixels change places, and the mean counts. Where there is no bias this
is 0 in the mean; where there is, noise may hide the worst groups, so that it is rather too small.
"""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Ints

# Blocks of the picture, across and down; each is halved by brightness.
_BLOCKS: Final = (5, 4)
_BRIGHTNESSES: Final = 2
_WORST_SHARE: Final = 0.1
# What a group has at least in the mean, for there to be a worst tenth.
_LEAST_PIXELS_A_GROUP: Final = 3
_LEAST_PATHS_A_GROUP: Final = 24
# Of equal share in a sum, for its spread to tell anything: (sum x)^2 / sum x^2.
_LEAST_EFFECTIVE_PIXELS: Final = 4.0


@dataclass(frozen=True)
class Bias:
    """What is stated of one channel, relative to the light of the reference.

    Attributes:
        total: Of the whole picture: -0.01 is one per cent too dark.
        total_error: Its standard error.
        worst_tenth: Mean size of the bias in the tenth of the pixels where it is worst; about 0,
            and now and then below, where there is none. None where the pixels are too few.
        worst_tenth_error: Its standard error.
        pixels: How many were rendered again.
    """

    total: float
    total_error: float
    worst_tenth: float | None
    worst_tenth_error: float | None
    pixels: int


@dataclass(frozen=True, eq=False)
class SparsePixels:
    """Pixels of a picture, one by chance in each cell of a grid.

    Attributes:
        width: Of the picture, pixels.
        height: Of the picture, pixels.
        numbers: (N,) row by row of the picture.
        weights: (N,) how many pixels each stands for.
    """

    width: int
    height: int
    numbers: NDArray[np.uint32]
    weights: Array

    @staticmethod
    def draw(width: int, height: int, count: int, rng: np.random.Generator) -> "SparsePixels":
        """About so many pixels of a picture.

        Args:
            width: Of the picture.
            height: Of the picture.
            count: How many; at most all.
            rng: Draws the pixel of each cell.
        """
        across = int(np.clip(round((count * width / height) ** 0.5), 1, width))
        down = int(np.clip(round(count / across), 1, height))
        x, y = (np.arange(n + 1) * size // n for n, size in ((across, width), (down, height)))
        columns, rows = (
            np.broadcast_to(a, (down, across)) for a in (np.diff(x)[None], np.diff(y)[:, None])
        )
        at_x = x[:-1] + (rng.random((down, across)) * columns).astype(np.int64)
        at_y = y[:-1, None] + (rng.random((down, across)) * rows).astype(np.int64)
        numbers = (at_y * width + at_x).ravel().astype(np.uint32)
        return SparsePixels(width, height, numbers, (columns * rows).ravel().astype(np.float64))

    def groups(self, values: Array) -> Ints:
        """(N,) the number of each pixel's group: its block of the picture, halved by a value."""
        rows, columns = np.divmod(self.numbers.astype(np.int64), self.width)
        across, down = _BLOCKS
        block = rows * down // self.height * across + columns * across // self.width
        found = block * _BRIGHTNESSES
        for number in np.unique(block):
            inside = block == number
            found[inside] += values[inside] > np.median(values[inside])
        return np.asarray(np.unique(found, return_inverse=True)[1])


def measure(
    found: NDArray[Any],
    reference: NDArray[Any],
    pixels: SparsePixels,
    brightness: NDArray[Any],
    paths: int = 1,
) -> Bias | None:
    """The bias of one channel.

    Args:
        found: (N, C) by the method, at the pixels.
        reference: (N, C) unbiased samples of the same. Each pixel has random numbers of its own;
            the two of a pixel may share them, which takes away noise.
        pixels: Which they are.
        brightness: (N,) of the finished picture there, which has other random numbers than these.
        paths: Of which each pixel is the mean.

    Returns:
        None where the reference has seen nothing of the channel, or in a few pixels alone.
    """
    # Components add up: what counts is light.
    a, b = (np.asarray(each, np.float64).sum(axis=1) for each in (found, reference))
    total = _ratio(a - b, b, pixels.weights)
    if total is None:
        return None
    tenth: tuple[float, float] | tuple[None, None] = None, None
    a_group = len(pixels.numbers) / (_BRIGHTNESSES * np.prod(_BLOCKS))
    if a_group >= _LEAST_PIXELS_A_GROUP and a_group * paths >= _LEAST_PATHS_A_GROUP:
        groups = pixels.groups(np.asarray(brightness, np.float64))
        tenth = _worst_tenth(a, b, pixels.weights, groups) or tenth
    return Bias(*total, tenth[0], tenth[1], len(pixels.numbers))


def _worst_tenth(
    found: Array, reference: Array, weights: Array, groups: Ints
) -> tuple[float, float] | None:
    """The mean size of the bias where it is worst, and its standard error.

    Args:
        found: (N,) by the method.
        reference: (N,) by the reference.
        weights: (N,) of the pixels.
        groups: (N,) their groups.
    """
    second = np.zeros(len(groups), dtype=bool)
    second[np.argsort(groups, kind="stable")[1::2]] = True
    measured = []
    for half in (second, ~second):
        told = _worst_groups(found[half], reference[half], weights[half], groups[half])
        signs = np.where(half, 0.0, told[groups])
        inside = signs != 0.0
        off = signs * (found - reference)
        ratio = _ratio(*(each[inside] for each in (off, reference, weights)))
        if ratio is None:
            return None
        measured.append(ratio)
    (x, x_error), (y, y_error) = measured
    # Both see all pixels: as if they were one measurement, which is rather too careful.
    return 0.5 * (x + y), float(np.hypot(x_error, y_error) / np.sqrt(2.0))


def _worst_groups(found: Array, reference: Array, weights: Array, groups: Ints) -> Array:
    """(G,) the sign of the bias of the groups that are the worst tenth; 0 for others.

    A group whose bias may be noise counts less: b^3 / (b^2 + s^2) with its standard error s. Here
    the bias is relative to the mean of both, so that neither few paths nor none make it endless.
    """
    off, scale = found - reference, 0.5 * (found + reference)
    count = int(groups.max()) + 1
    told = _ratios(off, scale, weights, groups, count)
    bias, error = np.where(np.isnan(told), (0.0, 1.0), told).T
    power = bias**2 + error**2
    surely = np.divide(bias**2, power, out=np.zeros(count), where=power > 0.0) * np.abs(bias)
    most = max(1, round(_WORST_SHARE * count))
    worst = np.argsort(-surely, kind="stable")[:most]
    signs = np.zeros(count)
    signs[worst] = np.where(bias[worst] < 0.0, -1.0, 1.0)
    return signs


def _ratio(values: Array, scale: Array, weights: Array) -> tuple[float, float] | None:
    """The one of `_ratios` of all pixels together; None where there is none."""
    ratio, error = _ratios(values, scale, weights, np.zeros(len(values), np.int64), 1)[0].tolist()
    return None if np.isnan(ratio) else (ratio, error)


def _ratios(values: Array, scale: Array, weights: Array, groups: Ints, count: int) -> Array:
    """(G, 2) ratios of two weighted sums over the independent pixels of groups, and their errors.

    Where the lower sum has much noise, the plain ratio is too large in the mean; Beale's estimator
    (Tin, Comparison of Some Ratio Estimators, 1965) takes most of that away. The standard error is
    that of ratio estimators (Cochran, Sampling Techniques, 1977, section 6.3); that the pixels are
    spread evenly makes it rather too large.

    Returns:
        No number where too few pixels make the lower sum, or none, while the upper has something.
    """

    def summed(each: Array) -> Array:
        return np.bincount(groups, each, count).astype(np.float64)

    upper, lower = weights * values, weights * scale
    pixels, total, above = summed(np.ones(len(values))), summed(lower), summed(upper)
    squares, mixed, highs = summed(lower**2), summed(upper * lower), summed(upper**2)
    told = (total > 0.0) & (total**2 >= _LEAST_EFFECTIVE_PIXELS * squares)
    some = np.maximum(pixels, 1.0)
    below = np.where(told, total, 1.0)
    apart = some / np.maximum(some - 1.0, 1.0) / below**2
    plain = above / below
    along, across = squares - total**2 / some, mixed - above * total / some
    ratio = (plain + apart * across) / (1.0 + apart * along)
    residuals = np.maximum(highs - 2.0 * plain * mixed + plain**2 * squares, 0.0)
    found = np.stack([ratio, np.sqrt(apart * residuals)], axis=1)
    found[~told] = np.nan
    # Of nothing there is no share, whatever it is compared with.
    found[highs == 0.0] = 0.0
    return found
