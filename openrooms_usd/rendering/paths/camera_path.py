"""A path of a camera: where it is in each frame, for pictures of one size."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.usd.cameras import PinholeCamera


@dataclass(frozen=True, eq=False)
class CameraPath:
    """Poses at a fixed rate.

    Attributes:
        name: What it is called; frames have random numbers by it.
        poses: (F, 4, 4) world_from_camera of each frame, OpenCV frame, metres.
        K: (3, 3) intrinsics in pixels.
        rate: Frames a second.
        exposure: What pictures multiply luminance in nits by; None fits one to the whole path.
    """

    name: str
    poses: Array
    K: Array
    rate: int
    exposure: float | None = None

    def __len__(self) -> int:
        return len(self.poses)

    @property
    def cameras(self) -> Iterator[PinholeCamera]:
        """One a frame: everything is sharp."""
        return (PinholeCamera(self.K, pose, self.exposure) for pose in self.poses)

    def frame_name(self, frame: int) -> str:
        """Sets the random numbers of a frame apart from those of all others."""
        return f"{self.name}/frame_{frame:04d}"


def frame_times(seconds: float, rate: int) -> Array:
    """(F,) seconds of the frames of a path of some length, at least one."""
    return np.arange(max(1, round(seconds * rate))) / rate
