"""Procedural materials: tileable base colour, normal and roughness with a physical size.

Three families (wood, paint, fabric), each with variants. The arithmetic is in double precision and
draws only uniform numbers, so that the eight bits stored are the same on machines whose elementary
functions differ in the last place.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd.errors import InputError
from openrooms_usd.library.pictures import write_png
from openrooms_usd.library.textures import fabric, paint, wood
from openrooms_usd.library.textures.maps import Maps, TextureSet, encoded

__all__ = ["FAMILIES", "MAPS", "TextureSet", "Variant", "make", "write_set"]

Color = tuple[float, float, float]
Make = Callable[[np.random.Generator, Color | None, float | None, int, float], Maps]

# The pictures of a set, by the name of their field.
MAPS: Final = ("albedo", "normal", "roughness")


@dataclass(frozen=True)
class Variant:
    """One look of a family.

    Attributes:
        make: Makes it.
        spread: Its physical size, as a factor of what the caller asks for: yarns need a fine grid,
            floors a wide one.
        finer: Its resolution, as a factor of what the caller asks for.
    """

    make: Make
    spread: float = 1.0
    finer: int = 1


FAMILIES: Final[dict[str, dict[str, Variant]]] = {
    "wood": {
        "panel": Variant(wood.make_panel),
        "floor": Variant(wood.make_floor, spread=2.0, finer=2),
    },
    "paint": {
        name: Variant(partial(paint.make, finish), spread=0.5)
        for name, finish in paint.FINISHES.items()
    },
    "fabric": {
        name: Variant(partial(fabric.make, weave), spread=0.25)
        for name, weave in fabric.WEAVES.items()
    },
}


def make(
    family: str,
    rng: np.random.Generator,
    *,
    color: Color | None = None,
    roughness: float | None = None,
    resolution: int = 512,
    physical_size: float = 1.0,
    variant: str | None = None,
) -> TextureSet:
    """Make a material of a family.

    Args:
        family: A key of `FAMILIES`.
        rng: What is not given is drawn from it.
        color: Mean base colour, scene-linear Rec.709.
        roughness: Mean perceptual roughness.
        resolution: Texels along each side; a floor has twice as many.
        physical_size: Length that a panel of wood covers, metres. A floor covers twice, paint half
            and fabric a quarter of it: `TextureSet.size` says what came out.
        variant: A key of the family; its first by default.

    Raises:
        InputError: There is no such family or variant.
    """
    variants = FAMILIES.get(family)
    if variants is None:
        raise InputError(f"no material family {family!r}", remedy=f"use {', '.join(FAMILIES)}")
    look = variants.get(variant or next(iter(variants)))
    if look is None:
        raise InputError(
            f"{family} has no variant {variant!r}", remedy=f"use {', '.join(variants)}"
        )
    size = physical_size * look.spread
    return encoded(look.make(rng, color, roughness, resolution * look.finer, size), size)


def write_set(textures: TextureSet, folder: Path, name: str) -> None:
    """Write a set as ``<name>_albedo.png``, ``<name>_normal.png`` and ``<name>_roughness.png``.

    Raises:
        OutputError: A file cannot be written.
    """
    for item in MAPS:
        write_png(folder / f"{name}_{item}.png", getattr(textures, item), is_color=item == "albedo")
