"""What the library makes: each style in its usual size, built once for all tests that look."""

from functools import cache

import numpy as np

from openrooms_usd.furniture import CATEGORIES, Furniture, Size
from openrooms_usd.furniture.joinery.pieces import fitted

STYLES = [(name, style) for name, spec in CATEGORIES.items() for style in spec.styles]


def usual(name: str, style: str) -> Size:
    """The usual size of a style, metres."""
    return CATEGORIES[name].styles[style].size or CATEGORIES[name].size


@cache
def planned(name: str, style: str) -> Furniture:
    """A style as its builder leaves it, by the first seed."""
    made = CATEGORIES[name].styles[style].build(usual(name, style), np.random.default_rng(0))
    return made if isinstance(made, Furniture) else Furniture(made)


@cache
def piece(name: str, style: str) -> Furniture:
    """A style as `make` gives it, by the first seed."""
    return fitted(planned(name, style), usual(name, style))
