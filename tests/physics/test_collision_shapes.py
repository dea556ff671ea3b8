"""The default shapes of ordinary objects, measured by trimesh alone."""

import numpy as np
import pytest
import trimesh

from openrooms_usd.furniture import make
from openrooms_usd.physics.components import Part
from openrooms_usd.physics.decomposition import Shapes, collision_shapes
from openrooms_usd.showroom.exhibits import exhibits

TOLERANCE = 0.01
# The most shapes that somebody would call reasonable.
MOST = {
    "box": 1,
    "table": 12,
    "coffee_table": 12,
    "side_table": 6,
    "monitor": 8,
    "television": 10,
    "chair": 30,
    "picture": 20,
    "bottle": 8,
    "jar": 6,
    "telephone": 12,
    "kitchen_cabinet": 20,
    "wall_lamp": 16,
    "desk": 36,
    "dresser": 70,
}


def shapes_of(category: str) -> list[tuple[list[Part], Shapes]]:
    exhibit = exhibits([category])[0]
    made = make(exhibit.category, exhibit.size, exhibit.style, np.random.default_rng(0))
    joint = {name: joint.name for joint in made.joints for name in joint.meshes}
    links: dict[str, list[Part]] = {}
    for name, mesh in made.parts.items():
        corners, _ = mesh.triangles()
        part = Part(name, mesh.points, mesh.indices[corners])
        links.setdefault(joint.get(name, ""), []).append(part)
    return [(parts, collision_shapes(parts, tolerance=TOLERANCE)) for parts in links.values()]


def farthest_outside(points: np.ndarray, meshes: list[trimesh.Trimesh]) -> float:
    """How far points lie outside of all closed meshes, at most."""
    whole = trimesh.util.concatenate(meshes)
    away = trimesh.proximity.closest_point(whole, points)[1]
    for k in np.flatnonzero(away > TOLERANCE):
        if any(mesh.contains(points[k : k + 1])[0] for mesh in meshes):
            away[k] = 0.0
    return float(away.max())


@pytest.mark.one_in(64)
@pytest.mark.parametrize("category", list(MOST))
def test_shapes_are_few_and_within_the_tolerance_both_ways(category: str) -> None:
    found = shapes_of(category)
    assert sum(len(shapes.shapes) for _, shapes in found) <= MOST[category]
    for parts, shapes in found:
        bodies = [trimesh.Trimesh(part.points, part.triangles) for part in parts]
        hulls = [
            trimesh.Trimesh(s.mesh.points, s.mesh.triangles, process=False) for s in shapes.shapes
        ]
        of_shapes = np.concatenate(
            [trimesh.sample.sample_surface(hull, 40, seed=1)[0] for hull in hulls]
        )
        of_thing = np.concatenate(
            [trimesh.sample.sample_surface(body, 200, seed=2)[0] for body in bodies]
        )
        assert farthest_outside(of_shapes, bodies) <= TOLERANCE + 1e-6
        assert farthest_outside(of_thing, hulls) <= TOLERANCE + 1e-6
        assert shapes.error <= TOLERANCE + 1e-6


def test_a_door_frame_is_three_boxes() -> None:
    from shapely.geometry import Polygon

    outline = [[0, 0], [0.05, 0], [0.05, 2], [0.85, 2], [0.85, 0], [0.9, 0], [0.9, 2.05], [0, 2.05]]
    frame = trimesh.creation.extrude_polygon(Polygon(outline), 0.1)
    found = collision_shapes([Part("frame", frame.vertices, frame.faces)])
    assert [shape.box for shape in found.shapes] == [True, True, True]
    assert sum(abs(np.prod(np.ptp(s.mesh.points, axis=0))) for s in found.shapes) == pytest.approx(
        frame.volume, rel=1e-6
    )


def test_an_open_box_of_one_piece_is_five_boards() -> None:
    exhibit = exhibits(["dresser"])[0]
    made = make(exhibit.category, exhibit.size, exhibit.style, np.random.default_rng(0))
    mesh = made.parts["drawer_box_0"]
    corners, _ = mesh.triangles()
    found = collision_shapes([Part("drawer", mesh.points, mesh.indices[corners])])
    assert [shape.box for shape in found.shapes] == [True] * 5
    body = trimesh.Trimesh(mesh.points, mesh.indices[corners])
    hulls = [trimesh.Trimesh(s.mesh.points, s.mesh.triangles) for s in found.shapes]
    assert sum(hull.volume for hull in hulls) == pytest.approx(body.volume, rel=0.05)


def test_solids_that_touch_in_an_edge_have_an_inside() -> None:
    pair = [trimesh.creation.box((0.2, 0.2, 0.2)), trimesh.creation.box((0.2, 0.2, 0.2))]
    pair[1].apply_translation([0.2, 0.2, 0.0])
    both = trimesh.util.concatenate(pair)
    both.merge_vertices()
    found = collision_shapes([Part("pair", both.vertices, both.faces)])
    assert [shape.box for shape in found.shapes] == [True, True]
    assert found.error <= TOLERANCE


@pytest.mark.slow
def test_an_inverted_mesh_has_the_same_shapes() -> None:
    mesh = trimesh.creation.annulus(0.2, 0.3, 0.1, sections=24)
    there = collision_shapes([Part("ring", mesh.vertices, mesh.faces)])
    back = collision_shapes([Part("ring", mesh.vertices, mesh.faces[:, ::-1])])
    assert len(there.shapes) == len(back.shapes) > 4
    assert max(there.error, back.error) <= TOLERANCE + 1e-3


@pytest.mark.slow
def test_a_crowd_of_components_is_pooled_and_says_so() -> None:
    cube = trimesh.creation.box((0.02, 0.02, 0.02))
    places = np.array([[0.06 * x, 0.06 * y, 0.0] for x in range(40) for y in range(30)])
    points = (cube.vertices[None] + places[:, None]).reshape(-1, 3)
    faces = (cube.faces[None] + 8 * np.arange(len(places))[:, None, None]).reshape(-1, 3)
    found = collision_shapes([Part("crowd", points, faces)])
    assert len(found.shapes) <= 256
    assert found.error > TOLERANCE


def test_boxes_too_far_apart_are_not_merged() -> None:
    boxes = [trimesh.creation.box((0.2, 0.2, 0.2)) for _ in range(2)]
    boxes[1].apply_translation([0.205, 0.1, 0.0])
    found = collision_shapes(
        [Part(f"b{k}", box.vertices, box.faces) for k, box in enumerate(boxes)]
    )
    assert len(found.shapes) == 2


def test_steps_are_covered_to_their_corners() -> None:
    from shapely.geometry import Polygon

    steps = [[0.0, 0.0]]
    for k in range(8):
        steps += [[0.25 * k, 0.17 * (k + 1)], [0.25 * (k + 1), 0.17 * (k + 1)]]
    mesh = trimesh.creation.extrude_polygon(Polygon([*steps, [2.0, 1.1], [0.5, 0.0]]), 0.025)
    found = collision_shapes([Part("stringer", mesh.vertices, mesh.faces)])
    hulls = [trimesh.Trimesh(s.mesh.points, s.mesh.triangles) for s in found.shapes]
    points = trimesh.sample.sample_surface(mesh, 800, seed=3)[0]
    assert farthest_outside(points, hulls) <= 1e-3
