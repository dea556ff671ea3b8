"""How deep bodies overlap, what carries what, and the least motion by itself."""

import numpy as np
import pytest

from openrooms_usd.geometry.rotations import about_z
from openrooms_usd.scan.placement.arrangement import arranged
from openrooms_usd.scan.placement.bodies import Body, solid
from openrooms_usd.scan.placement.enclosure import Enclosure
from openrooms_usd.scan.placement.penetration import Lattice, chords, exits, gaps, near, penetration
from openrooms_usd.scan.placement.spreading import Condition, least_motion
from openrooms_usd.scan.placement.support import rest
from tests.scan.placement_cases import MODELS, blocks, found, meets

AXES = np.eye(3)


def body(*rows, turn: float = 0.0) -> Body:
    triangles = solid(*blocks(*rows)) @ about_z(np.radians(turn)).T
    return Body(triangles, about_z(np.radians(turn))[:2, :2].T)


CUBE = (0, 1, 0, 1, 0, 1)


@pytest.mark.parametrize("depth", [0.01, 0.3, 0.7])
def test_two_boxes_are_as_deep_as_their_overlap(depth: float) -> None:
    other = body((1 - depth, 2 - depth, 0.2, 0.8, 0.1, 0.9))
    assert exits(body(CUBE), other, AXES)[0] == pytest.approx(depth, abs=1e-9)
    result = penetration(body(CUBE), other, 0.002)
    assert result is not None and result.depth == pytest.approx(min(depth, 0.7), abs=1e-9)


def test_exits_in_both_ways_and_gaps() -> None:
    a, other = body((0, 0.2, 0, 1, 0, 1)), body((0.15, 0.3, 0, 1, 0, 1))
    np.testing.assert_allclose(exits(a, other, AXES), (0.05, 0.3), atol=1e-9)
    apart = a.moved(np.array([-0.06, 0, 0]))
    back, ahead = gaps(apart, other, np.array([1.0, 0.0]))
    assert back == np.inf and ahead == pytest.approx(0.01, abs=1e-9)


@pytest.mark.parametrize("shift", [(1, 0, 0), (0, 0, 1), (0.999, 0, 0)])
def test_what_touches_or_nearly_does_not_penetrate(shift) -> None:
    other = body(CUBE).moved(np.array(shift, dtype=float))
    assert penetration(body(CUBE), other, 0.002) is None


def test_a_body_inside_of_another_is_found() -> None:
    inner = body((0.4, 0.6, 0.4, 0.6, 0.4, 0.6))
    result = penetration(inner, body(CUBE), 0.002)
    assert result is not None and result.depth == pytest.approx(0.6)


def test_a_peg_in_a_hole_does_not_penetrate_though_boxes_do() -> None:
    frame = body((0, 0.2, 0, 1, 0, 1), (0.8, 1, 0, 1, 0, 1), (0.2, 0.8, 0, 0.2, 0, 1))
    peg = body((0.3, 0.7, 0.3, 0.9, 0, 1))
    assert near(peg, frame) and penetration(peg, frame, 0.002) is None


def test_the_way_out_of_a_turned_box_is_along_its_side() -> None:
    """A wall at 30 degrees, a box turned with it and 4 cm in it."""
    wall, item = body((-2, 2, 0, 1, 0, 1), turn=30), body((-0.3, 0.3, -0.56, 0.04, 0, 1), turn=30)
    result = penetration(item, wall, 0.002)
    assert result is not None and result.depth == pytest.approx(0.04, abs=1e-6)
    direction, depth = min(result.ways, key=lambda way: way[1])
    np.testing.assert_allclose(direction, [np.sin(np.radians(30)), -np.cos(np.radians(30))])
    assert depth == pytest.approx(0.04, abs=1e-6)


def test_a_mesh_inside_out_is_turned_and_an_open_one_becomes_a_sheet() -> None:
    vertices, faces = blocks(CUBE)
    np.testing.assert_allclose(_volume(solid(vertices, faces[:, ::-1])), 1.0)
    sheet = solid(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]), np.array([[0, 1, 2]]))
    assert _volume(sheet) == pytest.approx(0.5 * 0.002)
    # Parts that share no corner are each turned by themselves.
    two, rows = blocks(CUBE, (2, 3, 0, 1, 0, 1))
    rows[12:] = rows[12:, ::-1]
    assert _volume(solid(two, rows)) == pytest.approx(2.0)


def _volume(triangles: np.ndarray) -> float:
    a, b, c = np.moveaxis(triangles, 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def test_chords_of_a_sphere_integrate_to_its_volume() -> None:
    import trimesh

    ball = trimesh.creation.icosphere(4, 0.5)
    lattice = Lattice.over(np.array([-0.5, -0.5]), np.array([0.5, 0.5]), 5000)
    found_ = chords(solid(ball.vertices, ball.faces), lattice)
    volume = float((found_.high - found_.low).sum()) * lattice.spacing**2
    assert volume == pytest.approx(ball.volume, rel=3e-3)


def test_parts_that_overlap_count_once() -> None:
    lattice = Lattice.over(np.array([0.1, 0.1]), np.array([0.9, 0.9]), 100)
    both = chords(solid(*blocks(CUBE, (0.5, 2, 0, 1, 0, 1))), lattice)
    np.testing.assert_allclose(both.low, 0.0, atol=1e-12)
    np.testing.assert_allclose(both.high, 2.0)


@pytest.mark.slow
def test_random_furniture_agrees_with_fcl() -> None:
    rng = np.random.default_rng(3)
    names, counts = ["table", "chair", "bookshelf", "box"], [0, 0]
    for _ in range(100):
        one, two = (
            found(k, names[rng.integers(4)], (*rng.normal(0, 0.3, 2), 0), rng.uniform(0, 360))
            for k in (1, 2)
        )
        result = penetration(_body(one), _body(two), 0.001, 6000)
        if result is None:
            # Free, or freed by a hair's breadth in some direction.
            ways = np.concatenate([_body(one).axes, _body(two).axes])
            steps = [np.append(s * 0.004 * way, 0.0) for way in ways for s in (1, -1)]
            freed = not meets(one, two) or any(not meets(one, two, step) for step in steps)
            assert freed
        else:
            direction, depth = min(result.ways, key=lambda way: way[1])
            if depth > 0.5:  # beyond what is measured
                continue
            assert not meets(one, two, np.append((depth + 0.006) * direction, 0.0))
            if depth > 0.02:
                assert meets(one, two, np.append((depth - 0.012) * direction, 0.0))
        counts[result is not None] += 1
    assert min(counts) > 20


def _body(item) -> Body:
    from openrooms_usd.scan.placement.arrangement import arranged

    return arranged([item], MODELS, []).bodies[0]


X, Y = np.array([1.0, 0.0]), np.array([0.0, 1.0])
ELL = Enclosure(np.array([[0, 0], [4, 0], [4, 3], [2, 3], [2, 1.5], [0, 1.5]], dtype=float), 0, 2.5)


def bodies(*items) -> list[Body]:
    return arranged(items, MODELS, []).bodies


@pytest.mark.parametrize("height", [0.74, 0.78, 0.70])
def test_the_gap_to_a_table_top(height: float) -> None:
    table, box = bodies(found(1, "table", (0, 0, 0)), found(2, "box", (0.2, 0.1, height)))
    there = rest(box, table)
    assert there is not None and there.gap == pytest.approx(height - 0.74, abs=1e-9)
    assert there.share == 1.0


def test_half_of_a_box_over_an_edge() -> None:
    table, box = bodies(found(1, "table", (0, 0, 0)), found(2, "box", (0.6, 0, 0.75)))
    there = rest(box, table)
    assert there is not None and there.share == pytest.approx(0.5, abs=0.05)


def test_nothing_below() -> None:
    table, box = bodies(found(1, "table", (0, 0, 0)), found(2, "box", (0.9, 0, 0.75)))
    assert rest(box, table) is None


def test_a_pointed_foot_is_not_missed_between_lines() -> None:
    tip = np.array([[0, 0, 0], [0.3, 0.3, 0.4], [-0.3, 0.3, 0.4], [0, -0.4, 0.4]], dtype=float)
    faces = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    (table,) = bodies(found(1, "table", (0.01, 0.02, 0)))
    there = rest(Body(solid(tip + np.array([0, 0, 0.75]), faces), np.eye(2)), table)
    assert there is not None and there.gap == pytest.approx(0.01, abs=1e-6)


def test_an_l_shaped_room() -> None:
    square = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    assert ELL.leave(square + np.array([1.0, 0.8])) == {}
    # In the outer corner both walls, at the inner corner the nearer one.
    assert ELL.leave(square + np.array([0.4, 0.3])) == pytest.approx({0: 0.2, 5: 0.1})
    around = np.concatenate([square, [[-0.5, 0.45], [-0.45, 0.5]]]) + np.array([2.42, 1.1])
    assert ELL.leave(around) == pytest.approx({3: 0.08})
    gaps = ELL.gaps(square + np.array([3.4, 0.6]))
    assert gaps == pytest.approx({0: 0.1, 1: 0.1})


def test_the_nearest_wall_and_the_turn_along_it() -> None:
    (wardrobe,) = bodies(found(1, "wardrobe", (1.0, 1.15, 0), yaw=5))
    facing = ELL.facing(wardrobe)
    assert facing is not None and facing.wall == 4
    assert np.degrees(facing.angle) == pytest.approx(-5)
    assert facing.gap == pytest.approx(0.05, abs=1e-6)


def test_the_least_motion_against_a_closed_form() -> None:
    """Two objects apart by d share it in inverse proportion to their weights."""
    apart = Condition({1: X, 0: -X}, 0.3, 1e-9)
    motion = least_motion(np.array([1.0, 2.0]), np.eye(2), [apart])
    np.testing.assert_allclose(motion, [[-0.2, 0], [0.1, 0]], atol=1e-6)


def test_a_wall_behind_one_leaves_the_way_to_the_other() -> None:
    rows = [Condition({1: X, 0: -X}, 0.3, 1e-9), Condition({0: X}, -0.05, 1e-9)]
    motion = least_motion(np.ones(2), np.eye(2), rows)
    np.testing.assert_allclose(motion, [[-0.05, 0], [0.25, 0]], atol=1e-6)


def test_what_is_carried_moves_along_for_nothing() -> None:
    carried = np.array([[1.0, 0.0], [1.0, 1.0]])
    motion = least_motion(np.ones(2), carried, [Condition({0: Y}, 0.1, 1e-9)])
    np.testing.assert_allclose(carried @ motion, [[0, 0.1], [0, 0.1]], atol=1e-6)


def test_contradictions_end_in_the_middle_and_the_harder_condition_wins() -> None:
    both = [Condition({0: X}, 0.1, 1e-6), Condition({0: -X}, 0.1, 1e-6)]
    np.testing.assert_allclose(least_motion(np.ones(1), np.eye(1), both), 0.0, atol=1e-6)
    uneven = [both[0], Condition({0: -X}, 0.1, 1e-9)]
    np.testing.assert_allclose(least_motion(np.ones(1), np.eye(1), uneven)[0, 0], -0.1, atol=1e-3)


def test_a_corner_of_the_room_that_sticks_into_the_side_of_something_is_seen() -> None:
    """The side of a wardrobe, 4 cm beyond the inner corner, none of its own corners outside."""
    middle = np.array([2.0, 1.5]) + (0.3 - 0.04) * np.array([1.0, -1.0]) / np.sqrt(2.0)
    (wardrobe,) = bodies(found(1, "wardrobe", (*middle, 0), yaw=45))
    assert ELL.beyond(wardrobe.outline).max() == 0.0
    footprint = ELL.footprint(wardrobe)
    way = ELL.leave(footprint)
    # Along one of the walls' normals: the depth across the side times the root of two.
    assert list(way.values()) == pytest.approx([0.04 * np.sqrt(2.0)], abs=4e-3)
