"""Depth pictures of 16 bits, pictures of whole numbers, and the sizes of pictures."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError

_MOST_PIXELS: Final = 1 << 25
_MOST_CHANNELS: Final = 4
# What a picture's header may say of its sides.
_LONGEST_SIDE: Final = 1 << 20


def read_sixteen_bits(path: Path) -> NDArray[np.uint16]:
    """(H, W) the numbers of a picture with one channel of 16 bits.

    Raises:
        InputError: It cannot be read, or is not such a picture.
    """
    with _opened(path) as source:
        spec = source.spec()
        if spec.nchannels != 1 or str(spec.format) != "uint16":
            raise InputError(
                f"one channel of 16 bits expected, not {spec.nchannels} of {spec.format}",
                place=path,
            )
        return np.asarray(_pixels(source, "uint16", path)[:, :, 0], dtype=np.uint16)


def read_picture(path: Path, kind: Literal["uint8", "uint16"]) -> NDArray[Any]:
    """(H, W, C) the numbers of a picture.

    Raises:
        InputError: It cannot be read, or has more pixels than any frame of a scan.
    """
    with _opened(path) as source:
        return _pixels(source, kind, path)


def picture_size(path: Path) -> tuple[int, int]:
    """Width and height, from the picture's header.

    Raises:
        InputError: It cannot be read, or has no sensible size.
    """
    with _opened(path) as source:
        spec = source.spec()
        width, height = int(spec.width), int(spec.height)
    if not (0 < width <= _LONGEST_SIDE and 0 < height <= _LONGEST_SIDE):
        raise InputError(f"a picture of {width} x {height} pixels makes no sense", place=path)
    return width, height


def _pixels(source: Any, kind: str, path: Path) -> NDArray[Any]:
    spec = source.spec()
    if not 0 < spec.width * spec.height <= _MOST_PIXELS or spec.nchannels > _MOST_CHANNELS:
        text = f"{spec.width} x {spec.height} pixels of {spec.nchannels} channels are not read"
        raise InputError(text, place=path)
    values = source.read_image(kind)
    if values is None:
        raise InputError(
            f"cannot read its pixels: {source.geterror()}",
            place=path,
            remedy="download or export it again",
        )
    return np.asarray(values).reshape(spec.height, spec.width, spec.nchannels)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    import OpenImageIO

    untrusted.checked(path, "picture")
    try:
        source = OpenImageIO.ImageInput.open(str(path))
        if source is None:
            reason = (OpenImageIO.geterror().strip().splitlines() or ["its format is not known"])[0]
            raise _unreadable(reason, path)
        try:
            yield source
        finally:
            source.close()
    # Its messages quote the file, in whatever bytes.
    except UnicodeDecodeError as error:
        raise _unreadable("its header is not text", path) from error


def _unreadable(reason: str, path: Path) -> InputError:
    return InputError(f"cannot read the picture: {reason}", place=path, remedy="check the file")
