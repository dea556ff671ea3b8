"""Real photographs and rooms, and pictures of another renderer; skipped where they are absent."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
import pytest

from openrooms_usd.appearance.motions import motion_size
from openrooms_usd.appearance.registration import register, register_stage
from openrooms_usd.appearance.views import Geometry, Photograph, Seen, Size, geometry_of
from openrooms_usd.arrays import Array
from openrooms_usd.composing import compose_room
from openrooms_usd.geometry.rotations import pose
from tests.appearance.box_rooms import box_room

# The arkit capture is Y up.
UPRIGHT = np.array(
    [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0, 0, 0, 1]]
)

Real = Callable[[str], Path]


def picture(path: Path) -> Any:
    pixels = OpenImageIO.ImageBuf(str(path))
    kind = OpenImageIO.UINT16 if path.suffix == ".png" else OpenImageIO.UINT8
    return np.asarray(pixels.get_pixels(kind))


def photographs(folder: Path, name: str) -> list[Photograph]:
    read = json.loads((folder / name).read_text())
    return [
        Photograph(
            picture(folder / frame["picture"])[..., :3],
            np.array(frame["K"]),
            np.array(frame["world_from_camera"]),
        )
        for frame in (read["frames"] if isinstance(read, dict) else read)
    ]


def textured_mesh(path: Path) -> Geometry:
    rows = [line.split() for line in path.read_text().splitlines()]
    points = np.array([row[1:4] for row in rows if row and row[0] == "v"], dtype=np.float64)
    corners = [[c.split("/")[0] for c in row[1:4]] for row in rows if row and row[0] == "f"]
    return geometry_of(points, np.array(corners, dtype=np.int64) - 1)


def mean_error(poses: list[Array], truth: list[Photograph]) -> Array:
    """(2,) metres and degrees."""
    pairs = [(a, b.world_from_camera) for a, b in zip(poses, truth, strict=True)]
    off = [motion_size(a @ np.linalg.inv(b), b[:3, 3]) for a, b in pairs]
    return np.asarray(np.mean(off, axis=0))


@pytest.mark.slow
def test_a_phone_that_moved_its_world_is_noticed(real: Real) -> None:
    folder = real("real_dev/data/arkit_lounge")
    mesh = textured_mesh(folder / "textured.obj")

    def upright(K: Array, at: Array, size: Size) -> Seen:
        seen = mesh(K, np.linalg.inv(UPRIGHT) @ at, size)
        return seen._replace(normal=seen.normal @ UPRIGHT[:3, :3].T)

    taken, truth = (
        [
            Photograph(one.pixels, one.K, UPRIGHT @ one.world_from_camera)
            for one in photographs(folder, name)
        ]
        for name in ("frames_as_recorded.json", "frames.json")
    )
    found = register(taken, upright)
    assert found.verdict == "moved"
    # What is called true here was measured to 4 cm.
    assert mean_error([found.correction @ one.world_from_camera for one in taken], truth)[0] < 0.06
    assert mean_error(found.poses(taken), truth)[0] < 0.06


@pytest.mark.slow
@pytest.mark.parametrize("name", ["room_3_glossy", "room_7_degenerate"])
def test_noise_of_poses_is_taken_away_by_lines(name: str, real: Real, tmp_path: Path) -> None:
    folder = real("photographs/simulated/dev") / name
    compose_room(folder / "room.yaml", tmp_path)
    taken = photographs(folder, "frames_noisy.json")
    found = register_stage(tmp_path / "scene.usda", taken)
    assert found.verdict == "fits"
    error = mean_error(found.poses(taken), photographs(folder, "frames.json"))
    assert error[0] < 0.015 and error[1] < 0.3


def test_a_kitchen_is_not_this_room(real: Real) -> None:
    folder = real("photographs/sevenscenes_kitchen")
    K = np.loadtxt(folder / "camera-intrinsics.txt")[:3, :3]
    taken = []
    for color in sorted(folder.glob("*.color.jpg"))[::8]:
        depth = picture(folder / color.name.replace("color.jpg", "depth.png"))[..., 0]
        at = np.loadtxt(folder / color.name.replace("color.jpg", "pose.txt"))
        metres = np.where(depth == 65535, 0, depth) / 1000.0
        taken.append(Photograph(picture(color)[..., :3], K, at, metres))
    # Its Y is about down; the cameras go to the middle of the room.
    middle = np.mean([one.world_from_camera[:3, 3] for one in taken], axis=0)
    upright = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    placed = pose(upright, np.array([2.2, 1.8, 1.4]) - upright @ middle)
    moved = [Photograph(p.pixels, K, placed @ p.world_from_camera, p.depth) for p in taken]
    assert register(moved, box_room()).verdict == "refused"
