"""Moments and lamps of generated rooms: the sun stands where it shall, nobody is in the dark."""

import math
from collections import Counter

import numpy as np
import pytest

from openrooms_usd.description.lights import OutsideEnvironment
from openrooms_usd.generate import moments
from openrooms_usd.generate.lighting import lamps, screens
from openrooms_usd.generate.moments import MOMENTS, environment, moment_of
from openrooms_usd.generate.rooms import Furnishing, Generated, draw_shell, generate, named
from openrooms_usd.library.lamplight import WORK_ROOMS
from openrooms_usd.library.sky import sun_direction
from openrooms_usd.library.solar import sun_position


def empty(room_type: str, seed: int) -> Generated:
    shell, rows = draw_shell(room_type, seed)
    return Generated(room_type, seed, shell, rows)


@pytest.mark.parametrize("name", MOMENTS)
def test_the_sun_stands_as_the_moment_says(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(moments, "moment_of", lambda room: name)
    low, high = MOMENTS[name].elevation
    for seed in range(8):
        room = empty("living_room", seed)
        sky = OutsideEnvironment.model_validate(environment(room))
        sun = sun_position(sky.moment, sky.latitude, sky.longitude)
        assert low <= sun.elevation <= high
        assert sky.overcast == MOMENTS[name].overcast
        outward = [-room.shell.sides[g.side].inward for g in room.shell.gaps if g.kind == "window"]
        flat = sun_direction(sun, sky.north)[:2] / math.cos(math.radians(sun.apparent))
        if MOMENTS[name].shines_in:
            # North is given to a degree.
            assert max(way @ flat for way in outward) > math.cos(math.radians(51.0))


def test_every_moment_is_drawn_as_often_as_it_shall() -> None:
    rooms = [Generated("bedroom", seed, empty("bedroom", 0).shell, []) for seed in range(600)]
    found = Counter(map(moment_of, rooms))
    for name, moment in MOMENTS.items():
        expected = 600 * moment.weight
        assert abs(found[name] - expected) < 4.0 * math.sqrt(expected)


def test_lamps_are_warm_at_home_and_cool_at_work_and_somebody_has_light_at_night() -> None:
    states: Counter[tuple[str, bool]] = Counter()
    for room_type in ("living_room", "office", "closet"):
        for seed in range(4):
            room = generate(room_type, seed)
            found = lamps(room)
            assert found == lamps(room)
            for name, lamp in found.items():
                at_work = room_type in WORK_ROOMS
                least, most = (3500, 4000) if at_work else (2400, 4000)
                assert "color" in lamp or least <= lamp["kelvin"] <= most, name
            is_on = [lamp.get("on", True) for lamp in found.values()]
            states.update((room_type, on) for on in is_on)
            if MOMENTS[moment_of(room)].elevation[1] < 0.0:
                assert any(is_on)
            assert all(lamp.get("on", True) for lamp in lamps(room, seen=False).values())
    assert states["living_room", True]
    assert states["living_room", False]
    # Nobody stands in a closet without windows in the dark.
    assert not states["closet", False]


def test_a_room_without_lamps_or_windows_is_described_too() -> None:
    room = empty("closet", 3)
    assert room.furnishing == Furnishing([], 0) or not room.furnishing.groups
    assert lamps(room) == {}
    assert np.isfinite(environment(room)["north"])


def test_screens_that_are_on_are_there_and_flat() -> None:
    rooms = [generate("office", seed) for seed in range(5)]
    found = {(room.seed, name): row for room in rooms for name, row in screens(room).items()}
    assert found
    for (seed, name), row in found.items():
        items = {n: item for _, n, item, _ in named(rooms[seed].furnishing.groups)}
        assert items[name].category in {"laptop", "monitor", "television"}
        assert items[name].style not in {"curved", "tube"}
        assert 100 <= row["nits"] <= 300
