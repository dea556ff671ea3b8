"""The camera trajectory of ARKitScenes: poses over time, intrinsics and depth of frames."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import untrusted
from openrooms_usd.capture import CapturedFrame
from openrooms_usd.scan.points.fusion import DepthFrame
from orusd_scans.formats.depthpicture import read_picture, read_sixteen_bits
from orusd_scans.frames import intrinsics
from orusd_scans.records.jsonfile import Node
from orusd_scans.scanned import broken

Array = NDArray[np.float64]

_MILLIMETRES: Final = 1e-3
# Poses are interpolated up to this far from both neighbours on the trajectory, seconds.
_MAX_POSE_GAP_S: Final = 0.25
# Pictures and intrinsics of one moment differ by rounding, seconds.
_SAME_MOMENT_S: Final = 0.02
# Depth is kept where its confidence is not the lowest of 0, 1 and 2.
_MIN_CONFIDENCE: Final = 1
_MAX_COORDINATE_M: Final = 1e6


@dataclass(frozen=True, eq=False)
class CameraPath:
    """A trajectory: poses over time.

    Attributes:
        times: (N,) seconds, ascending.
        quaternions: (N, 4) x, y, z, w, from the camera to the world.
        places: (N, 3) metres.
    """

    times: Array
    quaternions: Array
    places: Array

    def at(self, time: float) -> Array | None:
        """(4, 4) world_from_camera, interpolated; None where the neighbours are too far."""
        from scipy.spatial.transform import Rotation, Slerp

        after = int(np.searchsorted(self.times, time))
        around = [i for i in (after - 1, after) if 0 <= i < len(self.times)]
        near = [i for i in around if abs(self.times[i] - time) <= _MAX_POSE_GAP_S]
        if not near:
            return None
        pose = np.eye(4)
        if len(near) == 2:
            t0, t1 = self.times[near]
            turns = Slerp([t0, t1], Rotation.from_quat(self.quaternions[near]))
            pose[:3, :3] = turns(time).as_matrix()
            part = (time - t0) / (t1 - t0)
            pose[:3, 3] = (1.0 - part) * self.places[near[0]] + part * self.places[near[1]]
        else:
            pose[:3, :3] = Rotation.from_quat(self.quaternions[near[0]]).as_matrix()
            pose[:3, 3] = self.places[near[0]]
        return pose


def read_path(path: Path) -> CameraPath:
    """Read ``lowres_wide.traj``: time, axis-angle and translation from the world to the camera.

    Raises:
        InputError: A line is no pose.
    """
    from scipy.spatial.transform import Rotation

    rows = np.array([_numbers(line, 7, path, i) for i, line in enumerate(_lines(path))])
    if len(rows) == 0:
        raise broken(path, "it holds no poses")
    _, first = np.unique(rows[:, 0], return_index=True)
    rows = rows[first]
    turns = Rotation.from_rotvec(rows[:, 1:4]).inv()
    return CameraPath(rows[:, 0], turns.as_quat(), -turns.apply(rows[:, 4:7]))


def captured_frames(folder: Path, poses: CameraPath, notes: list[str]) -> tuple[CapturedFrame, ...]:
    """The photographs with intrinsics in ``lowres_wide_intrinsics``, as far as they have poses.

    Args:
        folder: What holds the path's file.
        poses: The path.
        notes: Receives a sentence about those without a pose.

    Raises:
        InputError: A file of intrinsics holds nonsense.
    """
    found, lost = [], 0
    for time, path in _timed(folder / "lowres_wide_intrinsics", "pincam"):
        pose = poses.at(time)
        if pose is None:
            lost += 1
            continue
        K, size = _pincam(path)
        picture = folder / "lowres_wide" / f"{path.stem}.png"
        name = f"lowres_wide/{picture.name}" if picture.is_file() else None
        found.append(CapturedFrame(path.stem, pose, K, size, name))
    if lost:
        notes.append(f"{lost} of {lost + len(found)} photographs have no pose: they were left out")
    return tuple(found)


def depth_frames(folder: Path, poses: CameraPath, every: int) -> Iterator[DepthFrame]:
    """One in some of the pictures of ``lowres_depth``, where they have poses and intrinsics.

    Pixels of the lowest confidence are left out.

    Raises:
        InputError: There are none, or one holds nonsense.
    """
    pictures = _timed(folder / "lowres_depth", "png")
    cameras = _timed(folder / "lowres_wide_intrinsics", "pincam")
    if not pictures or not cameras:
        raise broken(folder, "no lowres_depth/*.png and lowres_wide_intrinsics/*.pincam are here")
    times = np.array([time for time, _ in cameras])
    for time, path in pictures[::every]:
        nearest = int(np.argmin(np.abs(times - time)))
        pose = poses.at(time)
        if pose is None or abs(times[nearest] - time) > _SAME_MOMENT_S:
            pose = np.full((4, 4), np.nan)
        depth = read_sixteen_bits(path) * _MILLIMETRES
        sure = folder / "confidence" / path.name
        if sure.is_file():
            depth = np.where(_confidence(sure, depth.shape), depth, 0.0)
        K, size = _pincam(cameras[nearest][1])
        scale = np.array([depth.shape[1] / size[0], depth.shape[0] / size[1], 1.0])
        yield DepthFrame(depth, scale[:, None] * K, pose)


def _confidence(path: Path, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    levels = read_picture(path, "uint8")
    if levels.shape[:2] != shape:
        raise broken(path, "this is no picture of the size of its depth")
    return np.asarray(levels[:, :, 0] >= _MIN_CONFIDENCE)


def _timed(folder: Path, ending: str) -> list[tuple[float, Path]]:
    """The files ``<id>_<seconds>.<ending>`` in the order of their times."""
    found = []
    for path in folder.glob(f"*.{ending}"):
        try:
            found.append((float(path.stem.rpartition("_")[2]), path))
        except ValueError:
            continue
    return sorted(found)


def _pincam(path: Path) -> tuple[Array, tuple[int, int]]:
    lines = _lines(path)
    if len(lines) != 1:
        raise broken(path, "one line of six numbers is expected")
    width, height, fx, fy, cx, cy = _numbers(lines[0], 6, path, 0)
    if width < 1 or height < 1:
        raise broken(path, "pictures have no size")
    rows = [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]
    return intrinsics(Node(rows, path)), (int(width), int(height))


def _numbers(line: str, count: int, path: Path, index: int) -> Array:
    try:
        values = [float(word) for word in line.split()]
    except ValueError as error:
        raise broken(path, f"line {index + 1}: {error}") from error
    return Node(values, path, f"line {index + 1}").numbers(count, _MAX_COORDINATE_M)


def _lines(path: Path) -> list[str]:
    lines = untrusted.read_text(path, "table").splitlines()
    return [line for line in lines if line.strip()]
