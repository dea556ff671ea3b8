"""Depth pictures of 16 bits, and the sizes of pictures."""

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError

_MOST_PIXELS: Final = 1 << 25


def read_sixteen_bits(path: Path) -> NDArray[np.uint16]:
    """(H, W) the numbers of a picture with one channel of 16 bits.

    Raises:
        InputError: It cannot be read, or is no such picture.
    """
    source = _opened(path)
    try:
        spec = source.spec()
        if spec.nchannels != 1 or str(spec.format) != "uint16":
            raise InputError(
                f"one channel of 16 bits expected, not {spec.nchannels} of {spec.format}",
                place=path,
            )
        if spec.width * spec.height > _MOST_PIXELS:
            raise InputError(f"{spec.width}x{spec.height} pixels are too many", place=path)
        values = source.read_image("uint16")
        if values is None:
            raise InputError(
                f"cannot read its pixels: {source.geterror()}",
                place=path,
                remedy="download or export it again",
            )
        return np.asarray(values, dtype=np.uint16).reshape(spec.height, spec.width)
    finally:
        source.close()


def picture_size(path: Path) -> tuple[int, int]:
    """Width and height, from the picture's header.

    Raises:
        InputError: It cannot be read.
    """
    source = _opened(path)
    spec = source.spec()
    source.close()
    return int(spec.width), int(spec.height)


def _opened(path: Path) -> Any:
    import OpenImageIO

    source = OpenImageIO.ImageInput.open(str(path)) if path.is_file() else None
    if source is None:
        reason = OpenImageIO.geterror() or "it is not there"
        raise InputError(f"cannot read the picture: {reason}", place=path, remedy="check the path")
    return source
