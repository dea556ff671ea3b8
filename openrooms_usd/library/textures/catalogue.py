"""All families by substance, and how a material is ordered by its name."""

from dataclasses import replace
from difflib import get_close_matches
from typing import Final

from openrooms_usd.description.substances import Substance
from openrooms_usd.draws import generator
from openrooms_usd.errors import InputError
from openrooms_usd.library.textures import (
    fabric,
    leather,
    metal,
    paint,
    plastic,
    rough_stone,
    rubber,
    specular_stone,
    wood,
)
from openrooms_usd.library.textures.base.expanse import laid, worn
from openrooms_usd.library.textures.base.family import Color, Family, Order
from openrooms_usd.library.textures.base.maps import TextureSet, encoded

DEFAULT_RESOLUTION: Final = 1024
# Quotients of lengths are no whole numbers.
_LESS: Final = 1e-6

FAMILIES: Final[dict[Substance, dict[str, Family]]] = {
    "fabric": fabric.FAMILIES,
    "leather": leather.FAMILIES,
    "metal": metal.FAMILIES,
    "paint": paint.FAMILIES,
    "plastic": plastic.FAMILIES,
    "rough_stone": rough_stone.FAMILIES,
    "rubber": rubber.FAMILIES,
    "specular_stone": specular_stone.FAMILIES,
    "wood": wood.FAMILIES,
}

_SUBSTANCES: Final = {name: kind for kind, families in FAMILIES.items() for name in families}


def substance_of(name: str) -> Substance:
    """The substance of a family.

    Raises:
        InputError: There is no such family.
    """
    if name not in _SUBSTANCES:
        near = get_close_matches(name, _SUBSTANCES, 3)
        remedy = f"did you mean {' or '.join(near)}?" if near else "`orusd materials list` has all"
        raise InputError(f"no material family {name!r}", remedy=remedy)
    return _SUBSTANCES[name]


def family_of(name: str) -> Family:
    """A family by its name.

    Raises:
        InputError: There is no such family.
    """
    return FAMILIES[substance_of(name)][name]


def make(
    name: str,
    number: int,
    *,
    color: Color | None = None,
    roughness: float | None = None,
    resolution: int = DEFAULT_RESOLUTION,
    size: float | None = None,
) -> TextureSet:
    """Make one material of a family: name and number alone say which, in whatever room.

    Args:
        name: The family.
        number: Which of its materials, from 0.
        color: Mean base colour, scene-linear Rec.709, in place of the material's own.
        roughness: Mean perceptual roughness, in place of the material's own.
        resolution: Texels along each side.
        size: Physical length of each side, metres; by default the family's usual size.

    Raises:
        InputError: There is no such family.
    """
    family = family_of(name)
    metres = family.size if size is None else size
    order = Order(generator(number, "textures", name), resolution, metres, color, roughness)
    over = replace(order, rng=generator(number, "textures", name, "over"))
    count = _laid(family, order)
    if count > 1:
        small = replace(order, resolution=resolution // count, size=metres / count)
        maps = laid(family.make(small), over, count)
    else:
        maps = family.make(order)
    return encoded(worn(maps, over, substance_of(name)), metres)


def _laid(family: Family, order: Order) -> int:
    """How often a family's picture is laid along a side: a power of two that divides it."""
    count = 1
    while (
        2 * count <= min(family.laid, order.size / family.size + _LESS)
        and order.resolution % (2 * count) == 0
    ):
        count *= 2
    return count
