"""Collision shapes: few, within what they state, equal every time, and hollows stay hollow."""

import hashlib
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import trimesh
from shapely.geometry import Polygon

from openrooms_usd.errors import InputError
from openrooms_usd.furniture import make
from openrooms_usd.physics.collision_error import collision_error
from openrooms_usd.physics.components import Part, components
from openrooms_usd.physics.decomposition import (
    METHODS,
    ConvexShape,
    Method,
    Shapes,
    collision_shapes,
)
from openrooms_usd.physics.hulls import volume
from openrooms_usd.physics.solid import Solid
from openrooms_usd.showroom.exhibits import exhibits


def box(*sides: float, at: tuple[float, float, float] = (0, 0, 0)) -> trimesh.Trimesh:
    return trimesh.creation.box(sides, trimesh.transformations.translation_matrix(at))


def part(mesh: trimesh.Trimesh, contact: str = "wood", name: str = "part") -> Part:
    return Part(name, np.asarray(mesh.vertices), np.asarray(mesh.faces), contact)


def library(category: str, size: tuple[float, float, float], style: str) -> list[Part]:
    made = make(category, size, style, np.random.default_rng(0))
    parts = []
    for name, mesh in made.parts.items():
        corners, _ = mesh.triangles()
        parts.append(Part(name, mesh.points, mesh.indices[corners], "wood"))
    return parts


def touches(shapes: Sequence[ConvexShape], points: np.ndarray, radius: float) -> np.ndarray:
    """Whether a ball meets any shape: trimesh's own hulls of their corners."""
    found = np.zeros(len(points), dtype=bool)
    for shape in shapes:
        hull = trimesh.Trimesh(shape.mesh.points, shape.mesh.triangles, process=False)
        found |= trimesh.proximity.signed_distance(hull, points) > -radius
    return found


def l_shape() -> trimesh.Trimesh:
    outline = [[0, 0], [1, 0], [1, 0.2], [0.2, 0.2], [0.2, 1], [0, 1]]
    return trimesh.creation.extrude_polygon(Polygon(outline), 0.5)


def test_a_box_is_one_box() -> None:
    found = collision_shapes([part(box(0.5, 0.4, 0.3))])
    assert [shape.box for shape in found.shapes] == [True]
    assert volume(found.shapes[0].mesh) == pytest.approx(0.06)
    assert found.error < 1e-6


def test_no_box_stands_lower_than_what_leans() -> None:
    bar = Polygon([(0, 0), (0.016, 0), (0.016, 0.2), (0, 0.2)]).buffer(-0.003).buffer(0.003, 1)
    leaning = trimesh.creation.extrude_polygon(bar, 0.3)
    turn = trimesh.transformations.rotation_matrix(np.radians(12), (0, 0, 1))
    leaning.apply_transform(trimesh.transformations.euler_matrix(np.pi / 2, 0, 0) @ turn)
    leaning.apply_translation((0, 0, -leaning.bounds[0, 2]))
    found = collision_shapes([part(leaning)])
    assert min(shape.mesh.points[:, 2].min() for shape in found.shapes) == pytest.approx(
        0, abs=1e-4
    )


def test_what_is_printed_on_a_thing_is_no_shape_of_its_own() -> None:
    cover = box(0.2, 0.2, 0.02, at=(0, 0, 0.01))
    title = box(0.1, 0.02, 0.0008, at=(0, -0.08, 0.02))
    found = collision_shapes([part(cover, name="cover"), part(title, "paper", "title")])
    assert [shape.parts for shape in found.shapes] == [("cover",)]
    assert found.uncovered == pytest.approx(0.0004, abs=1e-4)


def test_an_l_is_two_boxes_exactly() -> None:
    found = collision_shapes([part(l_shape())])
    assert [shape.box for shape in found.shapes] == [True, True]
    assert sum(volume(s.mesh) for s in found.shapes) == pytest.approx(0.36 * 0.5, rel=1e-4)


def test_boards_in_line_are_one_shape_and_other_materials_are_not() -> None:
    boards = [box(0.2, 0.5, 0.02, at=(0.2 * k, 0, 0)) for k in range(4)]
    one = collision_shapes([part(board, name=f"b{k}") for k, board in enumerate(boards)])
    assert len(one.shapes) == 1
    assert one.shapes[0].parts == ("b0", "b1", "b2", "b3")
    two = collision_shapes([part(b, "wood" if k < 2 else "metal") for k, b in enumerate(boards)])
    assert sorted(shape.contact for shape in two.shapes) == ["metal", "wood"]


def test_a_flush_pane_keeps_its_own_contact() -> None:
    frame = [box(1, 0.1, 0.02, at=(0, y, 0)) for y in (-0.45, 0.45)]
    frame += [box(0.1, 0.8, 0.02, at=(x, 0, 0)) for x in (-0.45, 0.45)]
    parts = [part(mesh, "wood") for mesh in frame] + [part(box(0.8, 0.8, 0.02), "glass")]
    found = collision_shapes(parts)
    wood = [shape for shape in found.shapes if shape.contact == "wood"]
    assert not touches(wood, np.array([[0.0, 0.0, 0.0]]), 0.3).any()
    assert any(shape.contact == "glass" for shape in found.shapes)


def test_compartments_of_a_shelf_stay_open() -> None:
    parts = [part(box(0.02, 0.3, 1.0, at=(x, 0, 0.5))) for x in (-0.39, 0.39)]
    parts += [part(box(0.8, 0.02, 1.0, at=(0, 0.16, 0.5)))]
    parts += [part(box(0.76, 0.3, 0.02, at=(0, 0, 0.01 + 0.245 * k))) for k in range(5)]
    found = collision_shapes(parts)
    middles = np.array([[0.0, 0.0, 0.1325 + 0.245 * k] for k in range(4)])
    assert not touches(found.shapes, middles, 0.1).any()
    assert touches(found.shapes, middles + np.array([0, 0, 0.1225]), 0.01).all()


@pytest.mark.slow
def test_a_cup_stays_hollow() -> None:
    cup = trimesh.creation.revolve(
        [[0, 0], [0.04, 0], [0.05, 0.1], [0.045, 0.1], [0.036, 0.006], [0, 0.006]], sections=32
    )
    found = collision_shapes([part(cup)], tolerance=0.005)
    points = np.array([[0, 0, z] for z in (0.03, 0.06, 0.09)])
    assert not touches(found.shapes, points, 0.015).any()
    assert found.error <= 0.005 + 1e-9


@pytest.mark.parametrize(
    ("category", "size", "style"),
    [("chair", (0.46, 0.53, 0.84), "slat"), ("bowl", (0.24, 0.24, 0.09), "round")],
)
def test_the_stated_bound_holds(
    category: str, size: tuple[float, float, float], style: str
) -> None:
    parts = library(category, size, style)
    found = collision_shapes(parts)
    assert found.protrusion <= 0.01 + 1e-9
    # Independently: random points of the shapes' surfaces, by trimesh.
    closed = [trimesh.Trimesh(p.points, p.triangles) for p in parts]
    whole = trimesh.util.concatenate(closed)
    for shape in found.shapes:
        hull = trimesh.Trimesh(shape.mesh.points, shape.mesh.triangles, process=False)
        points = trimesh.sample.sample_surface(hull, 60, seed=1)[0]
        away = trimesh.proximity.closest_point(whole, points)[1]
        away[np.any([mesh.contains(points) for mesh in closed], axis=0)] = 0.0
        assert away.max() <= found.protrusion + 1e-6
    # And the other way: the thing's corners against the shapes.
    least = np.full(len(whole.vertices), np.inf)
    for shape in found.shapes:
        hull = trimesh.Trimesh(shape.mesh.points, shape.mesh.triangles, process=False)
        least = np.minimum(least, -trimesh.proximity.signed_distance(hull, whole.vertices))
    assert least.max() <= found.uncovered + 1e-5


def digest(found: Shapes) -> str:
    data = b"".join(s.mesh.points.tobytes() + s.mesh.triangles.tobytes() for s in found.shapes)
    return hashlib.sha256(data).hexdigest()


CHILD = """
import sys; sys.path.insert(0, {here!r})
from test_decomposition import digest, l_shape, part
from openrooms_usd.physics.decomposition import collision_shapes
print(digest(collision_shapes([part(l_shape())], "auto", 0.03)))
"""


@pytest.mark.slow
def test_bytes_are_equal_in_other_processes_and_with_other_threads() -> None:
    here = str(Path(__file__).parent)
    found = set()
    for threads in ("1", "2"):
        done = subprocess.run(
            [sys.executable, "-c", CHILD.format(here=here)],
            env={**os.environ, "OMP_NUM_THREADS": threads},
            capture_output=True,
            text=True,
            check=True,
        )
        assert len(done.stdout.split()) == 1, "the decomposer speaks"
        found.add(done.stdout)
    assert len(found) == 1


@pytest.mark.parametrize("method", METHODS)
def test_every_method_covers_and_states_its_error(method: Method) -> None:
    mesh = l_shape()
    found = collision_shapes([part(mesh)], method, tolerance=0.03)
    measured = collision_error([s.mesh for s in found.shapes], Solid(components([part(mesh)])))
    # The greater of both distances: that between the filled volumes, at their surfaces.
    greatest = max(measured.protrusion, measured.uncovered)
    assert greatest <= found.error + measured.slack + 1e-6
    # The hull's slope is farthest from the arms in its middle, the box at its corner.
    expected = {"hull": 0.4, "box": 0.8}
    if method in expected:
        assert found.error == pytest.approx(expected[method], abs=0.02)
    else:
        assert found.error < 0.06


def test_hard_input() -> None:
    sheet = Part(
        "sheet",
        np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]]),
        np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32),
    )
    assert len(collision_shapes([sheet]).shapes) == 1
    tiny = collision_shapes([part(box(0.001, 0.001, 0.001))])
    assert volume(tiny.shapes[0].mesh) == pytest.approx(1e-9, rel=1e-3)
    huge = collision_shapes([part(box(10, 10, 10, at=(1000, 0, 0)))])
    assert volume(huge.shapes[0].mesh) == pytest.approx(1000, rel=1e-6)
    inside_out = l_shape()
    inside_out.invert()
    assert len(collision_shapes([part(inside_out)]).shapes) == 2
    twice = [part(l_shape()), part(l_shape(), name="again")]
    assert len(collision_shapes(twice).shapes) == 2


def test_many_components_stay_below_the_most() -> None:
    grid = [box(0.02, 0.02, 0.02, at=(0.1 * x, 0.1 * y, 0.0)) for x in range(7) for y in range(7)]
    found = collision_shapes([part(trimesh.util.concatenate(grid))], most=20)
    assert len(found.shapes) <= 20
    assert found.error > 0.01


@pytest.mark.slow
def test_what_stands_inside_a_rim_is_not_lifted() -> None:
    disc = trimesh.creation.cylinder(0.2, 0.02, sections=48)
    rim = trimesh.creation.annulus(0.185, 0.2, 0.008, sections=48)
    rim.apply_translation([0, 0, 0.014])
    found = collision_shapes([part(disc, name="disc"), part(rim, name="rim")])
    # Straight down through the rim's opening onto the shapes, by trimesh's rays.
    places = np.random.default_rng(4).uniform(-0.12, 0.12, (40, 2))
    origins = np.column_stack([places, np.full(len(places), 1.0)])
    highest = max(
        trimesh.Trimesh(s.mesh.points, s.mesh.triangles, process=False)
        .ray.intersects_location(origins, np.tile([0.0, 0.0, -1.0], (len(places), 1)))[0][:, 2]
        .max(initial=-1.0)
        for s in found.shapes
    )
    assert 0.01 - 1e-6 <= highest <= 0.012


@pytest.mark.slow
def test_hundreds_of_components_apart() -> None:
    cells = [(x, y) for x in range(20) for y in range(20)]
    cubes = [box(0.05, 0.05, 0.05, at=(0.1 * x, 0.1 * y, 0.0)) for x, y in cells]
    found = collision_shapes([part(trimesh.util.concatenate(cubes))], most=400)
    assert len(found.shapes) == 400
    assert found.error <= 1e-6


def test_bad_input_is_named() -> None:
    broken = box(1, 1, 1)
    points = np.array(broken.vertices)
    points[0, 0] = np.nan
    with pytest.raises(InputError, match=r"leg: .*finite"):
        collision_shapes([Part("leg", points, np.asarray(broken.faces))])
    with pytest.raises(InputError, match="at least one triangle with an area"):
        collision_shapes([Part("line", np.eye(3), np.array([[0, 1, 1]], dtype=np.int32))])
    with pytest.raises(InputError, match="auto"):
        collision_shapes([part(box(1, 1, 1))], "best")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="tolerance"):
        collision_shapes([part(box(1, 1, 1))], tolerance=0.0)


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
    steps = [[0.0, 0.0]]
    for k in range(8):
        steps += [[0.25 * k, 0.17 * (k + 1)], [0.25 * (k + 1), 0.17 * (k + 1)]]
    mesh = trimesh.creation.extrude_polygon(Polygon([*steps, [2.0, 1.1], [0.5, 0.0]]), 0.025)
    found = collision_shapes([Part("stringer", mesh.vertices, mesh.faces)])
    hulls = [trimesh.Trimesh(s.mesh.points, s.mesh.triangles) for s in found.shapes]
    points = trimesh.sample.sample_surface(mesh, 800, seed=3)[0]
    assert farthest_outside(points, hulls) <= 1e-3
