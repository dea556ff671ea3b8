"""Which way up a user's model stands, and how long its unit is.

Formats say little: OBJ has neither an up axis nor a unit, and programs with Z up write it as well
as those with Y up. So if it is not given, the posture is chosen in which the model's size differs
least from the usual size of its category. If it is given, an implausible one is reported.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.joinery.pieces import Size

Up = Literal["Y", "Z"]

# Metres for one unit of files.
_UNITS: Final = {"1 m": 1.0, "1 dm": 0.1, "1 cm": 0.01, "1 mm": 0.001, "1 in": 0.0254}
# Each metre beyond the least and the most that a category has weighs so much more than one between.
_BEYOND: Final = 3.0
# How much better another posture must fit than the format's own: sums of logarithms of ratios.
_MARGIN: Final = 0.3
_UNIT_MARGIN: Final = 0.7
# Programs put the floor at zero: what a file's axis gains that begins there, and the part of its
# length that is as good as zero.
_AT_ZERO: Final = 0.4
_ZERO_SHARE: Final = 0.01
# Formats that state their axes are believed longer.
_STATED_MARGIN: Final = 1.5
# Sides this many times beyond the limits are reported.
_TOLD: Final = 1.15


@dataclass(frozen=True)
class Usual:
    """The sizes of a category: width, depth and height, metres."""

    name: str
    size: Size
    least: Size
    most: Size

    def misfit(self, extent: Array) -> float:
        """How far a box is from the usual one; which side is its front does not matter."""
        off = np.abs(np.log(_sorted(extent) / _sorted(self.size)))
        return float((off + _BEYOND * np.log(self.beyond(extent))).sum())

    def proportions(self, extent: Array, size: Size) -> float:
        """How much a box would be distorted to have a size."""
        ratio = np.log(_sorted(extent) / _sorted(size))
        return float(np.abs(ratio - ratio.mean()).sum())

    def beyond(self, extent: Array) -> Array:
        """(3,) how many times each side is beyond the least or the most, at least 1."""
        sides = _sorted(extent)
        return np.maximum(1.0, np.maximum(sides / _sorted(self.most), _sorted(self.least) / sides))


@dataclass(frozen=True)
class Posture:
    """How a model stands.

    Attributes:
        up: The file's up axis.
        unit: Metres for one unit of the file.
        notes: What was presumed, or looks wrong.
    """

    up: Up
    unit: float
    notes: tuple[str, ...] = ()


def posture(
    low: Sequence[float],
    high: Sequence[float],
    own: Posture,
    usual: Usual | None,
    *,
    up: Up | None = None,
    unit: float | None = None,
    size: Size | None = None,
    stated: bool = False,
) -> Posture:
    """Find how a model stands.

    Args:
        low: (3,) least coordinates along the file's axes, in its unit.
        high: (3,) the greatest.
        own: As its format has it.
        usual: The sizes of its category; None where that has none.
        up: The up axis, if given.
        unit: Metres for one unit, likewise.
        size: The box that it is stretched to, if any: then its unit is of no account.
        stated: Whether its format states the axis and the unit.
    """
    least, sides = np.asarray(low, float), np.subtract(high, low).astype(float)
    said = Posture(up or own.up, unit or own.unit)
    if usual is None or not sides.max() > 0.0:
        return said
    sides = np.maximum(sides, 1e-6 * sides.max())
    at_zero = np.abs(least) < _ZERO_SHARE * sides

    def misfit(one: Posture) -> float:
        box = one.unit * standing(sides, one.up)
        axis, other = (1, 2) if one.up == "Y" else (2, 1)
        floating = _AT_ZERO * float(at_zero[other] and not at_zero[axis])
        return floating + (usual.proportions(box, size) if size else usual.misfit(box))

    def wanted(one: Posture) -> float:
        margin = _STATED_MARGIN if stated else _MARGIN
        turned, scaled = one.up != said.up, one.unit != said.unit
        return misfit(one) + margin * turned + (margin + _UNIT_MARGIN) * scaled

    choices = [said, *_others(said, up, unit, size)]
    best = min(choices, key=wanted)
    notes = [*_posture_notes(best, said, sides, usual)]
    if size is None:
        notes += _odd(best, sides, usual, [said, *_others(said, None, None)])
    return Posture(best.up, best.unit, tuple(notes))


def standing(sides: Array, up: Up) -> Array:
    """(3,) width, depth and height of a box along a file's axes."""
    return sides[[0, 2, 1]] if up == "Y" else sides


def _sorted(box: "Array | Size") -> Array:
    """The longer side, the shorter one, and the height."""
    width, depth, height = box
    return np.array([max(width, depth), min(width, depth), height])


def _others(
    said: Posture, up: Up | None, unit: float | None, size: Size | None = None
) -> Iterator[Posture]:
    """What else it may be: what is said stays, and a size makes the unit be of no account."""
    ups: tuple[Up, ...] = (said.up,) if up else ("Y", "Z")
    units = (said.unit,) if unit or size else tuple(dict.fromkeys((said.unit, *_UNITS.values())))
    for way in ups:
        for length in units:
            if (way, length) != (said.up, said.unit):
                yield Posture(way, length)


def _posture_notes(best: Posture, said: Posture, sides: Array, usual: Usual) -> Iterator[str]:
    """What is taken in place of what the format has."""
    box = _written(best.unit * standing(sides, best.up))
    if best.up != said.up:
        yield (
            f"{best.up} is taken for its up axis: so it is {box}, as a {usual.name} is (`up` says"
            " otherwise)"
        )
    if best.unit != said.unit:
        yield f"{_named(best.unit)} is taken for its unit: so it is {box} (`unit` says otherwise)"


def _odd(best: Posture, sides: Array, usual: Usual, others: Sequence[Posture]) -> Iterator[str]:
    """That no such thing has this size, and what to do about it."""
    box = best.unit * standing(sides, best.up)
    if usual.beyond(box).max() <= _TOLD:
        return
    fitting = [
        one
        for one in others
        if usual.beyond(one.unit * standing(sides, one.up)).max() <= _TOLD
        and usual.misfit(one.unit * standing(sides, one.up)) < usual.misfit(box)
    ]
    nearest = min(
        fitting, key=lambda one: usual.misfit(one.unit * standing(sides, one.up)), default=None
    )
    remedy = f"give its `size`, such as {list(usual.size)}"
    if nearest is not None:
        changes = [f"up: {nearest.up}"] if nearest.up != best.up else []
        changes += [f"unit: {_named(nearest.unit)}"] if nearest.unit != best.unit else []
        remedy = f"`{', '.join(changes)}` would make it"
        remedy += f" {_written(nearest.unit * standing(sides, nearest.up))}"
    yield (
        f"it is {_written(box)}, an impossible size for a {usual.name} (usually "
        f"{_written(usual.size)}): {remedy}"
    )


def _named(unit: float) -> str:
    return next((name for name, length in _UNITS.items() if length == unit), f"{unit:g} m")


def _written(box: "Array | Size") -> str:
    return " x ".join(f"{float(side):.3g}" for side in box) + " m"
