"""Rooms whose walls have tops of their own: closed solids, the volumes of attics, no light."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from openrooms_usd.building.openings import clamped
from openrooms_usd.building.roofs import ceiling_solid, crowned, stretched
from openrooms_usd.building.shell import Hole, slab, wall_solid
from openrooms_usd.building.walls import Wall
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.polygons import counter_clockwise
from openrooms_usd.geometry.slopes import heights_over, sloping
from openrooms_usd.geometry.topology import is_closed
from openrooms_usd.physics.hulls import volume
from openrooms_usd.physics.panels import panel_pieces, slab_pieces
from tests.building.test_shell import ROOMS, THICKNESS, inside_points, misses, walls_around
from tests.physics.test_panels import triangles

Array = np.ndarray

# A room of 5 m by 4 m with its tops, and the mean height and the planes of its ceiling.
GABLE = [(0, 0, 2), (5, 0, 2), (5, 2, 3), (5, 4, 2), (0, 4, 2), (0, 2, 3)]
LEAN = [(0, 0, 2.6), (5, 0, 2.6), (5, 4, 3.4), (0, 4, 3.4)]
SALTBOX = [(0, 0, 1), (5, 0, 1), (5, 3, 3), (5, 4, 2), (0, 4, 2), (0, 3, 3)]
MANSARD = [(0, 0, 1), (5, 0, 1), (5, 1, 2), (5, 3, 2), (5, 4, 1), (0, 4, 1), (0, 3, 2), (0, 1, 2)]
TOPS = {
    "gable": (GABLE, 2.5, 2),
    "lean-to": (LEAN, 3.0, 1),
    "saltbox": (SALTBOX, (3 * 2.0 + 2.5) / 4, 2),
    "mansard": (MANSARD, (1.5 + 2 * 2.0 + 1.5) / 4, 3),
}
RECTANGLE = np.array([(0, 0), (5, 0), (5, 4), (0, 4)], dtype=float)


def line_over(name: str) -> tuple[Array, Array]:
    """The corners of a room, and tops that differ at all of them, with a peak over each wall."""
    corners = counter_clockwise(ROOMS[name])[0]
    heights = 2.0 + 0.7 * np.sin(np.arange(len(corners)))
    line = []
    for a, b, z in zip(corners, np.roll(corners, -1, axis=0), heights, strict=True):
        line.append([*a, z])
        if np.linalg.norm(b - a) > 1.0:
            line.append([*(0.4 * a + 0.6 * b), z + 0.5])
    return corners, np.array(line)


def shell_of(
    corners: Array, line: Array, holes: dict[int, list[Hole]] | None = None
) -> tuple[list[Wall], list[Mesh]]:
    walls = list(crowned(walls_around(corners), np.asarray(line, dtype=float)))
    height = float(np.max(np.asarray(line)[:, 2]))
    solids = [wall_solid(w, height, (holes or {}).get(w.number, [])) for w in walls]
    above = ceiling_solid(walls, counter_clockwise(corners)[0], height, THICKNESS)
    return walls, [slab(corners, THICKNESS, -THICKNESS, 0.0), above, *solids]


def faces_of(mesh: Mesh) -> list[Array]:
    ends = np.cumsum(mesh.counts)
    return [mesh.points[mesh.indices[a:b]] for a, b in pairwise([0, *ends.tolist()])]


def area(face: Array) -> Array:
    """(3,) the vector of a flat face, as long as its area."""
    return 0.5 * np.cross(face - face[0], np.roll(face, -1, axis=0) - face[0]).sum(axis=0)


def enclosed(corners: Array, walls: list[Wall], meshes: list[Mesh]) -> float:
    """The volume between the inner faces of a shell, by the divergence theorem."""
    low, high = corners.min(axis=0) - 1e-9, corners.max(axis=0) + 1e-9
    inner = [[*p, 0.0] for p in corners[::-1]]
    total = -float(np.mean(np.array(inner) @ area(np.array(inner))))
    for wall, mesh in zip(walls, meshes[2:], strict=True):
        for face in faces_of(mesh):
            if np.abs(wall.from_plan(face[:, :2])[:, 1]).max() < 1e-9:
                total -= float(face[0] @ area(face))
    for face in faces_of(meshes[1]):
        over = (face[:, :2] >= low).all() and (face[:, :2] <= high).all()
        if over and area(face)[2] < -1e-9:
            total -= float(face[0] @ area(face))
    return total / 3.0


@pytest.mark.parametrize("name", TOPS)
def test_a_room_is_as_large_as_its_floor_times_its_mean_height(name: str) -> None:
    line, mean, planes = TOPS[name]
    walls, meshes = shell_of(RECTANGLE, np.array(line))
    assert enclosed(RECTANGLE, walls, meshes) == pytest.approx(20.0 * mean)
    sides = [np.cross(t[1] - t[0], t[2] - t[0]) for t in stretched(np.array(line, dtype=float))]
    assert len({tuple(np.round(s / np.linalg.norm(s), 6)) for s in sides}) == planes


def test_a_gable_is_a_pentagon_and_an_eaves_wall_a_rectangle() -> None:
    walls, meshes = shell_of(RECTANGLE, np.array(GABLE))
    for wall, mesh, size in zip(walls, meshes[2:], (10.0, 10.0, 10.0, 10.0), strict=True):
        inner = [f for f in faces_of(mesh) if np.abs(wall.from_plan(f[:, :2])[:, 1]).max() < 1e-9]
        assert sum(np.linalg.norm(area(f)) for f in inner) == pytest.approx(size)
        assert mesh.points[:, 2].max() == (3.0 if wall.number % 2 else 2.0)
        assert sum(map(len, inner)) == (5 if wall.number % 2 else 4)


@pytest.mark.parametrize("name", ROOMS)
def test_all_solids_are_closed_and_no_ray_leaves_the_room(name: str) -> None:
    corners, line = line_over(name)
    _, meshes = shell_of(corners, line)
    assert all(map(is_closed, meshes))
    rng = np.random.default_rng(0)
    origins = inside_points(corners, 40, rng) * [1.0, 1.0, 0.4]
    assert not misses(meshes, origins, rng.normal(size=(40, 3))).any()
    # Along the seams between walls and ceiling, and between its triangles.
    seams = np.concatenate([line, stretched(line).reshape(-1, 3)])
    seams = 0.5 * (seams + np.roll(seams, -1, axis=0))
    start = np.broadcast_to(origins[0], seams.shape)
    assert not misses(meshes, start, seams - start).any()


def test_walls_with_tops_and_holes_are_closed() -> None:
    holes = {1: [Hole(0.3, 1.2, 0.0, 2.0), Hole(1.5, 2.5, 0.9, 2.7)], 0: [Hole(1.0, 2.0, 0.9, 1.9)]}
    walls, meshes = shell_of(RECTANGLE, np.array(GABLE), holes)
    assert all(map(is_closed, meshes))
    solid, cut = (triangles(wall_solid(walls[1], 3.0, h)) for h in ((), holes[1]))
    assert volume(solid) - volume(cut) == pytest.approx((0.9 * 2.0 + 1.8) * THICKNESS)
    pieces = panel_pieces(cut)
    assert sum(map(volume, pieces)) == pytest.approx(volume(cut))
    assert all(volume(piece) == pytest.approx(ConvexHull(piece.points).volume) for piece in pieces)


def test_the_pieces_of_a_sloping_ceiling_are_convex_and_all_of_it() -> None:
    ceiling = triangles(shell_of(RECTANGLE, np.array(GABLE))[1][1])
    pieces = slab_pieces(ceiling)
    assert sum(map(volume, pieces)) == pytest.approx(volume(ceiling))
    assert all(volume(piece) == pytest.approx(ConvexHull(piece.points).volume) for piece in pieces)


def test_a_ceiling_is_as_high_as_its_lowest_face() -> None:
    ceiling = triangles(shell_of(RECTANGLE, np.array(GABLE))[1][1])
    slopes = sloping(ceiling.points[ceiling.triangles])
    places = np.array([[1.0, 0.5], [2.5, 2.0], [4.0, 4.0], [9.0, 9.0]])
    assert heights_over(slopes, places, 7.0) == pytest.approx([2.25, 3.0, 2.0, 7.0])
    level = triangles(slab(RECTANGLE, 0.2, 2.5, 2.7))
    assert not len(sloping(level.points[level.triangles]))


def test_a_ceiling_over_a_convex_room_sags_nowhere() -> None:
    rng = np.random.default_rng(7)
    angles = np.sort(rng.uniform(0.0, 2 * np.pi, 30))
    plan = np.column_stack([3.0 * np.cos(angles), 2.0 * np.sin(angles)])
    line = np.column_stack([plan, rng.uniform(2.0, 3.0, len(plan))])
    faces = stretched(line)
    a, b, c = np.moveaxis(faces, 1, 0)
    areas = 0.5 * np.linalg.det(np.stack([b - a, c - a], axis=1)[:, :, :2])
    below = np.column_stack([plan, np.zeros(len(plan))])
    hull = ConvexHull(np.concatenate([line, below]))
    assert (areas > 0.0).all()
    assert float(areas @ faces[:, :, 2].mean(axis=1)) == pytest.approx(hull.volume)


def test_a_hole_stays_below_the_top_of_its_wall() -> None:
    gable = crowned(walls_around(RECTANGLE), np.array(GABLE, dtype=float))[1]
    assert gable.top(3.0) == 2.0
    assert gable.top(3.0, (1.0, 2.5)) == 2.5
    for hole, top in ((Hole(0.1, 3.9, 1.0, 2.9), 2.05), (Hole(1.5, 2.5, 1.0, 2.9), 2.75)):
        fitting = clamped(gable, gable.top(3.0, (hole.left, hole.right)), hole)
        assert fitting is not None
        assert fitting.top == pytest.approx(top - 0.02)
