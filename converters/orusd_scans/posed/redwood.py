"""Folders as of Redwood and Open3D: ``color/``, ``depth/`` and a trajectory ``*.log``.

A trajectory has three whole numbers, then a pose of 4 x 4 numbers for each frame, from the camera
(x right, y down, z forward) to the world, metres. The world is that of the first frame, so which
way is up is not known. (Choi, Zhou and Koltun, "Robust Reconstruction of Indoor Scenes", CVPR
2015.)
"""

from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd.appearance.photographs import PosedPhotographs
from openrooms_usd.capture import CapturedFrame
from openrooms_usd.errors import InputError
from orusd_scans.posed.pictures import (
    files_of,
    intrinsics_near,
    left_out,
    numbers_of,
    pinhole,
    size_of_first,
    tracked,
)
from orusd_scans.records import Node
from orusd_scans.scanned import broken

_COLORS: Final = ("color", "image", "rgb")
_DEPTH: Final = "depth"
_LOGS: Final = ("*.log", "scene/trajectory.log")
_ROW: Final = 19
_USUAL: Final = (525.0, 525.0, 320.0, 240.0)


class RedwoodPhotographs:
    """Reads the folder of a scan with its trajectory."""

    reads = "a folder with color/, depth/ and a trajectory .log (Redwood, Open3D)"

    def recognises(self, path: Path) -> bool:
        """Whether there are pictures and a trajectory."""
        return path.is_dir() and bool(_logs(path)) and _colors(path) is not None

    def read(self, path: Path) -> PosedPhotographs:
        """Read the pictures that have a pose.

        Raises:
            InputError: The trajectory holds nonsense, or pictures and depth maps do not match.
        """
        logs, colors = _logs(path), _colors(path)
        if len(logs) != 1 or colors is None:
            told = f"{len(logs)} trajectories (*.log) are here, and one is needed beside color/"
            raise InputError(told, place=path, remedy="leave the one that belongs to the pictures")
        poses = _poses(logs[0])
        pictures, depths = files_of(colors), files_of(path / _DEPTH, (".png",))
        if depths and len(depths) != len(pictures):
            raise InputError(
                f"{len(pictures)} pictures and {len(depths)} depth maps do not match",
                place=path,
                remedy="leave one depth map for each picture",
            )
        K, notes = intrinsics_near(path), list[str]()
        if K is None:
            K = pinhole(*_USUAL, Node(None, path))
            notes.append("no intrinsics are here: the usual ones count (525 pixels)")
        names = [f"{colors.name}/{file.name}" for file in pictures]
        size = size_of_first(path, names)
        frames = []
        for number, node in poses:
            if number >= len(pictures):
                raise node.error(f"there is no picture {number}: {len(pictures)} are here")
            pose = tracked(node)
            depth = f"{_DEPTH}/{depths[number].name}" if depths else None
            if pose is not None:
                name = names[number]
                frames.append(
                    CapturedFrame(pictures[number].stem, pose, K, size, name, depth=depth)
                )
        notes += left_out(len(pictures) - len(frames), len(pictures))
        return PosedPhotographs(tuple(frames), path, "redwood", True, False, tuple(notes))


def _logs(path: Path) -> list[Path]:
    return next((found for kind in _LOGS if (found := sorted(path.glob(kind)))), [])


def _colors(path: Path) -> Path | None:
    return next((path / name for name in _COLORS if (path / name).is_dir()), None)


def _poses(path: Path) -> list[tuple[int, Node]]:
    """The number of the picture and the pose of each row."""
    numbers = numbers_of(path, "table")
    if not numbers or len(numbers) % _ROW:
        raise broken(path, f"each pose has 3 + 16 numbers: {len(numbers)} are here")
    table = np.array(numbers).reshape(-1, _ROW)
    # The first two are the same; the third is a number of frames.
    first = table[:, 0]
    if not np.isfinite(first).all() or (first < 0).any() or (first % 1 != 0).any():
        raise broken(path, "each pose begins with the number of its picture")
    if len(set(first)) != len(first):
        raise broken(path, "two poses are of the same picture")
    return [(int(row[0]), Node(row[3:].tolist(), path, f"pose {i}")) for i, row in enumerate(table)]
