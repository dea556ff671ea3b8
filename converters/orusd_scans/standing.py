"""How a plain scan stands: which way is up in it, and how long its unit is.

What the file, or somebody, says is compared with the evidence of all axes and all units. Where that
is clear it is followed, with a note; where it is not, or contradicts what was asked, the scan is
refused with the option that settles it. The options are those of the importer: ``--up``,
``--unit``, or ``up:`` and ``unit:`` in a description.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.rooms.verticals import Vertical, verticals

Array = NDArray[np.float64]

UNITS: Final = {
    "m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048, "km": 1000.0,
}  # fmt: skip
AUTO: Final = "auto"
# What files are in, as logarithms of odds.
_USUAL: Final = {"m": 0.0, "mm": -3.0, "cm": -3.0, "in": -4.0, "ft": -4.0, "dm": -5.0, "km": -5.0}
# Heights of rooms: flats, halls and what else there is: weight, median in metres, spread.
_HEIGHTS: Final = ((0.7, 2.6, 0.12), (0.25, 3.4, 0.4), (0.02, 6.0, 1.0))
_NO_HEIGHT: Final = 1e-3
_HEIGHT_WEIGHT: Final = 1.1
_OPEN_WEIGHT: Final = 0.4
# Usual extents of a scan: its height where an end is open, and its length, metres; their spreads.
_TALL, _LONG = (2.6, 0.5), (6.0, 0.8)
# No scan of a room is smaller or larger, metres.
_TALL_LIMITS_M: Final = (0.4, 60.0)
_LONG_LIMITS_M: Final = (0.8, 800.0)
_BEYOND_LIMITS: Final = -8.0
# Log odds from which evidence counts: so much more than the rest is clear, so much less is absurd.
_CLEAR: Final = 2.0
_ALONE: Final = 1.5
_PARTLY: Final = 1.0
_DOUBTFUL: Final = 0.5
_SURE: Final = 1.0
_UNIT_CLEAR: Final = 4.0
_NO_ROOM: Final = -5.0
_ODD_HEIGHT, _ODD_SIZE = -2.5, -1.1
_ABSURD: Final = 6.0
_UPSIDE_DOWN: Final = -3.5
_SOME_WAY: Final = 1.0
_POSITIVE: Final = 1.0
# Axes within this are one, an axis of the file is taken within this, degrees.
_SAME_DEG: Final = 20.0
_AXIS_DEG: Final = 8.0


@dataclass(frozen=True)
class Asked:
    """What the file and the person say.

    Attributes:
        up: (3,) unit; as the format has it where nobody says anything.
        up_said: Whether somebody said so.
        unit: Metres for one unit, and its name; None where it is to be found.
    """

    up: Array
    up_said: bool = False
    unit: tuple[float, str] | None = None


@dataclass(frozen=True, eq=False)
class Standing:
    """How a scan stands.

    Attributes:
        up: (3,) unit, in the scan's frame.
        unit: Metres for one unit of it.
        settled: Options that say what was found where it is not what the file says.
        notes: What people should know.
    """

    up: Array
    unit: float
    settled: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def unit_named(text: str, source: Path) -> tuple[float, str] | None:
    """Metres for one unit, and its name; None for ``auto``.

    Raises:
        InputError: It is no unit and no length.
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


def find_standing(cloud: Cloud, asked: Asked, source: Path) -> Standing:
    """Find how a scan stands.

    Args:
        cloud: Finite points in the file's frame and unit.
        asked: What is said of it.
        source: The file, for messages.

    Raises:
        InputError: What is said is absurd, or the evidence is not clear.
    """
    found, notes = verticals(cloud), list[str]()
    if not found:
        found = (_as_said(cloud, asked.up),)
        if not asked.up_said:
            notes.append(
                f"{_written(asked.up)} is taken for up: the scan shows too little surface to tell"
                " (`--up` says otherwise)"
            )
    unit, name = _unit(found, asked, source, notes)
    up = _up(found, asked, unit, source, notes)
    settled = {} if np.allclose(up, asked.up, atol=1e-3) else {"up": _written(up)}
    if asked.unit is None and name != "m":
        settled["unit"] = name
    return Standing(up, unit, settled, tuple(notes))


def _as_said(cloud: Cloud, up: Array) -> Vertical:
    """The direction that is said, of a scan that shows hardly any surface."""
    heights = cloud.points @ up
    across = cloud.points - heights[:, None] * up
    along = float(np.ptp(np.percentile(heights, (1.0, 99.0))))
    sizes = np.ptp(np.percentile(across, (1.0, 99.0), axis=0), axis=0)
    return Vertical(up, 0.0, np.inf, None, (along, float(np.linalg.norm(sizes))))


def _sizes(one: Vertical, unit: float) -> float:
    """What the sizes say for a vertical and a unit, log odds."""
    tall, long = (length * unit for length in one.extent)
    if one.height is not None:
        height = np.log(max(one.height * unit, 1e-9))
        bells = (
            weight / spread / 2.5066 * np.exp(-0.5 * ((height - np.log(middle)) / spread) ** 2)
            for weight, middle, spread in _HEIGHTS
        )
        score = _HEIGHT_WEIGHT * float(np.log(sum(bells) + _NO_HEIGHT))
    else:
        score = _OPEN_WEIGHT * _near(tall, _TALL)
    for length, (least, most) in ((tall, _TALL_LIMITS_M), (long, _LONG_LIMITS_M)):
        score += 0.0 if least <= length <= most else _BEYOND_LIMITS
    return score + _near(long, _LONG)


def _near(length: float, usual: tuple[float, float]) -> float:
    """Odds of a length by a wide bell around the usual one (Cauchy's, of its logarithm)."""
    off = np.log(max(length, 1e-9) / usual[0]) / usual[1]
    return -float(np.log1p(off**2))


def _unit(
    found: tuple[Vertical, ...], asked: Asked, source: Path, notes: list[str]
) -> tuple[float, str]:
    """Metres for one unit, and its name."""
    fits = {
        name: max(v.line + _sizes(v, length) + _USUAL[name] for v in found)
        for name, length in UNITS.items()
    }
    best, second = sorted(fits, key=lambda name: -fits[name])[:2]
    said, name = asked.unit or (1.0, "m")
    own = max(v.line + _sizes(v, said) for v in found)
    against = 0.0 if np.isclose(UNITS[best], said) else fits[best] - own
    room, other = _room(found, said), f"`--unit {best}` would make it {_room(found, UNITS[best])}"
    if asked.unit is not None:
        if against > _ABSURD:
            raise InputError(
                f"in {_called(name)} the scan would be {room}", place=source, remedy=other
            )
        if against > _CLEAR:
            notes.append(f"in {_called(name)} the scan is {room}; {other}")
        return said, name
    if _sizes(_likeliest(found, UNITS[best]), UNITS[best]) < _NO_ROOM:
        one = max(found, key=lambda v: v.line)
        raise InputError(
            f"in metres the scan would be {room}, and no usual unit makes a room of it",
            place=source,
            remedy="say how many metres one unit is, perhaps"
            f" `--unit {_TALL[0] / (one.height or one.extent[0]):.2g}`, or `--unit m` if it is in"
            " metres all the same",
        )
    if against > _UNIT_CLEAR and fits[best] - fits[second] > _ALONE:
        notes.append(
            f"{_called(best)} are taken for the scan's unit: it is {_room(found, UNITS[best])}, and"
            f" in metres would be {room} (`--unit` says otherwise)"
        )
        return UNITS[best], best
    if against > _DOUBTFUL:
        raise InputError(
            f"the scan's unit is not clear: in metres it would be {room}",
            place=source,
            remedy=f"{other}; `--unit m` if it is in metres",
        )
    if _is_odd(_likeliest(found, said), said):
        notes.append(f"in metres the scan is {room}: should its unit be another, `--unit` says so")
    return said, name


def _is_odd(one: Vertical, unit: float) -> bool:
    """Whether a room of that size would be unusual, though there are such."""
    usual = _near(one.extent[1] * unit, _LONG)
    if one.height is None:
        return _sizes(one, unit) < _ODD_SIZE
    return _sizes(one, unit) - usual < _ODD_HEIGHT


def _likeliest(found: tuple[Vertical, ...], unit: float) -> Vertical:
    return max(found, key=lambda v: v.line + _sizes(v, unit))


def _called(name: str) -> str:
    words = {
        "m": "metres", "dm": "decimetres", "cm": "centimetres", "mm": "millimetres",
        "in": "inches", "ft": "feet", "km": "kilometres",
    }  # fmt: skip
    return words.get(name, name)


def _room(found: tuple[Vertical, ...], unit: float) -> str:
    """The scan's size in words, by its likeliest vertical in that unit."""
    one = _likeliest(found, unit)
    return f"{_length(one.extent[1] * unit)} wide and {_length(one.extent[0] * unit)} high"


def _length(metres: float) -> str:
    for least, name, factor in ((1000.0, "km", 1e-3), (0.5, "m", 1.0), (0.0, "mm", 1e3)):
        if metres >= least:
            return f"{metres * factor:.2g} {name}" if metres < 9.5e5 else f"{metres:.0e} m"
    return f"{metres} m"


def _up(
    found: tuple[Vertical, ...], asked: Asked, unit: float, source: Path, notes: list[str]
) -> Array:
    """(3,) unit, upwards."""
    odds = {id(v): v.line + _sizes(v, unit) for v in found}
    ranked = sorted(found, key=lambda v: -odds[id(v)])
    own = next((v for v in ranked if _between(v.axis, asked.up) < _SAME_DEG), None)
    others = [v for v in ranked if v is not own]
    if not others:
        return _sided(own, asked, source, notes) if own else asked.up
    best = others[0]
    ahead = (odds[id(own)] if own else -np.inf) - odds[id(best)]
    turned = _towards(best)
    remedy = f"`--up {_written(turned)}`, or the direction that is up"
    if asked.up_said:
        if own is not None and ahead < -2.0 * _CLEAR:
            raise InputError(
                f"with {_written(asked.up)} up the room lies on its side: its floor and walls say"
                f" {_written(turned)}",
                place=source,
                remedy=remedy,
            )
        if ahead < -_CLEAR:
            notes.append(
                f"{_written(asked.up)} is up, as it was said; the scan itself says {remedy}"
            )
        return _sided(own, asked, source, notes) if own else asked.up
    if own is not None and ahead >= 0.0:
        if ahead < _SURE:
            notes.append(
                f"{_written(asked.up)} is taken for up, which the scan does not show clearly:"
                f" should the room lie on its side, {remedy}"
            )
        return _sided(own, asked, source, notes)
    alone = len(others) < 2 or odds[id(best)] - odds[id(others[1])] > _ALONE
    way = abs(best.upwards + _bias(best))
    # A part of a room, whose height is not seen, may have a wall for its largest level.
    shown = best.height is not None or (own is not None and ahead < -_CLEAR - _PARTLY)
    if ahead > -_CLEAR or not alone or way < _SOME_WAY or not shown:
        likely = (_written(_towards(v)) for v in others[:2])
        raise InputError(
            f"which way is up is not clear: {_written(asked.up)} hardly is",
            place=source,
            remedy=f"`--up {' or --up '.join(likely)}`, by what the scan shows; `--up"
            f" {_written(asked.up)}` if it is up all the same. A scan of a part of a room also"
            " needs `partial: true`",
        )
    notes.append(
        f"{_written(turned)} is taken for up, and not {_written(asked.up)}: the scan's floor and"
        " walls say so (`--up` says otherwise)"
    )
    return turned


def _sided(own: Vertical, asked: Asked, source: Path, notes: list[str]) -> Array:
    """The asked direction, or the opposite one where all that stands in the room hangs in it."""
    upwards = own.upwards * float(np.sign(own.axis @ asked.up))
    if upwards >= _SOME_WAY:
        return asked.up
    turned = _written(-asked.up)
    if upwards > _UPSIDE_DOWN:
        notes.append(
            f"the scan hardly tells its floor from its ceiling: should it be upside down,"
            f" `--up {turned}`"
        )
        return asked.up
    if asked.up_said:
        raise InputError(
            f"with {_written(asked.up)} up the room is upside down",
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
    return _POSITIVE if _axis_near(one.axis) is not None else 0.0


def _axis_near(axis: Array) -> Array | None:
    """The file's own axis, where one is near."""
    nearest = np.eye(3)[np.abs(axis).argmax()] * np.sign(axis[np.abs(axis).argmax()])
    return nearest if _between(nearest, axis) < _AXIS_DEG else None


def _towards(one: Vertical) -> Array:
    """The likelier direction of a vertical, along the file's axis where that is near."""
    near = _axis_near(one.axis)
    axis = np.round(one.axis, 3) if near is None else near
    return np.asarray(axis if one.upwards + _bias(one) >= 0.0 else -axis) + 0.0


def _written(direction: Iterable[float]) -> str:
    return ",".join(f"{value + 0.0:.3g}" for value in direction)
