"""ScanNet's frames: a folder that the SensReader exported, or a ``.sens`` file."""

from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd.appearance.photographs import PosedPhotographs
from openrooms_usd.capture import CapturedFrame
from orusd_scans.formats.depthpicture import picture_size
from orusd_scans.frames import intrinsics
from orusd_scans.records import Node
from orusd_scans.scannet.frames import centred, matrix, read_scannet_frames

_POSES: Final = "pose"
_DEPTH_K: Final = "intrinsic/intrinsic_depth.txt"
# Depth that is farther off in the corners, in shares of the width, shows something else.
_MOST_OFF: Final = 0.02


class ScanNetPhotographs:
    """Reads an exported folder, a ``.sens`` file, or a folder with one."""

    reads = "a .sens file or its exported color/, depth/, pose/, intrinsic/ (ScanNet)"

    def recognises(self, path: Path) -> bool:
        """Whether there are ScanNet's frames."""
        if path.is_dir():
            exported = (path / _POSES).is_dir() and (path / "intrinsic").is_dir()
            return exported or len(list(path.glob("*.sens"))) == 1
        return path.suffix.lower() == ".sens"

    def read(self, path: Path) -> PosedPhotographs:
        """Read the frames that did not lose track.

        Raises:
            InputError: A file is missing, cut off or holds nonsense.
        """
        notes: list[str] = []
        frames = read_scannet_frames(path, notes)
        folder = path if path.is_dir() else path.parent
        if frames and not any(frame.picture for frame in frames):
            notes.append("the pictures are not in a folder: export them with ScanNet's SensReader")
        if (folder / _DEPTH_K).is_file():
            frames = _with_depth(folder, frames, notes)
        return PosedPhotographs(frames, folder, "scannet", True, True, tuple(notes))


def _with_depth(
    folder: Path, frames: tuple[CapturedFrame, ...], notes: list[str]
) -> tuple[CapturedFrame, ...]:
    """Frames with their depth maps, where these show the same as the pictures."""
    names = [f"depth/{frame.id}.png" for frame in frames]
    there = [(folder / name).is_file() for name in names]
    if not any(there):
        return frames
    off = _mismatch(folder, frames[0], folder / names[there.index(True)])
    if off > _MOST_OFF:
        notes.append("the depth camera does not show what the pictures show: depth is left out")
        return frames
    if off > 0.0:
        notes.append(f"depth is up to {off:.1%} of the picture's width off: it has its own camera")
    return tuple(
        replace(frame, depth=name) if found else frame
        for frame, name, found in zip(frames, names, there, strict=True)
    )


def _mismatch(folder: Path, frame: CapturedFrame, depth: Path) -> float:
    """How far corners of the depth map are off in the picture, in shares of its width."""
    path = folder / _DEPTH_K
    K = centred(intrinsics(Node(matrix(path, 4)[:3, :3].tolist(), path)))
    size, own = picture_size(depth), frame.resolution
    corners = np.array([[x, y, 1.0] for x in (0.0, size[0]) for y in (0.0, size[1])])
    shown = corners @ np.linalg.inv(K).T @ frame.K.T
    meant = corners[:, :2] * (own[0] / size[0], own[1] / size[1])
    return float(np.abs(shown[:, :2] - meant).max() / own[0])
