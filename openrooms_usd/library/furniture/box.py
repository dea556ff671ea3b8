"""A plain box: what is kept of things that the library does not know."""

from typing import Final

import numpy as np

from openrooms_usd.library.furniture.joinery import CategorySpec, Parts, Size, Style, board


def plain(size: Size, rng: np.random.Generator) -> Parts:
    """A box with slightly rounded edges."""
    width, depth, height = size
    edge = min(0.004, 0.2 * min(size))
    low, high = (-0.5 * width, -0.5 * depth, 0.0), (0.5 * width, 0.5 * depth, height)
    return {"body": board(low, high, edge)}


SPECS: Final = {
    "box": CategorySpec(
        (0.4, 0.3, 0.3), (0.02, 0.02, 0.02), (20.0, 20.0, 20.0),
        {"plain": Style(plain)}, "a plain box",
    ),
}  # fmt: skip
