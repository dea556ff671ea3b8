"""Pictures written by OpenImageIO alone."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
from numpy.typing import NDArray


def save_picture(
    path: Path, pixels: NDArray[Any], kind: str = "", *, names: Sequence[str] = ()
) -> str:
    """Write (H, W, C) pixels, top row first, to a file whose format its suffix says.

    They are stored as a ``kind``, or as bytes or floats, as they are; alpha is not multiplied in.
    """
    height, width, channels = pixels.shape
    kind = kind or ("uint8" if pixels.dtype == np.uint8 else "float")
    spec = OpenImageIO.ImageSpec(width, height, channels, kind)
    spec.attribute("oiio:UnassociatedAlpha", 1)
    if names:
        spec.channelnames = tuple(names)
    file: Any = OpenImageIO.ImageOutput.create(str(path))
    assert file.open(str(path), spec)
    assert file.write_image(np.ascontiguousarray(pixels)) and file.close()
    return str(path)
