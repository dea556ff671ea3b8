"""Photographs of lenses made straight, put into metres with Z up, and kept in their folder."""

from dataclasses import replace
from math import atan, hypot
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from openrooms_usd.appearance.photographs import (
    PosedPhotographs,
    metric,
    read_posed,
    seen,
    undistorted,
)
from openrooms_usd.capture import CapturedFrame
from openrooms_usd.errors import InputError

K = np.array([[210.0, 0.0, 163.2], [0.0, 214.0, 117.4], [0.0, 0.0, 1.0]])
SIZE = (320, 240)
LENSES = {
    "four": ((-0.21, 0.05, 0.004, -0.003), False),
    "five": ((0.26, -0.9, -0.005, 0.003, 1.1), False),
    "eight": ((0.6, -0.1, 0.001, 0.0008, 0.02, 0.9, -0.2, 0.06), False),
    "fisheye": ((-0.04, 0.012, -0.006, 0.001), True),
}


def frame(lens: str | None = None, pose: np.ndarray | None = None) -> CapturedFrame:
    distortion, fisheye = LENSES[lens] if lens else ((), False)
    world_from_camera = np.eye(4) if pose is None else pose
    return CapturedFrame("1", world_from_camera, K, SIZE, "1.jpg", distortion, fisheye)


def shown_at(point: np.ndarray, lens: str) -> tuple[float, float]:
    """The pixel that shows a point of the camera's frame, as OpenCV's documentation writes it."""
    x, y = point[0] / point[2], point[1] / point[2]
    (k1, k2, p1, p2, k3, k4, k5, k6), fisheye = (*LENSES[lens][0], 0, 0, 0, 0)[:8], LENSES[lens][1]
    r = hypot(x, y)
    if fisheye:
        k1, k2, k3, k4 = LENSES[lens][0]
        t = atan(r)
        bent = t * (1 + k1 * t**2 + k2 * t**4 + k3 * t**6 + k4 * t**8)
        x, y = x * bent / r, y * bent / r
    else:
        radial = (1 + k1 * r**2 + k2 * r**4 + k3 * r**6) / (1 + k4 * r**2 + k5 * r**4 + k6 * r**6)
        x, y = (
            x * radial + 2 * p1 * x * y + p2 * (r**2 + 2 * x**2),
            y * radial + p1 * (r**2 + 2 * y**2) + 2 * p2 * x * y,
        )
    return K[0, 0] * x + K[0, 2], K[1, 1] * y + K[1, 2]


def spots(pixels: list[tuple[float, float]]) -> np.ndarray:
    """(H, W) a picture with soft spots, whose middles are at these pixels."""
    v, u = np.mgrid[: SIZE[1], : SIZE[0]] + 0.5
    return sum(np.exp(-((u - x) ** 2 + (v - y) ** 2) / (2 * 1.8**2)) for x, y in pixels)


@pytest.mark.parametrize("lens", LENSES)
def test_known_points_are_where_a_pinhole_shows_them(lens: str) -> None:
    grid = [(x, y) for x in (-0.5, -0.2, 0.13, 0.42) for y in (-0.36, 0.05, 0.33)]
    points = [np.array([x * z, y * z, z]) for (x, y), z in zip(grid, range(1, 13), strict=True)]
    picture = spots([shown_at(point, lens) for point in points])
    straight, camera = undistorted(picture, frame(lens))
    assert camera.distortion == ()
    assert not camera.fisheye
    v, u = np.mgrid[: SIZE[1], : SIZE[0]] + 0.5
    moved = []
    for point in points:
        meant = (K @ point / point[2])[:2]
        near = straight * (np.hypot(u - meant[0], v - meant[1]) < 8.0)
        found = np.array([(near * u).sum(), (near * v).sum()]) / near.sum()
        moved.append(np.hypot(*(np.array(shown_at(point, lens)) - meant)))
        assert found == pytest.approx(meant, abs=0.1)
    # The test would say nothing of a lens that bends by less.
    assert max(moved) > 3.0


def test_pixels_keep_their_type_and_shape_and_depth_is_not_blended() -> None:
    depth = np.where(np.arange(SIZE[0]) < 160, 1000, 3000).astype(np.uint16)
    depth = np.tile(depth, (SIZE[1], 1))
    straight, _ = undistorted(depth, frame("four"), blend=False)
    assert straight.dtype == np.uint16
    assert set(np.unique(straight)) <= {0, 1000, 3000}
    colour = np.full((SIZE[1], SIZE[0], 3), 77, np.uint8)
    even, camera = undistorted(colour, frame("five"))
    assert even.dtype == np.uint8
    assert (even[seen(frame("five"))] == 77).all()
    assert undistorted(colour, camera)[0] is colour


def test_what_the_photograph_does_not_show_is_marked() -> None:
    spread = replace(frame(), distortion=(0.3, 0.0, 0.0, 0.0))
    mask = seen(spread)
    v, u = np.mgrid[: SIZE[1], : SIZE[0]] + 0.5
    x, y = (u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1]
    bent = 1.0 + 0.3 * (x * x + y * y)
    at = K[0, 0] * x * bent + K[0, 2], K[1, 1] * y * bent + K[1, 2]
    inside = (at[0] >= 0) & (at[0] <= SIZE[0]) & (at[1] >= 0) & (at[1] <= SIZE[1])
    assert (mask == inside).all()
    assert 0.7 < mask.mean() < 0.99
    white, _ = undistorted(np.ones((SIZE[1], SIZE[0])), spread)
    assert ((white > 0) == mask).all()
    assert seen(frame()).all()


def test_a_lens_that_folds_the_picture_shows_nothing_beyond_the_fold() -> None:
    # r - 0.9 r^3 turns back at r = 0.609.
    mask = seen(replace(frame(), distortion=(-0.9, 0.0, 0.0, 0.0)))
    v, u = np.mgrid[: SIZE[1], : SIZE[0]] + 0.5
    r = np.hypot((u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1])
    assert mask[r < 0.60].all()
    assert not mask[r > 0.62].any()


def test_other_sizes_and_lenses_are_refused() -> None:
    with pytest.raises(InputError, match="100 x 50 pixels, its camera 320 x 240"):
        undistorted(np.zeros((50, 100)), frame("four"))
    with pytest.raises(InputError, match="4 or 5 or 8 coefficients, not 3"):
        seen(replace(frame(), distortion=(0.1, 0.1, 0.1)))


def posed(frames: tuple[CapturedFrame, ...], known: bool = False) -> PosedPhotographs:
    return PosedPhotographs(frames, Path(), "colmap", known, known)


def walk() -> list[np.ndarray]:
    """Upright cameras that look around and up and down, Z up."""
    found = []
    for i in range(12):
        M = np.eye(4)
        level = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
        tilt = Rotation.from_euler("x", 25 * np.sin(2.1 * i), degrees=True).as_matrix()
        M[:3, :3] = Rotation.from_euler("z", 31 * i, degrees=True).as_matrix() @ level @ tilt
        M[:3, 3] = [0.2 * i, 0.1 * i * i, 1.5]
        found.append(M)
    return found


def test_a_model_without_scale_or_vertical_is_asked_for_them() -> None:
    model = posed((frame(),))
    with pytest.raises(InputError, match="--scale"):
        metric(model, up="z")
    with pytest.raises(InputError, match="--up"):
        metric(model, scale=0.1)
    for bad in ("q", "1,2", "0,0,0", "nan,0,1", "--x"):
        with pytest.raises(InputError, match="is not a direction"):
            metric(model, scale=0.1, up=bad)
    for bad in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(InputError, match="make no sense"):
            metric(model, scale=bad, up="z")
    known = metric(posed((frame(),), known=True))
    assert known.frames[0].world_from_camera == pytest.approx(np.eye(4))
    assert known.notes == ()


@pytest.mark.parametrize("up", ["-y", "0,-2,0", "cameras"])
def test_scale_and_vertical_are_taken(up: str) -> None:
    # The world of the model: a fifth of the size, and Y down.
    turn = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    frames = []
    for pose in walk():
        M = np.eye(4)
        M[:3, :3], M[:3, 3] = turn @ pose[:3, :3], turn @ pose[:3, 3] / 5.0
        frames.append(frame(pose=M))
    found = metric(posed(tuple(frames)), scale=5.0, up=up)
    assert found.scale_known
    assert found.up_known
    assert len(found.notes) == 2
    for one, pose in zip(found.frames, walk(), strict=True):
        # The heading stays free; heights, tilts and distances do not.
        assert one.world_from_camera[2] == pytest.approx(pose[2], abs=1e-4)
    places = [np.array([p[:3, 3] for p in poses]) for poses in (
        [one.world_from_camera for one in found.frames], walk())]  # fmt: skip
    lengths = [np.linalg.norm(p[:, None] - p[None], axis=-1) for p in places]
    assert lengths[0] == pytest.approx(lengths[1])
    assert found.frames[0].depth_unit == pytest.approx(0.005)


@pytest.mark.parametrize("name", ["../secret.jpg", "/etc/hostname", "link.jpg", "a\0b", "x" * 400])
def test_a_picture_is_never_outside_of_its_folder(tmp_path: Path, name: str) -> None:
    (tmp_path / "secret.jpg").write_bytes(b"x")
    folder = tmp_path / "in"
    folder.mkdir()
    (folder / "link.jpg").symlink_to(tmp_path / "secret.jpg")
    (folder / "own.jpg").write_bytes(b"x")
    found = PosedPhotographs((), folder, "frames", True, True)
    assert found.file(replace(frame(), picture=name)) is None
    assert found.depth_file(replace(frame(), depth=name)) is None
    assert found.file(replace(frame(), picture="own.jpg")) == folder / "own.jpg"
    assert found.file(replace(frame(), picture=None)) is None


def test_what_is_not_known_names_the_forms(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_posed(tmp_path / "nothing")
    with pytest.raises(InputError) as caught:
        read_posed(tmp_path)
    for word in ("COLMAP", "transforms.json", "7-Scenes", "TUM", "Redwood", "ScanNet", "frames"):
        assert word in caught.value.remedy
    with pytest.raises(InputError, match="did you mean 'colmap'"):
        read_posed(tmp_path, "kolmap")
