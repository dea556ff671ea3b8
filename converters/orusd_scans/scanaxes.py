"""Which way is up in a scan: what is said, against the verticals that it shows."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.scan.rooms.verticals import Vertical

# How long a scan's unit is: what is said, against the sizes that rooms have.

UNITS: Final = {
    "m": 1.0,
    "dm": 0.1,
    "cm": 0.01,
    "mm": 0.001,
    "in": 0.0254,
    "ft": 0.3048,
    "km": 1000.0,
}
AUTO: Final = "auto"
# What files are in, as logarithms of odds.
_USUAL_LOG_ODDS: Final = {
    "m": 0.0,
    "mm": -3.0,
    "cm": -3.0,
    "in": -4.0,
    "ft": -4.0,
    "dm": -8.0,
    "km": -8.0,
}
_RARE_LOG_ODDS: Final = -5.0
# Heights of rooms: flats, halls and what else there is: weight, median in metres, spread.
_HEIGHTS_M: Final = ((0.7, 2.6, 0.12), (0.25, 3.4, 0.4), (0.02, 6.0, 1.0))
_NO_HEIGHT_DENSITY: Final = 1e-3
_HEIGHT_WEIGHT: Final = 1.1
_OPEN_WEIGHT: Final = 0.4
# Usual extents of a scan: its height where an end is open, and its length, metres; their spreads.
_TALL_M_AND_SPREAD, _LONG_M_AND_SPREAD = (2.6, 0.5), (6.0, 0.8)
# Seats, beds and tables: how high they usually are, and the spread; how much that counts at
# most for the unit and for the axis, log odds.
_TOPS_M_AND_SPREAD: Final = (0.7, 0.4)
_MOST_OF_TOPS, _MOST_OF_TOPS_UP = 3.5, 1.0
# No scan of a room is smaller or larger, nor is its ceiling lower or higher, metres.
_TALL_LIMITS_M: Final = (0.0, 60.0)
_LONG_LIMITS_M: Final = (0.8, 800.0)
_CEILING_LIMITS_M: Final = (1.6, 60.0)
_BEYOND_LOG_ODDS: Final = -8.0
# Log odds of another unit from which it is reported, is used, and the stated one is rejected.
_DOUBTFUL_LOG_ODDS: Final = 0.5
_CLEAR_UNIT_LOG_ODDS: Final = 4.0
_ABSURD_LOG_ODDS: Final = 6.0
# Log odds of a size below which a room is unusual.
_ODD_HEIGHT_LOG_ODDS, _ODD_SIZE_LOG_ODDS = -2.5, -1.1


@dataclass(frozen=True)
class Asked:
    """What the file and the person say.

    Attributes:
        up: (3,) unit; by default that of the format.
        up_said: Whether it was stated.
        unit: Metres for one unit, and its name; None where it is to be found.
    """

    up: Array
    up_said: bool = False
    unit: tuple[float, str] | None = None


def unit_named(text: str, source: Path) -> tuple[float, str] | None:
    """Metres for one unit, and its name; None for ``auto``.

    Raises:
        InputError: It is neither a unit nor a length.
    """
    if text == AUTO:
        return None
    if text in UNITS:
        return UNITS[text], text
    try:
        length = float(text)
    except ValueError:
        length = 0.0
    if not 0.0 < length < np.inf:
        raise InputError(
            f"the unit {text[:20]!r} is not known",
            place=source,
            remedy=f"give {', '.join(UNITS)}, auto, or how many metres one unit is, such as 0.3048",
        )
    return length, f"units of {length:g} m"


def find_unit(
    found: tuple[Vertical, ...], asked: Asked, source: Path, notes: list[str]
) -> tuple[float, str]:
    """Metres for one unit, and its name.

    Args:
        found: The verticals that the scan may have.
        asked: What is said of it.
        source: The file, for messages.
        notes: Receives what people should know.

    Raises:
        InputError: What is said is absurd, or the evidence is not clear.
    """
    likeliest = {name: _likeliest(found, asked, length) for name, length in UNITS.items()}
    fits = {
        name: _fit(one, asked, UNITS[name]) + _USUAL_LOG_ODDS[name]
        for name, one in likeliest.items()
    }
    best, second = sorted(fits, key=lambda name: -fits[name])[:2]
    said, name = asked.unit or (1.0, "m")
    own = _likeliest(found, asked, said)
    against = 0.0 if np.isclose(UNITS[best], said) else fits[best] - _fit(own, asked, said)
    room, better = _room(own, said), _room(likeliest[best], UNITS[best])
    other = f"`--unit {best}` would make it {better}"
    if asked.unit is not None:
        if against > _ABSURD_LOG_ODDS and not _is_room(own, said):
            raise InputError(
                f"in {_plural(name)} the scan would be {room}", place=source, remedy=other
            )
        if against > _CLEAR_LOG_ODDS:
            notes.append(f"in {_plural(name)} the scan is {room}; {other}")
        return said, name
    possible = _is_room(likeliest[best], UNITS[best])
    alone = fits[best] - fits[second] > _ALONE_LOG_ODDS
    if against > _CLEAR_UNIT_LOG_ODDS and alone and possible:
        notes.append(
            f"{_plural(best)} are taken for the scan's unit: it is {better}, and in metres would be"
            f" {room} (`--unit` says otherwise)"
        )
        return UNITS[best], best
    if not _is_room(own, said):
        if possible and _USUAL_LOG_ODDS[best] > _RARE_LOG_ODDS:
            raise InputError(
                f"the scan's unit is not clear: in metres it would be {room}",
                place=source,
                remedy=f"{other}; `--unit m` if it is in metres",
            )
        one = max(found, key=lambda v: v.line)
        likely = _TALL_M_AND_SPREAD[0] / max(one.height or one.extent[0], 1e-12)
        raise InputError(
            f"in metres the scan would be {room}, and no usual unit gives the size of a room",
            place=source,
            remedy=f"give the metres of one unit, perhaps `--unit {likely:.2g}`, or `--unit m` if "
            "it really is in metres",
        )
    if against > _DOUBTFUL_LOG_ODDS:
        notes.append(f"in metres the scan is {room}, which is assumed; {other}")
    elif _is_odd(own, said):
        notes.append(f"in metres the scan is {room}: if its unit is different, give `--unit`")
    return said, name


def _fit(one: Vertical, asked: Asked, unit: float) -> float:
    """What speaks for a vertical and a unit: its surfaces, its size, its tops, what is said."""
    said = _CLEAR_LOG_ODDS * (_between(one.axis, asked.up) < _SAME_DEG)
    return one.line + size_odds(one, unit) - _tops_odds(one, unit, _MOST_OF_TOPS) + said


def _tops_odds(one: Vertical, unit: float, most: float) -> float:
    """What the heights of seats, beds and tables say against a vertical, at most so much."""
    if one.tops is None:
        return 0.0
    middle, spread = _TOPS_M_AND_SPREAD
    off = np.log(max(one.tops * unit, 1e-9) / middle) / spread
    return min(0.5 * float(off) ** 2, most)


def _is_room(one: Vertical, unit: float) -> bool:
    """Whether there are rooms of that size."""
    lengths = (one.height or one.extent[0], *one.extent)
    limits = (_CEILING_LIMITS_M if one.height else _TALL_LIMITS_M, _TALL_LIMITS_M, _LONG_LIMITS_M)
    return all(
        least <= length * unit <= most
        for length, (least, most) in zip(lengths, limits, strict=True)
    )


def size_odds(one: Vertical, unit: float) -> float:
    """What the sizes say for a vertical and a unit, log odds."""
    tall, long = (length * unit for length in one.extent)
    if one.height is not None:
        height = np.log(max(one.height * unit, 1e-9))
        bells = (
            weight / spread / 2.5066 * np.exp(-0.5 * ((height - np.log(middle)) / spread) ** 2)
            for weight, middle, spread in _HEIGHTS_M
        )
        score = _HEIGHT_WEIGHT * float(np.log(sum(bells) + _NO_HEIGHT_DENSITY))
    else:
        score = _OPEN_WEIGHT * _near(tall, _TALL_M_AND_SPREAD)
    score += 0.0 if _is_room(one, unit) else _BEYOND_LOG_ODDS
    return score + _near(long, _LONG_M_AND_SPREAD)


def _near(length: float, usual: tuple[float, float]) -> float:
    """Odds of a length by a wide bell around the usual one (Cauchy's, of its logarithm)."""
    off = np.log(max(length, 1e-9) / usual[0]) / usual[1]
    return -float(np.log1p(off**2))


def _is_odd(one: Vertical, unit: float) -> bool:
    """Whether a room of that size would be unusual, though there are such."""
    usual = _near(one.extent[1] * unit, _LONG_M_AND_SPREAD)
    if one.height is None:
        return size_odds(one, unit) < _ODD_SIZE_LOG_ODDS
    return size_odds(one, unit) - usual < _ODD_HEIGHT_LOG_ODDS


def _likeliest(found: tuple[Vertical, ...], asked: Asked, unit: float) -> Vertical:
    return max(found, key=lambda v: _fit(v, asked, unit))


def _plural(name: str) -> str:
    words = {
        "m": "metres",
        "dm": "decimetres",
        "cm": "centimetres",
        "mm": "millimetres",
        "in": "inches",
        "ft": "feet",
        "km": "kilometres",
    }
    return words.get(name, name)


def _room(one: Vertical, unit: float) -> str:
    """The scan's size in words, by a vertical of it and a unit."""
    return f"{_length(one.extent[1] * unit)} wide and {_length(one.extent[0] * unit)} high"


def _length(metres: float) -> str:
    for least, name, factor in ((1000.0, "km", 1e-3), (0.5, "m", 1.0), (0.0, "mm", 1e3)):
        if metres >= least:
            rounded = float(f"{metres * factor:.2g}")
            return f"{rounded:g} {name}" if metres < 9.5e5 else f"{metres:.0e} m"
    return f"{metres} m"


# Log odds between two verticals: from which the one is clearly better, partly so, surely the right
# one, and alone.
_CLEAR_LOG_ODDS: Final = 2.0
_PARTLY_LOG_ODDS: Final = 1.0
_SURE_LOG_ODDS: Final = 1.0
_ALONE_LOG_ODDS: Final = 1.5
# Log odds of a vertical's upper end: from which it is reported, and below which it is the lower
# one.
_UPWARDS_LOG_ODDS: Final = 1.0
_UPSIDE_DOWN_LOG_ODDS: Final = -3.5
# By so much files of another axis have its positive end up.
_POSITIVE_LOG_ODDS: Final = 1.0
# Axes within this are one, an axis of the file is taken within this, degrees.
_SAME_DEG: Final = 20.0
_AXIS_DEG: Final = 8.0


def find_up(
    found: tuple[Vertical, ...], asked: Asked, unit: float, source: Path, notes: list[str]
) -> Array:
    """(3,) unit, upwards.

    Args:
        found: The verticals that the scan may have.
        asked: What is said of it.
        unit: Metres for one unit of it.
        source: The file, for messages.
        notes: Receives what people should know.

    Raises:
        InputError: What is said is absurd, or the evidence is not clear.
    """
    odds = {
        id(v): v.line + size_odds(v, unit) - _tops_odds(v, unit, _MOST_OF_TOPS_UP) for v in found
    }
    ranked = sorted(found, key=lambda v: -odds[id(v)])
    own = next((v for v in ranked if _between(v.axis, asked.up) < _SAME_DEG), None)
    others = [v for v in ranked if v is not own]
    if not others:
        return _sided(own, asked, source, notes) if own else asked.up
    best = others[0]
    ahead = (odds[id(own)] if own else -np.inf) - odds[id(best)]
    turned = _towards(best)
    remedy = f"`--up {written(turned)}`, or the direction that is up"
    if asked.up_said:
        if own is not None and ahead < -2.0 * _CLEAR_LOG_ODDS:
            raise InputError(
                f"with {written(asked.up)} up the room lies on its side: its floor and walls "
                f"suggest {written(turned)}",
                place=source,
                remedy=remedy,
            )
        if ahead < -_CLEAR_LOG_ODDS:
            notes.append(
                f"{written(asked.up)} is up, as it was said; the scan itself says {remedy}"
            )
        return _sided(own, asked, source, notes) if own else asked.up
    if own is not None and ahead >= 0.0:
        if ahead < _SURE_LOG_ODDS:
            notes.append(
                f"{written(asked.up)} is taken for up, which the scan does not show clearly:"
                f" should the room lie on its side, {remedy}"
            )
        return _sided(own, asked, source, notes)
    alone = len(others) < 2 or odds[id(best)] - odds[id(others[1])] > _ALONE_LOG_ODDS
    way = abs(best.upwards + _bias(best))
    # A part of a room, whose height is not seen, may have a wall for its largest level.
    shown = best.height is not None or (
        own is not None and ahead < -_CLEAR_LOG_ODDS - _PARTLY_LOG_ODDS
    )
    if ahead > -_CLEAR_LOG_ODDS or not alone or way < _UPWARDS_LOG_ODDS or not shown:
        likely = (written(_towards(v)) for v in others[:2])
        raise InputError(
            f"the up direction is not clear: {written(asked.up)} is unlikely",
            place=source,
            remedy=f"`--up {' or --up '.join(likely)}`, as the scan suggests; `--up "
            f"{written(asked.up)}` if that really is up. A scan of a part of a room also "
            "needs `partial: true`",
        )
    notes.append(
        f"{written(turned)} is taken for up, and not {written(asked.up)}: the scan's floor and"
        " walls say so (`--up` says otherwise)"
    )
    return turned


def _sided(own: Vertical, asked: Asked, source: Path, notes: list[str]) -> Array:
    """The asked direction, or the opposite one where all that stands in the room hangs in it."""
    upwards = own.upwards * float(np.sign(own.axis @ asked.up))
    if upwards >= _UPWARDS_LOG_ODDS:
        return asked.up
    turned = written(-asked.up)
    if upwards > _UPSIDE_DOWN_LOG_ODDS:
        notes.append(
            "floor and ceiling of the scan are hard to distinguish: if it is upside down, give "
            f"`--up {turned}`"
        )
        return asked.up
    if asked.up_said:
        raise InputError(
            f"with {written(asked.up)} up the room is upside down",
            place=source,
            remedy=f"`--up {turned}`",
        )
    notes.append(f"{turned} is taken for up: the scan is upside down (`--up` says otherwise)")
    return -asked.up


def _between(one: Array, other: Array) -> float:
    """The angle between two axes, either way, degrees."""
    return float(np.rad2deg(np.arccos(min(1.0, abs(float(one @ other))))))


def _bias(one: Vertical) -> float:
    """Files of another axis have their positive one up, rather than the negative."""
    return _POSITIVE_LOG_ODDS if _axis_near(one.axis) is not None else 0.0


def _axis_near(axis: Array) -> Array | None:
    """The file's own axis, where one is near."""
    nearest = np.eye(3)[np.abs(axis).argmax()] * np.sign(axis[np.abs(axis).argmax()])
    return nearest if _between(nearest, axis) < _AXIS_DEG else None


def _towards(one: Vertical) -> Array:
    """The likelier direction of a vertical, along the file's axis where that is near."""
    near = _axis_near(one.axis)
    axis = np.round(one.axis, 3) if near is None else near
    return np.asarray(axis if one.upwards + _bias(one) >= 0.0 else -axis) + 0.0


def written(direction: Iterable[float]) -> str:
    """A direction as the option says it."""
    return ",".join(f"{value + 0.0:.3g}" for value in direction)
