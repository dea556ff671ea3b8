"""The sun's place against published values and a second algorithm that shares nothing with ours."""

import math
from datetime import UTC, datetime, timedelta, timezone
from itertools import pairwise

import pytest

from openrooms_usd.library.solar import equatorial, refraction, sun_position

CENTURY = 36_525 * 86_400


def psa(moment: datetime, latitude: float, longitude: float) -> tuple[float, float]:
    """Azimuth and elevation, degrees, of the PSA algorithm.

    Blanco-Muriel et al., Computing the Solar Vector, Solar Energy 70 (2001); good to 0.01 degree
    for 1999 to 2015, with parallax.
    """
    noon = datetime(2000, 1, 1, 12, tzinfo=UTC)
    days = (moment - noon).total_seconds() / 86_400
    utc = moment.astimezone(UTC)
    hours = utc.hour + utc.minute / 60 + utc.second / 3600
    omega = 2.1429 - 0.0010394594 * days
    mean = 4.8950630 + 0.017202791698 * days
    anomaly = 6.2400600 + 0.0172019699 * days
    ecliptic = mean + 0.03341607 * math.sin(anomaly) + 0.00034894 * math.sin(2 * anomaly)
    ecliptic += -0.0001134 - 0.0000203 * math.sin(omega)
    tilt = 0.4090928 - 6.2140e-9 * days + 0.0000396 * math.cos(omega)
    ascension = math.atan2(math.cos(tilt) * math.sin(ecliptic), math.cos(ecliptic))
    declination = math.asin(math.sin(tilt) * math.sin(ecliptic))
    sidereal = 6.6974243242 + 0.0657098283 * days + hours
    angle = math.radians(sidereal * 15 + longitude) - ascension
    phi = math.radians(latitude)
    zenith = math.acos(
        math.cos(phi) * math.cos(angle) * math.cos(declination)
        + math.sin(declination) * math.sin(phi)
    )
    y = -math.sin(angle)
    x = math.tan(declination) * math.cos(phi) - math.sin(phi) * math.cos(angle)
    zenith += 6371.01 / 149_597_890 * math.sin(zenith)
    return math.degrees(math.atan2(y, x)) % 360, 90 - math.degrees(zenith)


def at(text: str, offset: float = 0.0) -> datetime:
    zone = timezone(timedelta(hours=offset))
    return datetime.fromisoformat(text).replace(tzinfo=zone)


def test_the_example_of_the_solar_position_algorithm() -> None:
    """Reda and Andreas, NREL/TP-560-34302 (2004), table A5.1; elevation without refraction."""
    found = sun_position(at("2003-10-17T12:30:30", -7), 39.742476, -105.1786)
    assert found.azimuth == pytest.approx(194.34024, abs=0.003)
    assert found.elevation == pytest.approx(39.872046, abs=0.003)
    # At 820 mbar and 11 degrees Celsius there; ours is the standard atmosphere.
    assert found.apparent - found.elevation == pytest.approx(0.016332, abs=0.004)


def test_the_example_of_meeus() -> None:
    """Astronomical Algorithms, example 25.a: 1992 October 13, 0 h TD."""
    t = (at("1992-10-13") - at("2000-01-01T12:00")).total_seconds() / CENTURY
    ascension, declination, distance = equatorial(t)
    assert math.degrees(ascension) % 360 == pytest.approx(198.38083, abs=1e-4)
    assert math.degrees(declination) == pytest.approx(-7.78507, abs=1e-4)
    assert distance == pytest.approx(0.99766, abs=1e-5)


@pytest.mark.parametrize(
    ("moment", "declination"),
    [
        ("2024-03-20T03:06", 0.0),
        ("2024-06-20T20:51", 23.4386),
        ("2024-09-22T12:44", 0.0),
        ("2024-12-21T09:20", -23.4386),
    ],
    ids=["March equinox", "June solstice", "September equinox", "December solstice"],
)
def test_the_seasons_begin_when_the_almanac_says(moment: str, declination: float) -> None:
    t = (at(moment) - at("2000-01-01T12:00")).total_seconds() / CENTURY
    assert math.degrees(equatorial(t)[1]) == pytest.approx(declination, abs=0.01)


PLACES = {
    "Berlin": (52.52, 13.405),
    "Sydney": (-33.8688, 151.2093),
    "Quito": (-0.1807, -78.4678),
    "Tromso": (69.6492, 18.9553),
    "Fiji": (-17.7134, 178.065),
    "Samoa": (-13.759, -172.1046),
    "almost the pole": (89.9, 0.0),
    "Ushuaia": (-54.8019, -68.303),
}


@pytest.mark.parametrize("place", PLACES)
def test_a_second_algorithm_agrees_through_the_year(place: str) -> None:
    latitude, longitude = PLACES[place]
    for hour in range(0, 366 * 24, 101):
        moment = datetime(2008, 1, 1, tzinfo=UTC) + timedelta(hours=hour)
        found = sun_position(moment, latitude, longitude)
        azimuth, elevation = psa(moment, latitude, longitude)
        assert found.elevation == pytest.approx(elevation, abs=0.02)
        turn = (found.azimuth - azimuth + 180) % 360 - 180
        # Near the zenith a small step turns the azimuth far.
        assert abs(turn) * math.cos(math.radians(elevation)) < 0.02


def test_at_noon_it_stands_in_the_south_or_in_the_north() -> None:
    north = sun_position(at("2026-06-21T13:08", 2), 52.52, 13.405)
    assert north.azimuth == pytest.approx(180, abs=0.5)
    assert north.elevation == pytest.approx(90 - 52.52 + 23.436, abs=0.01)
    south = sun_position(at("2026-06-21T11:57", 10), -33.8688, 151.2093)
    assert min(south.azimuth, 360 - south.azimuth) < 0.5
    assert south.elevation == pytest.approx(90 - 33.8688 - 23.436, abs=0.01)


def test_morning_is_in_the_east() -> None:
    assert 60 < sun_position(at("2026-03-20T07:00", 1), 52.52, 13.405).azimuth < 120
    assert 240 < sun_position(at("2026-03-20T17:30", 1), 52.52, 13.405).azimuth < 300


def test_the_pole_has_a_night_and_a_day_of_half_a_year() -> None:
    winter = [sun_position(at(f"2026-12-21T{h:02}:00"), 90.0, 0.0) for h in range(24)]
    assert all(p.elevation == pytest.approx(-23.436, abs=0.01) for p in winter)
    summer = [sun_position(at(f"2026-06-21T{h:02}:00"), -90.0, 0.0) for h in range(24)]
    assert all(p.elevation == pytest.approx(-23.436, abs=0.01) for p in summer)


def test_one_moment_has_one_sun_on_both_sides_of_the_date_line() -> None:
    a = sun_position(at("2026-02-28T23:30", 12), -17.0, 180.0)
    b = sun_position(at("2026-02-27T23:30", -12), -17.0, -180.0)
    assert (a.azimuth, a.elevation) == pytest.approx((b.azimuth, b.elevation), abs=1e-9)


@pytest.mark.parametrize(
    ("elevation", "minutes"), [(90.0, 0.0), (45.0, 0.97), (10.0, 5.3), (0.0, 28.9), (-0.575, 34.5)]
)
def test_refraction_is_that_of_the_tables(elevation: float, minutes: float) -> None:
    """Bennett's values for the standard atmosphere, in minutes of arc."""
    assert 60 * refraction(elevation) == pytest.approx(minutes, rel=0.03, abs=0.05)


def test_refraction_has_no_steps() -> None:
    steps = [refraction(-90 + k / 1000) for k in range(180_001)]
    assert all(math.isfinite(value) for value in steps)
    assert max(abs(a - b) for a, b in pairwise(steps)) < 2e-3
