"""Camera poses and intrinsics of ScanNet: an exported folder, or a ``.sens`` file.

Only numbers are read: pictures are neither decoded nor copied. Poses take points of the camera
(x right, y down, z forward) to the scan, row by row; frames without one hold -inf. ScanNet counts
pixels from the centre of the first one, so half a pixel is added to its principal points.
"""

import os
import struct
import zlib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import untrusted
from openrooms_usd.arrays import Array, Floats
from openrooms_usd.capture import CapturedFrame
from openrooms_usd.errors import InputError
from orusd_scans.formats.depthpicture import picture_size
from orusd_scans.frames import intrinsics, read_frames
from orusd_scans.records import Node
from orusd_scans.worldframe import rigid

_PICTURES: Final = (".jpg", ".jpeg", ".png")
_REMEDY: Final = "give a .sens file, a folder that the SensReader exported, or a frames JSON"


def read_scannet_frames(source: Path, notes: list[str]) -> tuple[CapturedFrame, ...]:
    """The frames of a scan, in the frame of the scan.

    Args:
        source: A ``.sens`` file, a folder with ``pose/N.txt`` and
            ``intrinsic/intrinsic_color.txt``, a folder that holds one ``.sens`` file, or a JSON
            list as in `frames`.
        notes: Receives a sentence about frames without a pose.

    Raises:
        InputError: It is not one of these, or holds nonsense.
    """
    if source.suffix.lower() == ".json":
        return read_frames(source)
    file = source
    if source.is_dir():
        if (source / "pose").is_dir():
            return _exported(source, notes)
        inside = sorted(source.glob("*.sens"))
        if len(inside) != 1:
            raise InputError("no frames are here", place=source, remedy=_REMEDY)
        file = inside[0]
    if file.suffix.lower() != ".sens":
        raise InputError("no frames can be read from this", place=source, remedy=_REMEDY)
    with untrusted.opened(file, "frames") as stream:
        sens = Sens(stream, file)
        K = centred(sens.color_intrinsics())
        return posed(sens.poses(), K, sens.color_size, {}, notes)


def _exported(folder: Path, notes: list[str]) -> tuple[CapturedFrame, ...]:
    K = centred(intrinsics(Node(_square(folder / "intrinsic/intrinsic_color.txt", 3), folder)))
    poses = {int(path.stem): path for path in folder.glob("pose/*.txt") if path.stem.isdecimal()}
    if not poses:
        raise InputError("no pose/N.txt is here", place=folder, remedy=_REMEDY)
    pictures = {
        int(path.stem): path.name
        for path in folder.glob("color/*")
        if path.stem.isdecimal() and path.suffix.lower() in _PICTURES
    }
    resolution = _resolution(folder, pictures)
    return posed(
        ((n, Node(matrix(path, 4).tolist(), path)) for n, path in sorted(poses.items())),
        K,
        resolution,
        {n: f"color/{name}" for n, name in pictures.items()},
        notes,
    )


def posed(
    poses: Iterator[tuple[int, Node]],
    K: Array,
    resolution: tuple[int, int],
    pictures: dict[int, str],
    notes: list[str],
) -> tuple[CapturedFrame, ...]:
    """Frames of the poses that were not lost."""
    found, lost = [], 0
    for number, node in poses:
        if not np.isfinite(np.array(node.value)).all():
            lost += 1
            continue
        found.append(CapturedFrame(str(number), rigid(node), K, resolution, pictures.get(number)))
    if lost:
        notes.append(f"{lost} of {lost + len(found)} frames have no pose: they were left out")
    return tuple(found)


def centred(K: Array) -> Array:
    """Intrinsics of pixels that are counted from the corner of the first, not from its centre."""
    half = np.array([[0.0, 0.0, 0.5], [0.0, 0.0, 0.5], [0.0, 0.0, 0.0]])
    return np.asarray(K + half, dtype=np.float64)


def _square(path: Path, size: int) -> list[list[float]]:
    corner: list[list[float]] = matrix(path, 4)[:size, :size].tolist()
    return corner


def matrix(path: Path, size: int) -> Array:
    """A square matrix in a text file."""
    words = untrusted.read_text(path, remedy=_REMEDY).split()
    try:
        return np.asarray(np.array([float(word) for word in words]).reshape(size, size))
    except ValueError as error:
        raise InputError(
            f"no {size} x {size} matrix can be read: {error}", place=path, remedy=_REMEDY
        ) from error


def _resolution(folder: Path, pictures: dict[int, str]) -> tuple[int, int]:
    """Width and height of the colour pictures: from a picture's header, or the scan's text file."""
    if pictures:
        with suppress(InputError):  # the scan's text file may say it, too
            return picture_size(folder / "color" / pictures[min(pictures)])
    for path in (folder / f"{folder.resolve().name}.txt", folder / "_info.txt"):
        if path.is_file():
            found = settings(path)
            sizes = [found.get(k) or found.get(f"m_{k}") for k in ("colorWidth", "colorHeight")]
            if all(size and size.isdigit() for size in sizes):
                return int(sizes[0] or 0), int(sizes[1] or 0)
    raise InputError(
        "the size of the colour pictures is not known",
        place=folder,
        remedy=f"put color/N.jpg or {folder.resolve().name}.txt (colorWidth, colorHeight) there",
    )


def settings(path: Path) -> dict[str, str]:
    """The ``key = value`` lines of a file."""
    pairs = (line.partition("=") for line in untrusted.read_text(path).splitlines())
    return {key.strip(): value.strip() for key, _, value in pairs}


# `.sens` files of ScanNet, version 4, streamed from their beginning: poses, intrinsics, depth.
#
# Colour pictures are skipped. Poses take points of the camera (x right, y down, z forward) to the
# scan, row by row; frames that lost track hold -inf.

_SENS_VERSION: Final = 4
_MOST_FRAMES: Final = 1_000_000
_LONGEST_NAME: Final = 4096
_MAX_SIDE_PIXELS: Final = 32_768  # pixels
_MOST_PIXELS: Final = 1 << 25
_RAW, _ZLIB = 0, 1


class Sens:
    """A ``.sens`` file; it is read once, from its beginning to its end.

    Args:
        stream: The file's bytes.
        path: The file, for messages.

    Raises:
        InputError: It is cut off, of another version, or holds nonsense.
    """

    def __init__(self, stream: BinaryIO, path: Path) -> None:
        self._stream = stream
        self._path = path
        self._size = os.fstat(stream.fileno()).st_size
        (version,) = self._unpack("<I")
        if version != _SENS_VERSION:
            raise self._error(f"its version is {version}, not {_SENS_VERSION}")
        (length,) = self._unpack("<Q")
        self._skip(length, _LONGEST_NAME)
        self._matrices = np.array(self._unpack("<64f"), dtype=np.float64).reshape(4, 4, 4)
        _, self._coding = self._unpack("<2i")
        width, height, *depth = self._unpack("<4I")
        (self._units,) = self._unpack("<f")
        self.color_size = (width, height)
        self.depth_size = (depth[0], depth[1])
        if not (0 < width <= _MAX_SIDE_PIXELS and 0 < height <= _MAX_SIDE_PIXELS):
            raise self._error(f"pictures of {width}x{height} pixels make no sense")

    def color_intrinsics(self) -> Array:
        """(3, 3) of the colour pictures, whose pixels count from the centre of the first."""
        return intrinsics(Node(self._matrices[0, :3, :3].tolist(), self._path, "intrinsic_color"))

    def depth_intrinsics(self) -> Array:
        """(3, 3) of the depth pictures, whose pixels count from the centre of the first."""
        return intrinsics(Node(self._matrices[2, :3, :3].tolist(), self._path, "intrinsic_depth"))

    def poses(self) -> Iterator[tuple[int, Node]]:
        """The number and the pose (4, 4) of each frame, also of those that lost track."""
        for number, pose, length in self._records():
            self._skip(length, self._size)
            yield number, pose

    def depths(self, every: int = 1) -> Iterator[tuple[int, Node, Floats]]:
        """Number, pose and depth picture (H, W), metres, of one in some frames."""
        width, height = self.depth_size
        if not 0 < width * height <= _MOST_PIXELS or not 1e-3 < self._units < 1e9:
            raise self._error(f"depth pictures of {width}x{height} pixels make no sense")
        if self._coding not in (_RAW, _ZLIB):
            raise self._error(f"its depth is packed by a method that is not known: {self._coding}")
        for number, pose, length in self._records():
            if number % every:
                self._skip(length, self._size)
                continue
            # What is packed may be a little longer than what is not.
            self._check(length, 4 * width * height + 1024)
            values = self._depth(self._stream.read(length), number)
            metres = values.reshape(height, width).astype(np.float32) / np.float32(self._units)
            yield number, pose, metres

    def _depth(self, blob: bytes, number: int) -> NDArray[np.uint16]:
        size = 2 * self.depth_size[0] * self.depth_size[1]
        if self._coding == _ZLIB:
            try:
                # One byte more than there may be shows that there is more.
                blob = zlib.decompressobj().decompress(blob, size + 1)
            except zlib.error as error:
                raise self._error(f"the depth of frame {number} is damaged: {error}") from error
        if len(blob) != size:
            raise self._error(f"the depth of frame {number} is not of {size:,} bytes")
        return np.frombuffer(blob, "<u2")

    def _records(self) -> Iterator[tuple[int, Node, int]]:
        """Number, pose and length of the depth of each frame; who takes it must pass the depth."""
        (count,) = self._unpack("<Q")
        if count > _MOST_FRAMES:
            raise self._error(f"it announces {count:,} frames")
        for number in range(count):
            pose = np.array(self._unpack("<16f"), dtype=np.float64).reshape(4, 4)
            _, _, color, depth = self._unpack("<4Q")
            self._skip(color, self._size)
            yield number, Node(pose.tolist(), self._path, f"frame {number}"), depth

    def _unpack(self, layout: str) -> tuple[int, ...]:
        data = self._stream.read(struct.calcsize(layout))
        if len(data) < struct.calcsize(layout):
            raise self._error("it ends too early")
        return struct.unpack(layout, data)

    def _check(self, length: int, most: int) -> None:
        """Refuse a length that reaches beyond the file."""
        if length > most or self._stream.tell() + length > self._size:
            raise self._error("it ends too early, or a length in it is wrong")

    def _skip(self, length: int, most: int) -> None:
        """Pass over bytes that must be there."""
        self._check(length, most)
        self._stream.seek(length, os.SEEK_CUR)

    def _error(self, message: str) -> InputError:
        return InputError(message, place=self._path, remedy="download the .sens file again")
