"""Depth pictures of an empty room, whose surfaces are known exactly, are fused."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.geometry.pinhole import look_at
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.fusion import (
    DepthFrame,
    Fused,
    FusionOptions,
    depth_noise,
    estimate_normals,
    fuse,
    towards,
    views,
    with_normals,
)
from openrooms_usd.scan.points.surfels import nearest_planes, surfels

SIZE = np.array([3.0, 2.5, 2.4])
K = np.array([[150.0, 0, 80], [0, 150.0, 60], [0, 0, 1]])
WIDTH, HEIGHT = 160, 120
SPACING, THICKNESS = 0.13, 0.18


def shot(pose: np.ndarray, noise: np.random.Generator | None) -> DepthFrame:
    """What a camera inside the box sees: depth, and the wall's axis as its label."""
    v, u = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    local = np.stack([(u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1], np.ones_like(u)], -1)
    rays, origin = local @ pose[:3, :3].T, pose[:3, 3]
    with np.errstate(divide="ignore"):
        ways = np.where(rays > 0, (SIZE - origin) / rays, -origin / rays)
    depth = ways.min(axis=-1)
    label = ways.argmin(axis=-1) + 1
    if noise is not None:
        depth = depth + depth_noise(depth) * noise.normal(size=depth.shape)
    colors = np.zeros((HEIGHT, WIDTH, 3), "u1")
    colors[..., 0] = 50 * label
    return DepthFrame(depth, K, pose, label=label, instance=label + 10, color=colors)


def shots(count: int, noisy: bool = True) -> Iterator[DepthFrame]:
    rng = np.random.default_rng(0)
    for i in range(count):
        angle = 2.0 * np.pi * i / count
        origin = np.array([1.5 + 0.4 * np.cos(angle), 1.2 + 0.3 * np.sin(angle), 1.3])
        target = origin + np.array([np.cos(3 * angle), np.sin(3 * angle), 0.8 * (-1) ** i])
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = look_at(origin, target)[:3, :3] @ np.diag([1, -1, -1]), origin
        yield shot(pose, rng if noisy else None)


@pytest.fixture(scope="module")
def fused() -> Fused:
    return fuse(shots(14))


def off(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance to the nearest wall, and its axis."""
    to = np.minimum(np.abs(points), np.abs(points - SIZE))
    return to.min(axis=1), to.argmin(axis=1)


def test_exact_depth_gives_points_on_the_walls() -> None:
    cloud = fuse(shots(6, noisy=False)).cloud
    away, _ = off(cloud.points)
    # The mean of a voxel that holds two walls lies between them.
    assert np.percentile(away, 95) < 1e-6
    assert away.max() < 0.02


def test_noise_falls_where_confidence_says_so(fused: Fused) -> None:
    away, _ = off(fused.cloud.points)
    confidence = fused.cloud.confidence
    rms = [
        np.sqrt(np.mean(away[(confidence >= low) & (confidence < high)] ** 2))
        for low, high in ((0.0, 0.3), (0.3, 0.7), (0.7, 1.0))
    ]
    assert rms[0] > 1.5 * rms[1] > 1.5 * rms[2]
    assert rms[2] < 0.005


def test_normals_look_into_the_room(fused: Fused) -> None:
    cloud = fused.cloud.take(fused.cloud.confidence > 0.5)
    _, axis = off(cloud.points)
    rows = np.arange(len(cloud))
    inward = np.where(cloud.points[rows, axis] < 0.5 * SIZE[axis], 1.0, -1.0)
    assert np.mean(inward * cloud.normals[rows, axis] > np.cos(np.radians(25))) > 0.85
    assert np.mean(inward * cloud.normals[rows, axis] > 0.0) > 0.99


def test_labels_instances_and_colours_come_along(fused: Fused) -> None:
    cloud = fused.cloud.take(fused.cloud.confidence > 0.5)
    _, axis = off(cloud.points)
    assert np.mean(cloud.label == axis + 1) > 0.98
    assert (cloud.instance == cloud.label + 10).mean() > 0.99
    assert np.mean(np.abs(cloud.colors[:, 0] - 50.0 * (axis + 1)) < 20) > 0.95


def test_drop_outs_and_lost_frames_are_passed_over() -> None:
    def broken() -> Iterator[DepthFrame]:
        for i, frame in enumerate(shots(8)):
            depth = frame.depth.copy()
            depth[::2], depth[1::4, ::3], depth[5] = 0.0, np.nan, np.inf
            pose = frame.world_from_camera if i % 4 else np.full((4, 4), -np.inf)
            yield replace(frame, depth=depth, world_from_camera=pose)

    found = fuse(broken())
    assert (found.frames, found.lost) == (6, 2)
    assert found.notes == ("2 of 8 frames have no pose: they were left out",)
    assert np.isfinite(found.cloud.points).all()
    assert len(found.cloud.sensor_origins) == 6


def test_pixels_at_the_edge_of_a_thing_do_not_fly() -> None:
    depth = np.full((HEIGHT, WIDTH), 3.0)
    depth[:, 60:100] = 1.0
    # What a sensor makes of the edge: a column between both.
    depth[:, 100] = 2.0
    cloud = fuse([DepthFrame(depth, K, np.eye(4))]).cloud
    assert set(np.round(cloud.points[:, 2], 3)) == {1.0, 3.0}


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_flying_pixel_beside_a_drop_out_goes_too(mirrored: bool) -> None:
    depth = np.full((HEIGHT, WIDTH), 1.0)
    depth[:, 100], depth[:, 101:] = 2.0, 0.0
    depth = depth[:, ::-1] if mirrored else depth
    cloud = fuse([DepthFrame(depth, K, np.eye(4))]).cloud
    assert set(np.round(cloud.points[:, 2], 3)) == {1.0}


@pytest.mark.slow
def test_voxels_that_few_frames_saw_can_be_dropped() -> None:
    all_of_them = fuse(shots(8)).cloud
    often = fuse(shots(8), FusionOptions(frames=2)).cloud
    assert 0 < len(often) < len(all_of_them)


def test_equal_frames_give_equal_bits() -> None:
    a, b = fuse(shots(3)).cloud, fuse(shots(3)).cloud
    for name in ("points", "normals", "confidence", "label", "colors"):
        assert getattr(a, name).tobytes() == getattr(b, name).tobytes()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"depth": np.zeros(5)}, "rows and columns"),
        ({"label": np.zeros((3, 3), int)}, "label picture has another size"),
        ({"world_from_camera": np.diag([1.0, 1, -1, 1])}, "not a rotation"),
        ({"world_from_camera": 2.0 * np.eye(4)}, "not a rotation"),
        ({"K": np.diag([0.0, 1.0, 1.0])}, "intrinsics"),
    ],
)
def test_nonsense_is_refused_with_its_frame(change: dict, said: str) -> None:
    good = next(shots(1))
    with pytest.raises(InputError, match=said) as caught:
        fuse([good, replace(good, **change)])
    assert caught.value.place == "frame 1"


def test_no_frames_and_black_frames_give_an_empty_cloud() -> None:
    assert len(fuse([]).cloud) == 0
    black = DepthFrame(np.zeros((4, 4)), K, np.eye(4))
    found = fuse([black])
    assert (len(found.cloud), found.frames, found.cloud.label) == (0, 1, None)


def grid(rng: np.random.Generator, spacing: float = SPACING) -> np.ndarray:
    """(N, 2) jittered points of 3 x 3 m."""
    steps = np.arange(0.0, 3.0, spacing)
    plan = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    return plan + spacing * rng.uniform(-0.2, 0.2, plan.shape)


def two_faces() -> np.ndarray:
    rng = np.random.default_rng(3)
    faces = [
        np.column_stack([place, np.full(len(place), x)])
        for x in (0.0, THICKNESS)
        for place in (grid(rng),)
    ]
    return np.concatenate(faces) + 0.003 * rng.normal(size=(2 * len(faces[0]), 3))


def test_both_faces_of_a_thin_wall_have_surfels():
    pieces = surfels(Cloud(two_faces()))
    upright = np.abs(pieces.normals[:, 2]) > np.cos(np.deg2rad(10.0))
    assert upright.mean() > 0.95
    for height in (0.0, THICKNESS):
        near = upright & (np.abs(pieces.points[:, 2] - height) < 0.02)
        # At the spacing of dense scans: 9 m2 in cells of 5 cm.
        assert near.sum() > 0.5 * 9.0 / 0.05**2


def test_a_place_at_an_edge_lies_on_one_of_its_faces():
    rng = np.random.default_rng(4)
    place = grid(rng)
    floor = np.column_stack([place, np.zeros(len(place))])
    wall = np.column_stack([place[:, 0], np.full(len(place), -0.06), place[:, 1] + 0.06])
    points = np.concatenate([floor, wall])
    found = nearest_planes(points, points)
    inner = (np.abs(points[:, 0] - 1.5) < 1.2) & (points[:, 1:] < 2.7).all(axis=1)
    along = np.abs(found.normals[:, 1:]).max(axis=1)
    assert (along[inner] > np.cos(np.deg2rad(10.0))).mean() > 0.97


def test_stray_points_are_no_surfaces():
    points = np.random.default_rng(5).uniform(-1.0, 1.0, (4000, 3))
    assert nearest_planes(points, points).flat.mean() < 0.15
    assert nearest_planes(two_faces(), two_faces()).flat.mean() > 0.9


def test_too_few_points_give_no_plane():
    points = np.zeros((3, 3)) + np.eye(3)
    assert not nearest_planes(points, points).flat.any()


def sphere(count: int, offset: float = 0.0) -> np.ndarray:
    rng = np.random.default_rng(0)
    points = rng.normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True) + offset


@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_a_sphere_seen_from_its_middle(offset: float) -> None:
    points = sphere(20_000, offset)
    cloud = with_normals(Cloud(points, sensor_origins=np.full((1, 3), offset)))
    cosines = -np.einsum("ni,ni->n", cloud.normals, points - offset)
    assert np.degrees(np.arccos(cosines.clip(-1, 1))).mean() < 1.0
    assert cosines.min() > 0.97


def test_the_two_sides_of_a_wall_look_to_their_own_eyes() -> None:
    rng = np.random.default_rng(1)
    sheet = rng.uniform(0, 1, (4000, 3)) * [2.0, 0.0, 2.0]
    points = np.concatenate([sheet[:2000], sheet[2000:] + np.array([0.0, 0.3, 0.0])])
    sensor_origins = np.array([[1.0, -1.0, 1.0], [1.0, 1.3, 1.0]])
    normals = with_normals(Cloud(points, sensor_origins=sensor_origins)).normals
    assert (normals[:2000, 1] < -0.99).all()
    assert (normals[2000:, 1] > 0.99).all()


def test_without_eyes_walls_look_inwards() -> None:
    points = sphere(3000, 5.0)
    cloud = with_normals(Cloud(points))
    assert (np.einsum("ni,ni->n", cloud.normals, points - 5.0) < 0.0).all()


def test_given_normals_stay() -> None:
    given = np.tile(np.array([[0, 0, 1]], "f4"), (5, 1))
    cloud = Cloud(np.random.default_rng(2).random((5, 3)), normals=given)
    assert with_normals(cloud) is cloud


def test_few_points() -> None:
    for count in range(4):
        normals = estimate_normals(np.random.default_rng(3).random((count, 3)))
        assert normals.shape == (count, 3)
        assert np.linalg.norm(normals, axis=1) == pytest.approx(np.ones(count))
    assert (estimate_normals(np.zeros((20, 3))) ** 2).sum(axis=1) == pytest.approx(np.ones(20))
    assert views(np.empty((0, 3)), None).shape == (0, 3)


def test_turning_keeps_what_looks_the_right_way() -> None:
    normals = np.array([[0, 0, 1], [0, 0, 1]], "f4")
    turned = towards(normals, np.array([[0.1, 0, 1.0], [0, 5.0, -0.1]]))
    assert turned.tolist() == [[0, 0, 1], [0, 0, -1]]
