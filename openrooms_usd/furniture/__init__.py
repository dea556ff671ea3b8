"""What each word for a thing means, and how to build it: parts as meshes, arrays alone.

From the ground up: `construction` (how parts are made inside), `schemes` (which finishes they
have), `placements` (where small things lie), `joinery` (boards, legs, cloth and other shared
components). `record` is the description of a category, `categories` has those that the library
builds, one module each, and `others` those known only by name. `registry` finds the record of a
word, and `words` has the meaning of the words of captures. Here: a piece from a category, a size, a
style and a seed.
"""

from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np

from openrooms_usd.description.advice import in_metres
from openrooms_usd.description.categories import other_words
from openrooms_usd.errors import InputError
from openrooms_usd.furniture.joinery.pieces import (
    NOTHING_ORDERED,
    FitOptions,
    Furniture,
    Joint,
    Parts,
    Size,
    fitted,
    part_of,
)
from openrooms_usd.furniture.placements import Place
from openrooms_usd.furniture.record import BuiltCategory
from openrooms_usd.furniture.registry import BUILT, built, module_of
from openrooms_usd.spelling import did_you_mean

__all__ = [
    "CATEGORIES",
    "MAX_SIDE",
    "MIN_SIDE",
    "NOTHING_ORDERED",
    "BuiltCategory",
    "FitOptions",
    "Furniture",
    "Joint",
    "Parts",
    "Size",
    "category",
    "check",
    "make",
    "module_of",
    "offered_surfaces",
    "part_of",
    "styles",
]

# Sides of boxes that can be built, metres.
MIN_SIDE: Final = 0.004
MAX_SIDE: Final = 20.0


class _Library(Mapping[str, BuiltCategory]):
    """The records of all categories, loaded when they are asked for."""

    def __getitem__(self, name: str) -> BuiltCategory:
        if name not in BUILT:
            raise KeyError(name)
        return built(name)

    def __iter__(self) -> Iterator[str]:
        return iter(BUILT)

    def __len__(self) -> int:
        return len(BUILT)


CATEGORIES: Final[Mapping[str, BuiltCategory]] = _Library()


def category(name: str) -> BuiltCategory:
    """Look up a category.

    Raises:
        InputError: The library cannot make it.
    """
    if name not in BUILT:
        raise _unknown("category", name, BUILT)
    return CATEGORIES[name]


def offered_surfaces(word: str) -> tuple[Place, ...]:
    """What people use the surfaces of a thing for; nothing where the library cannot build it."""
    return built(word).offers_surfaces if word in BUILT else ()


def styles(name: str, size: Size | None = None) -> tuple[str, ...]:
    """The styles of a category that suit a size (metres); all of them when none does.

    Raises:
        InputError: The library cannot make the category.
    """
    spec = category(name)
    suited = tuple(n for n, style in spec.styles.items() if style.suits(size or spec.size))
    return suited or tuple(spec.styles)


def check(name: str, size: Size, style: str | None, order: FitOptions = NOTHING_ORDERED) -> None:
    """See that an object can be built.

    Args:
        name: Its category.
        size: Width, depth and height of its bounding box, metres.
        style: Its style; None where it is still to be drawn.
        order: What is ordered with it.

    Raises:
        InputError: It cannot; the error's place is the field that is to blame.
    """
    spec = category(name)
    if style is not None and style not in spec.styles:
        known = ", ".join(spec.styles)
        hint = did_you_mean(style, spec.styles)
        said = f"no {name} has the style {style!r}{hint}"
        raise InputError(said, place="style", remedy=f"known: {known}")
    if not all(MIN_SIDE <= side <= MAX_SIDE for side in size):
        hint = in_metres(max(size), MAX_SIDE)
        raise InputError(
            f"a {name} of {size[0]:g} x {size[1]:g} x {size[2]:g} m cannot be built",
            place="size",
            remedy=f"give sides between {MIN_SIDE:g} m and {MAX_SIDE:g} m{hint}",
        )
    for key in ("fronts", "cutouts"):
        takes = spec.styles[style].takes if style else (key,)
        if getattr(order, key) and key not in takes:
            said = f"a {name} of the style {style} has no {key} to choose"
            raise InputError(said, place=key, remedy=f"leave {key} out")


def make(
    name: str, size: Size, style: str, rng: np.random.Generator, order: FitOptions = NOTHING_ORDERED
) -> Furniture:
    """Build an object.

    Args:
        name: Its category.
        size: Width, depth and height of its bounding box, metres; the result has exactly these.
        style: One of the category's styles.
        rng: Draws the details.
        order: What is ordered with it.

    Returns:
        Closed meshes by part, and the joints of those that move. Metres, Z up, origin in the middle
        of the base, front towards -Y.

    Raises:
        InputError: The category, style, size or options cannot be built.
    """
    check(name, size, style, order)
    spec = category(name)
    width, depth, height = np.clip(size, spec.min_size, spec.max_size).tolist()
    ordered = (order,) if spec.styles[style].takes else ()
    return fitted(spec.styles[style].build((width, depth, height), rng, *ordered), size)


def _unknown(what: str, name: str, known: tuple[str, ...]) -> InputError:
    also = other_words() if known is BUILT else None
    return InputError(
        f"no {what} is named {name!r}{did_you_mean(name, known, also)}",
        remedy="`orusd library list` has all" if known is BUILT else f"known: {', '.join(known)}",
    )
