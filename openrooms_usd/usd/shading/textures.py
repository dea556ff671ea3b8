"""Pictures on disk or inside USD packages, as arrays. OpenImageIO is imported when one is read."""

import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray
from pxr import Ar, Usd, UsdShade

from openrooms_usd import imagefile, removal, untrusted
from openrooms_usd.arrays import Bytes, Floats
from openrooms_usd.errors import InputError
from openrooms_usd.scratch import scratch_folder
from openrooms_usd.usd.files.diagnostics import plain, reading
from openrooms_usd.usd.shading.surfaces import ColorSpace

# More values than this are refused before they fill the memory: 16,384 x 8,192 RGBA.
_MAX_VALUES: Final = 2**29
# Fewer than these are harmless, whatever the file; no format packs more of them into a byte.
_HARMLESS_VALUES: Final = 2**26
_MOST_RATIO: Final = 4096
# Enough to tell what else a file may be.
_HEAD_BYTES: Final = 512


@dataclass(frozen=True)
class PictureFacts:
    """What a picture's header says.

    Attributes:
        width: Pixels in a row.
        height: Rows.
        channels: Values in a pixel.
        is_float: Whether values are floating point numbers, which are linear by custom, rather
            than whole numbers, which hold encoded colours.
        is_8_bit: Whether values are whole numbers of 8 bits.
    """

    width: int
    height: int
    channels: int
    is_float: bool
    is_8_bit: bool

    @property
    def has_alpha(self) -> bool:
        """Whether the last channel is read as alpha."""
        return self.channels in (2, 4)


def picture_facts(path: str) -> PictureFacts:
    """What a picture's header says, without its pixels.

    Raises:
        InputError: There is no such file, or it is not a picture that can be read.
    """
    stamp = _stamp(path)
    return _facts(path) if stamp is None else _known_facts(path, stamp)


def _stamp(path: str) -> tuple[int, ...] | None:
    """What changes with a file, or with its package; None where there is none."""
    outer = Ar.SplitPackageRelativePathOuter(path)[0] if Ar.IsPackageRelativePath(path) else path
    try:
        about = Path(outer).stat()
    except (OSError, ValueError):
        return None
    return about.st_ino, about.st_mtime_ns, about.st_size


@lru_cache(maxsize=4096)
def _known_facts(path: str, _stamp: tuple[int, ...]) -> PictureFacts:
    """Many materials ask the same of one picture."""
    return _facts(path)


def _facts(path: str) -> PictureFacts:
    with _opened(path) as picture:
        spec = picture.spec()
        kind = str(spec.format)
        is_float = kind in ("half", "float", "double")
        return PictureFacts(spec.width, spec.height, spec.nchannels, is_float, kind == "uint8")


def _shape(path: str) -> tuple[int, int, int]:
    facts = picture_facts(path)
    return facts.height, facts.width, facts.channels


def read_texture(path: str) -> Floats:
    """Read a picture's stored values, without any colour decoding.

    Args:
        path: A file, or a file inside a package (``/x/y.usdz[0/z.png]``), or tiles (UDIM).

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


def read_codes(path: str) -> Bytes | None:
    """Read the codes of a picture of 8 bits as they are stored.

    Args:
        path: A file, or a file inside a package.

    Returns:
        (H, W, C), the first row at the top; None if it is not such a picture or cannot be read:
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
    facts = picture_facts(one_of(path))
    return "sRGB" if facts.is_8_bit and facts.channels >= 3 else "raw"


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
                reason = plain(OpenImageIO.geterror()) or "unknown format"
                raise _unreadable(_instead(file) or f"not a readable picture: {reason}", path)
            try:
                if weighed:
                    _check_size(picture.spec(), file.stat().st_size, path)
                yield picture
            finally:
                picture.close()
        # Its messages and names quote the file, in whatever bytes.
        except UnicodeDecodeError as error:
            why = "not a readable picture: its header is not text"
            raise _unreadable(why, path) from error


def _instead(file: Path) -> str:
    """What a file is instead of a picture; empty if it is not one of the usual mistakes."""
    with untrusted.opened(file, "picture") as stream:
        head = stream.read(_HEAD_BYTES)
    if not head:
        return "not a picture: the file is empty"
    is_page = head.lstrip().lower().startswith((b"<!doctype html", b"<html"))
    return "not a picture: it is a web page" if is_page else ""


def flaw(path: str) -> str:
    """Why a picture cannot be read by its header, with the remedy; empty where it can."""
    try:
        picture_facts(one_of(path))
    except InputError as error:
        return report_line(error)
    return ""


UNREADABLE: Final = "cannot be read:"
"""What stands in each sentence of `report_line`."""


def report_line(error: InputError) -> str:
    """What is wrong with a picture's file, and the remedy, in the words of reports."""
    return f"{Path(str(error.place)).name} {UNREADABLE} {error.message} ({error.remedy})"


def _unreadable(reason: str, path: str) -> InputError:
    return InputError(reason, place=path, remedy="use PNG, JPEG, EXR or HDR")


def _check_size(spec: Any, size: int, path: str) -> None:
    """Refuse what fills the memory, or claims more than its bytes can hold."""
    values = spec.width * spec.height * spec.nchannels
    if not 0 < values <= min(_MAX_VALUES, max(_HARMLESS_VALUES, _MOST_RATIO * size)):
        raise InputError(
            f"{spec.width} x {spec.height} pixels of {spec.nchannels} channels are not supported",
            place=path,
            remedy="give a smaller picture",
        )


@contextmanager
def local_file(path: str) -> Iterator[Path]:
    """A plain file with the content of ``path``, which may lie inside a package.

    The file is ``path`` itself, or a temporary copy that lives as long as the ``with`` block.

    Raises:
        InputError: There is no such file, or it cannot be a picture.
    """
    if is_udim(path):
        with joined(path, _shape, read_codes, read_texture) as file:
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
            data = asset.GetBuffer()
            untrusted.check_head(bytes(data[:_HEAD_BYTES]), path)
            copy.write(data)
        yield Path(name)
    finally:
        removal.remove_file(Path(name))


# UDIM: one picture in tiles of a unit each, named by their number, as one picture.
#
# Tile 1001 + column + 10 row covers the square of texture coordinates that begins at (column, row).

# Column and row, or how many there are.
Place = tuple[int, int]
Shape = tuple[int, int, int]

MARK: Final = "<UDIM>"
_FIRST: Final = 1001
_COLUMNS: Final = 10
# The longest side of all tiles together; larger ones are halved.
_MOST_SIDE: Final = 8192


def is_udim(path: str) -> bool:
    """Whether a path names tiles."""
    return MARK in path


def resolved(attribute: Usd.Attribute, authored: str) -> str:
    """The path of tiles as an attribute's layers name them; empty where there are none.

    Args:
        attribute: That holds the path.
        authored: What it says, with ``<UDIM>``.
    """
    for spec in attribute.GetPropertyStack():
        found = UsdShade.UdimUtils.ResolveUdimTilePaths(authored, spec.layer)
        if found:
            path, number = found[0]
            before, _, after = path.rpartition(number)
            return f"{before}{MARK}{after}"
    return ""


def tiles(path: str) -> dict[Place, str]:
    """The tiles that are there, by column and row."""
    resolver = Ar.GetResolver()
    found = {}
    for number in range(100):
        tile = path.replace(MARK, str(_FIRST + number))
        if resolver.Resolve(tile):
            row, column = divmod(number, _COLUMNS)
            found[column, row] = tile
    return found


def one_of(path: str) -> str:
    """The first tile of a path of tiles; any other path itself."""
    return next(iter(tiles(path).values()), path) if is_udim(path) else path


def grid(path: str) -> Place:
    """How many columns and rows reach over all tiles."""
    return _reach(tiles(path))


@contextmanager
def joined(
    path: str,
    shape: Callable[[str], Shape],
    codes: Callable[[str], Bytes | None],
    values: Callable[[str], Floats],
) -> Iterator[Path]:
    """A file of all tiles, (0, 0) at its lower left; what is missing is black.

    Tiles of 8 bits are joined to a PNG, others to an EXR of floats. All are as large as the largest
    one, by nearest texels.

    Args:
        path: Of the tiles.
        shape: Reads the height, width and channels of a tile.
        codes: Reads one of 8 bits; None of others.
        values: Reads any.

    Raises:
        InputError: A tile is not a picture.
    """
    found = tiles(path)
    whole = _joined(found, shape, codes)
    kind, ending = ("float", ".exr") if whole is None else ("uint8", ".png")
    if whole is None:
        whole = _joined(found, shape, values)
    with scratch_folder() as folder:
        file = folder / f"tiles{ending}"
        imagefile.write(file, cast(Any, whole), kind, {"oiio:UnassociatedAlpha": 1})
        yield file


def _joined(
    found: Mapping[Place, str],
    shape: Callable[[str], Shape],
    read: Callable[[str], NDArray[Any] | None],
) -> NDArray[Any] | None:
    """All tiles in one array, each read and fitted at its turn; None where one is not stored so."""
    columns, rows = _reach(found)
    height, width, channels = map(max, zip(*map(shape, found.values()), strict=True))
    while max(height * rows, width * columns) > _MOST_SIDE:
        height, width = max(height // 2, 1), max(width // 2, 1)
    whole: NDArray[Any] | None = None
    for (column, row), path in found.items():
        tile = read(path)
        if tile is None:
            return None
        if whole is None:
            whole = np.zeros((rows * height, columns * width, channels), dtype=tile.dtype)
        top, left = (rows - 1 - row) * height, column * width
        whole[top : top + height, left : left + width] = _fitted(tile, height, width, channels)
    return whole


def _reach(found: Iterable[Place]) -> Place:
    columns, rows = zip(*found, strict=True)
    return max(columns) + 1, max(rows) + 1


def _fitted(tile: NDArray[Any], height: int, width: int, channels: int) -> NDArray[Any]:
    """A tile of a size, and of so many channels: grey is every colour, and all is opaque."""
    rows = np.arange(height) * tile.shape[0] // height
    columns = np.arange(width) * tile.shape[1] // width
    sized: NDArray[Any] = tile[rows][:, columns]
    if sized.shape[2] == channels:
        return sized
    opaque = np.full_like(sized[..., :1], 255 if tile.dtype == np.uint8 else 1)
    color = sized if sized.shape[2] >= 3 else np.repeat(sized[..., :1], 3, axis=2)
    whole: NDArray[Any] = np.concatenate([color, opaque], axis=2)
    return whole[..., :channels]
