"""Daylight: published lux, exact energy of the sun's disk, and no moment that breaks it."""

import math
import os
from datetime import UTC, datetime, timedelta, timezone
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.library.surroundings import skycache
from openrooms_usd.library.surroundings.environments import directions
from openrooms_usd.library.surroundings.sky import (
    Air,
    daylight,
    hosek_wilkie,
    rounded,
    sun_direction,
    sun_disk,
)
from openrooms_usd.library.surroundings.skycache import cached_picture
from openrooms_usd.library.surroundings.sunlight import (
    SunPosition,
    air_mass,
    clear_illuminance,
    direct_normal,
    equatorial,
    refraction,
    sun_position,
)
from openrooms_usd.usercache import VARIABLE

WEIGHTS = np.array([0.2126, 0.7152, 0.0722])


def standing(elevation: float, azimuth: float = 180.0) -> SunPosition:
    return SunPosition(azimuth, elevation, elevation + refraction(elevation), 1.0)


def pixel_angles(height: int) -> np.ndarray:
    """(H,) steradians of a pixel in each row, by the area of a zone between two latitudes."""
    latitude = [math.pi / 2 - math.pi * row / height for row in range(height + 1)]
    zones = [math.sin(a) - math.sin(b) for a, b in pairwise(latitude)]
    return np.array(zones) * 2 * math.pi / (2 * height)


def lux(pixels: np.ndarray, normal: np.ndarray) -> float:
    """Illuminance of a surface, pixel by pixel."""
    height = len(pixels)
    cosine = np.clip(directions(height) @ normal, 0, None)
    light = (pixels.astype(np.float64) @ WEIGHTS) * cosine
    return float(pixel_angles(height) @ light.sum(axis=1))


UP = np.array([0.0, 0.0, 1.0])


@pytest.mark.parametrize("height", [16, 90, 360, 720])
@pytest.mark.parametrize(
    ("elevation", "angle"),
    [(90, 0), (89.9, 33), (60, -90), (30, 90), (30.1, 90.05), (10, 123), (45, 0)],
    ids=["zenith", "by the zenith", "middle", "seam", "by the seam", "low", "side"],
)
def test_the_disk_has_the_energy_of_the_sun(height: int, elevation: float, angle: float) -> None:
    e, a = math.radians(elevation), math.radians(angle)
    sun = np.array([math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)])
    disk = sun_disk(height, sun, 0.2666)
    total = float(pixel_angles(height) @ disk.sum(axis=1))
    assert total == pytest.approx(1.0, rel=1e-9)
    weighted = (pixel_angles(height)[:, None] * disk)[..., None] * directions(height)
    middle = weighted.sum(axis=(0, 1))
    # Within a fifth of a pixel, or of the disk where that is larger.
    away = math.acos(min(1.0, float(middle @ sun / np.linalg.norm(middle))))
    assert away < 0.35 * math.pi / height
    assert np.count_nonzero(disk) > 0 and (disk >= 0).all()


@pytest.mark.slow
def test_the_disk_is_as_wide_as_the_sun() -> None:
    """Its mean square distance from the middle is half its radius squared; edges are soft."""
    height, radius = 1440, math.radians(0.2666)
    sun = np.array([0.6, -0.48, 0.64])
    disk = sun_disk(height, sun, 0.2666)
    rows, columns = np.nonzero(disk)
    weight = disk[rows, columns] * pixel_angles(height)[rows]
    away = directions(height)[rows, columns] - sun
    spread = float(weight @ (away**2).sum(axis=1))
    assert 1.0 < spread / (radius**2 / 2) < 1.15


def test_half_a_sun_is_left_at_the_horizon() -> None:
    sun = np.array([0.8, 0.6, 0.0])
    disk = sun_disk(720, sun, 0.2666)
    assert float(pixel_angles(720) @ disk.sum(axis=1)) == pytest.approx(0.5, abs=0.01)
    below = np.array([0.8, 0.6, -0.02])
    assert not sun_disk(720, below / np.linalg.norm(below), 0.2666).any()


@pytest.mark.parametrize(
    ("azimuth", "north", "expected"),
    [
        (0, 0, (0, 1, 0)),
        (90, 0, (1, 0, 0)),
        (180, 0, (0, -1, 0)),
        (270, 0, (-1, 0, 0)),
        (0, 90, (-1, 0, 0)),
        (90, 90, (0, 1, 0)),
        (180, -90, (-1, 0, 0)),
    ],
)
def test_east_lies_to_the_right_of_north(
    azimuth: float, north: float, expected: tuple[float, ...]
) -> None:
    found = sun_direction(SunPosition(azimuth, 0.0, 0.0, 1.0), north)
    np.testing.assert_allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize("north", [0.0, 77.0, -180.0])
def test_the_brightest_pixel_is_where_the_sun_is(north: float) -> None:
    position = standing(37.0, 211.0)
    pixels = daylight(position, Air(), north=north, height=180)
    row, column = np.unravel_index(int((pixels @ WEIGHTS).argmax()), (180, 360))
    # By the layout's definition: the middle looks along -Y, a quarter from the left along +X.
    longitude = 2 * math.pi * ((column + 0.5) / 360 - 0.5)
    latitude = math.pi * (0.5 - (row + 0.5) / 180)
    seen = np.array([-math.sin(longitude), -math.cos(longitude)]) * math.cos(latitude)
    # Compass to room by complex numbers: north is i, east is 1, both turned by ``north``.
    bearing = 1j * np.exp(-1j * math.radians(211.0)) * np.exp(1j * math.radians(north))
    flat = math.cos(math.radians(position.apparent))
    np.testing.assert_allclose(seen, [flat * bearing.real, flat * bearing.imag], atol=0.02)
    assert math.degrees(latitude) == pytest.approx(position.apparent, abs=1.0)


@pytest.mark.parametrize(
    ("elevation", "low", "high"), [(90, 90e3, 110e3), (60, 85e3, 105e3), (30, 60e3, 85e3)]
)
def test_the_beam_of_a_clear_day(elevation: float, low: float, high: float) -> None:
    assert low < float(direct_normal(elevation, 3.0) @ WEIGHTS) < high


@pytest.mark.parametrize("elevation", [15, 25, 40, 60, 90])
@pytest.mark.parametrize("turbidity", [2.0, 3.0, 4.5])
def test_the_beam_agrees_with_luminous_turbidity(elevation: float, turbidity: float) -> None:
    """E = 133.8 klx exp(-a m T), a = 1 / (9.9 + 0.043 m): Clear, Kittler, Navvab (1982)."""
    mass = 1.0 / math.sin(math.radians(elevation))
    expected = 133_800.0 * math.exp(-mass * turbidity / (9.9 + 0.043 * mass))
    found = float(direct_normal(elevation, turbidity) @ WEIGHTS)
    assert found == pytest.approx(expected, rel=0.25)


def test_air_mass_is_that_of_the_tables() -> None:
    """Kasten and Young 1989, table II: at 90, 30, 10 and 0 degrees."""
    found = [air_mass(h) for h in (90, 30, 10, 0)]
    np.testing.assert_allclose(found, [1.0, 1.9943, 5.5841, 37.92], rtol=3e-3)


@pytest.mark.parametrize(
    ("elevation", "low", "high"),
    [(60, 12e3, 20e3), (45, 12e3, 18e3), (30, 11e3, 17e3), (15, 7e3, 13e3)],
)
def test_the_sky_of_a_clear_day(elevation: float, low: float, high: float) -> None:
    """IESNA: horizontal illuminance of a clear sky, 0.8 + 15.5 sqrt(sin h) klx, and around."""
    pixels = daylight(standing(elevation), Air(turbidity=2.5), height=180)
    beam = float(direct_normal(standing(elevation).apparent, 2.5) @ WEIGHTS)
    diffuse = lux(pixels, UP) - beam * math.sin(math.radians(standing(elevation).apparent))
    assert low < diffuse < high
    published = 800.0 + 15_500.0 * math.sqrt(math.sin(math.radians(elevation)))
    assert diffuse == pytest.approx(published, rel=0.3)


@pytest.mark.parametrize("elevation", [70, 50, 35, 20, 12, 5, 2, 0.5])
def test_all_daylight_agrees_with_the_naval_observatory(elevation: float) -> None:
    """Janiczek and DeYoung (1987) for a usual clear sky; they give 10 % at best."""
    found = lux(daylight(standing(elevation), Air(), height=180), UP)
    assert found == pytest.approx(clear_illuminance(elevation), rel=0.4)


@pytest.mark.parametrize(
    ("elevation", "expected"),
    [(-0.8, 450.0), (-6.0, 3.4), (-12.0, 0.008), (-18.0, 0.00065), (-60.0, 0.00065)],
    ids=["sunset", "civil", "nautical", "astronomical", "midnight"],
)
def test_dusk_and_night(elevation: float, expected: float) -> None:
    """The usual values at the ends of civil, nautical and astronomical twilight."""
    pixels = daylight(standing(elevation), Air(), height=90)
    assert lux(pixels, UP) == pytest.approx(expected, rel=0.15)
    assert (pixels >= 0).all() and np.isfinite(pixels).all() and pixels.any()


def test_dusk_is_blue_but_for_the_glow_above_the_sun() -> None:
    pixels = daylight(standing(-4.0), Air(), height=90)
    # The sun stands at azimuth 180, along -Y, which is the middle of the picture.
    zenith, away, glow = pixels[0].mean(axis=0), pixels[20].mean(axis=0), pixels[43, 90]
    assert glow[2] / glow[0] < 0.5 * away[2] / away[0]
    assert zenith[2] > 2.0 * zenith[0]
    assert away[2] > 1.5 * away[0]


def test_light_has_no_steps_between_day_and_night() -> None:
    heights = np.arange(-19.0, 12.0, 0.1)
    found = [lux(daylight(standing(float(h)), Air(), height=32), UP) for h in heights]
    ratios = np.array(found[1:]) / np.array(found[:-1])
    # The curve rises by a factor of 10 in 1.7 degrees at most; its pieces meet within 8 %.
    assert (ratios > 0.9).all() and (ratios < 1.3).all()


def test_an_overcast_sky_has_its_shape_and_its_lux() -> None:
    pixels = daylight(standing(40.0), Air(overcast=True), height=180)
    expected = 300.0 + 21_000.0 * math.sin(math.radians(40.0))
    assert lux(pixels, UP) == pytest.approx(expected, rel=2e-3)
    zenith, horizon = pixels[0, 0, 0], pixels[89, 0, 0]
    assert zenith / horizon == pytest.approx(3.0, rel=0.02)
    # L = 9 E / (7 pi) at the zenith.
    assert zenith == pytest.approx(9 * expected / (7 * math.pi), rel=5e-3)
    assert np.ptp(pixels[:90], axis=-1).max() == 0.0


def test_the_ground_reflects_what_falls_on_it() -> None:
    ground = (0.1, 0.2, 0.4)
    pixels = daylight(standing(50.0), Air(ground=ground), height=180)
    for primary in range(3):
        one = np.repeat(pixels[..., primary : primary + 1], 3, axis=-1)
        expected = ground[primary] * lux(one, UP) / math.pi
        np.testing.assert_allclose(pixels[90:, :, primary], expected, rtol=2e-3)


@pytest.mark.parametrize("turbidity", [1.0, 1.5, 9.999, 10.0])
@pytest.mark.parametrize("elevation", [90.0, 45.0, 10.0, 0.3, 0.0, -0.27, -5.0, -90.0])
def test_nothing_breaks_at_the_ends(turbidity: float, elevation: float) -> None:
    for ground in ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)):
        pixels = daylight(standing(elevation), Air(turbidity, ground), height=64)
        assert np.isfinite(pixels).all() and (pixels >= 0).all()
        assert lux(pixels, UP) > 0


def test_a_year_at_many_places() -> None:
    for number, latitude in enumerate(np.linspace(-90, 90, 13).tolist()):
        for day in range(0, 366, 61):
            moment = datetime(2024, 1, 1, tzinfo=UTC) + timedelta(days=day, hours=3.7 * number)
            pixels = daylight(sun_position(moment, latitude, 179.99), Air(), height=16)
            assert np.isfinite(pixels).all() and (pixels >= 0).all()


def test_the_evening_is_red_and_the_sky_blue() -> None:
    noon, evening = direct_normal(60.0, 3.0), direct_normal(10.0, 3.0)
    assert evening[0] / evening[2] > 3 * noon[0] / noon[2] > 3
    way = directions(32)
    sky = hosek_wilkie(way, np.array([0.0, 0.5, math.sqrt(0.75)]), 2.0, np.full(3, 0.2))
    red, _, blue = sky[:16].mean(axis=(0, 1))
    assert blue > 2 * red


def test_rounding_keeps_so_many_bits() -> None:
    values = np.random.default_rng(1).exponential(1e5, 1000)
    found = rounded(values, 10)
    assert np.abs(found / values - 1).max() <= 2.0**-10
    np.testing.assert_array_equal(found, rounded(found, 10))
    np.testing.assert_array_equal(rounded(values * (1 + 1e-13), 10), found)
    assert rounded(np.zeros(1), 10)[0] == 0


KEY = "ab" * 32


class Maker:
    """Writes a picture, and counts how often."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self, path: Path) -> None:
        self.calls += 1
        path.write_bytes(b"pixels")


@pytest.fixture
def entries(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "cache"))
    return tmp_path / "cache" / skycache.FOLDER


def test_a_picture_is_made_once_and_again_where_its_entry_is_damaged(
    tmp_path: Path, entries: Path
) -> None:
    make = Maker()
    for name in "abc":
        cached_picture(KEY, tmp_path / name, make)
        assert (tmp_path / name).read_bytes() == b"pixels"
    assert make.calls == 1
    [entry] = entries.iterdir()
    entry.write_bytes(entry.read_bytes().replace(b"pixels", b"pixelz"))
    cached_picture(KEY, tmp_path / "d", make)
    assert make.calls == 2 and (tmp_path / "d").read_bytes() == b"pixels"
    cached_picture(KEY, tmp_path / "e", make)
    assert make.calls == 2


def test_it_is_made_each_time_where_there_is_no_cache(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, "off")
    make = Maker()
    for name in "ab":
        cached_picture(KEY, tmp_path / name, make)
    assert make.calls == 2


def test_those_used_last_stay_and_files_of_others_too(
    tmp_path: Path, entries: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(skycache, "_MOST", 2)
    make = Maker()
    entries.mkdir(parents=True)
    (entries / "mine.sky").write_bytes(b"of somebody else")
    os.utime(entries / "mine.sky", (1, 1))
    for age, name in enumerate(("first", "second")):
        cached_picture(name, tmp_path / name, make)
        os.utime(entries / f"{name}.sky", (10 + age, 10 + age))
    cached_picture("third", tmp_path / "third", make)
    assert {path.stem for path in entries.iterdir()} == {"mine", "second", "third"}


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
