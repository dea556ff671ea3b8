"""Materials without any picture: a base colour, a roughness and a metallic value."""

import math
from collections.abc import Mapping
from typing import Any, Final

from openrooms_usd.errors import InputError
from openrooms_usd.library.ownmaterials.material import F0, OwnMaterial
from openrooms_usd.usd.surfaces import PreviewSurface

# How many numbers each constant has.
_NUMBERS: Final = {"base_color": 3, "roughness": 1, "metallic": 1}


def from_constants(constants: Mapping[str, Any], *, name: str = "constant") -> OwnMaterial:
    """A material of constants.

    Args:
        constants: ``base_color`` (three numbers, scene-linear Rec.709), ``roughness`` (perceptual)
            and ``metallic``, each within 0 and 1; those that are missing keep the defaults of
            `PreviewSurface`. ``normal`` may be none: there is no other constant normal.
        name: For people.

    Raises:
        InputError: There is another key, or a value that is none.
    """
    values = {key: _value(name, key, value) for key, value in constants.items() if key != "normal"}
    if constants.get("normal") not in (None, "none"):
        raise InputError(
            "a normal that is the same everywhere says nothing",
            place=f"{name}.normal",
            remedy="leave it out, or give a folder with a normal map",
        )
    return OwnMaterial(name, PreviewSurface(**values, f0=F0))


def _value(name: str, key: str, given: Any) -> Any:
    count = _NUMBERS.get(key)
    if count is None:
        raise InputError(
            f"a material has no {key!r}", place=name, remedy=f"use {', '.join(_NUMBERS)}"
        )
    numbers = [given] if isinstance(given, int | float) else list(given or ())
    fits = len(numbers) == count and all(
        isinstance(n, int | float) and math.isfinite(n) and 0.0 <= n <= 1.0 for n in numbers
    )
    if not fits:
        wanted = "three numbers" if count == 3 else "a number"
        raise InputError(
            f"{given!r} is not {wanted} within 0 and 1",
            place=f"{name}.{key}",
            remedy="colours are scene-linear: 0.18 is a middle grey",
        )
    return float(numbers[0]) if count == 1 else tuple(map(float, numbers))
