"""The contact sheet: every view and its main channels at one glance."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd import atomic
from openrooms_usd.render.previews import Bytes, Preview, write_png

MAIN: Final = (
    "radiance", "denoised", "depth", "normal", "base_color", "roughness", "semantic", "instance",
    "material",
)  # fmt: skip
MOST_VIEWS: Final = 32
_TILE_WIDTH: Final = 256
_LINE, _LEADING = 14, 6
_GAP: Final = 6
_PAPER, _INK = 0.11, (0.92, 0.92, 0.92)

Tile = tuple[str, Bytes]


def tiles(view: str, previews: Mapping[str, Preview]) -> list[Tile]:
    """A view's row: captions and small pictures of its main channels, or of all it has.

    Args:
        view: The view's name.
        previews: By channel name.
    """
    chosen = [name for name in MAIN if name in previews] or list(previews)
    return [
        (f"{view}  {name}\n{previews[name].shows}", _reduced(previews[name].pixels))
        for name in chosen
    ]


def write_sheet(path: Path, rows: Sequence[Sequence[Tile]], *, below: bool = False) -> None:
    """Write a sheet of pictures with captions.

    Args:
        path: The PNG file; it appears whole or not at all.
        rows: Captions and pictures, such as what `tiles` gave for each view.
        below: Whether captions stand below their pictures, rather than above.

    Raises:
        OutputError: The file cannot be written.
    """
    sheet, captions = _laid_out(rows, below)
    with atomic.replacing(path) as beside:
        write_png(beside, _captioned(sheet, captions))


def _reduced(pixels: Bytes) -> Bytes:
    import OpenImageIO

    colored = np.repeat(pixels, 3, axis=-1) if pixels.shape[-1] == 1 else pixels
    height, width = colored.shape[:2]
    size = OpenImageIO.ROI(
        0, _TILE_WIDTH, 0, max(1, round(_TILE_WIDTH * height / width)), 0, 1, 0, 3
    )
    small = OpenImageIO.ImageBufAlgo.resize(
        OpenImageIO.ImageBuf(np.ascontiguousarray(colored)), "box", roi=size
    )
    return np.asarray(small.get_pixels(OpenImageIO.UINT8))


def _laid_out(
    rows: Sequence[Sequence[Tile]], below: bool
) -> tuple[Bytes, list[tuple[int, int, str]]]:
    """The sheet without its captions, and where they go: (x, y of the top edge, text)."""
    every = [tile for row in rows for tile in row]
    text = _LEADING + _LINE * max(caption.count("\n") + 1 for caption, _ in every)
    column = max(picture.shape[1] for _, picture in every) + _GAP
    tall = [max(len(picture) for _, picture in row) for row in rows]
    width = _GAP + max(len(row) for row in rows) * column
    shape = (sum(tall) + len(tall) * (text + _GAP) + _GAP, width, 3)
    sheet = np.full(shape, round(255 * _PAPER), np.uint8)
    captions = []
    tops = np.cumsum([0, *(high + text + _GAP for high in tall)]).tolist()
    for row, top, high in zip(rows, tops, tall, strict=False):
        for number, (caption, picture) in enumerate(row):
            x, y = _GAP + number * column, top + (_GAP if below else text)
            sheet[y : y + picture.shape[0], x : x + picture.shape[1]] = picture
            captions.append((x, top + _GAP + high - 2 if below else top, caption))
    return sheet, captions


def _captioned(sheet: Bytes, captions: Sequence[tuple[int, int, str]]) -> Bytes:
    """Draw the captions; without fonts the sheet stays as it is."""
    import OpenImageIO

    buffer: Any = OpenImageIO.ImageBuf(sheet)
    for x, y, caption in captions:
        for line, text in enumerate(caption.split("\n")):
            size, ink = (13, _INK) if line == 0 else (10, tuple(0.7 * value for value in _INK))
            OpenImageIO.ImageBufAlgo.render_text(
                buffer, x, y + 16 + _LINE * line, text, size, "", ink
            )
    return np.asarray(buffer.get_pixels(OpenImageIO.UINT8))
