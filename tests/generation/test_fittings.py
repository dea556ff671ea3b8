"""What is screwed to walls and ceilings of generated rooms, and what their shells wear."""

import numpy as np
import pytest

from openrooms_usd.description import parse_room
from openrooms_usd.generation import generate, write
from openrooms_usd.generation.boxes import overlap
from openrooms_usd.generation.finishing import finished, finishing
from openrooms_usd.generation.rooms import FITTINGS, Generated, draw_shell
from openrooms_usd.library.styles.interiors import INTERIORS

ROOMS = (("living_room", 1), ("bedroom", 2), ("kitchen", 2), ("hallway", 1))


def fittings(room: Generated) -> list:
    return [item for title, items in room.furnishing.groups if title == FITTINGS for item in items]


@pytest.fixture(scope="module", params=ROOMS, ids=lambda row: row[0])
def room(request: pytest.FixtureRequest) -> Generated:
    return generate(*request.param)


def test_doors_have_switches_at_the_height_of_hands(room: Generated) -> None:
    switches = [item for item in fittings(room) if item.category == "light_switch"]
    assert 1 <= len(switches) <= len(room.shell.doors)
    for item in switches:
        assert 1.04 <= item.z + 0.5 * item.size[2] <= 1.16
        place = np.array([item.x, item.y])
        doors = [room.shell.sides[gap.side].point(gap.at) for gap in room.shell.doors]
        assert min(np.linalg.norm(place - door) for door in doors) < 1.0


def test_fittings_are_apart_from_everything_else(room: Generated) -> None:
    found = fittings(room)
    others = [
        item.box
        for title, items in room.furnishing.groups
        if title != FITTINGS
        for item in items
        if item.on == "wall" and item.category not in ("backsplash", "curtain")
    ]
    flat = np.array([item.box for item in found if item.category != "ceiling_rose"])
    if others:
        assert not overlap(flat, np.array(others)).any()
    twice = overlap(flat, flat)
    assert np.array_equal(twice, np.eye(len(flat), dtype=bool))
    # Nor do they stand in the way of boards along the walls, save for pipes above these.
    thin = [item.box for item in found if item.category not in ("radiator", "ceiling_rose")]
    assert not overlap(np.array(thin), room.shell.attached).any()


def test_radiators_stay_below_sills(room: Generated) -> None:
    for item in fittings(room):
        if item.category == "radiator":
            place = np.array([item.x, item.y])
            for gap in room.shell.gaps:
                near = np.linalg.norm(room.shell.sides[gap.side].point(gap.at) - place) < 0.2
                assert not near or item.z + item.size[2] <= gap.sill - 0.05


def test_the_shell_is_written_down(room: Generated) -> None:
    layout = parse_room(write(room)).layout
    assert layout.trim.model_dump(exclude_unset=True).keys() == room.finish.trim.keys()
    assert layout.ceiling.kind == room.finish.ceiling.get("kind", "plain")


@pytest.mark.parametrize("style", INTERIORS)
def test_styles_keep_boards_behind_the_gap_of_furniture(style: str) -> None:
    for seed in range(12):
        for kind in ("living_room", "dining_room", "bathroom"):
            shell, _ = draw_shell(kind, seed)
            finish = finishing(kind, seed, shell, style)
            shell = finished(shell, finish)
            low = shell.fixed[shell.fixed[:, 6] == 0.0]
            assert (2.0 * low[:, 5] < 0.015).all()
            assert shell.clear_height > 2.0
            skirting = finish.trim.get("skirting")
            assert skirting is None or 0.06 <= skirting["height"] <= 0.15
            assert ("tiles" in str(finish.layout)) <= (kind == "bathroom")
