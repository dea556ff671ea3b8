"""Photographs as arrays, at the size that appearance is found at."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.appearance.photographs import PosedPhotographs, undistorted
from openrooms_usd.arrays import Array
from openrooms_usd.capture import CapturedFrame
from openrooms_usd.errors import InputError
from openrooms_usd.usd.shading.textures import read_codes, read_texture

_LONGEST_SIDE: Final = 640
# The largest number of 16 bits: depth cameras write it where they know nothing, beside 0.
_NO_DEPTH: Final = 65535


@dataclass(frozen=True, eq=False)
class TakenPicture:
    """A photograph without distortion, at the size that is worked at.

    Attributes:
        frame: Its camera.
        pixels: (H, W, 3) as the file has them.
        depth: (H', W') metres along the optical axis, 0 unknown; None without a depth map.
    """

    frame: CapturedFrame
    pixels: NDArray[np.uint8]
    depth: Array | None = None


def read_pictures(
    photographs: PosedPhotographs, frames: tuple[CapturedFrame, ...]
) -> list[TakenPicture]:
    """Pictures of frames, made straight and small, with their cameras; missing ones are left out.

    Args:
        photographs: Where they lie.
        frames: Which of them.

    Raises:
        InputError: None is there, or one cannot be read.
    """
    found = [
        _straight(frame, file, photographs.depth_file(frame))
        for frame in frames
        if (file := photographs.file(frame)) is not None
    ]
    if not found:
        raise InputError(
            "none of the photographs' pictures is there",
            place=photographs.folder,
            remedy="name the file or folder beside which the pictures lie",
        )
    return found


def _straight(frame: CapturedFrame, file: Path, depth_file: Path | None) -> TakenPicture:
    codes = read_codes(str(file))
    if codes is None or codes.shape[2] < 3:
        raise InputError("this is not a colour picture of 8 bits", place=file)
    pixels, straight = undistorted(codes[..., :3], frame)
    depth = None if depth_file is None else _depth(frame, depth_file)
    step = -(-max(straight.resolution) // _LONGEST_SIDE)
    height, width = (size // step for size in pixels.shape[:2])
    blocks = pixels[: height * step, : width * step].reshape(height, step, width, step, 3)
    small = np.rint(blocks.mean(axis=(1, 3), dtype=np.float64)).astype(np.uint8)
    K = np.diag([1.0 / step, 1.0 / step, 1.0]) @ straight.K
    return TakenPicture(replace(straight, K=K, resolution=(width, height)), small, depth)


def _depth(frame: CapturedFrame, file: Path) -> Array | None:
    """Metres, of the same field of view as the picture; None where the lens bends it."""
    if frame.distortion or frame.fisheye:
        return None
    counts = np.rint(read_texture(str(file))[..., 0].astype(np.float64) * _NO_DEPTH)
    known = (counts > 0) & (counts < _NO_DEPTH)
    return np.where(known, counts * frame.depth_unit, 0.0)
