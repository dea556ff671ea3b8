"""Words on pictures, in the typeface that OpenImageIO brings along: the same on every machine."""

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Bytes, Floats

Ink = Floats

_TYPEFACE: Final = "DroidSans"
# How far letters such as g reach below the line, relative to the size.
_DESCENT: Final = 0.25


def lettered(text: str, size: int) -> Ink:
    """A line of words.

    Args:
        text: What the typeface lacks is a box.
        size: Of the typeface, pixels: capitals are 0.71 of it high.

    Returns:
        (1.25 size, W) how much of each pixel is inked, 0 to 1; the words stand on the line of row
        ``size``. Nothing is inked where OpenImageIO was built without typefaces.
    """
    import OpenImageIO

    extent: Any = OpenImageIO.ImageBufAlgo.text_size(text, size, _TYPEFACE)
    width = max(1, extent.xend) if extent.defined else 1
    blank = np.zeros((size + math.ceil(_DESCENT * size), width, 1), np.float32)
    page: Any = OpenImageIO.ImageBuf(blank)
    OpenImageIO.ImageBufAlgo.render_text(page, 0, size, text, size, _TYPEFACE, (1.0,))
    page.geterror()
    return np.asarray(page.get_pixels(OpenImageIO.FLOAT)[..., 0], dtype=np.float32)


def stamp(
    pixels: Bytes, ink: NDArray[Any], column: int, row: int, color: tuple[float, ...]
) -> None:
    """Put ink on a picture; what lies beyond its edges is cut off.

    Args:
        pixels: (H, W, 3), changed in place.
        ink: (h, w) how much of each pixel is inked, 0 to 1.
        column: Where the ink's left edge comes.
        row: Where its upper edge comes.
        color: In 0 to 255.
    """
    top, left = max(row, 0), max(column, 0)
    shown = ink[top - row :, left - column :]
    page = pixels[top : top + shown.shape[0], left : left + shown.shape[1]]
    share = shown[: page.shape[0], : page.shape[1], None]
    page[:] = np.round(page + share * (np.array(color) - page))
