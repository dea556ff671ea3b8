"""The truth of a composed room is what its stage says, read in another way."""

import numpy as np
import pytest
from pxr import Usd, UsdGeom

pytest.importorskip("embreex")


@pytest.fixture(scope="module")
def read(composed_demo):
    from benchmarks.scan.rooms import read_room

    scene = composed_demo if composed_demo.is_file() else composed_demo / "scene.usda"
    return Usd.Stage.Open(str(scene)), read_room(scene)


def mesh_triangles(prim):
    """(F, 3, 3) corners of a mesh's triangles in the world, fan by fan."""
    mesh = UsdGeom.Mesh(prim)
    world = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(prim))
    points = np.array(mesh.GetPointsAttr().Get()) @ world[:3, :3] + world[3, :3]
    counts, rows = mesh.GetFaceVertexCountsAttr().Get(), mesh.GetFaceVertexIndicesAttr().Get()
    faces, at = [], 0
    for count in counts:
        ring = rows[at : at + count]
        faces += [(ring[0], ring[i], ring[i + 1]) for i in range(1, count - 1)]
        at += count
    return points[np.array(faces)]


@pytest.mark.slow
def test_the_outline_is_where_walls_stop_rays_from_inside(read):
    import shapely
    import trimesh

    stage, room = read
    walls = [mesh_triangles(p) for p in stage.GetPrimAtPath("/World/Room/Walls").GetChildren()]
    soup = np.concatenate(walls)
    mesh = trimesh.Trimesh(soup.reshape(-1, 3), np.arange(3 * len(soup)).reshape(-1, 3))
    outline = shapely.Polygon(room.floor)
    assert outline.exterior.is_ccw
    origin = np.array(
        [*outline.representative_point().coords[0], room.truth.rooms[0].ceiling - 0.02]
    )
    angles = np.radians(np.arange(0.5, 360, 5))
    ways = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    places, rays, _ = mesh.ray.intersects_location(
        np.tile(origin, (72, 1)), ways, multiple_hits=False
    )
    assert len(rays) == 72
    for place, ray in zip(places, rays, strict=True):
        line = shapely.LineString([origin[:2], origin[:2] + 100 * ways[ray, :2]])
        near = line.intersection(outline.exterior)
        expected = shapely.Point(origin[:2]).distance(near)
        assert np.linalg.norm(place - origin) == pytest.approx(expected, abs=1e-4)


@pytest.mark.slow
def test_openings_are_holes_in_their_walls_counter_clockwise_from_inside(read):
    stage, room = read
    layout = room.truth.rooms[0]
    assert len(layout.openings) == len(stage.GetPrimAtPath("/World/Room/Openings").GetChildren())
    assert {hole.type for hole in layout.openings} == {"door", "window"}
    for hole in layout.openings:
        a, b = layout.corners[hole.wall], layout.corners[(hole.wall + 1) % len(layout.corners)]
        along = (b - a) / np.linalg.norm(b - a)
        inward = np.array([-along[1], along[0], 0])
        assert np.abs((hole.corners - a) @ inward).max() < 1e-6
        across, up = hole.corners[1] - hole.corners[0], hole.corners[3] - hole.corners[0]
        assert np.cross(across, up) @ inward > 0 and up[2] > 0
        middle = hole.corners.mean(axis=0)
        for wall in stage.GetPrimAtPath("/World/Room/Walls").GetChildren():
            faces = mesh_triangles(wall)
            n = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
            flat = np.linalg.norm(n, axis=1) > 1e-9
            faces, n = faces[flat], n[flat]
            on = (np.abs((faces - middle) @ inward) < 1e-5).all(axis=1)
            sides = [
                np.einsum(
                    "ij,ij->i",
                    n[on],
                    np.cross(faces[on, (i + 1) % 3] - faces[on, i], middle - faces[on, i]),
                )
                for i in range(3)
            ]
            assert not (np.stack(sides) > 1e-9).all(axis=0).any()


@pytest.mark.slow
def test_objects_are_their_cads_in_their_poses(read):
    from benchmarks.scan.truth import moved, pose_matrix

    stage, room = read
    assert len(room.truth.objects) == len(stage.GetPrimAtPath("/World/Furniture").GetChildren())
    for item in room.truth.objects:
        cad = room.truth.cads[item.cad]
        placed = moved(pose_matrix(item.pose), cad.vertices)
        number = [i for i, part in enumerate(room.parts) if part.instance == item.instance]
        seen = room.points[np.unique(room.triangles[np.isin(room.part, number)])]
        assert np.allclose(placed.min(axis=0), seen.min(axis=0), atol=1e-6)
        assert np.allclose(placed.max(axis=0), seen.max(axis=0), atol=1e-6)
        used = cad.vertices[np.unique(cad.faces)]
        assert used[:, 2].min() == pytest.approx(0, abs=0.01)


def test_corridors_lie_outside_and_close_the_view(read):
    import shapely

    from benchmarks.scan.path import corridor_plan, with_corridors

    _, room = read
    layout = room.truth.rooms[0]
    outline = shapely.Polygon(room.floor)
    doors = [hole for hole in layout.openings if hole.type == "door"]
    for door in doors:
        plan = shapely.Polygon(corridor_plan(door.corners))
        assert plan.intersection(outline).area == 0
        assert plan.distance(shapely.Point(door.corners.mean(axis=0)[:2])) == pytest.approx(0.2)
    more = with_corridors(room)
    assert len(more.triangles) == len(room.triangles) + 10 * len(doors)
    assert more.truth is room.truth


def test_symmetries_of_simple_shapes():
    import trimesh

    from benchmarks.scan.rooms import symmetry_of

    shapes = {
        "inf": trimesh.creation.cylinder(0.3, 0.8, sections=96),
        "4": trimesh.creation.box((0.6, 0.6, 0.5)),
        "2": trimesh.creation.box((1.2, 0.6, 0.7)),
    }
    for name, mesh in shapes.items():
        assert symmetry_of(np.array(mesh.vertices), np.array(mesh.faces)) == name
    back = trimesh.creation.box((0.5, 0.05, 0.5)).apply_translation((0, 0.25, 0.5))
    chair = trimesh.util.concatenate([trimesh.creation.box((0.5, 0.5, 0.5)), back])
    assert symmetry_of(np.array(chair.vertices), np.array(chair.faces)) == "none"
