"""Points as text: XYZ, PTS, CSV and what else has one point a line.

Files differ in their marks of order (UTF-8 or UTF-16), separators, decimal commas, quotes, comments
and lines before the first point. What a file does is seen from its first lines.
"""

import io
from collections import Counter
from collections.abc import Iterator
from functools import partial
from itertools import chain, islice
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.untrusted import encoding_of
from orusd_scans.formats.columns import guessed, heading_of
from orusd_scans.formats.ptx import is_ptx, read_stations
from orusd_scans.formats.rows import ANY, COMMENTS, Layout, read_rows
from orusd_scans.scanned import Scanned, broken, cloud_of, opened

_LONGEST_LINE: Final = 1 << 20
# Rows that show how a file is written, and lines among which they are looked for.
_SAMPLE: Final = 100
_MOST_HEADING: Final = 1000
_LAYOUTS: Final = (
    *(Layout(separator) for separator in ("\t", ",", ";", "")),
    *(Layout(separator, decimal_comma=True) for separator in (";", "\t", "", ",")),
    Layout(ANY),
)
_REMEDY: Final = "give a table with x, y and z in each line, preferably with a first line of names"


def read_text(path: Path) -> Scanned:
    """Read one point a line.

    A line of words, which may be a comment, names the columns and their unit. Without one, three
    columns are x, y and z; the values show what the others are. Lines of a single whole number
    are counts of points, and passed over.

    Raises:
        InputError: It is not such a table, or half of its lines are damaged, or more.
    """
    with opened(path) as stream:
        lines = _lines(stream)
        start = list(islice(lines, _MOST_HEADING))
        if is_ptx(start):
            return read_stations(chain(start, lines), path)
        layout, first, width = _find_layout(start, path)
        before = start[:first]
        heading = heading_of(before, layout, width, path)
        if heading is not None and heading.more:
            width = len(heading.names)
        rows = read_rows(
            chain(start[first:], lines),
            width,
            path,
            layout=layout,
            first=first + 1,
            more=heading is not None and heading.more,
            is_row=_is_row,
        )
    values, notes = rows.values[~rows.lost], list(rows.told)
    if heading is None:
        # PTS files begin with the number of points.
        is_pts = path.suffix.lower() == ".pts" or any(line.strip().isdecimal() for line in before)
        heading = guessed(values, notes, intensity_first=is_pts)
    columns: dict[str, Array] = {}
    for name, column in zip(heading.names, values.T, strict=True):
        columns.setdefault(name, column)
    return Scanned(cloud_of(columns, path, notes), notes=tuple(notes), unit=heading.unit)


def _lines(stream: BinaryIO) -> Iterator[str]:
    """The lines of a file; of those that no point needs, the beginning."""
    mark = stream.read(3)
    stream.seek(0)
    decoded = io.TextIOWrapper(stream, encoding_of(mark), errors="replace")
    for line in iter(partial(decoded.readline, _LONGEST_LINE), ""):
        yield line
        while len(line) == _LONGEST_LINE and not line.endswith("\n"):
            line = decoded.readline(_LONGEST_LINE)


def _is_row(line: str) -> bool:
    """Whether a line is neither empty, nor a comment or a count."""
    text = line.strip()
    return bool(text) and not text.startswith(COMMENTS) and not text.isdecimal()


def _find_layout(start: list[str], path: Path) -> tuple[Layout, int, int]:
    """How a file is written, the index of its first row, and how many numbers that has.

    Raises:
        InputError: No line is a row.
    """
    lines = [(index, line) for index, line in enumerate(start) if _is_row(line)]
    best: tuple[int, Layout, int, int] | None = None
    for layout in _LAYOUTS:
        rows = [
            (index, len(numbers))
            for index, line in lines[: 2 * _SAMPLE]
            if len(numbers := layout.numbers(line) or []) >= 3 and not np.isnan(numbers).all()
        ]
        if rows and (best is None or len(rows) > best[0]):
            usual = Counter(width for _, width in rows).most_common(1)[0][0]
            best = len(rows), layout, rows[0][0], usual
    if best is None:
        shown = next((line.strip()[:60] for _, line in lines), "")
        raise broken(path, f"no line is a row of three numbers or more; one is {shown!r}", _REMEDY)
    _, layout, first, width = best
    # Before the first valid row there may be damaged ones, with words that are not names.
    for index, line in lines:
        fields = layout.fields(line)
        if index < first and len(fields) == width and not all(map(_is_name, fields)):
            first = index
    return layout, first, width


def _is_name(field: str) -> bool:
    # Tables of pandas do not name the column of their index.
    return not field or field[0].isalpha() or field[0] == "_"
