"""Light that few samples have met: which part of a picture is sure, and where the rest may be.

What both of two independent halves have, or a pixel's neighbours, is supported. The rest was met by
chance: a bright path in one pixel tells that there are such paths, and as likely in pixels that
have met none. As many are still unmet as have been met once (Good 1953), so what one half alone has
is spread over the smallest surroundings that have met it several times.
"""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

# So many paths of equal brightness, or more of unequal, make surroundings of a pixel large enough.
_ENOUGH_PATHS: Final = 4.0
# A network that sorts the median of nine to the middle (Smith 1996).
_MEDIAN_OF_NINE: Final = (
    (1, 2),
    (4, 5),
    (7, 8),
    (0, 1),
    (3, 4),
    (6, 7),
    (1, 2),
    (4, 5),
    (7, 8),
    (0, 3),
    (5, 8),
    (4, 7),
    (3, 6),
    (1, 4),
    (2, 5),
    (4, 7),
    (4, 2),
    (6, 4),
    (4, 2),
)


def supported(a: Array, b: Array, mean: Array) -> Array:
    """The part of a picture that more than one pixel of one half tells of.

    Args:
        a: (height, width, components) sizes of one half.
        b: Of the other.
        mean: Of all samples.

    Returns:
        (height, width, components): the smaller half, or the median of the pixel and its
        neighbours, whichever is more; at most the mean.
    """
    return np.asarray(np.minimum(mean, np.maximum(np.minimum(a, b), _median_of_neighbours(mean))))


def alone(a: Array, b: Array) -> Array:
    """How far one half alone has met what a pixel holds, 0 to 1: ((a - b) / (a + b))^2.

    Args:
        a: (height, width, components) sizes of one half.
        b: Of the other.
    """
    total = a + b
    part = np.divide(a - b, total, out=np.zeros_like(total), where=total > 0)
    return np.asarray(np.square(part))


def spread(chance: Array) -> tuple[Array, Array]:
    """What was met by chance, evenly over the smallest block of pixels that has met it often.

    Blocks have sides of 2, 4, 8, ... pixels. One is large enough when (sum x)^2 / sum x^2 of its
    pixels, which is how many paths of equal brightness there would be, reaches `_ENOUGH_PATHS`;
    else the picture is.

    Args:
        chance: (height, width, components), not negative.

    Returns:
        (height, width, components) its mean over the block about each pixel, and how much that may
        be wrong: its part that is 1 over the square root of the paths.
    """
    sums, squares = [chance], [np.square(chance)]
    counts = [np.ones((*chance.shape[:2], 1), dtype=np.float32)]
    while max(sums[-1].shape[:2]) > 1:
        for levels in (sums, squares, counts):
            levels.append(_halved(levels[-1]))
    means, errors = sums[-1] / counts[-1], np.sqrt(squares[-1]) / counts[-1]
    for level in reversed(range(1, len(sums) - 1)):
        total, square, count = sums[level], squares[level], counts[level]
        often = (total > 0) & (np.square(total) >= _ENOUGH_PATHS * square)
        means = np.where(often, total / count, _doubled(means, total.shape))
        errors = np.where(often, np.sqrt(square) / count, _doubled(errors, total.shape))
    return _doubled(means, chance.shape), _doubled(errors, chance.shape)


def _median_of_neighbours(picture: Array) -> Array:
    height, width = picture.shape[:2]
    padded = np.pad(picture, ((1, 1), (1, 1), (0, 0)), mode="edge")
    nine = [padded[y : y + height, x : x + width] for y in range(3) for x in range(3)]
    for low, high in _MEDIAN_OF_NINE:
        nine[low], nine[high] = np.minimum(nine[low], nine[high]), np.maximum(nine[low], nine[high])
    return nine[4]


def _halved(sums: Array) -> Array:
    """Sums over two by two."""
    height, width = sums.shape[:2]
    for axis, side in enumerate((height, width)):
        starts = np.arange(0, side, 2)
        sums = np.add.reduceat(sums, starts, axis=axis)
    return sums


def _doubled(means: Array, shape: tuple[int, ...]) -> Array:
    """Each for two by two, as many as there are."""
    return means.repeat(2, axis=0).repeat(2, axis=1)[: shape[0], : shape[1]]
