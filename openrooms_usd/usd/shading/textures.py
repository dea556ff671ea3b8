"""Pictures on disk or inside USD packages, as arrays. OpenImageIO is imported when one is read."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pxr import Ar

from openrooms_usd import removal, untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.usd.files.diagnostics import plain, reading
from openrooms_usd.usd.shading import udim
from openrooms_usd.usd.shading.surfaces import ColorSpace

# More values than this are refused before they fill the memory: 16,384 x 8,192 RGBA.
_MAX_VALUES: Final = 2**29
# Fewer than these are harmless, whatever the file; no format packs more of them into a byte.
_HARMLESS_VALUES: Final = 2**26
_MOST_RATIO: Final = 4096


@dataclass(frozen=True)
class PictureFacts:
    """What a picture's header says.

    Attributes:
        width: Pixels in a row.
        height: Rows.
        channels: Values in a pixel.
        is_float: Whether values are floating point numbers, which are linear by custom, rather
            than whole numbers, which hold encoded colours.
    """

    width: int
    height: int
    channels: int
    is_float: bool

    @property
    def has_alpha(self) -> bool:
        """Whether the last channel is read as alpha."""
        return self.channels in (2, 4)


def picture_facts(path: str) -> PictureFacts:
    """What a picture's header says, without its pixels.

    Raises:
        InputError: There is no such file, or it is not a picture that can be read.
    """
    with _opened(path) as picture:
        spec = picture.spec()
        is_float = str(spec.format) in ("half", "float", "double")
        return PictureFacts(spec.width, spec.height, spec.nchannels, is_float)


def _shape(path: str) -> tuple[int, int, int]:
    facts = picture_facts(path)
    return facts.height, facts.width, facts.channels


def read_texture(path: str) -> NDArray[np.float32]:
    """Read a picture's stored values, without any colour decoding.

    Args:
        path: A file, or a file inside a package (``/x/y.usdz[0/z.png]``), or tiles of ``udim``.

    Returns:
        (H, W, C) float32, the first row at the top; 8- and 16-bit pixels are in 0..1.

    Raises:
        InputError: There is no such file, or it is not a picture that can be read.
    """
    with _opened(path, weighed=True) as picture:
        pixels = picture.read_image("float")
        if pixels is None or picture.has_error:
            raise InputError(
                f"unreadable picture: {plain(picture.geterror()) or 'it is damaged'}",
                place=path,
                remedy="open it in an image viewer and save it again",
            )
        return np.atleast_3d(np.asarray(pixels, dtype=np.float32))


def read_codes(path: str) -> NDArray[np.uint8] | None:
    """Read the codes of a picture of 8 bits as they are stored.

    Args:
        path: A file, or a file inside a package.

    Returns:
        (H, W, C), the first row at the top; None where it is no such picture or cannot be read:
        `read_texture` then says why.
    """
    try:
        with _opened(path, weighed=True) as picture:
            if str(picture.spec().format) != "uint8":
                return None
            pixels = picture.read_image("uint8")
            if pixels is None or picture.has_error:
                return None
            return np.atleast_3d(np.asarray(pixels, dtype=np.uint8))
    except InputError:
        return None


def texture_size(path: str) -> tuple[int, int]:
    """Width and height of a picture in pixels.

    Raises:
        InputError: There is no such file, or it is not a picture that can be read.
    """
    facts = picture_facts(path)
    return facts.width, facts.height


def color_space(path: str) -> ColorSpace:
    """What ``sourceColorSpace = auto`` means for a file: 8-bit RGB and RGBA are sRGB.

    Raises:
        InputError: There is no such file, or it is not a picture that can be read.
    """
    with _opened(udim.one_of(path)) as picture:
        spec = picture.spec()
        return "sRGB" if str(spec.format) == "uint8" and spec.nchannels >= 3 else "raw"


@contextmanager
def _opened(path: str, *, weighed: bool = False) -> Iterator[Any]:
    """A picture's header, and its pixels where it was weighed whether they are too many."""
    import OpenImageIO

    with local_file(path) as file:
        # An alpha channel must come as it is stored, not multiplied into the colour.
        config = OpenImageIO.ImageSpec()
        config.attribute("oiio:UnassociatedAlpha", 1)
        try:
            picture = OpenImageIO.ImageInput.open(str(file), config)
            if picture is None:
                raise _unreadable(plain(OpenImageIO.geterror()) or "unknown format", path)
            try:
                if weighed:
                    _check_size(picture.spec(), file.stat().st_size, path)
                yield picture
            finally:
                picture.close()
        # Its messages and names quote the file, in whatever bytes.
        except UnicodeDecodeError as error:
            raise _unreadable("its header is no text", path) from error


def _unreadable(reason: str, path: str) -> InputError:
    return InputError(
        f"not a readable picture: {reason}", place=path, remedy="use PNG, JPEG, EXR or HDR"
    )


def _check_size(spec: Any, size: int, path: str) -> None:
    """Refuse what fills the memory, or claims more than its bytes can hold."""
    values = spec.width * spec.height * spec.nchannels
    if not 0 < values <= min(_MAX_VALUES, max(_HARMLESS_VALUES, _MOST_RATIO * size)):
        raise InputError(
            f"{spec.width} x {spec.height} pixels of {spec.nchannels} channels are not read",
            place=path,
            remedy="give a smaller picture",
        )


@contextmanager
def local_file(path: str) -> Iterator[Path]:
    """A plain file with the content of ``path``, which may lie inside a package.

    The file is ``path`` itself, or a temporary copy that lives as long as the ``with`` block.

    Raises:
        InputError: There is no such file, or it is none that a picture could be.
    """
    if udim.is_udim(path):
        with udim.joined(path, _shape, read_codes, read_texture) as file:
            yield file
        return
    if not Ar.IsPackageRelativePath(path):
        untrusted.checked(Path(path), "picture", remedy="check the texture's path")
        yield Path(path)
        return
    untrusted.checked(Path(Ar.SplitPackageRelativePathOuter(path)[0]), "archive")
    with reading(path):
        asset = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(path))
    if asset is None:
        raise InputError("no such file in the package", place=path, remedy="package it again")
    inner = Ar.SplitPackageRelativePathInner(path)[1]
    handle, name = tempfile.mkstemp(suffix=Path(inner).suffix)
    try:
        with os.fdopen(handle, "wb") as copy:
            copy.write(asset.GetBuffer())
        yield Path(name)
    finally:
        removal.remove_file(Path(name))
