"""Doors and windows in their opening: closed ones keep the light out, open ones are free."""

from itertools import product

import numpy as np
import pytest
import shapely

from openrooms_usd.building.doors import Door, door, free_angle
from openrooms_usd.building.shell import Hole, cut_apart, wall_solid
from openrooms_usd.building.walls import Wall, footprint
from openrooms_usd.building.windows import STYLES as WINDOW_STYLES
from openrooms_usd.building.windows import window
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.raycast import RayCaster

WIDTH, HEIGHT, THICKNESS = 0.9, 2.05, 0.2
SIDES = list(product(("left", "right"), ("in", "out")))


def straight_wall(thickness: float = THICKNESS) -> Wall:
    """A wall along x, 4 m to both sides of the opening, which is in its middle."""
    outline = footprint(8.0, 0.0, 0.0, thickness)
    return Wall(0, np.array([-4.0, 0.0]), np.array([4.0, 0.0]), thickness, outline, 0.0)


def leaf(made: Door, angle: float) -> Mesh:
    """All leaves and handles, each opened by an angle in degrees."""
    moved = []
    for part in made.leaves:
        turn = np.radians(part.sense * angle)
        pose = np.eye(4)
        pose[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
        pose[:2, 3] = part.hinge
        moved.append(joined([part.panel, part.handle]).transformed(pose))
    return joined(moved)


def passes(meshes: list[Mesh], width: float, height: float, count: int = 4000) -> np.ndarray:
    """Rays from inside to points of the opening that meet nothing behind it either."""
    rng = np.random.default_rng(3)
    mesh = joined(meshes)
    corners, _ = mesh.triangles()
    caster = RayCaster(mesh.points, mesh.indices[corners])
    margin = np.array([0.5 * width, 0.0, 0.5 * height])
    targets = rng.uniform(-1, 1, (count, 3)) * margin
    # Half of the rays aim at the seams along the edges, where leaf and lining meet.
    edges = rng.choice([-1.0, 1.0], count // 2)
    side = rng.integers(0, 2, count // 2) * 2
    targets[np.arange(count // 2), side] = edges * (margin[side] - rng.uniform(0, 0.06, count // 2))
    origins = rng.uniform([-2, -3, -0.4 * height], [2, -0.3, 0.4 * height], (count, 3))
    directions = targets - origins
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return np.isinf(caster.first_hit(origins, directions).distance)


@pytest.mark.parametrize(("hinge", "swing"), SIDES)
@pytest.mark.parametrize("thickness", [0.02, 0.2, 0.5])
def test_a_closed_door_keeps_the_light_out_and_an_open_one_lets_it_in(
    hinge: str, swing: str, thickness: float
) -> None:
    wall = straight_wall(thickness)
    hole = Hole(4 - 0.5 * WIDTH, 4 + 0.5 * WIDTH, 0.0, HEIGHT)
    solid = wall_solid(wall, 2.6, [hole]).moved([0, 0, -0.5 * HEIGHT])
    below = Mesh(
        np.array([[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0.0]]) - [0, 0, 0.5 * HEIGHT],
        np.array([4], dtype=np.int32),
        np.arange(4, dtype=np.int32),
        np.zeros((4, 3), dtype=np.float32),
        np.zeros((4, 2), dtype=np.float32),
    )
    made = door(WIDTH, HEIGHT, thickness, hinge=hinge, swing=swing)  # type: ignore[arg-type]
    room = [solid, below, made.frame]
    assert not passes([*room, leaf(made, 0.0)], WIDTH, HEIGHT).any()
    assert passes([*room, leaf(made, 85.0)], WIDTH, HEIGHT).mean() > 0.03


def section(mesh: Mesh, axis: int, at: float) -> list[shapely.LineString]:
    """Where the triangles of a mesh cross a plane, in the two other coordinates."""
    corners, _ = mesh.triangles()
    others = [k for k in range(3) if k != axis]
    lines = []
    for triangle in mesh.points[mesh.indices[corners]]:
        side = triangle[:, axis] - at
        ends = [
            (triangle[i] + (triangle[i - 1] - triangle[i]) * side[i] / (side[i] - side[i - 1]))
            for i in range(3)
            if side[i] * side[i - 1] < 0
        ]
        if len(ends) == 2:
            lines.append(shapely.LineString([end[others] for end in ends]))
    return lines


@pytest.mark.parametrize("swing", ["in", "out"])
@pytest.mark.parametrize(("axis", "at"), [(2, 0.0123), (0, 0.0123)])
def test_no_crooked_way_leads_around_a_closed_leaf(swing: str, axis: int, at: float) -> None:
    """Light turns corners by scattering: in a section, inside and outside are not connected."""
    wall = straight_wall()
    hole = Hole(4 - 0.5 * WIDTH, 4 + 0.5 * WIDTH, 0.0, HEIGHT)
    solid = wall_solid(wall, 2.6, [hole]).moved([0, 0, -0.5 * HEIGHT])
    made = door(WIDTH, HEIGHT, THICKNESS, swing=swing)  # type: ignore[arg-type]
    lines = section(joined([solid, made.frame, leaf(made, 0.0)]), axis, at)
    if axis == 0:
        lines.append(shapely.LineString([(-3, -0.5 * HEIGHT), (3, -0.5 * HEIGHT)]))
    solids = shapely.union_all(lines).buffer(5e-5)
    region = shapely.box(-0.7, -1.0, 0.7, 1.0) if axis == 2 else shapely.box(-1, -1.03, 1, 1.1)
    inside, outside = (
        shapely.Point((0.0, y) if axis == 2 else (y, 0.5)) for y in (-0.5, THICKNESS + 0.5)
    )
    parts = shapely.get_parts(region.difference(solids))
    for part in parts:
        assert not (part.contains(inside) and part.contains(outside))
    assert sum(part.contains(inside) or part.contains(outside) for part in parts) == 2


@pytest.mark.parametrize(("hinge", "swing"), SIDES)
@pytest.mark.parametrize("angle", [0.0, 5.0, 40.0, 90.0, 135.0, 170.0])
def test_a_leaf_never_meets_its_own_wall(hinge: str, swing: str, angle: float) -> None:
    made = door(WIDTH, HEIGHT, THICKNESS, hinge=hinge, swing=swing)  # type: ignore[arg-type]
    hole = Hole(4 - 0.5 * WIDTH, 4 + 0.5 * WIDTH, 0.0, HEIGHT)
    wall = straight_wall()
    pieces = [shapely.Polygon(wall.to_plan(ring)) for ring in cut_apart(wall, [hole])]
    points = shapely.MultiPoint(leaf(made, angle).points[:, :2])
    assert not any(points.convex_hull.intersects(piece) for piece in pieces) or angle in (0.0, 5.0)
    assert not any(points.intersects(piece) for piece in pieces)


@pytest.mark.parametrize(("hinge", "swing"), SIDES)
def test_hinge_and_swing_are_as_seen_from_inside(hinge: str, swing: str) -> None:
    made = door(WIDTH, HEIGHT, THICKNESS, hinge=hinge, swing=swing)  # type: ignore[arg-type]
    middle = leaf(made, 90.0).points[:, :2].mean(axis=0)
    assert (middle[0] < 0) == (hinge == "left")
    assert (middle[1] < 0) == (swing == "in")
    closed = leaf(made, 0.0).points
    assert abs(closed[:, 0].min() + closed[:, 0].max()) < 0.01
    assert closed[:, 1].min() > -0.1
    assert closed[:, 1].max() < THICKNESS + 0.1


def test_a_leaf_stops_before_a_wall_beside_it() -> None:
    made = door(WIDTH, HEIGHT, THICKNESS)
    panel = made.leaves[0]
    beside = np.array([[-0.7, -2.0], [-0.6, -2.0], [-0.6, 0.0], [-0.7, 0.0]])
    angle = free_angle(panel, 150.0, [beside])
    assert 85.0 < angle < 110.0
    points = shapely.MultiPoint(leaf(made, angle).points[:, :2]).convex_hull
    assert not points.intersects(shapely.Polygon(beside))
    assert free_angle(panel, 60.0, [beside]) == 60.0
    assert free_angle(panel, 0.0, [beside]) == 0.0


def test_an_open_leaf_does_not_jump_over_what_is_in_its_way() -> None:
    post = np.array([[-0.05, -0.6], [0.05, -0.6], [0.05, -0.5], [-0.05, -0.5]])
    assert 5.0 < free_angle(door(WIDTH, HEIGHT, THICKNESS).leaves[0], 120.0, [post]) < 60.0


@pytest.mark.parametrize("size", [(0.15, 0.2), (0.3, 2.0), (1.2, 1.3), (4.0, 2.4)])
@pytest.mark.parametrize("thickness", [0.01, 0.2, 1.0])
@pytest.mark.parametrize("style", WINDOW_STYLES)
def test_window_frames_fill_the_edge_and_leave_most_of_the_opening_free(
    size: tuple[float, float], thickness: float, style: str
) -> None:
    width, height = size
    frame = window(width, height, thickness, board=thickness > 0.1, style=style).closed()
    low, high = frame.extent
    assert np.all(low[[0, 2]] < [-0.5 * width, -0.5 * height])
    assert np.all(high[[0, 2]] > [0.5 * width, 0.5 * height])
    assert frame.volume() > 0
    rng = np.random.default_rng(0)
    targets = rng.uniform(-0.5, 0.5, (2000, 3)) * [width, 0.0, height]
    corners, _ = frame.triangles()
    caster = RayCaster(frame.points, frame.indices[corners])
    hits = caster.first_hit(targets - [0.0, 1.0, 0.0], np.tile([0.0, 1.0, 0.0], (2000, 1)))
    free = np.isinf(hits.distance).mean()
    assert (0.3 if style == "sliding" else 0.35) < free < 0.95


def test_normals_and_texture_coordinates_are_complete() -> None:
    made = door(WIDTH, HEIGHT, THICKNESS)
    part = made.leaves[0]
    whole = window(1.2, 1.3, 0.2, board=True).closed()
    for mesh in (made.frame, part.panel, part.handle, whole):
        assert mesh.normals is not None
        assert mesh.st is not None
        assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-5)
        corners, _ = mesh.triangles()
        a, b, c = np.moveaxis(mesh.points[mesh.indices[corners]], 1, 0)
        facing = np.einsum("ij,ij->i", np.cross(b - a, c - a), mesh.normals[corners[:, 0]])
        assert (facing > 0).all()


def test_the_same_door_is_the_same_to_the_last_bit() -> None:
    first, second = (door(WIDTH, HEIGHT, THICKNESS, hinge="right") for _ in range(2))
    assert np.array_equal(first.leaves[0].panel.points, second.leaves[0].panel.points)
    assert np.array_equal(first.frame.indices, second.frame.indices)
