"""The photographs of a capture: a plain JSON list of camera poses and intrinsics.

::

    [{"id": "12", "picture": "color/12.jpg", "resolution": [1296, 968],
      "K": [[1170, 0, 648], [0, 1170, 484], [0, 0, 1]],
      "world_from_camera": [[1, 0, 0, 2.5], [0, 0, 1, 1.0], [0, -1, 0, 1.4], [0, 0, 0, 1]]}]

Cameras look along +z with x to the right and y down (OpenCV). ``world_from_camera`` is row by row,
in the frame and the unit of the capture; K is in pixels, and the centre of the top-left pixel is
(0.5, 0.5). A frame may have ``distortion``, ``fisheye``, ``depth`` and ``depth_unit``, too.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.capture import NO_OPTIONS, CapturedFrame, Packed
from orusd_scans.records import Node, flag, identifiers, positive, read_json, text
from orusd_scans.worldframe import WorldFrame, rigid

# Focal lengths, principal points and sides of pictures, pixels.
_MAX_PIXELS: Final = 1e6
_MAX_COEFFICIENT: Final = 1e6
_LENS_COUNTS: Final = (0, 4, 5, 8)
_FISHEYE_COUNTS: Final = (0, 4)
_MAY_HAVE: Final = ("distortion", "fisheye", "depth", "depth_unit")
_REMEDY: Final = "write [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], in pixels"
# Beyond this, pixels are not square any more: USD's cameras and ours have square ones.
_SQUARE_PIXEL_TOLERANCE: Final = 5e-3


def read_frames(path: Path) -> tuple[CapturedFrame, ...]:
    """Read the frames of a JSON file, still in the frame and the unit of the capture.

    Raises:
        InputError: It is missing, or holds nonsense; names the place.
    """
    root = read_json(path)
    if isinstance(root.value, list):
        root = Node({"": root.value}, path)
        return frames_of(root.items(""))
    return frames_of(root.items("frames"))


def frames_of(nodes: Sequence[Node]) -> tuple[CapturedFrame, ...]:
    """The frames of a list of records, still in the frame and the unit of the capture.

    Raises:
        InputError: A field is missing or absurd, or an identifier repeats.
    """
    ids = identifiers(nodes, "")
    return tuple(_frame(node, id_) for node, id_ in zip(nodes, ids, strict=True))


def _frame(node: Node, identifier: str) -> CapturedFrame:
    picture, size = node.get("picture"), node.need("resolution")
    width, height = size.numbers(2, _MAX_PIXELS)
    if min(width, height) < 1 or width % 1 or height % 1:
        raise size.error("width and height in whole pixels expected", "such as [1296, 968]")
    return CapturedFrame(
        id=identifier,
        world_from_camera=rigid(node.need("world_from_camera")),
        K=intrinsics(node.need("K")),
        resolution=(int(width), int(height)),
        picture=text(picture) if picture else None,
        **_more(node),
    )


def _more(node: Node) -> dict[str, Any]:
    """The fields that a frame may have: its lens and its depth map."""
    lens, fisheye, depth, unit = (node.get(key) for key in _MAY_HAVE)
    found: dict[str, Any] = {}
    if fisheye is not None:
        found["fisheye"] = flag(fisheye)
    if lens is not None:
        counts = _FISHEYE_COUNTS if found.get("fisheye") else _LENS_COUNTS
        count = len(lens.value) if isinstance(lens.value, list) else -1
        if count not in counts:
            known = ", ".join(map(str, counts))
            raise lens.error(f"a lens has one of {known} coefficients", "write k1 k2 p1 p2 ...")
        found["distortion"] = tuple(lens.numbers(count, _MAX_COEFFICIENT).tolist())
    if depth is not None:
        found["depth"] = text(depth)
    if unit is not None:
        found["depth_unit"] = positive(unit, 1e3)
    return found


def intrinsics(node: Node) -> Array:
    """A node's (3, 3) intrinsics in pixels, row by row.

    Raises:
        InputError: They are invalid, or column-major.
    """
    K = node.numbers(9, _MAX_PIXELS).reshape(3, 3)
    if np.abs(K[2] - [0.0, 0.0, 1.0]).max() > 1e-9:
        raise node.error("the last row of intrinsics is 0 0 1", _REMEDY)
    if K[0, 0] <= 0.0 or K[1, 1] <= 0.0:
        raise node.error("a focal length is not positive", _REMEDY)
    return np.asarray(K)


def in_world(
    frames: Iterable[CapturedFrame], frame: WorldFrame, notes: list[str]
) -> tuple[CapturedFrame, ...]:
    """Frames with their cameras in the world, metres.

    Args:
        frames: As they were read.
        frame: Transform to the world.
        notes: Receives a sentence when pixels are not square.
    """
    found = tuple(replace(f, world_from_camera=frame.pose(f.world_from_camera)) for f in frames)
    oblong = sum(
        abs(f.K[1, 1] / f.K[0, 0] - 1.0) > _SQUARE_PIXEL_TOLERANCE or f.K[0, 1] != 0.0
        for f in found
    )
    if oblong:
        notes.append(f"{oblong} frames have skew or pixels that are not square: fx counts for both")
    return found


def as_text(frames: Iterable[CapturedFrame]) -> bytes:
    """Frames as a JSON file that `read_frames` reads back as the same frames."""
    return (json.dumps(as_plain(frames), indent=1, allow_nan=False) + "\n").encode()


def as_plain(frames: Iterable[CapturedFrame]) -> list[dict[str, Any]]:
    """Frames as data that `read_frames` reads back as the same frames."""
    return [
        {
            "id": frame.id,
            "picture": frame.picture,
            "resolution": list(frame.resolution),
            "K": frame.K.tolist(),
            "world_from_camera": frame.world_from_camera.tolist(),
            **{key: getattr(frame, key) for key in _MAY_HAVE if _differs(frame, key)},
        }
        for frame in frames
    ]


def _differs(frame: CapturedFrame, key: str) -> bool:
    """Whether a field that a frame may have is not the usual one."""
    return bool(getattr(frame, key) != getattr(CapturedFrame, key))


# The files of a scan that lie in folders, as far as a room needs them.


def packed_folder(
    root: Path,
    files: Iterable[Path | None],
    options: Mapping[str, str] = NO_OPTIONS,
    name: str | None = None,
    more: Mapping[str, bytes | Path] | None = None,
) -> Packed:
    """Files below a folder, as a folder of the same shape that lies beside a description.

    Args:
        root: The folder.
        files: What of it is needed; None is passed over.
        options: Of the importer that reads them.
        name: Name of the folder there; by default its own.
        more: Further files beside it, by path.
    """
    name = name or root.resolve().name
    inside = {f"{name}/{p.relative_to(root).as_posix()}": p for p in files if p is not None}
    return Packed(name, inside | dict(more or {}), options)


def there(*files: Path) -> list[Path]:
    """The existing ones of some files."""
    return [file for file in files if file.is_file()]
