"""Which way is up in a scan: what is said, against the verticals that it shows."""

from collections.abc import Iterable
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.scan.rooms.verticals import Vertical
from orusd_scans.scanunits import Asked, size_odds

# Log odds between two verticals: from which the one is clearly better, partly so, surely the right
# one, and alone.
_CLEAR_LOG_ODDS: Final = 2.0
_PARTLY_LOG_ODDS: Final = 1.0
_SURE_LOG_ODDS: Final = 1.0
_ALONE_LOG_ODDS: Final = 1.5
# Log odds of a vertical's upper end: from which it is told, and below which it is the lower one.
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
    odds = {id(v): v.line + size_odds(v, unit) for v in found}
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
                f"with {written(asked.up)} up the room lies on its side: its floor and walls say"
                f" {written(turned)}",
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
            f"which way is up is not clear: {written(asked.up)} hardly is",
            place=source,
            remedy=f"`--up {' or --up '.join(likely)}`, by what the scan shows; `--up"
            f" {written(asked.up)}` if it is up all the same. A scan of a part of a room also"
            " needs `partial: true`",
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
            f"the scan hardly tells its floor from its ceiling: should it be upside down,"
            f" `--up {turned}`"
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
