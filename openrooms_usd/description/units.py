"""Lengths, angles and masses as people write them: ``240 cm``, ``30 deg``, or plain numbers."""

import math
import re
from collections.abc import Mapping
from typing import Annotated, Any, Final

from pydantic import BeforeValidator, Field

# One of each unit, as a multiple and a divisor: 560 cm divided by 100 is 5.6 m to the last bit,
# 560 times 0.01 is not.
Units = Mapping[str, tuple[float, float]]
METRES: Final[Units] = {
    "mm": (1.0, 1000.0),
    "cm": (1.0, 100.0),
    "m": (1.0, 1.0),
    "in": (254.0, 10_000.0),
    "ft": (3048.0, 10_000.0),
}
KILOGRAMS: Final[Units] = {
    "g": (1.0, 1000.0),
    "kg": (1.0, 1.0),
    "lb": (45_359_237.0, 100_000_000.0),
}
DEGREES: Final[Units] = {"deg": (1.0, 1.0), "°": (1.0, 1.0), "rad": (180.0, math.pi)}

_NUMBER: Final = r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
_QUANTITY: Final = re.compile(rf"\s*({_NUMBER})\s*([A-Za-z°]*)\s*")

# No honest quantity is longer; the bound keeps the patterns fast on hostile text.
_LONGEST: Final = 64


def _quantity(value: Any, units: Units, what: str, plain: str) -> float:
    expected = f"{what}: a number of {plain}, or a number with a unit ({', '.join(units)})"
    if isinstance(value, str):
        match = _QUANTITY.fullmatch(value) if len(value) <= _LONGEST else None
        if match is None or (match[2] and match[2] not in units):
            raise ValueError(expected)
        times, over = units.get(match[2], (1.0, 1.0))
        number = float(match[1]) * times / over
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        number = float(value) if abs(value) < 1e300 else math.inf
    else:
        raise ValueError(expected)
    if not math.isfinite(number):
        raise ValueError(f"{what} that is finite")
    return number


def metres(value: Any) -> float:
    """Read a length: a plain number is metres, a string carries its unit."""
    return _quantity(value, METRES, "a length", "metres")


def degrees(value: Any) -> float:
    """Read an angle: a plain number is degrees, a string carries its unit."""
    return _quantity(value, DEGREES, "an angle", "degrees")


def kilograms(value: Any) -> float:
    """Read a mass: a plain number is kilograms, a string carries its unit."""
    return _quantity(value, KILOGRAMS, "a mass", "kilograms")


def _written(units: Units, example: str) -> Any:
    """The type that editors see: a number, or text with one of the units."""
    pattern = rf"^\s*{_NUMBER}\s*({'|'.join(units)})?\s*$"
    return float | Annotated[str, Field(pattern=pattern, examples=[example])]


_METRES = BeforeValidator(metres, json_schema_input_type=_written(METRES, "240 cm"))
_KILOGRAMS = BeforeValidator(kilograms, json_schema_input_type=_written(KILOGRAMS, "12 kg"))
_DEGREES = BeforeValidator(degrees, json_schema_input_type=_written(DEGREES, "30 deg"))

Length = Annotated[float, _METRES, Field(ge=-1000, le=1000)]
FarLength = Annotated[float, _METRES, Field(ge=-1e8, le=1e8)]
PositiveLength = Annotated[float, _METRES, Field(gt=0, le=1000)]
Angle = Annotated[float, _DEGREES, Field(ge=-3600, le=3600)]
Mass = Annotated[float, _KILOGRAMS, Field(gt=0, le=100_000)]
