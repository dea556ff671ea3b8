"""Folders as of 7-Scenes: ``frame-N.color.*``, ``frame-N.depth.png`` and ``frame-N.pose.txt``.

Poses take points of the camera (x right, y down, z forward) to the world, metres. The world is that
of the first frame, so which way is up is not known. (Shotton et al., "Scene Coordinate Regression
Forests for Camera Relocalization in RGB-D Images", CVPR 2013.)
"""

from pathlib import Path
from typing import Final

from openrooms_usd.appearance.photographs import PosedPhotographs
from openrooms_usd.capture import CapturedFrame
from orusd_scans.posed.pictures import (
    PICTURES,
    intrinsics_near,
    left_out,
    pinhole,
    pose_of,
    size_of_first,
    tracked,
)
from orusd_scans.records import Node

_POSES: Final = ("*.pose.txt", "seq-*/*.pose.txt")
_ENDING: Final = ".pose.txt"
# What the data set documents for its 640 x 480 pictures.
_USUAL: Final = (585.0, 585.0, 320.0, 240.0)


class SevenScenesPhotographs:
    """Reads a sequence, or a scene with ``seq-*`` in it."""

    reads = "a folder of frame-N.color, .depth.png and .pose.txt (7-Scenes)"

    def recognises(self, path: Path) -> bool:
        """Whether there are such poses."""
        return path.is_dir() and any(next(path.glob(kind), None) for kind in _POSES)

    def read(self, path: Path) -> PosedPhotographs:
        """Read all frames.

        Raises:
            InputError: A pose or the intrinsics hold nonsense, or no picture is there.
        """
        poses = _poses(path)
        names = [file.relative_to(path).as_posix().removesuffix(_ENDING) for file in poses]
        pictures = [_picture(path, name) for name in names]
        size = size_of_first(path, pictures)
        K, notes = intrinsics_near(path), list[str]()
        if K is None:
            K = pinhole(*_USUAL, Node(None, path))
            notes.append("no intrinsics are here: the usual ones of 7-Scenes count (585 pixels)")
        frames = []
        for file, name, picture in zip(poses, names, pictures, strict=True):
            pose, deep = tracked(pose_of(file)), path / f"{name}.depth.png"
            if pose is not None:
                depth = deep.relative_to(path).as_posix() if deep.is_file() else None
                frames.append(CapturedFrame(name, pose, K, size, picture, depth=depth))
        notes += left_out(len(poses) - len(frames), len(poses))
        return PosedPhotographs(tuple(frames), path, "sevenscenes", True, False, tuple(notes))


def _poses(folder: Path) -> list[Path]:
    """The files of the poses, in the order of the frames."""
    found = (sorted(folder.glob(kind)) for kind in _POSES)
    return next((files for files in found if files), [])


def _picture(folder: Path, name: str) -> str | None:
    names = (f"{name}.color{ending}" for ending in PICTURES)
    return next((picture for picture in names if (folder / picture).is_file()), None)
