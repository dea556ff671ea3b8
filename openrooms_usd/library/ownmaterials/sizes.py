"""How many metres a material's tile covers."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from openrooms_usd.errors import InputError
from openrooms_usd.usd.surfaces import Texture
from openrooms_usd.usd.textures import picture_facts

# What is taken where nobody says: the usual width of scanned materials, metres.
ASSUMED_WIDTH_M: Final = 1.0
# The sides that a texture can sensibly have, metres: a weave under a lens, a field from the air.
SMALLEST, LARGEST = 1e-4, 1e4
# Pictures of one material whose proportions differ by more are stretched, which is said.
_EQUAL_PROPORTION: Final = 0.01


def tile_size(
    given: float | tuple[float, float] | None,
    ratio: float,
    stated: tuple[float, float] | None,
    place: Path,
    losses: list[str],
) -> tuple[float, float]:
    """Width and height of a tile in metres.

    Args:
        given: What the user says: the width, or both sides.
        ratio: Height of the pictures by their width.
        stated: What the files say.
        place: The material, for errors.
        losses: Receives what was assumed.

    Raises:
        InputError: It is no size.
    """
    if given is None and stated is None:
        losses.append(f"its size is stated nowhere; {ASSUMED_WIDTH_M:g} m wide is assumed")
    size = given or stated or ASSUMED_WIDTH_M
    width, height = (size, size * ratio) if isinstance(size, int | float) else size
    if not all(math.isfinite(side) and SMALLEST <= side <= LARGEST for side in (width, height)):
        raise InputError(
            f"a tile of {width:g} by {height:g} m is none",
            place=place,
            remedy=f"give the metres that the pictures cover, {SMALLEST:g} to {LARGEST:g}",
        )
    return float(width), float(height)


def proportions(textures: Mapping[str, Texture], losses: list[str]) -> float:
    """Height of the pictures by their width; those that differ from the base colour are named.

    Raises:
        InputError: A picture cannot be read.
    """
    ratios: dict[str, float] = {}
    for texture in textures.values():
        facts = picture_facts(texture.file)
        # One texel is a constant, of any proportions.
        if (facts.width, facts.height) != (1, 1):
            ratios[texture.file] = facts.height / facts.width
    common = next(iter(ratios.values()), 1.0)
    losses.extend(
        f"{Path(file).name}: its proportions differ from the others'; it is stretched"
        for file, ratio in ratios.items()
        if abs(ratio - common) > _EQUAL_PROPORTION * common
    )
    return common
