"""Paths as curves: what is smooth is kept exactly, files say where, cameras of a stage move."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, UsdGeom

from openrooms_usd.errors import InputError, OrusdError
from openrooms_usd.geometry.rotations import is_rotation
from openrooms_usd.rendering.paths.camera_path import frame_times
from openrooms_usd.rendering.paths.choosing import read_keyframes, time_range, timed_poses
from openrooms_usd.rendering.paths.spline import eased, interpolated
from tests.small import Stage

TIMES = np.array([0.0, 0.5, 2.0, 2.25, 4.0])


def test_a_parabola_comes_out_as_it_is() -> None:
    def parabola(t: np.ndarray) -> np.ndarray:
        return np.column_stack([1.0 - t, 0.5 * t**2 - t, 3.0 + 0.0 * t])

    at = np.linspace(0.0, 4.0, 41)
    np.testing.assert_allclose(interpolated(TIMES, parabola(TIMES), at), parabola(at), atol=1e-12)


def test_a_curve_meets_its_values_without_a_kink_and_stands_still_outside() -> None:
    values = np.random.default_rng(0).random((5, 2))
    np.testing.assert_allclose(interpolated(TIMES, values, TIMES), values)
    step = 1e-6
    before, after = (
        (interpolated(TIMES, values, TIMES[1:-1] + side) - values[1:-1]) / side
        for side in (-step, step)
    )
    np.testing.assert_allclose(before, after, atol=1e-4)
    np.testing.assert_array_equal(interpolated(TIMES, values, [-1.0, 9.0]), values[[0, -1]])
    np.testing.assert_array_equal(interpolated([1.0], values[:1], [0.0, 2.0]), values[[0, 0]])


def test_a_walk_begins_and_stops_gently() -> None:
    share = eased(np.array([0.0, 1e-4, 0.5, 1.0]))
    assert share[[0, 2, 3]].tolist() == [0.0, 0.5, 1.0]
    assert share[1] < 1e-7


def test_frames_come_at_a_fixed_rate() -> None:
    times = frame_times(10.0, 24)
    assert len(times) == 240
    assert times[1] == 1 / 24
    assert len(frame_times(0.001, 24)) == 1


KEYS = """
fov: 80
keys:
- {time: 1, position: [0, 0, 1.5], target: [2, 0, 1]}
- {time: 2.5, position: [1, 0.5, 1.5], target: [2, 2, 1]}
- {time: 4, position: [2, 0, 1.5], target: [2, 3, 1]}
"""


def test_a_file_says_where_the_camera_is(tmp_path: Path) -> None:
    file = tmp_path / "tour.yaml"
    file.write_text(KEYS, encoding="utf-8")
    keys = read_keyframes(file)
    assert (keys.seconds, keys.fov) == (3.0, 80.0)
    poses = keys.poses(np.array([0.0, 1.5, 3.0]))
    np.testing.assert_allclose(poses[:, :3, 3], keys.positions)
    ahead = keys.targets - keys.positions
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    np.testing.assert_allclose(poses[:, :3, 2], ahead, atol=1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("keys: []", "not describe a camera path"),
        ("frames: []", "not describe a camera path"),
        (KEYS.replace("time: 4", "time: 2"), "must increase"),
        (KEYS.replace("[2, 0, 1.5]", "[2, 0]"), "are not 3 numbers"),
        (KEYS.replace("time: 4", "time: .nan"), "number"),
        (KEYS.replace("fov: 80", "fov: 200"), "200 degrees"),
        (KEYS.replace("target: [2, 3, 1]", "aim: [2, 3, 1]"), "not a key"),
        ("{", "tour.yaml"),
    ],
)
def test_a_file_that_says_nothing_is_refused(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "tour.yaml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(OrusdError, match=message):
        read_keyframes(file)
    with pytest.raises(InputError):
        read_keyframes(tmp_path / "none.yaml")


@pytest.mark.parametrize(("up", "metres"), [("Z", 1.0), ("Y", 0.01)])
def test_a_camera_with_time_samples_moves(up: str, metres: float) -> None:
    stage = Stage(up=up, metres=metres).stage
    stage.SetTimeCodesPerSecond(10)
    rig = UsdGeom.Xform.Define(stage, "/Rig")
    camera = UsdGeom.Camera.Define(stage, "/Rig/Camera")
    assert time_range(camera.GetPrim()) is None
    move = rig.AddTranslateOp()
    for code, x in ((5, 0.0), (15, 2.0), (25, 3.0)):
        move.Set(Gf.Vec3d(x / metres, 0.0, 0.0), code)
    assert time_range(camera.GetPrim()) == (5, 25)
    poses = timed_poses(camera.GetPrim(), np.array([0.0, 0.5, 1.0, 2.0]))
    np.testing.assert_allclose(poses[:, 0, 3], [0.0, 1.0, 2.0, 3.0], atol=1e-9)
    assert all(is_rotation(pose[:3, :3]) for pose in poses)
    # Cameras of USD look along -Z: down where that is up.
    ahead = [0, 0, -1] if up == "Z" else [0, 1, 0]
    np.testing.assert_allclose(poses[0, :3, 2], ahead, atol=1e-9)
