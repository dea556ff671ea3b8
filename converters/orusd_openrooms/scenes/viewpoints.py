"""A scene's cameras and the way of its layout: ``cam.txt`` and ``transform.dat``."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.capture import CapturedFrame
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.rotations import inverse, nearest_rotation, pose
from openrooms_usd.unpickling import read_pickled
from orusd_openrooms.readers import read_cameras
from orusd_openrooms.scenes.records import SceneFile, Step, whole

Array = NDArray[np.float64]

# A scene of the release has about twenty.
_MOST_CAMERAS: Final = 10_000
_USUAL_FOV: Final = 57.95
# Three decimals in the files; beyond this something else is wrong.
_CROOKED: Final = 0.02
_SAME: Final = 1e-3
_FARTHEST: Final = 1e6
_KINDS: Final = ("s", "rot", "t")


def read_frames(
    path: Path | None, file: SceneFile, scene_from_world: Array
) -> tuple[CapturedFrame, ...]:
    """The cameras of a scene, counted from 1 as its pictures are.

    Args:
        path: ``cam.txt``; None where there is none.
        file: The scene: its field of view and the size of its pictures.
        scene_from_world: (4, 4) rigid.

    Raises:
        InputError: It is no list of cameras.
    """
    if path is None:
        return ()
    width, height = file.resolution
    focal = 0.5 * width / np.tan(np.radians(file.fov or _USUAL_FOV) / 2.0)
    K = np.array([[focal, 0.0, 0.5 * width], [0.0, focal, 0.5 * height], [0.0, 0.0, 1.0]])
    world_from_scene = inverse(scene_from_world)
    cameras = read_cameras(path)
    if len(cameras) > _MOST_CAMERAS:
        raise InputError(
            f"{len(cameras):,} cameras; at most {_MOST_CAMERAS:,} are read", place=path
        )
    return tuple(
        CapturedFrame(
            f"{number}",
            world_from_scene @ camera_pose(rows, f"{path}: camera {number}"),
            K,
            file.resolution,
            f"im_{number}.hdr",
        )
        for number, rows in enumerate(cameras, 1)
    )


def camera_pose(rows: Array, place: str) -> Array:
    """(4, 4) from the OpenCV camera frame to the scene.

    Args:
        rows: (3, 3) origin, target, up.
        place: For messages.

    Raises:
        InputError: The rows are no camera.
    """
    origin, target, up = rows
    view = target - origin
    length, tall = np.linalg.norm(view), np.linalg.norm(up)
    if min(length, tall) < _SAME or abs(view @ up) > _CROOKED * length * tall:
        raise InputError("its view and its up are not at right angles", place=place)
    right = np.cross(view, up)
    frame = np.stack([right / np.linalg.norm(right), -up / tall, view / length], axis=1)
    return pose(nearest_rotation(frame), origin)


def read_transforms(path: Path, layout: tuple[Step, ...] | None) -> Iterator[str]:
    """What ``transform.dat`` says otherwise than the scene: the layout's way from the scan.

    The scene file has the same steps; the pickle is only compared with it.

    Args:
        path: The file, which need not exist.
        layout: The steps of the layout's shape.

    Raises:
        InputError: It is no pickle of plain data, or holds no transforms.
    """
    if not path.is_file() or layout is None:
        return
    found = read_pickled(path)
    try:
        matrix = np.eye(4)
        for kind, value in found[0]:
            matrix = _step(kind, value) @ matrix
    except (TypeError, ValueError, IndexError, KeyError) as error:
        raise InputError(f"no transforms of a scene: {error}", place=path) from error
    off = float(np.abs(matrix - whole(layout)).max())
    if off > _SAME:
        yield f"{path.name} moves the layout by {off:.3g} m otherwise than the scene, which counts"


def _step(kind: Any, value: Any) -> Array:
    if kind not in _KINDS:
        raise ValueError(f"a step {str(kind)[:20]!r}")
    numbers = np.asarray(value, dtype=np.float64)
    if not (np.abs(numbers) < _FARTHEST).all():
        raise ValueError("a number that is none")
    if kind == "s":
        return np.diag([*numbers.reshape(3), 1.0])
    return pose(numbers.reshape(3, 3)) if kind == "rot" else pose(np.eye(3), numbers.reshape(3))
