"""Which path is meant: ``walk``, a camera of the stage that moves, or a file with keys."""

from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.geometry.pinhole import intrinsics
from openrooms_usd.rendering.context import RenderContext
from openrooms_usd.rendering.paths.camera_path import CameraPath, frame_times
from openrooms_usd.rendering.paths.keyframes import SUFFIXES, read_keyframes
from openrooms_usd.rendering.paths.timed import time_range, timed_poses
from openrooms_usd.rendering.paths.walk import check_passable, walk
from openrooms_usd.rendering.plan import choose_cameras
from openrooms_usd.usd.cameras import PINHOLE, PinholeCamera, framing_camera, read_camera

WALK: Final = "walk"
WALK_SECONDS: Final = 10.0


def choose_path(
    spec: str, opened: RenderContext, size: tuple[int, int], seconds: float | None, rate: int
) -> CameraPath:
    """The path that is asked for.

    Args:
        spec: `WALK`, the name or path of a camera with time samples, or a file with keys.
        opened: The opened stage.
        size: Width and height of the pictures.
        seconds: How long; None for as long as the path is, and `WALK_SECONDS` for a walk.
        rate: Frames a second.

    Raises:
        InputError: Nothing is meant by it.
        RenderError: There is no room for a walk, or a path leads through something.
    """
    if spec == WALK:
        return stage_walk(opened, size, frame_times(seconds or WALK_SECONDS, rate), rate)
    if Path(spec).suffix.lower() in SUFFIXES:
        keys = read_keyframes(Path(spec))
        poses = keys.poses(frame_times(seconds or keys.seconds, rate))
        check_passable(opened.caster, poses[:, :3, 3])
        return CameraPath(Path(spec).stem, poses, intrinsics(keys.fov, *size), rate)
    stage = opened.stage
    name, path = next(iter(choose_cameras([spec], opened.cameras).items()))
    prim = stage.GetPrimAtPath(path)
    codes = time_range(prim)
    if codes is None:
        raise InputError(
            "this camera does not move",
            place=path,
            remedy=f"give its transform time samples, or take --path {WALK}",
        )
    camera = read_camera(prim, *size)
    if camera.projection != PINHOLE:
        raise InputError(
            f"an {camera.projection} camera films nothing",
            place=path,
            remedy=f"take a perspective one, or --path {WALK}",
        )
    length = (codes[1] - codes[0]) / stage.GetTimeCodesPerSecond()
    poses = timed_poses(prim, frame_times(seconds or length, rate))
    return CameraPath(name, poses, camera.K, rate, camera.exposure)


def stage_walk(
    opened: RenderContext, size: tuple[int, int], times: NDArray[np.float64], rate: int
) -> CameraPath:
    """A walk past the cameras of a stage, with the widest of their fields of view.

    Args:
        opened: The opened stage.
        size: Width and height of the pictures.
        times: (F,) seconds of the frames.
        rate: Frames a second.

    Raises:
        RenderError: There is no room for a walk.
    """
    stage = opened.stage
    prims = [stage.GetPrimAtPath(path) for path in opened.cameras]
    read = [read_camera(prim, *size) for prim in prims]
    cameras = [camera for camera in read if camera.projection == PINHOLE]
    cameras = cameras or [framing_camera(stage, *size)]
    widest: PinholeCamera = min(cameras, key=lambda camera: float(camera.K[0, 0]))
    poses = walk(opened.caster, [camera.world_from_camera for camera in cameras], times)
    K = widest.K.copy()
    # Straight ahead: a camera of a scan may look past its picture's middle.
    K[:2, 2] = size[0] / 2.0, size[1] / 2.0
    return CameraPath(WALK, poses, K, rate, cameras[0].exposure)
