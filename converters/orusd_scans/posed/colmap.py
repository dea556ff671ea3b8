"""COLMAP's models, as text and as binary files: cameras and images.

Poses take points of the world to the camera (x right, y down, z forward). Pixels count from the
corner of the first one, as ours do. A model has neither a scale nor a vertical. (Schönberger and
Frahm, "Structure-from-Motion Revisited", CVPR 2016.)
"""

import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np

from openrooms_usd import untrusted
from openrooms_usd.appearance.photographs import PosedPhotographs
from openrooms_usd.arrays import Array
from openrooms_usd.capture import CapturedFrame
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.rotations import inverse
from orusd_scans.posed.pictures import by_number, identifiers, is_inside, name_inside, pinhole
from orusd_scans.records import Node
from orusd_scans.worldframe import MAX_COORDINATE_M

# COLMAP's numbers of camera models, and where their parameters are.
_MODELS: Final = (
    ("SIMPLE_PINHOLE", 3),
    ("PINHOLE", 4),
    ("SIMPLE_RADIAL", 4),
    ("RADIAL", 5),
    ("OPENCV", 8),
    ("OPENCV_FISHEYE", 8),
    ("FULL_OPENCV", 12),
    ("FOV", 5),
    ("SIMPLE_RADIAL_FISHEYE", 4),
    ("RADIAL_FISHEYE", 5),
    ("THIN_PRISM_FISHEYE", 12),
)
_PARAMETERS: Final = dict(_MODELS)
_UNREAD: Final = ("FOV", "THIN_PRISM_FISHEYE")
_ONE_FOCAL: Final = ("SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "SIMPLE_RADIAL_FISHEYE",
                     "RADIAL_FISHEYE")  # fmt: skip
# Where models are in a project, and pictures from a model's folder.
_PLACES: Final = (".", "sparse/0", "sparse", "colmap/sparse/0", "colmap/sparse", "text", "0")
_PICTURES: Final = ("images", "input", "image", "rgb", ".")
_MAX_PIXELS: Final = 1e6
# So many pictures show which folder is theirs.
_FIRST: Final = 8
_MOST_ROWS: Final = 10_000_000
_LONGEST_NAME: Final = 1024
_UNIT_TOLERANCE: Final = 1e-2
_POINT_BYTES: Final = 24
_REMEDY: Final = "export the model again"


@dataclass(frozen=True, eq=False)
class _Camera:
    """A camera of a model: its pictures' size, (3, 3) intrinsics, and its lens."""

    size: tuple[int, int]
    K: Array
    distortion: tuple[float, ...]
    fisheye: bool


@dataclass(frozen=True, eq=False)
class _Image:
    """A picture of a model: quaternion w x y z and translation (7,) from the world, its camera."""

    pose: Array
    camera: int
    name: str
    node: Node


class ColmapPhotographs:
    """Reads a model's folder, or a project with ``sparse/0``."""

    reads = "a COLMAP model (cameras and images, .txt or .bin)"

    def recognises(self, path: Path) -> bool:
        """Whether there is a model."""
        return path.is_dir() and _model(path) is not None

    def read(self, path: Path) -> PosedPhotographs:
        """Read the model.

        Raises:
            InputError: A file is missing, cut off or holds nonsense.
        """
        folder = _model(path)
        if folder is None:
            raise InputError("no COLMAP model is here", place=path, remedy=f"give {self.reads}")
        ending = ".bin" if (folder / "cameras.bin").is_file() else ".txt"
        cameras = _cameras(folder / f"cameras{ending}")
        images = _images(folder / f"images{ending}")
        root = _pictures(path, folder, images)
        names = [name_inside(root, image.name, image.node) for image in images]
        frames = tuple(
            _frame(image, cameras, identifier, name)
            for image, identifier, name in zip(images, identifiers(names), names, strict=True)
        )
        return PosedPhotographs(frames, root, "colmap", False, False, _other_models(folder))


def _model(path: Path) -> Path | None:
    """The first folder of a project that holds a model."""
    folders = (path / place for place in _PLACES)
    files = ("cameras.bin", "cameras.txt")
    return next((f for f in folders if any((f / file).is_file() for file in files)), None)


def _pictures(path: Path, model: Path, images: list[_Image]) -> Path:
    """The folder that holds most of the first pictures."""
    above = [path, model, *list(model.resolve().parents)[:3]]
    places = [folder / name for folder in above for name in _PICTURES]
    folders = [path, *(place for place in places if place.is_dir())]

    def there(folder: Path) -> int:
        return sum(is_inside(folder, image.name) for image in images[:_FIRST])

    return max(folders, key=there)


def _other_models(model: Path) -> tuple[str, ...]:
    """A note about parts of a reconstruction that did not join: folders 0, 1 and so on."""
    beside = model.resolve().parent.glob("*") if model.name.isdecimal() else ()
    count = sum(folder.name.isdecimal() and folder.name != model.name for folder in beside)
    return (f"{count} other models are beside {model.name!r}",) if count else ()


def _frame(image: _Image, cameras: dict[int, _Camera], identifier: str, name: str) -> CapturedFrame:
    camera = cameras.get(image.camera)
    if camera is None:
        raise image.node.error(f"its camera {image.camera} is not in the model", _REMEDY)
    return CapturedFrame(
        id=identifier,
        world_from_camera=_pose(image),
        K=camera.K,
        resolution=camera.size,
        picture=name,
        distortion=camera.distortion,
        fisheye=camera.fisheye,
    )


def _pose(image: _Image) -> Array:
    from scipy.spatial.transform import Rotation

    quaternion = image.pose[:4]
    if abs(float(np.linalg.norm(quaternion)) - 1.0) > _UNIT_TOLERANCE:
        raise image.node.error("its quaternion is not of unit length", _REMEDY)
    camera_from_world = np.eye(4)
    turn = Rotation.from_quat(quaternion, scalar_first=True)
    camera_from_world[:3, :3], camera_from_world[:3, 3] = turn.as_matrix(), image.pose[4:]
    return inverse(camera_from_world)


def _camera(model: str, size: tuple[float, float], parameters: list[float], node: Node) -> _Camera:
    """A camera of what its file says."""
    if model in _UNREAD or model not in _PARAMETERS:
        readable = ", ".join(name for name, _ in _MODELS if name not in _UNREAD)
        raise node.error(
            f"cameras of the model {model[:40]} are not read",
            f"undistort the pictures (colmap image_undistorter), or use one of: {readable}",
        )
    width, height = Node(list(size), node.file, node.path).numbers(2, _MAX_PIXELS)
    if min(width, height) < 1:
        raise node.error("its pictures have no size", _REMEDY)
    values = Node(parameters, node.file, node.path).numbers(_PARAMETERS[model], _MAX_PIXELS)
    focals = 1 if model in _ONE_FOCAL else 2
    f, center, lens = values[:focals], values[focals : focals + 2], values[focals + 2 :]
    K = pinhole(float(f[0]), float(f[-1]), float(center[0]), float(center[1]), node)
    fisheye = model.endswith("FISHEYE")
    # Fewer coefficients are the first ones of OpenCV's four.
    filled = (*lens, *[0.0] * max(0, 4 - len(lens)))
    bends = fisheye or any(lens)
    distortion = tuple(float(value) for value in filled) if bends else ()
    return _Camera((int(width), int(height)), K, distortion, fisheye)


def _cameras(path: Path) -> dict[int, _Camera]:
    binary = path.suffix == ".bin"
    rows = _binary_cameras(path) if binary else _text_cameras(path)
    return {number: _camera(*row) for number, row in rows}


def _images(path: Path) -> list[_Image]:
    found = list(_binary_images(path) if path.suffix == ".bin" else _text_images(path))
    return sorted(found, key=lambda image: by_number(image.name))


_CameraRow = tuple[int, tuple[str, tuple[float, float], list[float], Node]]

# Text: a line a camera, two lines an image.


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    """Number and text of each line except comments; lines may be empty."""
    with untrusted.opened(path, "annotations") as stream:
        for number, line in enumerate(stream, 1):
            if not line.startswith(b"#"):
                yield number, line.decode("utf-8", errors="replace").rstrip("\r\n")


def _text_cameras(path: Path) -> Iterator[_CameraRow]:
    for number, line in _lines(path):
        words = line.split()
        if not words:
            continue
        node = Node(None, path, f"line {number}")
        if len(words) < 5:
            raise node.error("a camera has CAMERA_ID MODEL WIDTH HEIGHT PARAMS", _REMEDY)
        identifier, size = _whole(words[0], node), _floats(words[2:4], node)
        yield identifier, (words[1], (size[0], size[1]), _floats(words[4:], node), node)


def _text_images(path: Path) -> Iterator[_Image]:
    lines = _lines(path)
    for number, line in lines:
        words = line.split(maxsplit=9)
        if not words:
            continue
        node = Node(None, path, f"line {number}")
        if len(words) < 10:
            raise node.error("an image has IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME", _REMEDY)
        pose = Node(_floats(words[1:8], node), path, node.path).numbers(7, MAX_COORDINATE_M)
        yield _Image(pose, _whole(words[8], node), words[9].strip(), node)
        # Its points, which may be none, are on a line of their own.
        number, points = next(lines, (number, None))
        if points is None or len(points.split()) % 3:
            raise Node(None, path, f"line {number}").error("the points of an image are cut off")


def _floats(words: list[str], node: Node) -> list[float]:
    try:
        return [float(word) for word in words]
    except ValueError as error:
        raise node.error(f"numbers are expected: {str(error)[:80]}", _REMEDY) from error


def _whole(word: str, node: Node) -> int:
    if not word.isdecimal() or len(word) > 18:
        raise node.error(f"{word[:20]!r} is not an identifier", _REMEDY)
    return int(word)


# Binary: little-endian, a count before the rows.


class _Stream:
    """A binary file that knows where it ends.

    Args:
        stream: Its bytes.
        path: The file, for messages.
    """

    def __init__(self, stream: BinaryIO, path: Path) -> None:
        self._stream = stream
        self._size = os.fstat(stream.fileno()).st_size
        self.node = Node(None, path)

    def unpack(self, layout: str) -> tuple[int | float, ...]:
        """The next numbers."""
        data = self._stream.read(struct.calcsize(layout))
        if len(data) < struct.calcsize(layout):
            raise self.node.error("the file is cut off", _REMEDY)
        return struct.unpack(layout, data)

    def count(self, smallest: int) -> int:
        """A number of rows that have so many bytes or more, all of which must be there."""
        found = int(self.unpack("<Q")[0])
        if found > _MOST_ROWS or found * smallest > self._size - self._stream.tell():
            raise self.node.error(f"it announces {found:,} rows and is too short", _REMEDY)
        return found

    def name(self) -> str:
        """A text that a zero byte ends."""
        letters = bytearray()
        while (letter := self._stream.read(1)) != b"\0":
            if not letter or len(letters) >= _LONGEST_NAME:
                raise self.node.error("the name of a picture has no end", _REMEDY)
            letters += letter
        return letters.decode("utf-8", errors="replace")

    def skip_points(self) -> None:
        """Pass over the points of a picture."""
        self._stream.seek(self.count(_POINT_BYTES) * _POINT_BYTES, os.SEEK_CUR)

    def end(self) -> None:
        """See that nothing follows."""
        if self._stream.read(1):
            raise self.node.error("more follows than it announces", _REMEDY)


def _binary_cameras(path: Path) -> Iterator[_CameraRow]:
    with untrusted.opened(path, "array") as opened:
        stream = _Stream(opened, path)
        for row in range(stream.count(48)):
            stream.node = node = Node(None, path, f"camera {row}")
            identifier, number = (int(value) for value in stream.unpack("<Ii"))
            width, height = stream.unpack("<2Q")
            known = 0 <= number < len(_MODELS)
            model, count = _MODELS[number] if known else (str(number), 0)
            yield identifier, (model, (width, height), list(stream.unpack(f"<{count}d")), node)
        stream.end()


def _binary_images(path: Path) -> Iterator[_Image]:
    with untrusted.opened(path, "frames") as opened:
        stream = _Stream(opened, path)
        for row in range(stream.count(73)):
            stream.node = node = Node(None, path, f"image {row}")
            _, *numbers = stream.unpack("<I7d")
            pose = Node(numbers, path, node.path).numbers(7, MAX_COORDINATE_M)
            camera = int(stream.unpack("<I")[0])
            yield _Image(pose, camera, stream.name(), node)
            stream.skip_points()
        stream.end()
