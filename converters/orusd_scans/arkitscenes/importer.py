"""A scan of ARKitScenes becomes a Capture: mesh, 3D boxes, and low-resolution depth with its path.

Both layouts of the download are read: ``<id>/`` with its files side by side (raw), and with
``<id>_frames/`` below it (3dod). (Baruch et al., "ARKitScenes: A Diverse Real-World Dataset for 3D
Indoor Scene Understanding Using Mobile RGB-D Data", NeurIPS 2021 datasets.) The world is the
scan's: metres, Z up.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd import untrusted
from openrooms_usd.arrays import Array, Mask
from openrooms_usd.capture import NO_OPTIONS, Capture, CapturedBox, CapturedFrame, Packed
from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.fusion import DepthFrame, fuse
from orusd_scans.formats.depthpicture import read_picture, read_sixteen_bits
from orusd_scans.formats.ply import read_ply
from orusd_scans.frames import intrinsics, packed_folder
from orusd_scans.plainscan import UNDETERMINED, cloud_in, with_sensor_origins
from orusd_scans.records import Node, read_json, text
from orusd_scans.scanned import Scanned, broken, line_of_numbers, one_in
from orusd_scans.worldframe import MAX_COORDINATE_M, WorldFrame

_MESH: Final = "*_3dod_mesh.ply"
_BOXES: Final = "*_3dod_annotation.json"
TRAJECTORY: Final = "lowres_wide.traj"
_POSED: Final = (TRAJECTORY, "lowres_wide_intrinsics/*.pincam")
_DEPTH: Final = ("lowres_depth/*.png", "confidence/*.png")
_MAX_SIZE_M: Final = 1e3  # metres
_RIGHT_ANGLE_TOLERANCE: Final = 1e-2
_EVERY_FRAMES: Final = 10
_MILLIMETRES: Final = 1e-3
# Poses are interpolated up to this far from both neighbours on the trajectory, seconds.
_MAX_POSE_GAP_S: Final = 0.25
# Pictures and intrinsics of one moment differ by rounding, seconds.
_SAME_MOMENT_S: Final = 0.02
# Depth is kept where its confidence is not the lowest of 0, 1 and 2.
_MIN_CONFIDENCE: Final = 1


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
        InputError: A line is not a pose.
    """
    from scipy.spatial.transform import Rotation

    rows = np.array([line_of_numbers(line, 7, path, i) for i, line in enumerate(_lines(path))])
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
        raise broken(folder, "lowres_depth/*.png and lowres_wide_intrinsics/*.pincam are missing")
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


def _confidence(path: Path, shape: tuple[int, ...]) -> Mask:
    levels = read_picture(path, "uint8")
    if levels.shape[:2] != shape:
        raise broken(path, "this picture does not have the size of its depth")
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
    width, height, fx, fy, cx, cy = line_of_numbers(lines[0], 6, path, 0)
    if width < 1 or height < 1:
        raise broken(path, "pictures have no size")
    rows = [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]
    return intrinsics(Node(rows, path)), (int(width), int(height))


def _lines(path: Path) -> list[str]:
    lines = untrusted.read_text(path, "table").splitlines()
    return [line for line in lines if line.strip()]


class ARKitScenesImporter:
    """Reads a scan of Apple's ARKitScenes, a folder."""

    options: Mapping[str, str] = {
        "fuse": "Fuse one in this many low-resolution depth pictures, in place of the mesh."
    }

    def read(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Capture:
        """Read a scan.

        Args:
            source: Its folder.
            options: See `options`.

        Raises:
            InputError: It holds neither mesh nor depth, several scans, or nonsense.
        """
        notes: list[str] = []
        mesh, annotation = _one(source, _MESH), _one(source, _BOXES)
        folder = frames_folder(source)
        poses = read_path(folder / TRAJECTORY) if folder is not None else None
        frames = captured_frames(folder, poses, notes) if folder is not None and poses else ()
        if "fuse" in options or mesh is None:
            if folder is None or poses is None:
                raise InputError(
                    f"neither a mesh {_MESH} nor {TRAJECTORY} with lowres_depth is here",
                    place=source,
                    remedy="give the folder of one scan of ARKitScenes",
                )
            every = one_in(options, _EVERY_FRAMES, source, "pictures")
            fused = fuse(depth_frames(folder, poses, every))
            notes.extend(fused.notes)
            scanned = Scanned(fused.cloud)
        else:
            scanned = read_ply(mesh)
        same = WorldFrame(np.eye(3), np.zeros(3))
        cloud = with_sensor_origins(cloud_in(same, scanned, source, notes), frames)
        return Capture(
            source=source.name,
            source_from_world=np.eye(4),
            boxes=read_boxes(annotation) if annotation is not None else (),
            frames=frames,
            cloud=cloud,
            notes=tuple(notes),
            remedy=UNDETERMINED,
        )

    def pack(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Packed:
        """The mesh or the depth that is fused, the boxes, and the camera's path."""
        mesh, folder = _one(source, _MESH), frames_folder(source)
        fused = "fuse" in options or mesh is None
        files = [None if fused else mesh, _one(source, _BOXES)]
        if folder is not None:
            kinds = (*_POSED, *(_DEPTH if fused else ()))
            files += [path for kind in kinds for path in sorted(folder.glob(kind))]
        return packed_folder(source, files, options)


def _one(source: Path, pattern: str) -> Path | None:
    found = sorted(source.glob(pattern)) if source.is_dir() else []
    if len(found) > 1:
        raise InputError(
            f"several scans are here: {len(found)} of {pattern}", place=source, remedy="give one"
        )
    return found[0] if found else None


def frames_folder(source: Path) -> Path | None:
    """The folder of the camera's trajectory; None where there is none."""
    folders = [source, *sorted(source.glob("*_frames"))] if source.is_dir() else []
    return next((folder for folder in folders if (folder / TRAJECTORY).is_file()), None)


def read_boxes(path: Path) -> tuple[CapturedBox, ...]:
    """The boxes of ``<id>_3dod_annotation.json``: which side is their front is not known.

    Raises:
        InputError: A box holds nonsense, or an identifier repeats.
    """
    found: dict[str, CapturedBox] = {}
    for node in read_json(path).items("data"):
        box = _box(node)
        if box.id in found:
            raise node.error(f"the uid {box.id!r} exists already", "correct the annotation")
        found[box.id] = box
    return tuple(found.values())


def _box(node: Node) -> CapturedBox:
    drawn = node.need("segments").need("obbAligned")
    lengths = drawn.need("axesLengths").numbers(3, _MAX_SIZE_M)
    axes = drawn.need("normalizedAxes").numbers(9, 1.0 + _RIGHT_ANGLE_TOLERANCE).reshape(3, 3)
    if not (lengths > 0.0).all():
        raise drawn.error("a side of the box is not positive", "correct the annotation")
    if np.abs(axes @ axes.T - np.eye(3)).max() > _RIGHT_ANGLE_TOLERANCE:
        raise drawn.error("the axes of the box are not at right angles", "correct the annotation")
    rotation, size = _upright(axes, lengths)
    return CapturedBox(
        id=text(node.need("uid")),
        label=text(node.need("label")),
        center=drawn.need("centroid").numbers(3, MAX_COORDINATE_M),
        rotation=rotation,
        size=size,
    )


def _upright(axes: Array, lengths: Array) -> tuple[Array, Array]:
    """Axes (rows) as columns width, depth, height: the steepest is up, the longer other is wide."""
    up = int(np.argmax(np.abs(axes[:, 2])))
    others = [i for i in range(3) if i != up]
    wide = max(others, key=lambda i: float(lengths[i]))
    deep = next(i for i in others if i != wide)
    height = axes[up] * np.sign(axes[up, 2])
    rotation = np.column_stack([axes[wide], np.cross(height, axes[wide]), height])
    return rotation, lengths[[wide, deep, up]]
