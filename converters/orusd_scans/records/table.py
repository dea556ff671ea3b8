"""CSV tables of unknown origin: read with limits, every mistake with its line."""

import csv
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError
from orusd_scans.records.jsonfile import Node


def read_table(path: Path, need: Sequence[str], texts: Sequence[str] = ()) -> list[Node]:
    """Read a CSV file with a header.

    Args:
        path: The file; comma, semicolon or tab between the fields.
        need: Columns that must be there. Others become fields too.
        texts: Columns whose fields stay texts; elsewhere what looks like a number is one.

    Returns:
        An object for each row that is not empty; its place is its line.

    Raises:
        InputError: It is missing, no regular file, too large, or a column is missing.
    """
    lines = untrusted.read_text(path, "table").splitlines(keepends=True)
    separator = max(",;\t", key=lines[0].count) if lines else ","
    rows = csv.reader(lines, delimiter=separator, strict=True)
    try:
        return list(_records(rows, path, need, texts))
    except csv.Error as error:
        raise InputError(
            f"not readable as CSV: {error}",
            place=f"{path}: line {rows.line_num}",
            remedy="save the table again as CSV, UTF-8",
        ) from error


def _records(
    rows: Iterator[list[str]], path: Path, need: Sequence[str], texts: Sequence[str]
) -> Iterator[Node]:
    header = [name.strip().lower() for name in next(rows, [])]
    top = Node(None, path, "line 1")
    if missing := [name for name in need if name not in header]:
        raise top.error(
            f"the header lacks {', '.join(missing)}",
            f"the first line names the columns, at least: {', '.join(need)}",
        )
    if repeated := {name for name, times in Counter(header).items() if name and times > 1}:
        raise top.error(f"the header repeats {', '.join(sorted(repeated))}", "name each once")
    for row in rows:
        # csv counts the lines itself: fields in quotes may hold line ends.
        line = rows.line_num  # type: ignore[attr-defined]
        if not any(field.strip() for field in row):
            continue
        node = Node(None, path, f"line {line}")
        if len(row) != len(header):
            raise node.error(f"{len(header)} fields expected, found {len(row)}", "mend the line")
        fields = {name: field.strip() for name, field in zip(header, row, strict=True)}
        yield Node({n: _value(f, n in texts) for n, f in fields.items()}, path, node.path)


def _value(field: str, is_text: bool) -> float | str | None:
    """A number where it may be and is one, else a text; nothing where the field is empty."""
    if is_text:
        return field or None
    try:
        return float(field)
    except ValueError:
        return field or None
