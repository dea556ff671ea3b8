"""Which path is meant: ``walk``, a camera of the stage that moves, or a file with keys."""

import math
from pathlib import Path
from typing import Any, Final

import numpy as np
from pxr import Usd, UsdGeom

from openrooms_usd.arrays import Array
from openrooms_usd.description.reading import read_yaml
from openrooms_usd.errors import InputError, StageError
from openrooms_usd.geometry.framing import FOV_DEG
from openrooms_usd.geometry.pinhole import intrinsics, look_at
from openrooms_usd.geometry.rotations import nearest_rotation, pose
from openrooms_usd.rendering.context import RenderContext
from openrooms_usd.rendering.paths.camera_path import CameraPath, frame_times
from openrooms_usd.rendering.paths.spline import interpolated
from openrooms_usd.rendering.paths.walk import check_passable, walk
from openrooms_usd.rendering.plan import choose_cameras
from openrooms_usd.untrusted import read_text
from openrooms_usd.usd.cameras import FLIP, PINHOLE, PinholeCamera, framing_camera, read_camera
from openrooms_usd.usd.places.frames import local_to_world, world_from_stage

SUFFIXES: Final = (".yaml", ".yml", ".json")
_KEYS: Final = {"time", "position", "target"}
_TOP: Final = {"keys", "fov"}
_REMEDY: Final = "give `keys`, each with time, position [x, y, z] and target [x, y, z]"
_FOVS_DEG: Final = (1.0, 170.0)
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
            remedy=f"give its transform time samples, or use --path {WALK}",
        )
    camera = read_camera(prim, *size)
    if camera.projection != PINHOLE:
        raise InputError(
            f"an {camera.projection} camera cannot film",
            place=path,
            remedy=f"choose a perspective one, or --path {WALK}",
        )
    length = (codes[1] - codes[0]) / stage.GetTimeCodesPerSecond()
    poses = timed_poses(prim, frame_times(seconds or length, rate))
    return CameraPath(name, poses, camera.K, rate, camera.exposure)


def stage_walk(opened: RenderContext, size: tuple[int, int], times: Array, rate: int) -> CameraPath:
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


def time_range(prim: Usd.Prim) -> tuple[float, float] | None:
    """The first and the last time code at which a prim or what it stands in moves; None: never."""
    codes: list[float] = []
    while prim and not prim.IsPseudoRoot():
        if xformable := UsdGeom.Xformable(prim):
            codes += xformable.GetTimeSamples()
        prim = prim.GetParent()
    return (min(codes), max(codes)) if len(set(codes)) > 1 else None


def timed_poses(prim: Usd.Prim, times: Array) -> Array:
    """(F, 4, 4) world_from_camera at (F,) seconds after a moving camera's first time sample.

    Raises:
        StageError: Its transform is mirrored or singular at some time.
    """
    codes = time_range(prim)
    first = codes[0] if codes else 0.0
    stage = prim.GetStage()
    world, rate = world_from_stage(stage), stage.GetTimeCodesPerSecond()
    found = []
    for seconds in times:
        cache = UsdGeom.XformCache(Usd.TimeCode(first + seconds * rate))
        placed = world @ local_to_world(prim, cache) @ FLIP
        determinant = np.linalg.det(placed[:3, :3])
        if not (math.isfinite(determinant) and determinant > 0):
            raise StageError(
                f"its transform is mirrored or singular at {seconds:.2f} s",
                place=prim.GetPath(),
                remedy="use rotations and positive scales",
            )
        found.append(pose(nearest_rotation(placed[:3, :3]), placed[:3, 3]))
    return np.array(found)


class Keyframes:
    """Positions and targets at rising times.

    Attributes:
        times: (N,) seconds.
        positions: (N, 3) metres.
        targets: (N, 3) metres.
        fov: Horizontal field of view, degrees.

    Args:
        data: What the file says, as plain data.
        place: The file.

    Raises:
        InputError: It is not such a description.
    """

    def __init__(self, data: Any, place: Path) -> None:
        keys = data.get("keys") if isinstance(data, dict) and set(data) <= _TOP else None
        if not isinstance(keys, list) or not keys:
            raise InputError("this does not describe a camera path", place=place, remedy=_REMEDY)
        for number, key in enumerate(keys):
            if not (isinstance(key, dict) and set(key) == _KEYS):
                where = f"{place}: keys[{number}]"
                raise InputError("this is not a key of a path", place=where, remedy=_REMEDY)
        rows = [[[key["time"]], key["position"], key["target"]] for key in keys]
        self.times = _numbers([row[0] for row in rows], 1, place)[:, 0]
        self.positions = _numbers([row[1] for row in rows], 3, place)
        self.targets = _numbers([row[2] for row in rows], 3, place)
        if (np.diff(self.times) <= 0.0).any():
            raise InputError("the times of its keys must increase", place=place, remedy=_REMEDY)
        self.fov = float(_numbers([[data.get("fov", FOV_DEG)]], 1, place)[0, 0])
        if not _FOVS_DEG[0] <= self.fov <= _FOVS_DEG[1]:
            raise InputError(
                f"a camera cannot have a field of view of {self.fov:g} degrees",
                place=f"{place}: fov",
            )

    @property
    def seconds(self) -> float:
        """How long the path is."""
        return float(self.times[-1] - self.times[0])

    def poses(self, times: Array) -> Array:
        """(F, 4, 4) at (F,) seconds after the first key."""
        at = self.times[0] + times
        eyes = interpolated(self.times, self.positions, at)
        aims = interpolated(self.times, self.targets, at)
        return np.array([look_at(eye, aim) for eye, aim in zip(eyes, aims, strict=True)])


def read_keyframes(path: Path) -> Keyframes:
    """Read a YAML or JSON file.

    Raises:
        InputError: It cannot be read, or describes no path.
    """
    text = read_text(path, "description", remedy=_REMEDY)
    data, mistakes = read_yaml(text, path.name)
    if mistakes:
        raise InputError(str(mistakes[0]), place=path, remedy=_REMEDY)
    return Keyframes(data, path)


def _numbers(values: list[Any], width: int, place: Path) -> Array:
    for row in values:
        good = isinstance(row, list) and len(row) == width
        if not good or not all(isinstance(x, int | float) and abs(x) < 1e6 for x in row):
            found = f"{row} are not {width} numbers" if width > 1 else f"{row[0]!r} is not a number"
            raise InputError(found, place=place, remedy=_REMEDY)
    return np.array(values, dtype=np.float64)
