"""UDIM: one picture in tiles of a unit each, named by their number, as one picture.

Tile 1001 + column + 10 row covers the square of texture coordinates that begins at (column, row).
"""

import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray
from pxr import Ar, Usd, UsdShade

from openrooms_usd import imagefile

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
    codes: Callable[[str], NDArray[np.uint8] | None],
    values: Callable[[str], NDArray[np.float32]],
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
        InputError: A tile is no picture.
    """
    found = tiles(path)
    whole = _joined(found, shape, codes)
    kind, ending = ("float", ".exr") if whole is None else ("uint8", ".png")
    if whole is None:
        whole = _joined(found, shape, values)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"tiles{ending}"
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
