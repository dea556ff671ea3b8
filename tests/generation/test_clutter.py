"""What lies about: more at each level, on level tops, in the poses that records ask for."""

from collections import Counter
from itertools import pairwise

import numpy as np
import pytest

from openrooms_usd.building.windows import BOARD, reveal_depth, window
from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.furniture.placements import DRAPED_WALL_M
from openrooms_usd.generation import generate, write
from openrooms_usd.generation.clutter.draping import Edge, edges, hang_over
from openrooms_usd.generation.clutter.forms import LevelFinder
from openrooms_usd.generation.clutter.hooks import pegs
from openrooms_usd.generation.clutter.laying import posed_object
from openrooms_usd.generation.clutter.levels import along_edges, crossings, levels_of
from openrooms_usd.generation.clutter.living import sills
from openrooms_usd.generation.clutter.resting import rest_on
from openrooms_usd.generation.clutter.settling import settle, vessels
from openrooms_usd.generation.items import Item
from openrooms_usd.generation.rooms import Generated
from openrooms_usd.generation.shapes import BuiltForm, Shapes
from openrooms_usd.generation.shell import Gap, Shell
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.rotations import about_x
from openrooms_usd.geometry.solids import box

SIZE = (0.4, 0.18, 1.05)


def shelf(front: bool = False) -> BuiltForm:
    """A case of 80 x 30 x 60 cm with a board in its middle, walls of 2 cm, perhaps a front."""
    walls = [
        box((0.8, 0.3, 0.02), (0.0, 0.0, 0.01)),
        box((0.8, 0.3, 0.02), (0.0, 0.0, 0.59)),
        box((0.76, 0.3, 0.02), (0.0, 0.0, 0.3)),
        box((0.02, 0.3, 0.56), (-0.39, 0.0, 0.3)),
        box((0.02, 0.3, 0.56), (0.39, 0.0, 0.3)),
        box((0.76, 0.02, 0.56), (0.0, 0.14, 0.3)),
    ]
    doors = [box((0.76, 0.02, 0.56), (0.0, -0.16, 0.3))] if front else []
    return BuiltForm((joined([*walls, *doors]),))


def test_boards_and_tops_are_found() -> None:
    low, middle, top = levels_of(shelf())
    assert [level.z for level in (low, middle, top)] == pytest.approx([0.02, 0.31, 0.6])
    assert [low.headroom, middle.headroom] == pytest.approx([0.27, 0.27])
    assert np.isinf(top.headroom) and low.open and middle.open
    # Between the walls, and before the back; less than a cell is lost at each edge.
    assert 0.74 * 0.26 <= low.area <= 0.76 * 0.28
    assert top.area == pytest.approx(0.8 * 0.3, rel=0.08)


def test_boards_behind_a_front_are_closed() -> None:
    low, middle, top = levels_of(shelf(front=True))[:3]
    assert not low.open and not middle.open and top.open


def test_what_is_thinner_than_a_cell_takes_its_place() -> None:
    plate = box((0.4, 0.4, 0.02), (0.0, 0.0, 0.01))
    rim = box((0.4, 0.001, 0.05), (0.0, 0.1037, 0.04))
    (level,) = levels_of(BuiltForm((plate, rim)))
    assert level.within(np.array([0.0]), np.array([0.1037]))[0] <= 0.05
    assert np.isinf(level.within(np.array([0.0]), np.array([0.0]))[0])
    assert level.within(np.array([0.5]), np.array([0.0]))[0] == 0.0


@pytest.fixture(scope="module")
def rooms() -> list[Generated]:
    return [generate("bathroom", 4, 5.0, clutter=clutter) for clutter in range(4)]


def lying(room: Generated) -> list[Item]:
    return [item for _, items in room.furnishing.groups for item in items if item.lies]


def test_each_level_holds_what_the_one_below_has(rooms: list[Generated]) -> None:
    kept = [{item.key: item for item in lying(room)} for room in rooms]
    counts = [len(found) for found in kept]
    assert counts == sorted(counts) and 0 == counts[0] < counts[1] < counts[3]
    for below, above in pairwise(kept):
        assert below.items() <= above.items()
    bare = [[i for _, g in room.furnishing.groups for i in g if not i.lies] for room in rooms]
    assert bare[0] == bare[1] == bare[3]


@pytest.mark.slow
def test_equal_seeds_give_equal_clutter(rooms: list[Generated]) -> None:
    assert write(generate("bathroom", 4, 5.0, clutter=2)) == write(rooms[2])
    assert write(generate("bathroom", 5, 5.0, clutter=2)) != write(rooms[2])


@pytest.mark.slow
def test_makes_are_as_few_as_the_records_say(rooms: list[Generated]) -> None:
    made = {(item.category, item.size, item.style) for item in lying(rooms[3])}
    for name, count in Counter(category for category, _, _ in made).items():
        record = CATEGORIES[name]
        limits: dict[tuple[str, ...], int] = {}
        for place in record.placements:
            key = place.styles or tuple(record.styles)
            limits[key] = max(limits.get(key, 0), place.max_variants)
        assert count <= min(8, sum(limits.values())), name


def test_things_stand_on_sills_within_their_reveals() -> None:
    corners = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    usual, low = Gap("window", 2, 1.5, 1.4, 0.85, 2.15), Gap("window", 3, 1.5, 1.4, 0.1, 2.2)
    shell = Shell(corners, 2.6, (usual, low))
    (sill,) = sills(shell, 0)  # the one that begins low has no sill that people use
    made = window(1.4, 1.3, shell.thickness, board=True)
    # The board's upper side, from the nose to the frame, as the window itself is built.
    board = made.frame.points[:, 2] < -0.65 + BOARD + 1e-6
    assert sill.z == pytest.approx(0.85 + 0.65 + made.frame.points[board, 2].max())
    (x0, y0), (x1, y1) = sill.reach
    assert made.frame.points[:, 1].min() <= y0 and y1 <= reveal_depth(shell.thickness)
    assert x0 >= -0.7 and x1 <= 0.7 and y1 - y0 > 0.1
    assert sill.pose[:2] == pytest.approx((2.5, 3.0))  # in the wall's inner face


@pytest.mark.parametrize(
    ("name", "style"), [("coat", "coat"), ("towel", "hung"), ("coat", "jacket")]
)
def test_loops_lie_on_the_crooks_of_hooks(name: str, style: str) -> None:
    surfaces = LevelFinder(Shapes(1))
    rack = Item("rack", "coat_rack", (0.7, 0.075, 0.11), "plank", z=1.6, on="wall")
    (peg, *others) = pegs([("by the door", [rack])], surfaces)
    assert len(others) == 3 and peg.at[1] < 0.0  # before the board
    thing = posed_object(surfaces, name, (CATEGORIES[name].styles[style].size or SIZE, style))
    x, y, z = peg.hung(thing.size)
    corners = thing.form.corners + np.array([x, y, z])
    # A line upwards through the crook leaves the body, and meets the loop just above the crook.
    low = np.array(peg.at[:2]) - [0.0002, 0.0003]
    _, heights, _ = crossings(corners, low, 1, 1, 0.001)
    *body, under, _ = np.sort(heights)
    assert under - peg.at[2] == pytest.approx(0.0008, abs=0.0006)
    assert max(body) < peg.at[2] - 0.011  # so much below it is the hook
    assert corners[..., 1].max() < 0.5 * 0.075 - 0.015  # its back is before the board


def test_fruit_settles_in_its_bowl() -> None:
    surfaces = LevelFinder(Shapes(1))
    bowl = Item("bowl", "bowl", (0.28, 0.28, 0.1), "round", z=0.7)
    (vessel,) = vessels([(0, bowl)], surfaces)
    apple = posed_object(surfaces, "fruit", ((0.078, 0.078, 0.08), "apple"))
    rng = np.random.default_rng(1)
    laid = [item for k in range(12) if (item := settle(vessel, apple, f"apple {k}", rng))]
    assert 2 <= len(laid) < 12  # then others would carry it
    places = np.array([(item.x, item.y, item.z) for item in laid])
    away = np.linalg.norm(places[:, None] - places, axis=2) + np.eye(len(laid))
    assert away.min() > 0.07 and (places[:, 2] > 0.7).all() and (places[:, 2] < 0.76).all()
    assert not list(vessels([(0, bowl), (0, laid[0])], surfaces))  # it is no longer empty
    pan = Item("bin", "trash_bin", (0.26, 0.29, 0.42), "pedal")
    assert not list(vessels([(0, pan)], surfaces))  # it has a lid


def test_boards_behind_panes_are_seen() -> None:
    glass = levels_of(Shapes(1).of("kitchen_cabinet", (0.6, 0.35, 0.8), "glass"))
    doors = levels_of(Shapes(1).of("kitchen_cabinet", (0.6, 0.35, 0.8), "doors"))
    assert sum(level.glazed and level.open for level in glass) == 3
    assert not any(level.glazed for level in doors) and sum(level.open for level in doors) == 1


@pytest.mark.parametrize("width", [0.49, 0.6])
def test_towels_hang_between_the_posts_of_their_rails(width: float) -> None:
    rail = Item("rail", "towel_rail", (width, 0.075, 0.05), "bar", z=1.1, on="wall")
    (edge,) = edges([("bath", [rail])], LevelFinder(Shapes(1)))
    for seed in range(20):
        fit = hang_over(edge, 0.45, 0.45, np.random.default_rng(seed))
        assert fit is not None
        assert abs(fit.x) + 0.5 * fit.size[0] < 0.5 * width - 0.05
        assert fit.y + 0.5 * fit.size[1] <= 0.5 * 0.075  # clear of the wall


def test_cloths_hang_between_posts_that_are_higher_than_the_back() -> None:
    posts = [box((0.04, 0.03, 0.5), (side * 0.2, 0.2, 0.57)) for side in (-1, 1)]
    chair = Item("chair", "chair", (0.44, 0.45, 0.82), "slats")
    corners = BuiltForm((box((0.36, 0.02, 0.35), (0.0, 0.2, 0.625)), *posts)).corners
    edge = Edge("chair_back", chair, 0, along_edges(corners))
    for seed in range(20):
        fit = hang_over(edge, 0.38, 0.4, np.random.default_rng(seed))
        assert fit is not None and fit.size[0] > 0.25
        assert abs(fit.x) + 0.5 * fit.size[0] < 0.18
        assert fit.z + fit.size[2] == pytest.approx(0.8 + DRAPED_WALL_M, abs=0.002)


CUBE = box((0.1, 0.1, 0.1), (0.0, 0.0, 0.05))
RIDGE = box((0.1, 0.1, 0.1), (0.0, 0.0, 0.0)).transformed(about_x(np.pi / 4))
SPIKE = Mesh(
    np.array([[0.001, 0, 0], [-0.001, 0.0007, 0], [0, -0.001, 0], [0.0001, 0, 0.05]]),
    np.full(4, 3),
    np.array([0, 1, 3, 1, 2, 3, 2, 0, 3, 0, 2, 1]),
)


@pytest.mark.parametrize(
    ("below", "upper", "lifted", "near"),
    [
        (CUBE, CUBE, 0.1, 1e-9),
        (CUBE, CUBE.moved((0.02, 0.03, 0.2)), -0.1, 1e-9),
        (CUBE, CUBE.moved((0.2, 0.0, 0.0)), -np.inf, 0.0),
        # On a slope of 45 degrees, 5 cm before its ridge; a corner is what touches.
        (RIDGE, CUBE.moved((0.0, 0.1, 0.0)), 0.1 / np.sqrt(2) - 0.05, 1e-6),
        (CUBE, RIDGE, 0.1 + 0.1 / np.sqrt(2), 0.0015),
        # Between all lines.
        (SPIKE, CUBE, 0.05, 1e-6),
        (CUBE, SPIKE.transformed(np.diag([1.0, 1.0, -1.0])), 0.15, 1e-6),
    ],
)
def test_things_rest_where_they_meet_first(
    below: Mesh, upper: Mesh, lifted: float, near: float
) -> None:
    found = rest_on(BuiltForm((below,)).corners, BuiltForm((upper,)).corners)
    assert found == pytest.approx(lifted, abs=near)
