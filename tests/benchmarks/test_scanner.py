"""The scanner's errors are the ones that it declares, and without them it sees the room."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("embreex")

PERFECT = {"noise": 0.0, "wrong_labels": 0.0, "frames": 12, "reduce": 8, "voxel": 0.02, "fewest": 1}


@pytest.fixture(scope="module")
def room():
    """A box of 4 x 3 x 2.5 m with a cube (instance 1) in it and a mirror and a pane on walls."""
    import trimesh

    from benchmarks.scan.rooms import GLASS, MIRROR, Part, SimulatedRoom
    from benchmarks.scan.truth import Truth
    from openrooms_usd.scan.results import FoundRoom

    def box(low, high):
        return trimesh.creation.box(bounds=[low, high])

    shell = box((0, 0, 0), (4, 3, 2.5))
    up = shell.face_normals[:, 2]
    labels = np.select([up < -0.5, up > 0.5], [2, 22], 1)
    pieces = [
        (shell, labels, 0, 0),
        (box((1.5, 1, 0), (2.1, 1.6, 0.6)), 3, 1, 0),
        (box((3.97, 1, 1), (3.98, 2, 2)), 9, 2, GLASS),
        (box((0.02, 1, 1), (0.03, 2, 2)), 38, 3, MIRROR),
    ]
    points, triangles, rows, parts, offset = [], [], [], [], 0
    for mesh, kinds, instance, optics in pieces:
        points.append(mesh.vertices)
        triangles.append(mesh.faces + offset)
        offset += len(mesh.vertices)
        for label in np.broadcast_to(kinds, len(mesh.faces)).tolist():
            part = Part(label, instance, optics)
            if part not in parts:
                parts.append(part)
            rows.append(parts.index(part))
    corners = np.array([[0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0.0]])
    truth = Truth((FoundRoom(np.array([0, 0, 1.0]), corners[0], corners, ceiling=2.5),), (), {})
    return SimulatedRoom(
        np.concatenate(points), np.concatenate(triangles), np.array(rows), tuple(parts), truth
    )


def distance_to_surface(room, points):
    import trimesh

    mesh = trimesh.Trimesh(room.points, room.triangles, process=False)
    return np.abs(trimesh.proximity.closest_point_naive(mesh, points)[1])


def without_mirrors(room):
    return replace(room, parts=tuple(part._replace(optics=0) for part in room.parts))


@pytest.mark.slow
def test_without_errors_every_point_lies_on_the_room(room):
    from benchmarks.scan.scanner import Scanner, simulate

    cloud = simulate(without_mirrors(room), 1, Scanner(**PERFECT)).cloud
    away = distance_to_surface(room, cloud.points[::20])
    # The mean of a cell that an edge crosses lies off both of its sides, within the cell.
    assert away.max() < 0.02 and np.median(away) < 1e-6
    assert len(cloud) > 5000
    assert np.ptp(cloud.points, axis=0) == pytest.approx([4, 3, 2.5], abs=0.02)


def test_labels_and_normals_without_errors_are_those_of_the_room(room):
    from benchmarks.scan.scanner import Scanner, simulate

    cloud = simulate(without_mirrors(room), 1, Scanner(**PERFECT)).cloud
    floor = (cloud.points[:, 2] < 0.001) & (np.abs(cloud.points[:, :2] - (1.8, 1.3)).max(1) > 0.5)
    floor &= (cloud.points[:, :2].min(1) > 0.2) & (cloud.points[:, 0] < 3.8)
    floor &= cloud.points[:, 1] < 2.8
    assert floor.sum() > 500
    assert (cloud.label[floor] == 2).all() and (cloud.instance[floor] == 0).all()
    assert np.allclose(cloud.normals[floor], (0, 0, 1), atol=1e-3)
    cube = cloud.instance == 1
    assert (np.abs(cloud.points[cube] - (1.8, 1.3, 0.3)).max(1) < 0.3201).all()
    assert (cloud.label[cube] == 3).all()


def test_depth_noise_follows_the_formula():
    from benchmarks.scan.depth import noisy

    for z in (0.8, 2.0, 4.5):
        depth = noisy(np.full(200_000, z), 1.0, np.random.default_rng(1))
        sigma, step = 0.0012 + 0.0019 * (z - 0.4) ** 2, 0.0014 * z**2
        # Rounding to steps adds a twelfth of their square.
        assert depth.std() == pytest.approx(np.hypot(sigma, step / np.sqrt(12)), rel=0.02)
        assert depth.mean() == pytest.approx(z, abs=0.1 * sigma)
        levels = np.unique(depth)
        middle = levels[np.abs(levels - z) < 2.5 * step]
        assert np.diff(middle) == pytest.approx(step, rel=0.1)


def test_glass_gives_hardly_any_return_and_a_mirror_the_room_in_it(room):
    from benchmarks.scan.depth import GLINT, Scanner, returns, take
    from openrooms_usd.geometry.pinhole import look_at
    from openrooms_usd.geometry.raycast import RayCaster

    caster = RayCaster(room.points, room.triangles)
    how, random = Scanner(noise=0.0, reduce=8), np.random.default_rng(2)
    glass = take(room, caster, look_at((2, 2.0, 1.5), (4, 1.6, 1.5)), how, random)
    pane = glass.part[25:35, 35:45]
    assert (pane >= 0).mean() == pytest.approx(GLINT, abs=0.09)
    camera = look_at((1.0, 0.6, 1.4), (0, 1.5, 1.5))
    mirror = take(room, caster, camera, how, random)
    points, part, _ = returns(mirror, camera)
    behind = points[part == [p.instance for p in room.parts].index(3)]
    assert len(behind) > 500 and behind[:, 0].max() < 0.03
    # Turned round at the mirror's face, they lie on the room; a few met its narrow sides.
    behind[:, 0] = 0.06 - behind[:, 0]
    assert np.quantile(distance_to_surface(room, behind[::10]), 0.95) < 1e-3


@pytest.mark.parametrize("blind", [0.01, 0.1])
def test_missing_walls_and_ceilings_are_not_seen(room, blind):
    from benchmarks.scan.scanner import Scanner, simulate

    how = Scanner(missing_walls=1, blind=blind, ceiling=False, **PERFECT)
    scan = simulate(room, 3, how)
    (wall,) = scan.truth.rooms[0].guessed
    a, b = room.floor[wall], room.floor[(wall + 1) % 4]
    outward = np.array([(b - a)[1], -(b - a)[0]]) / np.linalg.norm(b - a)
    away = (scan.cloud.points[:, :2] - a) @ outward
    along = (scan.cloud.points[:, :2] - a) @ (b - a) / np.linalg.norm(b - a)
    between = (along > 0.05) & (along < np.linalg.norm(b - a) - 0.05)
    assert not (between & (away > 0.005 - blind)).any()
    assert (between & (away < -0.02 - blind) & (away > -0.1 - blind)).any()
    assert scan.cloud.points[:, 2].max() < 2.27
    assert scan.truth.rooms[0].ceiling is None


@pytest.mark.one_in(4)
@pytest.mark.parametrize("wrong", [0.05, 0.10])
def test_as_many_labels_are_wrong_as_asked_for(room, wrong):
    from benchmarks.scan.scanner import Scanner, simulate

    how = Scanner(**{**PERFECT, "wrong_labels": wrong})
    bad = simulate(room, 4, how).cloud
    good = simulate(room, 4, Scanner(**PERFECT)).cloud
    assert (bad.points == good.points).all()
    differs = (bad.label != good.label) | (bad.instance != good.instance)
    assert wrong <= differs.mean() < wrong + 0.02
    # In blobs: what is wrong has neighbours that are wrong.
    from scipy.spatial import cKDTree

    near = cKDTree(bad.points).query(bad.points[differs], k=5)[1][:, 1:]
    assert differs[near].mean() > 0.5


def test_drift_is_as_large_as_declared_and_has_no_mean(room):
    from benchmarks.scan.scanner import Scanner, drifted

    poses = np.broadcast_to(np.eye(4), (60, 4, 4)).copy()
    poses[:, 0, 3] = np.linspace(0, 10, 60)
    how = Scanner(drift=0.08, drift_degrees=0.8)
    moved = drifted(poses, how, np.random.default_rng(5))
    places = moved[:, :3, 3] - poses[:, :3, 3]
    assert np.linalg.norm(places, axis=1).max() == pytest.approx(0.08)
    assert np.abs(places.mean(axis=0)).max() < 1e-12
    cosine = (np.trace(moved[:, :3, :3], axis1=1, axis2=2) - 1) / 2
    assert np.degrees(np.arccos(cosine.min())) == pytest.approx(0.8)
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).max() < 0.03
    poses[:, 0, 3] /= 5  # a way of 2 m: a quarter
    shorter = drifted(poses, how, np.random.default_rng(5))[:, :3, 3] - poses[:, :3, 3]
    assert np.linalg.norm(shorter, axis=1).max() == pytest.approx(0.02)


def test_the_camera_is_held_in_free_space(room):
    from benchmarks.scan.path import walk
    from openrooms_usd.geometry.raycast import RayCaster

    poses = walk(room, RayCaster(room.points, room.triangles), 50, np.random.default_rng(6))
    sensor_origins = poses[:, :3, 3]
    assert (sensor_origins[:, 2] >= 1.4).all() and (sensor_origins[:, 2] <= 1.7).all()
    assert (sensor_origins[:, :2] > 0.15).all() and (
        sensor_origins[:, :2] < np.array([4, 3]) - 0.15
    ).all()
    assert not (np.abs(sensor_origins[:, :2] - (1.8, 1.3)).max(axis=1) < 0.3).any()


def test_equal_seeds_give_equal_scans(room):
    from benchmarks.scan.scanner import Scanner, simulate

    how = Scanner(frames=6, reduce=16, drift=0.05)
    a, b, c = (simulate(room, seed, how, keep_frames=True) for seed in (7, 7, 8))
    assert (a.cloud.points == b.cloud.points).all() and (a.cloud.label == b.cloud.label).all()
    assert len(a.cloud) != len(c.cloud) or (a.cloud.points != c.cloud.points).any()
    assert (a.frames[3].depth == b.frames[3].depth).all()
