"""The sun's patch on the floor lies where geometry says, and is as bright as the sun."""

import math
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.composing import compose_room
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.rendering import exr, render_stage

REFLECTED = 0.5
HEIGHT, SILL, WIDTH, MIDDLE, THICK = 1.2, 1.0, 1.4, 2.2, 0.25

ROOM = f"""
layout:
  polygon: [[0, 0], [5, 0], [5, 4], [0, 4]]
  wall_thickness: {THICK}
  openings:
    - {{kind: opening, wall: WALL, at: {MIDDLE}, width: {WIDTH}, height: {HEIGHT}, sill: {SILL}}}
materials:
  floor: {{family: paint, color: [{REFLECTED}, {REFLECTED}, {REFLECTED}], roughness: 1.0}}
lights:
  environment:
    {{from: sky, latitude: LATITUDE, longitude: LONGITUDE, date: DATE, time: "TIME",
      utc_offset: OFFSET, north: NORTH}}
cameras:
  resolution: [120, 96]
  views:
    - {{name: down, eye: [2.5, 1.99, 2.58], target: [2.5, 2.0, 0], fov: 95}}
"""

# Wall, its start and its direction in the plan.
WALLS = {0: ((0, 0), (1, 0)), 1: ((5, 0), (0, 1)), 2: ((5, 4), (-1, 0)), 3: ((0, 4), (0, -1))}

# The wall that looks to the sun, the place, what the description says, and the same in UTC.
CASES = {
    "Berlin at noon": (0, 52.5, 13.4, "2026-06-21 13:10 +2", 0.0, "2026-06-21T11:10"),
    "Berlin in the afternoon": (3, 52.5, 13.4, "2026-06-21 17:00 +2", 0.0, "2026-06-21T15:00"),
    "Sydney": (2, -33.87, 151.2, "2026-06-21 11:00 +10", 0.0, "2026-06-21T01:00"),
    "turned by 50 degrees": (1, 40.0, -105.0, "2026-03-10 12:30 -7", 50.0, "2026-03-10T19:30"),
}


def toward_sun(moment: datetime, latitude: float, longitude: float, north: float) -> np.ndarray:
    """From the geocentric direction of the sun and the place's own axes, by vectors alone.

    The sun's longitude is that of the Astronomical Almanac's low-precision formulas.
    """
    n = (moment - datetime(2000, 1, 1, 12, tzinfo=UTC)).total_seconds() / 86_400
    g = math.radians(357.528 + 0.9856003 * n)
    longitude_of_sun = math.radians(
        280.460 + 0.9856474 * n + 1.915 * math.sin(g) + 0.020 * math.sin(2 * g)
    )
    tilt = math.radians(23.439 - 4e-7 * n)
    sun = np.array(
        [
            math.cos(longitude_of_sun),
            math.cos(tilt) * math.sin(longitude_of_sun),
            math.sin(tilt) * math.sin(longitude_of_sun),
        ]
    )
    meridian = math.radians(280.46062 + 360.98564737 * n + longitude)
    phi = math.radians(latitude)
    up = np.array(
        [math.cos(phi) * math.cos(meridian), math.cos(phi) * math.sin(meridian), math.sin(phi)]
    )
    east = np.array([-math.sin(meridian), math.cos(meridian), 0.0])
    northwards = np.cross(up, east)
    turn = math.radians(north)
    # Where north and east lie in the room.
    north_in_room = np.array([-math.sin(turn), math.cos(turn), 0.0])
    east_in_room = np.array([math.cos(turn), math.sin(turn), 0.0])
    flat = (sun @ east) * east_in_room + (sun @ northwards) * north_in_room
    return np.asarray(flat + (sun @ up) * np.array([0.0, 0.0, 1.0]))


def passes(points: np.ndarray, sun: np.ndarray, wall: int, margin: float) -> np.ndarray:
    """Whether the ray to the sun passes the hole, on the wall's inner and outer side."""
    start, along = (np.array([*pair, 0.0], dtype=float) for pair in WALLS[wall])
    outwards = np.array([along[1], -along[0], 0.0])
    inside = np.ones(points.shape[:-1], dtype=bool)
    if sun @ outwards <= 0:
        return ~inside
    for depth in (0.0, THICK):
        t = (depth - (points - start) @ outwards) / (sun @ outwards)
        at = points + t[..., None] * sun - start
        x, z = at @ along, at[..., 2]
        inside &= np.abs(x - MIDDLE) < WIDTH / 2 + margin
        inside &= (z > SILL - margin) & (z < SILL + HEIGHT + margin)
    return inside


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_the_sun_falls_where_geometry_says(case: str, tmp_path: Path) -> None:
    wall, latitude, longitude, clock, north, moment = CASES[case]
    date, time, offset = clock.split()
    text = ROOM
    for word, value in {
        "WALL": wall,
        "LATITUDE": latitude,
        "LONGITUDE": longitude,
        "DATE": date,
        "TIME": time,
        "OFFSET": int(offset),
        "NORTH": north,
    }.items():
        text = text.replace(word, str(value))
    (tmp_path / "room.yaml").write_text(text)
    scene = compose_room(tmp_path / "room.yaml", tmp_path / "room").scene
    render_stage(
        scene,
        tmp_path / "out",
        RenderSettings(channels=["radiance", "position"], samples=16, bounces=1),
    )
    images = exr.read_channels(tmp_path / "out" / "down" / "channels.exr")
    points = images["position"].astype(np.float64)
    light = images["radiance"].astype(np.float64) @ np.array([0.2126, 0.7152, 0.0722])
    utc = datetime.fromisoformat(moment).replace(tzinfo=UTC)
    sun = toward_sun(utc, latitude, longitude, north)
    on_floor = (np.abs(points[..., 2]) < 1e-3) & (points[..., 0] > 0.05) & (points[..., 0] < 4.95)
    surely = passes(points, sun, wall, -0.06) & on_floor
    surely_not = ~passes(points, sun, wall, 0.06) & on_floor
    assert surely.sum() > 40 and surely_not.sum() > 2000
    dim = np.median(light[surely_not])
    bright = light[surely]
    assert (bright > 5 * dim).all()
    assert (light[surely_not] < bright.min()).mean() > 0.998
    # 60 to 100 klx on what faces it, from 35 degrees up.
    beam = bright.mean() * math.pi / REFLECTED / sun[2]
    assert 60e3 < beam < 110e3
