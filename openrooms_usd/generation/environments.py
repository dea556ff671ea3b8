"""The world outside a generated room at its moment: a place, a day, an hour and the weather."""

import math
from datetime import date, datetime, timedelta, timezone
from typing import Any, Final

import numpy as np

from openrooms_usd.draws import generator
from openrooms_usd.generation.moments import MOMENTS, moment_of
from openrooms_usd.generation.rooms import Generated
from openrooms_usd.generation.shell import Gap
from openrooms_usd.library.styles.assignment.weights import drawn
from openrooms_usd.library.surroundings.sunlight import sun_position

# How often a room stands in each kind of place, and how high up; homes and what is in towns.
_HOMES: Final = {"street": 4.0, "garden": 4.0, "hills": 1.5, "city": 1.5, "courtyard": 0.7}
_TOWN: Final = {"street": 1.5, "garden": 0.7, "hills": 0.3, "city": 4.0, "courtyard": 2.0}
_IN_TOWNS: Final = frozenset(
    {
        "hotel", "bookstore", "library", "classroom", "computer_cluster", "conference_room",
        "copy_room", "mail_room", "gym", "lobby", "office", "stairs",
    }
)  # fmt: skip
_UPSTAIRS: Final = frozenset(["bedroom", "bathroom", "closet"])
_BELOW: Final = frozenset(["garage", "basement", "lobby", "bookstore"])
# How high houses and trees stand before most of the sky, degrees: a lower sun seldom shines in.
_SKYLINE_DEG: Final = {
    "street": 18.0,
    "garden": 12.0,
    "hills": 0.0,
    "city": 28.0,
    "courtyard": 32.0,
}
# The part of the sky that clouds cover.
_CLOUDS: Final = (0.0, 0.5)
# A window that reaches lower than this opens onto the land, metres.
_LOW_SILL_M: Final = 0.3


def place(room: Generated, sun: float | None = None) -> dict[str, Any]:
    """What lies before the windows of a generated room: keys of its ``lights.environment``.

    Args:
        room: The room.
        sun: How high the sun stands that shall shine in, degrees; None where none shall.
    """
    rng = generator(room.seed, "generate", room.room_type, "outside")
    weights = _TOWN if room.room_type in _IN_TOWNS else _HOMES
    if sun is not None:
        weights = {name: weight for name, weight in weights.items() if _SKYLINE_DEG[name] < sun}
    scene = drawn(rng, weights or {"hills": 1.0})
    return {
        "scene": scene,
        "storey": _storey(rng, room, scene),
        "facing": _front(room),
        "clouds": round(float(rng.uniform(*_CLOUDS)), 2),
    }


def _storey(rng: np.random.Generator, room: Generated, scene: str) -> int:
    low = any(gap.kind == "window" and gap.sill < _LOW_SILL_M for gap in room.shell.gaps)
    if room.room_type in _BELOW or (low and scene not in ("city", "courtyard")):
        return 0
    if scene in ("city", "courtyard"):
        return int(rng.integers(1, 4))
    return int(rng.random() < (0.75 if room.room_type in _UPSTAIRS else 0.3))


def _front(room: Generated) -> float:
    """Degrees counter-clockwise from +X: outwards through the wall with most glass."""

    def glass(index: int) -> float:
        gaps = [gap for gap in room.shell.gaps if gap.side == index]
        return sum(_area(gap) * (1.0 if gap.kind == "window" else 0.1) for gap in gaps)

    sides = room.shell.sides
    outward = -sides[max(range(len(sides)), key=glass)].inward
    return round(math.degrees(math.atan2(outward[1], outward[0])) % 360.0, 1) % 360.0


def _area(gap: Gap) -> float:
    return gap.width * (gap.top - gap.sill)


# Where rooms lie: degrees north or south of the equator, and how often south of it.
_LATITUDE_DEG: Final = (30.0, 58.0)
_SOUTH_SHARE: Final = 0.2
_LONGITUDE_DEG: Final = (-120.0, 150.0)
# Clocks are read to so many minutes; days are tried until the sun stands as it shall.
_CLOCK_MIN: Final = 10
_MAX_DAYS: Final = 40
_FIRST_DAY: Final = date(2026, 1, 1)
# How far from facing a window the sun stands that shines in, degrees to either side.
_INTO_WINDOW_DEG: Final = 50.0


def environment(room: Generated) -> dict[str, Any]:
    """The world outside at the moment of a room: a place and an hour, and where north lies."""
    moment = MOMENTS[moment_of(room.room_type, room.seed)]
    rng = generator(room.seed, "generate", room.room_type, "environment")
    south = rng.random() < _SOUTH_SHARE
    latitude = round(float(rng.uniform(*_LATITUDE_DEG)) * (-1.0 if south else 1.0), 1)
    longitude = round(float(rng.uniform(*_LONGITUDE_DEG)), 1)
    local = _when(rng, latitude, longitude, moment.elevation)
    sun = sun_position(local, latitude, longitude)
    found: dict[str, Any] = {
        "from": "outside",
        **place(room, sun.elevation if moment.shines_in else None),
        "latitude": latitude,
        "longitude": longitude,
        "date": local.date().isoformat(),
        "time": f"{local:%H:%M}",
        "north": round(_north(rng, room, sun.azimuth, moment.shines_in)),
        "turbidity": round(float(rng.uniform(*moment.turbidity)), 1),
    }
    return found | ({"overcast": True} if moment.overcast else {})


def _when(
    rng: np.random.Generator, latitude: float, longitude: float, elevation: tuple[float, float]
) -> datetime:
    """A local time at which the sun stands within a range of heights, or as near as it comes."""
    zone = timezone(timedelta(hours=round(longitude / 15.0)))
    wanted = float(rng.uniform(*elevation))
    best: tuple[float, datetime] | None = None
    for _ in range(_MAX_DAYS):
        day = _FIRST_DAY + timedelta(days=int(rng.integers(365)))
        start = datetime(day.year, day.month, day.day, tzinfo=zone)
        # Mornings as often as evenings.
        half = 12 * 60 * int(rng.integers(2))
        for minute in range(half, half + 12 * 60, _CLOCK_MIN):
            local = start + timedelta(minutes=minute)
            off = abs(sun_position(local, latitude, longitude).elevation - wanted)
            if best is None or off < best[0]:
                best = off, local
        assert best is not None
        if elevation[0] <= sun_position(best[1], latitude, longitude).elevation <= elevation[1]:
            break
    assert best is not None
    return best[1]


def _north(rng: np.random.Generator, room: Generated, azimuth: float, shines_in: bool) -> float:
    """Where north lies, degrees from +Y; so that the sun stands before a window if it shall."""
    windows = [gap for gap in room.shell.gaps if gap.kind == "window"]
    if not (shines_in and windows):
        return float(rng.uniform(-180.0, 180.0))
    inward = room.shell.sides[windows[int(rng.integers(len(windows)))].side].inward
    outward = math.degrees(math.atan2(-inward[1], -inward[0]))
    sun = outward + float(rng.uniform(-_INTO_WINDOW_DEG, _INTO_WINDOW_DEG))
    # Azimuths run clockwise from north, angles of the room counter-clockwise from +X.
    return (sun - 90.0 + azimuth + 180.0) % 360.0 - 180.0
