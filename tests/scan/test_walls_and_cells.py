"""Evidence along lines, cells between lines, and the minimum cut against trying every labelling."""

from itertools import product

import numpy as np
import pytest

from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.surfels import surfels
from openrooms_usd.scan.rooms.candidates import wall_lines
from openrooms_usd.scan.rooms.cells import FloorCells, cut_plan, inside_by_cut
from openrooms_usd.scan.rooms.directions import angle_between, wall_directions
from openrooms_usd.scan.rooms.outline import outline_of
from openrooms_usd.scan.rooms.roomoutline import refitted
from openrooms_usd.scan.rooms.walls import Line, profile, upright
from tests.scan.scanned_rooms import CABINET, SQUARE, RoomScan, corner_error, motion, rings_found

RECTANGLE = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))
X, Y = np.array([1.0, 0.0]), np.array([0.0, 1.0])
# A block of 1 x 1.3 m stands out from the wall at x = 4.
BLOCK = (
    (0.0, 0.0),
    (4.0, 0.0),
    (4.0, 2.0),
    (2.7, 2.0),
    (2.7, 3.0),
    (4.0, 3.0),
    (4.0, 5.0),
    (0, 5.0),
)


def line(degrees: float, offset: float) -> Line:
    normal = np.array([np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))])
    return Line(normal, offset, -10.0, np.zeros(400), np.zeros(400))


def test_pieces_of_a_plane_lie_on_it():
    cloud = RoomScan(RECTANGLE, noise=0.0, floor=False, ceiling=False, missing=(1, 2, 3)).cloud()
    turned = cloud.moved(motion(20.0, 30.0, (0.0, 0.0, 0.0)))
    pieces = surfels(turned)
    normal = motion(20.0, 30.0, (0, 0, 0))[:3, :3] @ [0.0, 1.0, 0.0]
    assert np.abs(pieces.points @ normal).max() < 1e-9
    assert np.abs(np.abs(pieces.normals @ normal) - 1.0).max() < 1e-9
    assert pieces.rough.max() < 1e-6


def test_a_wall_covers_its_line_but_not_its_gap():
    cloud = RoomScan(RECTANGLE, holes=((0, 1.0, 2.0, 0.0, 2.5),)).cloud()
    found = profile(upright(surfels(cloud)), Y, 0.0)
    # The line runs along -x.
    assert found.covered(-4.0, 0.0) == pytest.approx(3.0, abs=0.15)
    assert found.covered(-1.9, -1.1) == pytest.approx(0.0, abs=0.01)
    assert found.covered(0.0, -4.0) == pytest.approx(float(found.covered(-4.0, 0.0)))


def test_furniture_is_evidence_against_a_wall():
    cloud = RoomScan(RECTANGLE, boxes=((1.0, 1.2, 1.5, 0.6, 0.0, 2.0),)).cloud()
    walls = upright(surfels(cloud))
    assert profile(walls, Y, 1.2).cover.min() < 0.0
    unlabelled = upright(surfels(Cloud(cloud.points)))
    low = profile(unlabelled, Y, 1.2)
    assert 0.0 < low.covered(-2.4, -1.1) < 0.6
    assert (cloud.label == CABINET).any()


def test_directions_and_lines_of_a_room_with_two_frames():
    corners = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (1.5, 3.0), (0.0, 1.5))
    pieces = surfels(RoomScan(corners).cloud())
    directions = wall_directions(pieces)
    assert directions[0] == pytest.approx(0.0, abs=0.3) or directions[0] == pytest.approx(
        90.0, abs=0.3
    )
    assert directions[1] == pytest.approx(45.0, abs=0.5)
    lines = wall_lines(upright(pieces), directions)
    slanted = Line(np.array([-1.0, 1.0]) / np.sqrt(2.0), 1.5 / np.sqrt(2.0), 0.0, X, X)
    apart = [
        abs(abs(found.normal @ slanted.normal) - 1.0) + abs(abs(found.offset) - slanted.offset)
        for found in lines
    ]
    assert min(apart) < 0.02


def test_cells_of_lines_in_general_position_tile_the_box():
    lines = [line(10.0, 0.3), line(75.0, -0.2), line(130.0, 0.1), line(35.0, -0.4)]
    cells = cut_plan(lines, np.array([-9.0, -9.0]), np.array([9.0, 9.0]))
    # n lines that all cross inside make 1 + n + n (n - 1) / 2 cells, each line n pieces.
    assert len(cells) == 1 + 4 + 6
    assert len(cells.pairs) == 4 * 4
    assert sum(shape.area for shape in cells.shapes) == pytest.approx(18.0**2)
    assert cells.rim.sum() == 2 * 4
    owner = cells.owners(np.array([[0.0, 0.0], [20.0, 0.0]]))
    assert owner[0] >= 0
    assert owner[1] == -1


@pytest.mark.parametrize("seed", range(6))
def test_the_cut_is_the_cheapest_of_all_labellings(seed):
    rng = np.random.default_rng(seed)
    angles, offsets = rng.uniform(0.0, 180.0, 4), rng.uniform(-1.0, 1.0, 4)
    lines = [line(a, o) for a, o in zip(angles, offsets, strict=True)]
    cells = cut_plan(lines, np.array([-3.0, -3.0]), np.array([3.0, 3.0]))
    cells = FloorCells(
        cells.shapes, cells.pairs, rng.uniform(0.0, 2.0, len(cells.pairs)), cells.rim
    )
    gain = rng.normal(0.0, 1.5, len(cells))
    none = np.zeros(len(cells), bool)
    inner, outer = none.copy(), none.copy()
    inner[0], outer[-1] = True, True

    def cost(inside: np.ndarray) -> float:
        a, b = cells.pairs.T
        missing = cells.missing[inside[a] != inside[b]].sum()
        return float(missing - gain[inside].sum())

    found = inside_by_cut(cells, gain, inner, outer)
    assert found[0]
    assert not found[-1]
    free = [i for i in range(len(cells)) if not (inner | outer)[i]]
    least = np.inf
    for bits in product((False, True), repeat=len(free)):
        inside = inner.copy()
        inside[free] = bits
        least = min(least, cost(inside))
    assert cost(found) == pytest.approx(least, abs=0.01)


def test_a_wall_that_nobody_saw_runs_as_the_others_do() -> None:
    from openrooms_usd.scan.rooms.directions import unseen_wall_cost

    turns = np.deg2rad([0.0, 92.0, 185.0, 20.0, 45.0, 110.0])
    normals = np.column_stack([np.cos(turns), np.sin(turns)])
    dear = unseen_wall_cost(normals, (0.0, 20.0))
    assert dear.tolist() == [1.0, 1.0, 1.0, 1.0, 1.5, 1.0]
    assert (unseen_wall_cost(normals, ()) == 1.0).all()


@pytest.mark.slow
def test_a_block_whose_side_nobody_saw_is_no_floor():
    scan = RoomScan(BLOCK, missing=(2,), boxes=((3.1, 1.2, 0.7, 0.6, 0.0, 0.9),))
    cloud = scan.cloud()
    # Nothing of the floor and ceiling is seen where furniture beside the block hides them.
    x, y, z = cloud.points.T
    hidden = (x > 2.9) & (y > 1.3) & (y < 2.0) & (z < 0.05)
    (corners,) = rings_found(cloud.take(~hidden))
    assert corner_error(corners, np.array(BLOCK)) < 0.06


def test_a_column_that_stands_free_before_a_wall_is_no_block():
    column = ((2.0, 1.0, 0.5, 0.5, 0.0, 2.5),)
    (corners,) = rings_found(Cloud(RoomScan(SQUARE, boxes=column).cloud().points))
    assert corner_error(corners, np.array(SQUARE)) < 0.06


@pytest.mark.parametrize("yaw", [8.0, 21.0, 37.0])
def test_directions_of_noisy_walls_are_those_of_their_places(yaw):
    cloud = RoomScan(SQUARE, spacing=0.025, noise=0.02).cloud().moved(motion(0.0, yaw, (3, 1, 0)))
    assert float(angle_between(wall_directions(surfels(cloud))[0], yaw)) < 0.15


def test_a_wall_of_which_strays_were_seen_keeps_its_direction():
    hall = ((0.0, 0.0), (4.2, 0.0), (4.2, 5.1), (0.0, 5.1))
    cloud = RoomScan(hall, missing=(1,)).cloud()
    y, z = (axis.ravel() for axis in np.meshgrid(np.arange(1.2, 2.0, 0.02), np.arange(0, 2, 0.02)))
    strays = np.column_stack([4.2 - 0.05 * (y - 1.2), y, z])
    points = np.concatenate([cloud.points, strays])
    outline = outline_of(np.array(hall))
    moved = refitted(outline, upright(surfels(Cloud(points))), (0.0,))
    np.testing.assert_allclose(moved.normals[1], outline.normals[1], atol=0.004)


def test_a_wall_that_was_seen_in_part_is_where_it_was_seen():
    cloud = RoomScan(SQUARE).cloud()
    x, y, z = cloud.points.T
    # Only 0.7 m of the wall at x = 4.2, and strays behind it.
    kept = (x < 4.15) | ((y > 1.2) & (y < 1.9)) | (z < 0.02) | (z > 2.48)
    strays = cloud.points[(x > 3.9) & (z < 0.05)] + [0.12, 0.0, 0.0]
    points = np.concatenate([cloud.points[kept], strays])
    (corners,) = rings_found(Cloud(points))
    assert corner_error(corners, np.array(SQUARE)) < 0.05
