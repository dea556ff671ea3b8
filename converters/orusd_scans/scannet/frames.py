"""Camera poses and intrinsics of ScanNet: an exported folder, or a ``.sens`` file.

Only numbers are read: pictures are neither decoded nor copied. Poses take points of the camera
(x right, y down, z forward) to the scan, row by row; frames without one hold -inf. ScanNet counts
pixels from the centre of the first one, so half a pixel is added to its principal points.
"""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd import untrusted
from openrooms_usd.arrays import Array
from openrooms_usd.capture import CapturedFrame
from openrooms_usd.errors import InputError
from orusd_scans.formats.depthpicture import picture_size
from orusd_scans.frames import intrinsics, read_frames
from orusd_scans.records.jsonfile import Node
from orusd_scans.scannet.sens import Sens
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
        InputError: It is none of these, or holds nonsense.
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
