"""Sequences of the TUM RGB-D benchmark: ``rgb.txt``, ``depth.txt`` and ``groundtruth.txt``.

Lines are a time in seconds, then a file, or a position and a quaternion x y z w of the camera
(x right, y down, z forward) in the world, metres, Z up. Times of the three differ: the nearest
counts, within 20 ms. (Sturm et al., "A Benchmark for the Evaluation of RGB-D SLAM Systems", IROS
2012.)
"""

from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd import untrusted
from openrooms_usd.appearance.photographs import PosedPhotographs
from openrooms_usd.arrays import Array
from openrooms_usd.capture import CapturedFrame
from openrooms_usd.geometry.quaternions import pose_of
from orusd_scans.posed.pictures import (
    intrinsics_near,
    left_out,
    name_inside,
    pinhole,
    size_of_first,
)
from orusd_scans.records import Node
from orusd_scans.scanned import broken, line_of_numbers

_PICTURES, _DEPTH, _POSES = "rgb.txt", "depth.txt", "groundtruth.txt"
_SAME_MOMENT_S: Final = 0.02
_LATEST_S: Final = 1e11
_DEPTH_UNIT_M: Final = 1.0 / 5000.0
_UNIT_TOLERANCE: Final = 1e-2
# The benchmark's calibrations of its cameras (fx, fy, cx, cy from the first pixel's centre; k1 k2
# p1 p2 k3), by a word of the sequence's name, and what it gives for any other.
_CAMERAS: Final[dict[str, tuple[tuple[float, float, float, float], tuple[float, ...]]]] = {
    "freiburg1": ((517.3, 516.5, 318.6, 255.3), (0.2624, -0.9531, -0.0054, 0.0026, 1.1633)),
    "freiburg2": ((520.9, 521.0, 325.1, 249.7), (0.2312, -0.7849, -0.0033, -0.0001, 0.9172)),
    "freiburg3": ((535.4, 539.2, 320.1, 247.6), ()),
}
_USUAL: Final = (525.0, 525.0, 319.5, 239.5)


class TumPhotographs:
    """Reads the folder of a sequence."""

    reads = "a folder with rgb.txt and groundtruth.txt (TUM RGB-D)"

    def recognises(self, path: Path) -> bool:
        """Whether there are the lists of a sequence."""
        return (path / _PICTURES).is_file() and (path / _POSES).is_file()

    def read(self, path: Path) -> PosedPhotographs:
        """Read the pictures that have a pose.

        Raises:
            InputError: A list is missing or holds nonsense, or no picture is there.
        """
        pictures, depths = _listed(path / _PICTURES, path), _listed(path / _DEPTH, path)
        poses = _poses(path / _POSES)
        K, lens, notes = _camera(path)
        size = size_of_first(path, (name for _, name in pictures))
        times = np.array([time for time, _ in depths])
        frames = []
        for time, name in pictures:
            row, at = _nearest(poses[:, 0], time), _nearest(times, time)
            if row is not None:
                pose = pose_of(poses[row, 1:4], poses[row, 4:8])
                depth = None if at is None else depths[at][1]
                frames.append(
                    CapturedFrame(
                        f"{time:.6f}", pose, K, size, name, lens, False, depth, _DEPTH_UNIT_M
                    )
                )
        notes += left_out(len(pictures) - len(frames), len(pictures))
        return PosedPhotographs(tuple(frames), path, "tum", True, True, tuple(notes))


def _camera(path: Path) -> tuple[Array, tuple[float, ...], list[str]]:
    """Intrinsics, distortion, and where they are from."""
    own = intrinsics_near(path)
    if own is not None:
        return own, (), []
    word = next((word for word in _CAMERAS if word in path.resolve().name), None)
    numbers, lens = _CAMERAS[word] if word else (_USUAL, ())
    fx, fy, cx, cy = numbers
    K = pinhole(fx, fy, cx + 0.5, cy + 0.5, Node(None, path))
    known = f"those of {word}" if word else "the usual ones (525 pixels)"
    return K, lens, [f"no intrinsics are here: {known} count"]


def _listed(path: Path, folder: Path) -> list[tuple[float, str]]:
    """Times and names of files, in the order of time."""
    if path.name == _DEPTH and not path.is_file():
        return []
    found = []
    for number, line in _lines(path):
        time, _, name = line.strip().partition(" ")
        node = Node(None, path, f"line {number + 1}")
        seconds = float(line_of_numbers(time, 1, path, number, _LATEST_S)[0])
        found.append((seconds, name_inside(folder, name.strip(), node)))
    return sorted(found)


def _poses(path: Path) -> Array:
    """(N, 8) seconds, position, quaternion x y z w; ascending."""
    rows = [line_of_numbers(line, 8, path, number, _LATEST_S) for number, line in _lines(path)]
    if not rows:
        raise broken(path, "it holds no poses")
    table = np.array(rows)
    if (np.abs(np.linalg.norm(table[:, 4:8], axis=1) - 1.0) > _UNIT_TOLERANCE).any():
        raise broken(path, "a quaternion is not of unit length")
    return np.asarray(table[np.argsort(table[:, 0], kind="stable")])


def _lines(path: Path) -> list[tuple[int, str]]:
    lines = enumerate(untrusted.read_text(path, "table").splitlines())
    return [(n, line) for n, line in lines if line.strip() and not line.lstrip().startswith("#")]


def _nearest(times: Array, time: float) -> int | None:
    """The nearest of ascending times, where one is near enough."""
    after = int(np.searchsorted(times, time))
    near = [i for i in (after - 1, after) if 0 <= i < len(times)]
    best = min(near, key=lambda i: abs(times[i] - time), default=None)
    return best if best is not None and abs(times[best] - time) <= _SAME_MOMENT_S else None
