"""Photographs as arrays, at the size that appearance is found at."""

from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.appearance.photographs import PosedPhotographs, undistorted
from openrooms_usd.capture import CapturedFrame
from openrooms_usd.errors import InputError
from openrooms_usd.usd.shading.textures import read_codes

_LONGEST_SIDE: Final = 640


def read_pictures(
    photographs: PosedPhotographs, frames: tuple[CapturedFrame, ...]
) -> list[tuple[CapturedFrame, NDArray[np.uint8]]]:
    """Pictures of frames, made straight and small, with their cameras; missing ones are left out.

    Args:
        photographs: Where they lie.
        frames: Which of them.

    Raises:
        InputError: None is there, or one cannot be read.
    """
    found = [
        _straight(frame, file) for frame in frames if (file := photographs.file(frame)) is not None
    ]
    if not found:
        raise InputError(
            "none of the photographs' pictures is there",
            place=photographs.folder,
            remedy="name the file or folder beside which the pictures lie",
        )
    return found


def _straight(frame: CapturedFrame, file: Path) -> tuple[CapturedFrame, NDArray[np.uint8]]:
    codes = read_codes(str(file))
    if codes is None or codes.shape[2] < 3:
        raise InputError("this is not a colour picture of 8 bits", place=file)
    pixels, straight = undistorted(codes[..., :3], frame)
    step = -(-max(straight.resolution) // _LONGEST_SIDE)
    if step == 1:
        return straight, np.ascontiguousarray(pixels)
    height, width = (size // step for size in pixels.shape[:2])
    blocks = pixels[: height * step, : width * step].reshape(height, step, width, step, 3)
    small = np.rint(blocks.mean(axis=(1, 3), dtype=np.float64)).astype(np.uint8)
    K = np.diag([1.0 / step, 1.0 / step, 1.0]) @ straight.K
    return replace(straight, K=K, resolution=(width, height)), small
