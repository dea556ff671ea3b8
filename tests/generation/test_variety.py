"""Things of a room are as unlike as people's are, and alike where people buy them together."""

from collections import Counter

import numpy as np
import pytest

from openrooms_usd.draws import generator
from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.registry import BUILT
from openrooms_usd.generation.clutter.forms import LevelFinder
from openrooms_usd.generation.clutter.laying import Taken, posed_object
from openrooms_usd.generation.clutter.levels import Level
from openrooms_usd.generation.clutter.making import ProductVariants
from openrooms_usd.generation.clutter.scatter import Scatter
from openrooms_usd.generation.clutter.spots import SupportSurface
from openrooms_usd.generation.groups import sleeping, wet, working
from openrooms_usd.generation.items import Item
from openrooms_usd.generation.kit import Kit
from openrooms_usd.generation.programs import PROGRAMS
from openrooms_usd.generation.shapes import Shapes
from openrooms_usd.library.styles.interiors import INTERIORS
from tests.generation.oddities import odd


def kit(room_type: str = "", style: str = "", seed: int = 0) -> Kit:
    return Kit(generator(seed, "a test"), Shapes(seed), interior=INTERIORS.get(style),
               room_type=room_type)  # fmt: skip


@pytest.mark.parametrize("style", ["", *INTERIORS])
def test_styles_are_drawn_as_often_as_their_records_say(style: str) -> None:
    some = kit("bathroom", style)
    lamps = {some.style("ceiling_lamp") for _ in range(300)}
    screens = Counter(some.style("monitor") for _ in range(400))
    assert "chandelier" not in lamps and len(lamps) > 3
    assert screens["tube"] < 12 < screens["curved"] < screens["flat"]
    assert "dryer" not in {some.style("washing_machine") for _ in range(100)}


def test_records_speak_of_rooms_that_there_are() -> None:
    for name in BUILT:
        for style in CATEGORIES[name].styles.values():
            assert style.weight >= 0.0 and set(style.rooms.split()) <= set(PROGRAMS)
        assert any(style.weight > 0.0 for style in CATEGORIES[name].styles.values())


@pytest.mark.parametrize("seed", range(6))
def test_furniture_of_one_kind_matches_in_a_room(seed: int) -> None:
    some = kit(seed=seed)
    for build in (sleeping.clothes, sleeping.bed_place, working.desk_place):
        first = build(some).items
        some.remember(first)
        second = build(some).items[0]
        assert first[0].style == second.style and first[0].size[1:] == second.size[1:]


def test_a_second_washing_machine_is_a_dryer() -> None:
    groups = [wet.laundry(kit(seed=seed)).items for seed in range(8)]
    rows = [
        [item.style for item in group if item.category == "washing_machine"] for group in groups
    ]
    assert {len(row) for row in rows} == {1, 2}
    assert all(row[1:] in ([], ["dryer"]) and row[0] != "dryer" for row in rows)


def row_of(name: str, count: int, seed: int, variants: int = 2) -> list[Item]:
    """A row on a board of 1.2 by 0.3 m."""
    rng = generator(seed, "a row")
    surfaces = LevelFinder(Shapes(seed))
    scatter = Scatter(rng, surfaces, ProductVariants(rng), Taken(), "storage", 2.5, Counter())
    board = Level(0.0, np.array([-0.6, -0.15]), np.full((30, 120), 0.4), True)
    spot = SupportSurface(
        "shelf", Item("board", "bookshelf", (1.2, 0.3, 0.02), "", z=1.0), 0, board
    )
    placement = on("shelf", pose="row", count=(count, count), max_variants=variants)
    make = scatter.variants.draw(name, placement)
    assert make is not None
    things = scatter._beside(posed_object(surfaces, name, make), placement, count, (1.2, 0.3, 0.4))
    return scatter._row(0, spot, things, placement)


def test_things_in_a_row_are_not_copies_in_line() -> None:
    rows = [row_of("bottle", 4, seed) for seed in range(20)]
    assert all(len(row) == 4 for row in rows)
    for row in rows:
        x, y = np.array([(item.x, item.y) for item in row]).T
        assert np.ptp(np.diff(x)) > 1e-3 and np.ptp(y) > 1e-3
        assert np.ptp([item.yaw for item in row]) > 20.0
    assert sum(len({(item.size, item.style) for item in row}) > 1 for row in rows) > 5
    # What has no round form keeps its front forward, and does not touch its neighbour.
    for item in row_of("food_box", 4, 1):
        assert abs(item.yaw) < 30.0


def test_a_room_has_no_more_of_a_thing_than_its_record_says() -> None:
    rng = generator(0, "few")
    scatter = Scatter(rng, LevelFinder(Shapes(0)), ProductVariants(rng), Taken(), "kitchen", 2.5,
                      Counter())  # fmt: skip
    for kettles in (1, 0):
        scatter.counts["kettle"] = kettles
        drawn = [scatter.drawn(0, "worktop", 2) for _ in range(300)]
        found = {row[0] for row in drawn if row}
        assert ("kettle" in found) == (not kettles) and len(found) > 5


def item(name: str, style: str, z: float = 0.0, where: str = "floor") -> Item:
    return Item(name, name, (0.3, 0.3, 0.3), style, z=z, on=where)


@pytest.mark.parametrize(
    ("room_type", "items", "wanted"),
    [
        ("kitchen", [item("kettle", "jug")] * 2, "there are 2 of kettle"),
        ("bedroom", [item("wardrobe", "open"), item("wardrobe", "sliding")], "open and sliding"),
        ("bathroom", [item("ceiling_lamp", "chandelier", 2.0, "ceiling")], "a chandelier"),
        ("office", [item("clock", "round", 1.95, "wall")], "2.10 m high"),
        ("laundry_room", [item("washing_machine", "front_loader")] * 2, "equal washing machines"),
        ("bedroom", [item("clock", "round", 1.5, "wall"), item("kettle", "jug")], ""),
    ],
)
def test_what_is_odd_is_found(room_type: str, items: list[Item], wanted: str) -> None:
    found = list(odd(room_type, items))
    assert len(found) == bool(wanted) and all(wanted in sentence for sentence in found)
