"""Pictures written by OpenImageIO, whose calls alone do not say that one reached the disk."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Bytes
from openrooms_usd.errors import OutputError

_PNG_END: Final = b"IEND\xaeB\x60\x82"


def write(path: Path, pixels: NDArray[Any], kind: str, attributes: Mapping[str, Any]) -> None:
    """Write the pixels of a picture.

    Args:
        path: The file; its ending says the format.
        pixels: (H, W) or (H, W, C), the first row on top.
        kind: OpenImageIO's name of a value's type, such as ``uint8`` or ``half``.
        attributes: OpenImageIO's, by their names.

    Raises:
        OutputError: It cannot be written.
    """
    import OpenImageIO

    # A plane without a channel axis would be read as rows of channels.
    pixels = np.ascontiguousarray(np.atleast_3d(pixels))
    height, width, channels = pixels.shape
    spec = OpenImageIO.ImageSpec(width, height, channels, kind)
    for name, value in attributes.items():
        spec.attribute(name, value)
    output: Any = OpenImageIO.ImageOutput.create(str(path))
    done = output.open(str(path), spec) and output.write_image(pixels)
    finish(output, done, path)


def write_png(path: Path, pixels: Bytes) -> None:
    """Write 8-bit sRGB pixels, with the same bytes for the same pixels.

    Args:
        path: The file.
        pixels: (height, width, 1 or 3).

    Raises:
        OutputError: The file cannot be written.
    """
    how = {"oiio:ColorSpace": "srgb_rec709_scene", "png:compressionLevel": 4}
    write(path, pixels, "uint8", how)


def finish(output: Any, done: bool, path: Path) -> None:
    """Close an image writer and see that the file is whole.

    On a full disk the writer's calls may all succeed: some failures show only in its error text,
    and that of the last buffer nowhere but in the file.

    Args:
        output: The ``OpenImageIO.ImageOutput``.
        done: Whether every call before succeeded.
        path: The file.

    Raises:
        OutputError: It is not.
    """
    closed = output.close()
    error = output.geterror() or ("" if done and closed else "unknown reason")
    if error or not is_whole(path):
        reason = error.strip().splitlines()[0] if error else "only part of it was written"
        raise OutputError(
            f"cannot write the picture: {reason}",
            place=path,
            remedy="free space, or choose another output folder",
        )


def is_whole(path: Path) -> bool:
    """Whether the end of a picture is there."""
    if path.suffix == ".png":
        # Its reader would complain on standard error.
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - len(_PNG_END)))
            return file.read(len(_PNG_END)) == _PNG_END
    import OpenImageIO

    source: Any = OpenImageIO.ImageInput.open(str(path))
    if source is None:
        OpenImageIO.geterror()
        return False
    last = source.spec().height - 1
    row = source.read_scanlines(last, last + 1, 0, 0, 1, OpenImageIO.FLOAT)
    damaged = bool(source.geterror())
    source.close()
    return row is not None and not damaged
