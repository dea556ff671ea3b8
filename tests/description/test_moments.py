"""Moments of daylight: what clocks, calendars and time zones say."""

from datetime import UTC, datetime

import pytest
from pydantic import ValidationError

from openrooms_usd.description import dump_room, parse_room
from openrooms_usd.description.lights import SkyEnvironment


def sky(**changes: object) -> SkyEnvironment:
    given = {"latitude": 52.5, "longitude": 13.4, "date": "2026-06-21", "time": "14:30"}
    return SkyEnvironment.model_validate({**given, **changes})


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"utc_offset": 2}, "2026-06-21T12:30"),
        ({"utc_offset": "Europe/Berlin"}, "2026-06-21T12:30"),
        ({"utc_offset": "Europe/Berlin", "date": "2026-12-21"}, "2026-12-21T13:30"),
        ({"utc_offset": "Asia/Kathmandu"}, "2026-06-21T08:45"),
        ({"utc_offset": -3.5}, "2026-06-21T18:00"),
        ({}, "2026-06-21T13:30"),
        ({"longitude": 180, "time": "7:05"}, "2026-06-20T19:05"),
        ({"longitude": -180, "time": "23:59:30"}, "2026-06-22T11:59:30"),
        ({"date": "2024-02-29", "utc_offset": 0}, "2024-02-29T14:30"),
    ],
)
def test_a_moment_is_one_everywhere(changes: dict[str, object], expected: str) -> None:
    assert sky(**changes).moment == datetime.fromisoformat(expected).replace(tzinfo=UTC)


@pytest.mark.parametrize(
    "changes",
    [
        {"date": "2023-02-29"},
        {"date": "1700-01-01"},
        {"date": "2026-6-1"},
        {"date": 20260621},
        {"time": "24:00"},
        {"time": "12:60"},
        {"time": "noon"},
        {"time": 12.5},
        {"utc_offset": "../etc/passwd"},
        {"utc_offset": ""},
        {"utc_offset": True},
        {"utc_offset": "/etc/localtime"},
        {"utc_offset": 15.5},
        {"utc_offset": float("nan")},
        {"latitude": 90.1},
        {"longitude": "13"},
        {"turbidity": 10.5},
        {"ground": [1, 1]},
    ],
)
def test_what_is_no_moment_or_place_is_refused(changes: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        sky(**changes)


def test_latitude_alone_says_that_it_is_a_sky_and_it_survives_writing() -> None:
    text = (
        "lights:\n  environment: {latitude: -33.9, longitude: 151.2, date: 2026-01-02, "
        "time: 9:15, utc_offset: Australia/Sydney, north: 30 deg}\n"
    )
    room = parse_room(text)
    environment = room.lights.environment
    assert isinstance(environment, SkyEnvironment)
    assert (environment.time, environment.north) == ("09:15:00", 30.0)
    assert parse_room(dump_room(room)) == room
