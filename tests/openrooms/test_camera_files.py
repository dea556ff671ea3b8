"""cam.txt, intrinsic.txt and transform.dat, by the steps of the published readers."""

import pickle
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.rendering.datasets import DatasetOptions
from openrooms_usd.rendering.reading import RenderedScene
from orusd_openrooms import OpenRoomsDataset
from orusd_openrooms.cameras import pose, write_cameras
from orusd_openrooms.readers import read_cameras
from tests.openrooms.synthetic import random_pose


def loaded(path: Path) -> list[tuple[np.ndarray, np.ndarray]]:
    """rui-indoorinv-data: R with the columns right, down, forward, and t; asserts included."""
    rows = path.read_text().splitlines()
    count = int(rows[0])
    numbers = np.array([x.split(" ") for x in rows[1:]]).astype(np.float64)
    assert numbers.shape[0] == count * 3
    found = []
    for origin, lookat, up in np.split(numbers, count, axis=0):
        at = (lookat - origin) / np.linalg.norm(lookat - origin)
        assert np.abs(np.dot(at, up)) < 2e-3
        found.append((np.stack((np.cross(-up, at), -up, at), -1), origin))
    return found


def test_readers_get_the_pose_back(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    cameras = [random_pose(rng, 10) for _ in range(20)]
    write_cameras(tmp_path / "cam.txt", [pose(camera) for camera in cameras])
    for (R, t), camera in zip(loaded(tmp_path / "cam.txt"), cameras, strict=True):
        # Y is up: (x, y, z) of ours is (x, z, -y) of theirs.
        theirs = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
        np.testing.assert_allclose(R, theirs @ camera[:3, :3], atol=3e-6)
        np.testing.assert_allclose(t, theirs @ camera[:3, 3], atol=1e-6)
        assert np.linalg.det(R) > 0.99


def test_view_and_up_are_far_more_orthogonal_than_loaders_demand(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    write_cameras(tmp_path / "cam.txt", [pose(random_pose(rng, 10)) for _ in range(200)])
    found = read_cameras(tmp_path / "cam.txt")
    assert len(found) == 200
    for origin, target, up in found:
        assert abs((target - origin) @ up) < 1e-5
        assert np.linalg.norm(target - origin) == pytest.approx(1.0, abs=3e-6)
        assert np.linalg.norm(up) == pytest.approx(1.0, abs=3e-6)


def test_a_camera_that_looks_along_y_with_z_up(tmp_path: Path) -> None:
    camera = np.eye(4)
    camera[:3, :3] = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # right, down, forward: x, -z, y
    camera[:3, 3] = [1, 2, 1.5]
    write_cameras(tmp_path / "cam.txt", [pose(camera)])
    assert (tmp_path / "cam.txt").read_text() == (
        "1\n1.000000 1.500000 -2.000000\n1.000000 1.500000 -3.000000\n0.000000 1.000000 0.000000\n"
    )


def test_a_point_falls_on_the_pixel_that_shows_it(render: RenderedScene, tmp_path: Path) -> None:
    """By their files alone: pose, intrinsics and depth put the floor at the height 0."""
    OpenRoomsDataset().write([render], tmp_path, DatasetOptions(layout="merged"))
    folder = tmp_path / "scenes/xml/scene0000_00"
    K = np.loadtxt(folder / "intrinsic.txt").astype(np.float32)
    assert K.shape == (3, 3) and K[0][2] == 64 / 2 and K[1][2] == 48 / 2
    np.testing.assert_array_equal(
        K, np.loadtxt(tmp_path / "main_xml/scene0000_00/intrinsic.txt").astype(np.float32)
    )
    for number, (R, t) in enumerate(loaded(folder / "cam.txt"), start=1):
        data = (tmp_path / f"main_xml/scene0000_00/imdepth_{number}.dat").read_bytes()
        depth = np.frombuffer(data, "<f4", offset=8).reshape(48, 64)
        x, y = np.meshgrid(np.arange(64) + 0.5, np.arange(48) + 0.5)
        rays = np.stack([(x - K[0, 2]) / K[0, 0], (y - K[1, 2]) / K[1, 1], np.ones_like(x)], -1)
        points = (rays * depth[..., None]) @ R.T + t
        labels = np.load(tmp_path / f"main_xml/scene0000_00/imsemLabel_{number}.npy")
        assert np.abs(points[labels == 44][:, 1]).max() < 1e-4  # up is y
        assert np.abs(points[labels == 43][:, 2] + 4.0).max() < 1e-4  # the wall y = 4 is z = -4


def test_transforms_take_a_point_into_their_world(render: RenderedScene, tmp_path: Path) -> None:
    OpenRoomsDataset().write([render], tmp_path, DatasetOptions())
    folder = tmp_path / "scenes/xml/scene0000_00"
    transforms = pickle.loads((folder / "transform.dat").read_bytes())
    point = np.array([1.0, 2.0, 3.0])
    (scale, turn, move) = transforms[0]
    assert (scale[0], turn[0], move[0]) == ("s", "rot", "t")
    assert scale[1].reshape((3, 1)).shape == move[1].reshape((3, 1)).shape
    np.testing.assert_allclose(turn[1] @ (scale[1] * point) + move[1], [1.0, 3.0, -2.0])


@pytest.mark.parametrize(
    "text", ["", "x\n", "1\n0 0 0\n0 0 1\n", "1\n0 0 0\n0 0 1\n0 1 a\n", "2\n0 0 0\n0 0 1\n0 1 0\n"]
)
def test_damaged_lists_of_cameras_are_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "cam.txt").write_text(text)
    with pytest.raises(InputError, match="not a list of cameras"):
        read_cameras(tmp_path / "cam.txt")
