"""One frame of SUN RGB-D becomes a Capture: points or depth, tilt, intrinsics and 3D boxes.

Three layouts are read: VoteNet's folder (``depth/N.mat``, ``calib/N.txt``, ``label/N.txt``), the
pickled index of MMDetection3D with the ``.bin`` files beside it, and the folder of one raw frame
(``intrinsics.txt``, ``extrinsics/``, ``depth_bfx/``). The frame of all is "upright depth": x right,
y forward, z up, the camera in the origin. (Song, Lichtenberg and Xiao, "SUN RGB-D: A RGB-D Scene
Understanding Benchmark Suite", CVPR 2015; Qi et al., "Deep Hough Voting", ICCV 2019.)

As ``readframeSUNRGBD.m`` of the dataset's toolbox reads them. A box is the polygon of its base in
the coordinates X and Z of upright depth (x right, y forward), from -Ymax to -Ymin. Its front is the
side between the first two corners.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd import untrusted
from openrooms_usd.arrays import Array
from openrooms_usd.capture import NO_OPTIONS, Capture, CapturedBox, CapturedFrame, Packed
from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.fusion import DepthFrame, FusionOptions, fuse
from orusd_scans.formats.depthpicture import picture_size, read_sixteen_bits
from orusd_scans.frames import intrinsics, packed_folder, there
from orusd_scans.plainscan import UNDETERMINED, cloud_in
from orusd_scans.records import Node, number, read_json, text
from orusd_scans.scanned import Scanned, broken
from orusd_scans.sunrgbd.files import (
    Entry,
    camera_of_projection,
    facing,
    read_boxes,
    read_calibration,
    read_index,
    read_matrix,
    read_points,
)
from orusd_scans.worldframe import WorldFrame, proper

_VOTENET: Final = ("depth", "calib")
_VOTENET_FILES: Final = (
    ("calib", ".txt"),
    ("label", ".txt"),
    ("depth", ".mat"),
    ("depth", ".png"),
    ("image", ".jpg"),
)
# What is read of the folder of a raw frame.
_RAW: Final = (
    "intrinsics.txt",
    "extrinsics/*.txt",
    "depth_bfx/*.png",
    "depth/*.png",
    "image/*.jpg",
    "annotation3Dfinal/index.json",
)
# The camera (x right, y down, z forward) as x right, y forward, z up.
_LEVEL: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
# Voxel size of a single depth picture, metres.
_VOXEL_M: Final = 0.01
# Intrinsics count pixels from 1 at the first one's centre, as MATLAB does.
_HALF: Final = np.array([[0.0, 0.0, 0.5], [0.0, 0.0, 0.5], [0.0, 0.0, 0.0]])
_MAX_SIZE_M: Final = 1e3  # metres
_STRUCTURE: Final = ("wall", "floor", "ceiling")


class SunRgbdImporter:
    """Reads a frame of SUN RGB-D."""

    options: Mapping[str, str] = {
        "frame": "Which frame, such as 000017; needed where the source holds several."
    }

    def read(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Capture:
        """Read one frame.

        Args:
            source: VoteNet's folder, the folder of a raw frame, or a pickled index (``.pkl``).
            options: See `options`.

        Raises:
            InputError: It is not one of these, lacks files, or holds nonsense.
        """
        notes: list[str] = []
        asked = options.get("frame")
        if source.suffix.lower() == ".pkl":
            entry = _chosen(read_index(source), asked, source)
            cloud, frame, boxes = _indexed(entry, source, notes)
        elif all((source / name).is_dir() for name in _VOTENET):
            cloud, frame, boxes = _votenet(source, asked, notes)
        elif (source / "intrinsics.txt").is_file():
            cloud, frame, boxes = _raw(source, notes)
        else:
            raise InputError(
                "this is not a frame of SUN RGB-D",
                place=source,
                remedy="give a folder with depth/, calib/ and label/, a raw frame with "
                "intrinsics.txt, or an index that ends in .pkl",
            )
        same = WorldFrame(np.eye(3), np.zeros(3))
        placed = replace(
            cloud_in(same, Scanned(cloud), source, notes), sensor_origins=np.zeros((1, 3))
        )
        return Capture(
            source=source.name,
            source_from_world=np.eye(4),
            boxes=boxes,
            frames=(frame,),
            cloud=placed,
            notes=tuple(notes),
            remedy=UNDETERMINED,
        )

    def pack(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Packed:
        """The files of the one frame."""
        if source.suffix.lower() == ".pkl":
            entry = _chosen(read_index(source), options.get("frame"), source)
            points = there(*_beside(source, entry.points))[:1]
            contents = {path.relative_to(source.parent).as_posix(): path for path in points}
            return Packed(source.name, {source.name: source, **contents}, options)
        if (source / "intrinsics.txt").is_file():
            return packed_folder(source, (f for kind in _RAW for f in source.glob(kind)), options)
        frame = _frame_of(source, options.get("frame"))
        files = [source / folder / f"{frame}{ending}" for folder, ending in _VOTENET_FILES]
        return packed_folder(source, there(*files), options)


_Read = tuple[Cloud, CapturedFrame, tuple[CapturedBox, ...]]


def _chosen(entries: list[Entry], asked: str | None, source: Path) -> Entry:
    found = [entry for entry in entries if asked in (None, entry.id)]
    if len(found) == 1:
        return found[0]
    such = ", ".join(entry.id for entry in entries[:3])
    raise InputError(
        f"no frame is named {asked!r}" if asked else f"the index holds {len(entries)} frames",
        place=source,
        remedy=f"give --frame ID, such as: {such}",
    )


def _indexed(entry: Entry, source: Path, notes: list[str]) -> _Read:
    """A frame of MMDetection3D's index."""
    points = next((p for p in _beside(source, entry.points) if p.is_file()), None)
    if points is None:
        raise broken(source, f"the points {entry.points!r} are missing", "put them beside it")
    K, turn = camera_of_projection(entry.projection, Node(None, source, entry.id))
    frame = _frame(entry.id, turn, K - _HALF, entry.size, entry.picture)
    boxes = tuple(
        facing(f"{entry.id}_{i}", box.label, box.center, box.size, box.angle)
        for i, box in enumerate(entry.boxes)
    )
    return read_points(points, entry.features, notes), frame, boxes


def _beside(source: Path, name: str) -> list[Path]:
    """Where the file of an index may lie; never outside its folder."""
    return [source.parent / name, source.parent / "points" / name]


def _frame_of(source: Path, asked: str | None) -> str:
    """The frame that is meant, of those in VoteNet's folder."""
    ids = sorted(path.stem for path in (source / "calib").glob("*.txt"))
    if asked is None and len(ids) == 1:
        return ids[0]
    if asked is None or asked not in ids:
        raise InputError(
            f"no frame is named {asked!r}" if asked else f"the folder holds {len(ids)} frames",
            place=source,
            remedy=f"give --frame ID, such as: {', '.join(ids[:3]) or 'none is in calib/'}",
        )
    return asked


def _votenet(source: Path, asked: str | None, notes: list[str]) -> _Read:
    asked = _frame_of(source, asked)
    tilt, K = read_calibration(source / "calib" / f"{asked}.txt")
    picture = source / "image" / f"{asked}.jpg"
    size = _size(picture, K, notes)
    frame = _frame(asked, tilt @ _LEVEL, K - _HALF, size, _named(picture))
    label = source / "label" / f"{asked}.txt"
    boxes = read_boxes(label, asked) if label.is_file() else ()
    if not boxes:
        notes.append("the frame has no boxes")
    stored = source / "depth" / f"{asked}.mat"
    if stored.is_file():
        return read_matrix(stored, notes), frame, boxes
    return _projected(source / "depth" / f"{asked}.png", frame, notes), frame, boxes


def _raw(source: Path, notes: list[str]) -> _Read:
    """The folder of one frame as it was published."""
    tilt, K = read_raw_calibration(source)
    pictures = [p for name in ("depth_bfx", "depth") for p in sorted((source / name).glob("*.png"))]
    if not pictures:
        raise broken(source, "no depth_bfx/*.png is here")
    image = next(iter(sorted((source / "image").glob("*.jpg"))), source / "image" / "none.jpg")
    name = source.resolve().name
    # The tilt turns the camera's own axes here.
    frame = _frame(name, _LEVEL @ tilt, K - _HALF, _size(image, K, notes), _named(image))
    annotation = source / "annotation3Dfinal" / "index.json"
    boxes = read_polygons(annotation) if annotation.is_file() else ()
    if not boxes:
        notes.append("the frame has no boxes")
    return _projected(pictures[0], frame, notes), frame, boxes


def _projected(path: Path, frame: CapturedFrame, notes: list[str]) -> Cloud:
    """The points of a depth picture, whose numbers are rotated by three bits."""
    stored = read_sixteen_bits(path)
    depth = ((stored >> 3) | (stored << 13)).astype(np.float64) / 1000.0
    fused = fuse([DepthFrame(depth, frame.K, frame.world_from_camera)], FusionOptions(_VOXEL_M))
    notes.extend(fused.notes)
    return fused.cloud


def _frame(
    name: str, turn: Array, K: Array, size: tuple[int, int], picture: str | None
) -> CapturedFrame:
    pose = np.eye(4)
    pose[:3, :3] = turn
    return CapturedFrame(name, pose, K, size, picture)


def _named(picture: Path) -> str | None:
    return f"image/{picture.name}" if picture.is_file() else None


def _size(picture: Path, K: Array, notes: list[str]) -> tuple[int, int]:
    if picture.is_file():
        return picture_size(picture)
    notes.append("the frame's picture is missing: its size is guessed from the principal point")
    return max(round(2.0 * float(K[0, 2])), 1), max(round(2.0 * float(K[1, 2])), 1)


def read_raw_calibration(folder: Path) -> tuple[Array, Array]:
    """(3, 3) tilt of the camera (x right, y down, z forward) and (3, 3) intrinsics.

    Raises:
        InputError: A file is missing, or holds no rotation or no intrinsics.
    """
    path = folder / "intrinsics.txt"
    K = intrinsics(Node(_words(path), path))
    found = sorted((folder / "extrinsics").glob("*.txt"))
    if not found:
        raise broken(folder, "no extrinsics/*.txt is here")
    node = Node(_words(found[-1]), found[-1])
    tilt = node.numbers(12, 1e6).reshape(3, 4)[:, :3]
    proper(tilt, node)
    return tilt, K


def read_polygons(path: Path) -> tuple[CapturedBox, ...]:
    """The boxes of ``annotation3Dfinal/index.json``; objects without a polygon are passed over.

    Raises:
        InputError: A box holds nonsense.
    """
    found = []
    for i, node in enumerate(read_json(path).items("objects")):
        drawn = node.items("polygon") if isinstance(node.value, dict) else []
        if not drawn:
            continue
        name = text(node.need("name")).partition(":")[0].rstrip("_ ")
        if name not in _STRUCTURE:
            found.append(_box(str(i), name, drawn[0]))
    return tuple(found)


def _box(identifier: str, name: str, node: Node) -> CapturedBox:
    x, y = (node.need(axis).numbers(4, _MAX_SIZE_M) for axis in ("X", "Z"))
    corners = np.column_stack([x, y])
    high, low = (-number(node.need(key), _MAX_SIZE_M) for key in ("Ymin", "Ymax"))
    across, along = corners[1] - corners[0], corners[2] - corners[1]
    size = np.array([np.linalg.norm(along), np.linalg.norm(across), abs(high - low)])
    if not (size > 0.0).all():
        raise node.error("a side of the box is not positive", "correct the annotation")
    middle = 0.5 * (corners[0] + corners[2])
    front = 0.5 * (corners[0] + corners[1]) - middle
    center = np.array([*middle, 0.5 * (high + low)])
    return facing(identifier, name, center, size, math.atan2(front[1], front[0]))


def _words(path: Path) -> list[float]:
    try:
        return [float(word) for word in untrusted.read_text(path).split()]
    except ValueError as error:
        raise broken(path, f"numbers are expected: {error}") from error
