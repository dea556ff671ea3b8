"""Parametric furniture: semantic parts as meshes, from a category, a size, a style and a seed."""

import re
from difflib import get_close_matches
from typing import Final

import numpy as np

from openrooms_usd.errors import InputError
from openrooms_usd.library.furniture import cabinet, chair, lamp, sofa, table
from openrooms_usd.library.furniture.joinery import CategorySpec, Parts, Size, fitted
from openrooms_usd.library.furniture.stand_in import STAND_INS

__all__ = [
    "CATEGORIES",
    "MAX_SIDE",
    "MIN_SIDE",
    "STAND_INS",
    "CategorySpec",
    "Parts",
    "Size",
    "category",
    "make",
    "part_of",
    "styles",
]

# Sides of boxes that can be built, metres.
MIN_SIDE: Final = 0.02
MAX_SIDE: Final = 20.0


CATEGORIES: Final[dict[str, CategorySpec]] = {
    "chair": CategorySpec(
        (0.46, 0.53, 0.84), (0.34, 0.36, 0.55), (1.1, 1.1, 1.4),
        chair.STYLES, "a seat for one, with a back",
    ),
    "table": CategorySpec(
        (1.4, 0.8, 0.74), (0.3, 0.3, 0.3), (5.0, 2.5, 1.2),
        table.STYLES, "a top on legs, dining or low",
    ),
    "sofa": CategorySpec(
        (2.0, 0.92, 0.82), (0.6, 0.6, 0.55), (4.5, 2.6, 1.3),
        sofa.STYLES, "a padded seat for several",
    ),
    "cabinet": CategorySpec(
        (0.9, 0.42, 0.9), (0.25, 0.2, 0.25), (6.0, 1.2, 3.2),
        cabinet.STYLES, "doors, drawers or open shelves",
    ),
    "floor_lamp": CategorySpec(
        (0.42, 0.42, 1.55), (0.16, 0.16, 0.8), (0.9, 0.9, 2.4),
        lamp.FLOOR_STYLES, "a lamp that stands on the floor", emits=True, lumen=1500.0,
    ),
    "table_lamp": CategorySpec(
        (0.3, 0.3, 0.48), (0.12, 0.12, 0.2), (0.6, 0.6, 0.9),
        lamp.TABLE_STYLES, "a lamp that stands on a table", "surface", emits=True, lumen=600.0,
    ),
    "ceiling_lamp": CategorySpec(
        (0.45, 0.45, 0.35), (0.1, 0.1, 0.05), (1.6, 1.6, 2.5),
        lamp.CEILING_STYLES, "a lamp at the ceiling", "ceiling", emits=True, lumen=3000.0,
    ),
}  # fmt: skip


_SPECS: Final = {**STAND_INS, **CATEGORIES}


def category(name: str) -> CategorySpec:
    """Look up a category or a stand-in.

    Raises:
        InputError: The library cannot make it.
    """
    if name not in _SPECS:
        raise _unknown("category", name, tuple(CATEGORIES))
    return _SPECS[name]


def styles(name: str, size: Size | None = None) -> tuple[str, ...]:
    """The styles of a category that suit a size (metres); all of them when none does.

    Raises:
        InputError: The library cannot make the category.
    """
    spec = category(name)
    suited = tuple(n for n, style in spec.styles.items() if style.suits(size or spec.size))
    return suited or tuple(spec.styles)


def make(name: str, size: Size, style: str, rng: np.random.Generator) -> Parts:
    """Build an object.

    Args:
        name: Its category, or one of `STAND_INS`.
        size: Width, depth and height of its bounding box, metres; the result has exactly these.
        style: One of the category's styles.
        rng: Draws the details.

    Returns:
        Closed meshes by part; instances of one part are numbered (``leg_0``, ``leg_1``). Metres,
        Z up, origin in the middle of the base, front towards -Y.

    Raises:
        InputError: The category, the style or the size is none that can be built.
    """
    spec = category(name)
    if style not in spec.styles:
        raise _unknown(f"style of {name}", style, tuple(spec.styles))
    if not all(MIN_SIDE <= side <= MAX_SIDE for side in size):
        raise InputError(
            f"a {name} of {size[0]:g} x {size[1]:g} x {size[2]:g} m cannot be built",
            remedy=f"give sides between {MIN_SIDE:g} m and {MAX_SIDE:g} m",
        )
    width, depth, height = np.clip(size, spec.least, spec.most).tolist()
    return fitted(spec.styles[style].build((width, depth, height), rng), size)


def part_of(mesh_name: str) -> str:
    """The semantic part of a mesh: ``leg`` of ``leg_2``."""
    return re.sub(r"_\d+$", "", mesh_name)


def _unknown(what: str, name: str, known: tuple[str, ...]) -> InputError:
    near = get_close_matches(name, known, n=1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    return InputError(f"no {what} is named {name!r}", remedy=f"{hint}known: {', '.join(known)}")
