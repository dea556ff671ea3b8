"""Small pictures in every format, written by OpenImageIO."""

from pathlib import Path
from typing import Any

import numpy as np


def write_picture(path: Path, pixels: np.ndarray, **attributes: Any) -> None:
    """Write (height, width, components) in the format that the name says."""
    import OpenImageIO

    path.parent.mkdir(parents=True, exist_ok=True)
    height, width, depth = pixels.shape
    spec = OpenImageIO.ImageSpec(width, height, depth, str(pixels.dtype))
    for key, value in attributes.items():
        spec.attribute(key, value)
    output = OpenImageIO.ImageOutput.create(str(path))
    if output is None or not output.open(str(path), spec):
        raise RuntimeError(f"{path}: {OpenImageIO.geterror()}")
    output.write_image(np.ascontiguousarray(pixels))
    output.close()


def ramp(size: int = 16, depth: int = 3) -> np.ndarray:
    """Colours that differ from pixel to pixel, 8 bits."""
    values = np.arange(size * size * depth) * 251 % 256
    return values.reshape(size, size, depth).astype(np.uint8)


def panorama(height: int = 8) -> np.ndarray:
    """A bright sky over a dark ground, floating point."""
    rows = np.linspace(4.0, 0.1, height, dtype=np.float32)[:, None, None]
    return np.tile(rows, (1, 2 * height, 3))
