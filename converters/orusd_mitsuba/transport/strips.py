"""Strips of rows, in which pictures are rendered one after the other: memory is that of a strip."""

from typing import Final

# Pictures of one strip, as two sums in double precision, bytes.
_MOST_SUMS_BYTES: Final = 1 << 27
# Samples of a pixel that are worth having in one batch, because they are spread evenly.
_SAMPLES_TOGETHER: Final = 64


def strips(
    size: tuple[int, int], planes: int, samples: int, capacity: int, step: int = 1
) -> list[slice]:
    """Rows that are rendered to completion before the next.

    They depend on the request alone, not on the machine: random numbers go by the strip.

    Args:
        size: Height and width of the picture.
        planes: How many pictures there are.
        samples: Of a pixel that a batch shall have.
        capacity: Samples, of all pixels together, that a batch may have.
        step: Strips begin at multiples of this.

    Returns:
        From the top.
    """
    height, width = size
    together = max(1, min(samples, _SAMPLES_TOGETHER))
    pixels = min(capacity // together, _MOST_SUMS_BYTES // (2 * 8 * 3 * planes))
    rows: int = max(1, pixels // (width * step)) * step
    return [slice(top, min(top + rows, height)) for top in range(0, height, rows)]


def most_samples(strip: slice, width: int, capacity: int) -> int:
    """Samples of each pixel of a strip that a batch may have."""
    rows: int = strip.stop - strip.start
    return max(1, capacity // (width * rows))
