"""The contact sheet: every view and its main channels at one glance."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd import atomic
from openrooms_usd.arrays import Bytes
from openrooms_usd.imagefile import write_png
from openrooms_usd.lettering import lettered, stamp
from openrooms_usd.rendering.previews import Preview

MAIN: Final = (
    "radiance",
    "denoised",
    "depth",
    "normal",
    "base_color",
    "roughness",
    "semantic",
    "instance",
    "material",
)
MOST_VIEWS: Final = 32
_TILE_WIDTH: Final = 256
# Of the small letters above a tile.
_MAX_LETTERS: Final = 44
_LINE, _LEADING = 14, 6
_GAP_PIXELS: Final = 6
_PAPER: Final = round(255 * 0.11)
# Of the typeface, pixels, and how bright it is: of a caption's first line, and of the others.
_SIZES: Final = ((13, 255 * 0.92), (10, 255 * 0.92 * 0.7))

Tile = tuple[str, Bytes]


def tiles(view: str, previews: Mapping[str, Preview]) -> list[Tile]:
    """A view's row: captions and small pictures of its main channels, or of all it has.

    Args:
        view: The view's name.
        previews: By channel name.
    """
    return [
        (f"{view}  {name}\n{_short(previews[name].shows)}", _reduced(previews[name].pixels))
        for name in chosen(previews)
    ]


def _short(text: str) -> str:
    """What fits above a tile; the manifest has all of it."""
    return text if len(text) <= _MAX_LETTERS else f"{text[: _MAX_LETTERS - 3]}..."


def chosen(channels: Iterable[str]) -> list[str]:
    """The channels of a view that a contact sheet shows: the main ones, or all that it has."""
    there = list(channels)
    return [name for name in MAIN if name in there] or there


def reduced(row: Sequence[Tile]) -> list[Tile]:
    """A row of pictures as small as those of a contact sheet."""
    return [(caption, _reduced(picture)) for caption, picture in row]


def write_sheet(
    path: Path, rows: Sequence[Sequence[Tile]], *, below: bool = False, widest: int | None = None
) -> None:
    """Write a sheet of pictures with captions.

    Args:
        path: The PNG file; it appears whole or not at all.
        rows: Captions and pictures, such as what `tiles` gave for each view.
        below: Whether captions stand below their pictures, rather than above.
        widest: A sheet of more pixels in a row is reduced to so many.

    Raises:
        OutputError: The file cannot be written.
    """
    sheet = _laid_out(rows, below)
    if widest is not None and sheet.shape[1] > widest:
        sheet = _reduced(sheet, widest)
    with atomic.replacing(path) as beside:
        write_png(beside, sheet)


def _reduced(pixels: Bytes, across: int = _TILE_WIDTH) -> Bytes:
    """The same in ``across`` pixels a row, with three channels."""
    import OpenImageIO

    colored = np.repeat(pixels, 3, axis=-1) if pixels.shape[-1] == 1 else pixels
    height, width = colored.shape[:2]
    size = OpenImageIO.ROI(0, across, 0, max(1, round(across * height / width)), 0, 1, 0, 3)
    small = OpenImageIO.ImageBufAlgo.resize(
        OpenImageIO.ImageBuf(np.ascontiguousarray(colored)), "box", roi=size
    )
    return np.asarray(small.get_pixels(OpenImageIO.UINT8))


def _laid_out(rows: Sequence[Sequence[Tile]], below: bool) -> Bytes:
    every = [tile for row in rows for tile in row]
    text = _LEADING + _LINE * max(caption.count("\n") + 1 for caption, _ in every)
    column = max(picture.shape[1] for _, picture in every) + _GAP_PIXELS
    tall = [max(len(picture) for _, picture in row) for row in rows]
    width = _GAP_PIXELS + max(len(row) for row in rows) * column
    shape = (sum(tall) + len(tall) * (text + _GAP_PIXELS) + _GAP_PIXELS, width, 3)
    sheet = np.full(shape, _PAPER, np.uint8)
    tops = np.cumsum([0, *(high + text + _GAP_PIXELS for high in tall)]).tolist()
    for row, top, high in zip(rows, tops, tall, strict=False):
        for number, (caption, picture) in enumerate(row):
            x, y = _GAP_PIXELS + number * column, top + (_GAP_PIXELS if below else text)
            sheet[y : y + picture.shape[0], x : x + picture.shape[1]] = picture
            _write_caption(sheet, caption, x, top + _GAP_PIXELS + high - 2 if below else top)
    return sheet


def _write_caption(sheet: Bytes, caption: str, left: int, top: int) -> None:
    for line, text in enumerate(caption.split("\n")):
        size, share = _SIZES[min(line, 1)]
        stamp(sheet, lettered(text, size), left, top + 16 + _LINE * line - size, (share,) * 3)
