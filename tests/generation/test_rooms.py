"""Generated rooms: every kind, what must be in it, equal draws, refusals, the text."""

import json
import subprocess
import sys
from typing import get_args

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from openrooms_usd.description import parse_room
from openrooms_usd.description.room import RoomType
from openrooms_usd.errors import InputError
from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.generation import generate, write
from openrooms_usd.generation.programs import PROGRAMS
from openrooms_usd.generation.rooms import draw_shell

ESSENTIAL = {
    "apartment": {"bed", "sofa", "refrigerator", "worktop"},
    "bathroom": {"toilet", "sink"},
    "bedroom": {"bed"},
    "hotel": {"bed", "desk"},
    "bookstore": {"bookshelf", "counter"},
    "library": {"bookshelf", "table"},
    "classroom": {"whiteboard", "desk", "chair"},
    "closet": {"wardrobe"},
    "computer_cluster": {"desk", "office_chair"},
    "conference_room": {"table", "office_chair"},
    "copy_room": {"bookshelf", "cabinet"},
    "mail_room": {"bookshelf", "box"},
    "dining_room": {"table", "chair"},
    "game_room": {"sofa", "table"},
    "gym": {"bench", "rug"},
    "hallway": set(),
    "kitchen": {"refrigerator", "kitchen_unit", "sink", "worktop"},
    "laundry_room": {"washing_machine"},
    "lounge": {"sofa", "plant_pot"},
    "living_room": {"sofa"},
    "lobby": {"counter", "sofa"},
    "office": {"desk"},
    "stairs": {"stairs"},
    "storage": {"bookshelf", "box"},
    "basement": {"bookshelf", "box"},
    "garage": {"table", "bookshelf"},
    "misc": set(),
}


def test_every_room_type_has_a_program() -> None:
    assert set(PROGRAMS) == set(get_args(RoomType)) == set(ESSENTIAL)


@pytest.mark.one_in(27)
@pytest.mark.parametrize("room_type", PROGRAMS)
def test_a_room_has_what_it_is_for(room_type: str) -> None:
    room = generate(room_type, 11)
    items = [item for _, group in room.furnishing.groups for item in group]
    assert room.furnishing.missing == 0
    assert ESSENTIAL[room_type] | {"ceiling_lamp"} <= {item.category for item in items}
    described = parse_room(write(room))
    assert described.room == room_type
    assert len(described.furniture.objects) == len(items)
    for item in items:
        spec = CATEGORIES[item.category]
        least, most = 0.999 * np.array(spec.min_size), 1.001 * np.array(spec.max_size)
        assert (least <= item.size).all() and (item.size <= most).all(), item
        assert item.style in spec.styles


@given(st.sampled_from(sorted(PROGRAMS)), st.integers(0, 2**63 - 1))
@settings(max_examples=150, deadline=None)
def test_shells_are_simple_and_their_openings_fit(room_type: str, seed: int) -> None:
    shell, rows = draw_shell(room_type, seed)
    polygon = shapely.Polygon(shell.corners)
    least, _, most = PROGRAMS[room_type].area
    assert polygon.is_valid and polygon.exterior.is_ccw
    assert 0.97 * least <= polygon.area <= 1.03 * most
    assert polygon.minimum_clearance > 0.3
    assert shell.area == pytest.approx(polygon.area)
    assert len(shell.doors) >= 1
    assert len(rows) == len(shell.gaps)
    for row in rows:
        length = shell.sides[row["wall"]].length
        assert (
            0.25 < row["at"] - 0.5 * row["width"] < row["at"] + 0.5 * row["width"] < length - 0.25
        )
        assert row.get("sill", 0.0) + row["height"] <= shell.height - 0.1


@pytest.mark.one_in(9)
@pytest.mark.parametrize("room_type", ["bathroom", "living_room", "gym"])
def test_a_wanted_area_is_met(room_type: str) -> None:
    for area in (6.0, 20.0, 80.0):
        assert generate(room_type, 3, area).shell.area == pytest.approx(area, rel=0.02)


def test_equal_seeds_give_equal_rooms_in_any_process() -> None:
    code = (
        "import json, sys; from openrooms_usd.generation import generate, write;"
        "print(json.dumps([write(generate(t, 5)) for t in sys.argv[1:]]))"
    )
    kinds = ["bathroom", "closet", "hallway"]
    here = [write(generate(kind, 5)) for kind in kinds]
    for seed in ("1", "2"):
        done = subprocess.run(
            [sys.executable, "-c", code, *kinds],
            capture_output=True,
            text=True,
            check=True,
            env={"PYTHONHASHSEED": seed},
        )
        assert json.loads(done.stdout) == here
    layout = here[0].partition("layout:")[2]
    assert layout and write(generate("bathroom", 6)).partition("layout:")[2] != layout


def test_rooms_of_a_kind_differ() -> None:
    drawn = {write(generate("closet", seed)).partition("layout:")[2] for seed in range(8)}
    assert len(drawn) == 8


def test_nonsense_is_refused() -> None:
    with pytest.raises(InputError, match="no room type is named 'attic'"):
        generate("attic", 0)
    for area in (0.5, 1e6):
        with pytest.raises(InputError, match="cannot be generated"):
            generate("office", 0, area)
