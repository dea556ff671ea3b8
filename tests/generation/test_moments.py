"""Moments and lamps of generated rooms: the sun stands where it shall, nobody is in the dark."""

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from openrooms_usd.description.lights import Lamp, OutsideEnvironment
from openrooms_usd.furniture import category
from openrooms_usd.generation import environments
from openrooms_usd.generation.curtains import curtains
from openrooms_usd.generation.environments import environment
from openrooms_usd.generation.items import Item
from openrooms_usd.generation.kit import Kit
from openrooms_usd.generation.lighting import lamps, screens
from openrooms_usd.generation.moments import MOMENTS, closes, moment_of
from openrooms_usd.generation.placement import Arrangement
from openrooms_usd.generation.rooms import Furnishing, Generated, draw_shell, generate, named
from openrooms_usd.generation.shapes import Shapes
from openrooms_usd.generation.shell import Gap, Shell
from openrooms_usd.library.styles.beams import WORK_ROOMS
from openrooms_usd.library.surroundings.sky import sun_direction
from openrooms_usd.library.surroundings.sunlight import sun_position

_LAMPS = ("ceiling_lamp", "floor_lamp", "table_lamp", "wall_lamp")


def empty(room_type: str, seed: int) -> Generated:
    shell, rows = draw_shell(room_type, seed)
    return Generated(room_type, seed, shell, rows)


@pytest.mark.parametrize("name", MOMENTS)
def test_the_sun_stands_as_the_moment_says(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(environments, "moment_of", lambda room_type, seed: name)
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
    found = Counter(moment_of("bedroom", seed) for seed in range(600))
    for name, moment in MOMENTS.items():
        expected = 600 * moment.weight
        assert abs(found[name] - expected) < 4.0 * math.sqrt(expected)


def test_lamps_are_warm_at_home_and_cool_at_work_and_somebody_has_light_at_night() -> None:
    states: Counter[tuple[str, bool]] = Counter()
    for room_type in ("living_room", "office", "closet"):
        for seed in range(3):
            room = generate(room_type, seed)
            found = lamps(room)
            assert found == lamps(room)
            for name, lamp in found.items():
                at_work = room_type in WORK_ROOMS
                least, most = (3500, 4000) if at_work else (2400, 4000)
                assert "color" in lamp or least <= lamp["kelvin"] <= most, name
            is_on = [lamp.get("on", True) for lamp in found.values()]
            states.update((room_type, on) for on in is_on)
            if MOMENTS[moment_of(room_type, seed)].elevation[1] < 0.0:
                assert any(is_on)
            assert all(lamp.get("on", True) for lamp in lamps(room, seen=False).values())
    assert states["living_room", True]
    assert states["living_room", False]
    # Nobody stands in a closet without windows in the dark.
    assert not states["closet", False]


@pytest.mark.parametrize("room_type", ["living_room", "office"])
def test_lamps_with_optics_of_their_own_have_wide_profiles(room_type: str) -> None:
    kinds = [(kind, style) for kind in _LAMPS for style in category(kind).styles]
    items = [Item("".join(made), made[0], (0.5, 0.5, 0.5), made[1]) for made in kinds]
    room = replace(empty(room_type, 3), furnishing=Furnishing([("light", items)], 0))
    found = {}
    for _, name, item, _ in named(room.furnishing.groups):
        lamp = lamps(room)[name]
        Lamp.model_validate(lamp)
        found[item.category, item.style] = lamp.get("profile")
        # What lights a room leaves no part of it to one bright patch.
        assert lamp.get("beam", 60) >= 60
    # Globes are even by themselves, shades shape light by their form.
    disc = "batwing" if room_type == "office" else "downlight"
    assert {key: profile for key, profile in found.items() if profile} == {
        ("ceiling_lamp", "flush"): disc,
        ("ceiling_lamp", "spots"): "downlight",
        ("ceiling_lamp", "pendant"): "bare bulb",
        ("floor_lamp", "arc"): "bare bulb",
    }


def test_a_room_without_lamps_or_windows_is_described_too() -> None:
    room = empty("closet", 3)
    assert room.furnishing == Furnishing([], 0) or not room.furnishing.groups
    assert lamps(room) == {}
    assert np.isfinite(environment(room)["north"])


def test_curtains_close_by_night_and_only_then() -> None:
    nights = [n for n in range(400) if moment_of("bedroom", n) == "night"]
    often = MOMENTS["night"].closed[0]
    closed = sum(closes("bedroom", seed) for seed in nights)
    assert abs(closed - often * len(nights)) < 4.0 * math.sqrt(len(nights) * often * (1.0 - often))
    assert not any(closes("bedroom", n) for n in range(60) if moment_of("bedroom", n) == "sun")


def test_what_is_closed_covers_the_window() -> None:
    found = Counter[str]()
    for seed in [n for n in range(120) if closes("living_room", n)]:
        shell = empty("living_room", seed).shell
        room, kit = Arrangement(shell), Kit(np.random.default_rng(seed), Shapes(seed))
        hung = curtains(room, kit, "living_room", 0.1, closed=True)
        found.update(item.style for item in hung)
        for item in hung:
            near = [g for g in shell.gaps if g.kind == "window" and _is_before(g, item, shell)]
            assert len(near) == 1
            assert item.z <= near[0].sill + 0.17 * (near[0].top - near[0].sill)
            assert item.size[0] > near[0].width
    assert set(found) == {"drawn", "sheer", "roller", "venetian"}
    assert curtains(Arrangement(shell), kit, "garage", 0.0, closed=True) == []


def _is_before(gap: Gap, item: Item, shell: Shell) -> bool:
    middle = shell.sides[gap.side].point(gap.at, 0.5 * item.size[1])
    return bool(np.hypot(*(middle - [item.x, item.y])) < 1e-6)


def test_screens_that_are_on_are_there_and_flat() -> None:
    rooms = [generate("office", seed) for seed in range(3)]
    found = {(room.seed, name): row for room in rooms for name, row in screens(room).items()}
    assert found
    for (seed, name), row in found.items():
        items = {n: item for _, n, item, _ in named(rooms[seed].furnishing.groups)}
        assert items[name].category in {"laptop", "monitor", "television"}
        assert items[name].style not in {"curved", "tube"}
        assert 100 <= row["nits"] <= 300
