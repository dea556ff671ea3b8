"""The files of one raw frame of SUN RGB-D: its calibration, and boxes drawn as polygons.

As ``readframeSUNRGBD.m`` of the dataset's toolbox reads them: a box is the polygon of its base in
the coordinates X and Z of upright depth (x right, y forward), from -Ymax to -Ymin; its front is the
side between the first two corners.
"""

import math
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import untrusted
from openrooms_usd.capture import CapturedBox
from orusd_scans.frames import intrinsics
from orusd_scans.records.fields import number, text
from orusd_scans.records.jsonfile import Node, read_json
from orusd_scans.scanned import broken
from orusd_scans.sunrgbd.files import facing
from orusd_scans.worldframe import proper

Array = NDArray[np.float64]

_MAX_SIZE_M: Final = 1e3  # metres
_STRUCTURE: Final = ("wall", "floor", "ceiling")


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
        raise node.error("a side of the box is not above zero", "mend the annotation")
    middle = 0.5 * (corners[0] + corners[2])
    front = 0.5 * (corners[0] + corners[1]) - middle
    center = np.array([*middle, 0.5 * (high + low)])
    return facing(identifier, name, center, size, math.atan2(front[1], front[0]))


def _words(path: Path) -> list[float]:
    try:
        return [float(word) for word in untrusted.read_text(path).split()]
    except ValueError as error:
        raise broken(path, f"numbers are expected: {error}") from error
