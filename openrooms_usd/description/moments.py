"""Dates, times of day and time zones as people write them."""

import re
from datetime import date, time, timedelta, timezone, tzinfo
from typing import Annotated, Any, Final
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from pydantic import BeforeValidator, Field

_DAY: Final = r"[0-9]{4}-[0-9]{2}-[0-9]{2}"
_CLOCK: Final = r"[0-9]{1,2}:[0-9]{2}(:[0-9]{2})?"
# The sun's position is known well enough between these.
_YEARS: Final = (1800, 2200)


def day(value: Any) -> str:
    """Read a date: year, month and day with hyphens."""
    expected = f"a date from {_YEARS[0]} to {_YEARS[1]} such as 2026-06-21"
    if not isinstance(value, str) or not re.fullmatch(_DAY, value):
        raise ValueError(expected)
    try:
        found = date.fromisoformat(value)
    except ValueError:
        raise ValueError(f"{expected}, on the calendar") from None
    if not _YEARS[0] <= found.year <= _YEARS[1]:
        raise ValueError(expected)
    return value


def clock_time(value: Any) -> str:
    """Read a time of day: hours and minutes, perhaps seconds, with colons."""
    expected = "a time from 00:00 to 23:59 such as 14:30"
    if not isinstance(value, str) or not re.fullmatch(_CLOCK, value):
        raise ValueError(expected)
    hour, minute, *second = map(int, value.split(":"))
    try:
        # Not fromisoformat: from Python 3.14 on that takes 24:00.
        return time(hour, minute, second[0] if second else 0).isoformat()
    except ValueError:
        raise ValueError(expected) from None


def utc_offset(value: Any) -> float | str:
    """Read an offset from UTC: hours, or a time zone that this machine knows."""
    expected = "hours ahead of UTC from -15 to 15, or a time zone such as Europe/Berlin"
    if isinstance(value, str):
        try:
            zone(value, 0.0)
        except (ZoneInfoNotFoundError, ValueError, OSError):
            raise ValueError(f"{expected} that this machine knows") from None
        return value
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= 15.0:
        raise ValueError(expected)
    return float(value)


def zone(given: float | str | None, longitude: float) -> tzinfo:
    """The time zone of what `utc_offset` accepted.

    Args:
        given: Hours, a name, or None for the whole hours nearest to the sun's own time.
        longitude: Degrees, positive eastwards.
    """
    if isinstance(given, str):
        return ZoneInfo(given)
    hours = round(longitude / 15.0) if given is None else given
    return timezone(timedelta(hours=hours))


Day = Annotated[
    str,
    BeforeValidator(
        day,
        json_schema_input_type=Annotated[str, Field(pattern=f"^{_DAY}$", examples=["2026-06-21"])],
    ),
]
ClockTime = Annotated[
    str,
    BeforeValidator(
        clock_time,
        json_schema_input_type=Annotated[str, Field(pattern=f"^{_CLOCK}$", examples=["14:30"])],
    ),
]
UtcOffset = Annotated[
    float | str,
    BeforeValidator(
        utc_offset,
        json_schema_input_type=Annotated[float, Field(ge=-15, le=15)]
        | Annotated[str, Field(examples=["Europe/Berlin"])],
    ),
]
