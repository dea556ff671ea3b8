"""The geometry that arranging rests on, against independent code."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from openrooms_usd.draws import generator
from openrooms_usd.furniture import make, styles
from openrooms_usd.generation.boxes import box, distance, overlap, posed
from openrooms_usd.generation.floor import CELL_M, components, floor_of
from openrooms_usd.generation.items import Item
from openrooms_usd.generation.kit import Kit
from openrooms_usd.generation.shapes import Shapes
from openrooms_usd.generation.shell import Gap, Shell

SQUARE = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)])
side = st.floats(0.05, 3.0)
place = st.floats(-2.0, 2.0)
boxes = st.builds(box, place, place, side, side, st.just(0.0), side, st.floats(-180, 180))


def polygon(row: np.ndarray) -> shapely.Polygon:
    x, y, c, s, a, b = row[:6]
    return shapely.Polygon(
        [(x + c * u - s * v, y + s * u + c * v) for u, v in [(a, b), (-a, b), (-a, -b), (a, -b)]]
    )


@pytest.mark.slow
@given(boxes, boxes)
@settings(max_examples=300, deadline=None)
def test_boxes_overlap_where_polygons_do(a: np.ndarray, b: np.ndarray) -> None:
    shared = polygon(a).intersection(polygon(b)).area
    apart = polygon(a).distance(polygon(b))
    found = bool(overlap(a[None], b[None]).any())
    assert found or shared < 1e-9
    assert not found or apart < 1e-9
    # A gap is kept at least; near corners a bit more.
    if not overlap(a[None], b[None], 0.1).any():
        assert apart >= 0.1 - 1e-9


def test_boxes_above_each_other_do_not_overlap() -> None:
    low, high = box(0, 0, 1, 1, 0.0, 0.5), box(0, 0, 1, 1, 0.5, 1.0)
    assert not overlap(low[None], high[None]).any()
    assert overlap(low[None], high[None], 0.01).any()


@given(boxes, place, place)
@settings(max_examples=100, deadline=None)
def test_distances_are_those_of_polygons(a: np.ndarray, x: float, y: float) -> None:
    found = distance(a[None], np.array(x), np.array(y))[0]
    assert found == pytest.approx(polygon(a).distance(shapely.Point(x, y)), abs=1e-9)


@given(boxes, place, place, st.floats(-180, 180))
@settings(max_examples=100, deadline=None)
def test_a_pose_moves_boxes_rigidly(a: np.ndarray, x: float, y: float, yaw: float) -> None:
    moved = polygon(posed(a[None], [(x, y, yaw)])[0, 0])
    turned = shapely.affinity.rotate(polygon(a), yaw, origin=(0, 0))
    wanted = shapely.affinity.translate(turned, x, y)
    # Corner by corner: the overlay of two outlines that almost coincide is not stable.
    assert moved.hausdorff_distance(wanted) < 1e-9


@pytest.mark.parametrize("share", [0.2, 0.5, 0.6, 0.8])
def test_components_are_those_of_scipy(share: float) -> None:
    mask = np.random.default_rng(3).random((60, 47)) < share
    ours, (theirs, count) = components(mask), ndimage.label(mask)
    assert ((ours > 0) == mask).all()
    assert len(np.unique(ours[mask])) == count
    assert len(np.unique(np.stack([ours[mask], theirs[mask]]), axis=1).T) == count


def test_a_wardrobe_across_the_room_cuts_off_a_door() -> None:
    doors = (Gap("door", 1, 1.5, 0.9, 0.0, 2.0), Gap("door", 3, 1.5, 0.9, 0.0, 2.0))
    floor = floor_of(Shell(SQUARE, 2.5, doors))
    assert floor.connected() is not None
    wide = floor.with_boxes(box(2.0, 1.2, 0.6, 2.4, 0.0, 2.0)[None])
    # 60 cm are left between it and the wall; cells of 5 cm may lose one of them.
    assert wide.connected() is None
    narrow = floor.with_boxes(box(2.0, 1.1, 0.6, 2.2, 0.0, 2.0)[None])
    reachable = narrow.connected()
    assert reachable is not None
    assert narrow.reaches(reachable, [(0.4, 0.4)]) and not narrow.reaches(reachable, [(2.0, 1.1)])
    rug = floor.with_boxes(box(2.0, 1.5, 0.6, 3.0, 0.0, 0.02)[None])
    assert (rug.clear == floor.clear).all()
    assert floor.clear.shape == (round(3.0 / CELL_M), round(4.0 / CELL_M))


@pytest.mark.parametrize("name", ["table", "chair", "desk", "office_chair", "sofa", "side_table"])
def test_slices_hold_all_of_an_object(name: str) -> None:
    from openrooms_usd.furniture import category

    for style in styles(name):
        size = category(name).styles[style].size or category(name).size
        shape = Shapes(3).of(name, size, style)
        rng = generator(3, "alignment", "details", name, repr(size), style)
        points = np.concatenate([m.points for m in make(name, size, style, rng).parts.values()])
        rows = shape.slices
        off = np.abs(points[:, None, :2] - rows[:, :2]) - rows[:, 4:6]
        within = (off <= 1e-6).all(axis=2)
        within &= (points[:, None, 2] >= rows[:, 6] - 1e-6) & (
            points[:, None, 2] <= rows[:, 7] + 1e-6
        )
        assert within.any(axis=1).all(), style


def test_things_stand_only_on_level_tops() -> None:
    kit = Kit(np.random.default_rng(1), Shapes(0))
    table = kit.item("table", size=(1.4, 0.8, 0.74), style="four_legs")
    jar = kit.placed_on(table, "jar", 0.0, 0.0)
    assert jar is not None and jar.z == pytest.approx(0.74, abs=1e-3) and jar.on == table.key
    assert kit.placed_on(table, "jar", 0.69, 0.0) is None  # over the edge
    assert kit.placed_on(table, "jar", 0.0, 0.0, beside=[jar]) is None  # taken
    chair = kit.item("chair", size=(0.46, 0.53, 0.84), style="slat")
    assert kit.placed_on(chair, "monitor", 0.0, 0.1) is None  # the back is in the way


def test_a_chair_goes_below_a_table_as_far_as_legs_allow() -> None:
    kit = Kit(np.random.default_rng(1), Shapes(0))
    table = kit.item("table", size=(1.6, 0.9, 0.74), style="four_legs")
    chair = kit.item("chair", size=(0.46, 0.53, 0.84), style="slat")
    tucked = kit.tucked(chair, table, 0.0, -90.0, jitter=0.0)
    assert tucked is not None and overlap(tucked.box[None], table.box[None]).any()
    assert not kit.clash(tucked, table)
    # Where a leg is, it stays outside.
    outside = kit.tucked(chair, table, 0.75, -90.0, jitter=0.0)
    assert outside is None or not overlap(outside.box[None], table.box[None]).any()


def test_items_turn_with_their_group() -> None:
    item = Item("a", "chair", (0.5, 0.5, 0.8), "slat", 1.0, 0.0, yaw=170.0).posed((2.0, 1.0, 90.0))
    assert (item.x, item.y) == pytest.approx((2.0, 2.0))
    assert item.yaw == pytest.approx(-100.0)


@pytest.mark.parametrize(("y", "sound"), [(1.2, False), (2.2, True)])
def test_the_widest_floor_is_not_cut_off_from_the_door(y: float, sound: bool) -> None:
    floor = floor_of(Shell(SQUARE, 2.5, (Gap("door", 0, 1.0, 0.9, 0.0, 2.0),)))
    beyond = floor.with_boxes(box(2.0, y, 4.0, 0.3, 0.0, 2.0)[None])
    assert (beyond.connected() is not None) == sound
