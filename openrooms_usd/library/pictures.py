"""Writing pictures: whole or not at all, and without anything that differs between runs."""

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import atomic, imagefile
from openrooms_usd.arrays import Bytes, Floats

# PNG_FILTER_UP of libpng: rows are stored as their differences from those above.
_PNG_FILTER_UP: Final = 0x20


def write_png(
    path: Path, pixels: Bytes | NDArray[np.uint16], *, is_color: bool, description: str = ""
) -> None:
    """Write pixels of eight or sixteen bits.

    Args:
        path: Where.
        pixels: (H, W) or (H, W, 3), the first row on top.
        is_color: Whether they are sRGB-encoded colours; data carry no colour profile.
        description: What the values mean, for those who open the file alone.

    Raises:
        OutputError: It cannot be written.
    """
    attributes: dict[str, Any] = {
        "oiio:ColorSpace": "sRGB" if is_color else "data",
        # More effort takes a third more time and saves a twentieth.
        "png:compressionLevel": 2,
        # Trying all filters for each row takes twice the time and saves a hundredth.
        "png:filter": _PNG_FILTER_UP,
    }
    if description:
        attributes["ImageDescription"] = description
    _write(path, pixels, str(pixels.dtype), attributes)


def write_exr(path: Path, pixels: Floats, *, half: bool = False) -> None:
    """Write scene-linear Rec.709 pixels.

    Args:
        path: Where.
        pixels: (H, W, 3), the first row on top.
        half: Sixteen bits a value: smaller, up to 65,504 and with three digits.

    Raises:
        OutputError: It cannot be written.
    """
    attributes: dict[str, Any] = {
        "oiio:ColorSpace": "lin_rec709_scene",
        "compression": "zip",
        # Otherwise the writer adds the time of day.
        "DateTime": "",
    }
    _write(path, pixels, "half" if half else "float", attributes)


def _write(path: Path, pixels: NDArray[Any], kind: str, attributes: dict[str, Any]) -> None:
    with atomic.replacing(path) as beside:
        imagefile.write(beside, pixels, kind, attributes)
