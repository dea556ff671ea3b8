"""Photographs and rooms: planted motions are found, others' photographs are refused."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom, Vt

from openrooms_usd.appearance.lines import distances, drawing, geometry_lines
from openrooms_usd.appearance.motions import motion, motion_size
from openrooms_usd.appearance.registration import Registration, register, register_stage
from openrooms_usd.appearance.views import Photograph, geometry_of
from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from tests.appearance.box_rooms import (
    FURNITURE,
    ROOM,
    SIZE,
    Box,
    K,
    box_room,
    cameras,
    noisy,
    photographs,
)

# 40 cm and 9 degrees about the vertical.
PLANTED = motion([0.3, -0.25, 0.08, 0.0, 0.0, np.radians(-9.0)], np.array([2.2, 1.8, 1.4]))

# Lines take some ten times as long.
EVIDENCE = pytest.mark.parametrize("depth", [True, pytest.param(False, marks=pytest.mark.slow)])


def placed(taken: Sequence[Photograph], poses: Sequence[Array]) -> list[Photograph]:
    return [replace(one, world_from_camera=at) for one, at in zip(taken, poses, strict=True)]


def errors(poses: Sequence[Array], truth: Sequence[Array]) -> Array:
    """(F, 2) metres and degrees."""
    pairs = zip(poses, truth, strict=True)
    return np.array([motion_size(a @ np.linalg.inv(b), b[:3, 3]) for a, b in pairs])


def registered(truth: Sequence[Array], said: Sequence[Array], *, depth: bool) -> Registration:
    room = box_room()
    return register(placed(photographs(room, truth, depth=depth), said), room)


@pytest.mark.parametrize(
    ("depth", "metres", "degrees"),
    [(True, 0.01, 0.2), pytest.param(False, 0.03, 0.6, marks=pytest.mark.slow)],
)
def test_a_planted_motion_is_found(depth: bool, metres: float, degrees: float) -> None:
    truth = cameras(6)
    said = [PLANTED @ one for one in truth]
    found = registered(truth, said, depth=depth)
    assert found.verdict == "moved"
    assert re.search(r"is (39|40|41) cm and (8.9|9.0|9.1) degrees off", found.sentence)
    off = errors([found.correction @ one for one in said], truth)
    assert off[:, 0].max() < metres
    assert off[:, 1].max() < degrees
    for frame in found.frames:
        assert frame.before is not None and frame.after is not None
        assert frame.after < 0.2 * frame.before


@EVIDENCE
def test_noise_of_poses_is_taken_away_from_each_photograph(depth: bool) -> None:
    truth = cameras(6)
    said = noisy(truth)
    found = registered(truth, said, depth=depth)
    assert found.verdict == "fits"
    assert np.array_equal(found.correction, np.eye(4))
    taken = placed(photographs(box_room(), truth, depth=False), said)
    off = errors(found.poses(taken), truth).mean(axis=0)
    assert off[0] < 0.014 and off[1] < 0.35


@EVIDENCE
def test_true_poses_stay(depth: bool) -> None:
    truth = cameras(5)
    found = registered(truth, truth, depth=depth)
    assert found.verdict == "fits"
    off = errors([f.correction @ one for f, one in zip(found.frames, truth, strict=True)], truth)
    assert off[:, 0].max() < 0.006 and off[:, 1].max() < 0.15


def test_a_square_room_is_not_turned_by_a_quarter() -> None:
    square: Box = ((0.0, 0.0, 0.0), (4.0, 4.0, 2.5))
    room = box_room(square, [((0.0, 1.6, 0.0), (0.6, 2.4, 1.0))])
    truth = cameras(6, square)
    off = motion([-0.4, 0.45, 0.0, 0.0, 0.0, np.radians(15.0)], np.array([2.0, 2.0, 1.4]))
    said = [off @ one for one in truth]
    found = register(placed(photographs(room, truth, depth=True), said), room)
    assert found.verdict == "moved"
    assert errors([found.correction @ one for one in said], truth)[:, 0].max() < 0.01


@EVIDENCE
def test_photographs_of_another_room_are_refused(depth: bool) -> None:
    hall: Box = ((0.0, 0.0, 0.0), (7.5, 1.9, 3.4))
    truth = cameras(6)
    other = box_room(hall, [((2.0, 0.0, 0.0), (2.4, 0.9, 1.5)), ((4.0, 1.3, 0.0), (6.0, 1.9, 0.9))])
    eyes = [motion([1.5, -0.9, 0.2, 0, 0, 0], np.zeros(3)) @ one for one in truth]
    eyes = [at for at in eyes if 0.2 < at[1, 3] < 1.7]
    taken = placed(photographs(other, eyes, depth=depth), truth[: len(eyes)])
    found = register(taken, box_room())
    assert found.verdict == "refused"
    assert "not of this room" in found.sentence
    assert all(
        np.array_equal(at, one.world_from_camera)
        for at, one in zip(found.poses(taken), taken, strict=True)
    )


def test_the_same_again_is_the_same() -> None:
    truth = cameras(4)
    said = noisy(truth)
    one, two = (registered(truth, said, depth=True) for _ in range(2))
    assert all(
        np.array_equal(a.correction, b.correction)
        for a, b in zip(one.frames, two.frames, strict=True)
    )


def test_no_photograph_and_no_pose_are_errors() -> None:
    with pytest.raises(InputError, match="no photographs"):
        register([], box_room())
    taken = photographs(box_room(), cameras(1), depth=True)
    with pytest.raises(InputError, match="not finite"):
        register(placed(taken, [np.full((4, 4), np.nan)]), box_room())


def shell() -> tuple[Array, Array]:
    """The walls of the room as quads."""
    corners = np.array([[x, y, z] for x in (0, 4.4) for y in (0, 3.6) for z in (0, 2.5)])
    quads = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
    return corners, np.array(quads)


def test_a_stage_is_asked_for_its_surfaces(tmp_path: Path) -> None:
    corners, quads = shell()
    stage = Usd.Stage.CreateNew(str(tmp_path / "room.usda"))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    mesh = UsdGeom.Mesh.Define(stage, "/Room")
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(corners.astype(np.float32)))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateFaceVertexCountsAttr([4] * len(quads))
    mesh.CreateFaceVertexIndicesAttr(quads.ravel().tolist())
    stage.Save()
    taken = photographs(box_room(ROOM, []), cameras(4), depth=True)
    found = register_stage(tmp_path / "room.usda", taken)
    assert found.verdict == "fits"
    assert max(frame.after or 0.0 for frame in found.frames) < 0.001


def test_triangles_are_seen_as_the_closed_form_says() -> None:
    corners, quads = shell()
    triangles = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    cast, closed = geometry_of(corners, triangles), box_room(ROOM, [])
    for at in cameras(3):
        ours, theirs = cast(K, at, SIZE), closed(K, at, SIZE)
        assert np.allclose(ours.depth, theirs.depth, atol=1e-5)
        same = (np.abs(ours.normal - theirs.normal) < 1e-6).all(axis=-1)
        assert same.mean() > 0.999


def test_lines_of_geometry_are_on_the_lines_of_its_photograph() -> None:
    room = box_room(ROOM, FURNITURE)
    for one in photographs(room, cameras(3), depth=False):
        lines = geometry_lines(room, one.K, one.world_from_camera, SIZE)
        off = distances(
            drawing(one.pixels, one.K, one.world_from_camera), lines, one.world_from_camera
        )
        assert len(off) > 200
        assert np.quantile(off, 0.75) <= 1.5
