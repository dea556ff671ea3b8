"""Rows of numbers in text: read at once where all is well, line by line where one is damaged."""

import csv
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np

from openrooms_usd.arrays import Array, Mask
from orusd_scans.scanned import broken

# Lines that are read at once.
_CHUNK: Final = 1 << 16
# What writers print for NaN: Microsoft's C library, spreadsheets, databases.
_NO_NUMBER: Final = re.compile(
    r"|[-+]?(1\.?#\w+|nan(\(\w*\))?)|null|none|n/?a|-+|#n/?a|#num!", re.IGNORECASE
)
COMMENTS: Final = ("#", "%", "//", "!")
"""The start of a line that is not a row."""
ANY: Final = ",;\t"
"""Separators of files that use several."""


@dataclass(frozen=True)
class Layout:
    """How a line falls into numbers.

    Attributes:
        separator: Between them: blanks where it is empty, each of several with `ANY`.
        decimal_comma: Whether a comma begins the fraction.
    """

    separator: str = ""
    decimal_comma: bool = False

    def fields(self, line: str) -> list[str]:
        """The texts between the separators, without quotes; none where quotes do not close."""
        if self.separator == ANY:
            line = re.sub(f"[{ANY}]", " ", line)
        if '"' in line and self.separator not in ("", ANY):
            try:
                found = next(csv.reader([line], delimiter=self.separator, strict=True), [])
            except csv.Error:
                return []
        elif self.separator in ("", ANY):
            found = line.replace('"', " ").split()
        else:
            found = line.split(self.separator)
        found = [field.strip() for field in found]
        while found and not found[-1]:
            found.pop()
        return found

    def numbers(self, line: str, most: int | None = None) -> list[float] | None:
        """The first numbers of a line, NaN for none; None where a field is something else."""
        try:
            return [self._number(field) for field in self.fields(line)[:most]]
        except ValueError:
            return None

    def _number(self, field: str) -> float:
        if self.decimal_comma:
            field = field.replace(",", ".")
        if _NO_NUMBER.fullmatch(field):
            return np.nan
        if "_" in field:  # a number to Python alone
            raise ValueError(field)
        return float(field)

    def at_once(self, lines: list[str], width: int, *, more: bool) -> Array:
        """(N, C) the numbers of sound lines.

        Raises:
            ValueError: A line is damaged, or quotes hide commas.
        """
        if self.separator == "," and self.decimal_comma:
            raise ValueError("commas within quotes")
        if self.decimal_comma:
            lines = [line.replace(",", ".") for line in lines]
        if self.separator == ANY:
            lines = [re.sub(f"[{ANY}]", " ", line) for line in lines]
        elif self.separator and lines[0].rstrip(" \n").endswith(self.separator):
            lines = [line.rstrip().rstrip(self.separator) for line in lines]
        return np.loadtxt(
            lines,
            delimiter=None if self.separator in ("", ANY) else self.separator,
            quotechar='"',
            comments=None,
            ndmin=2,
            usecols=range(width) if more else None,
        )


BLANKS: Final = Layout()


def lines_before(stream: BinaryIO) -> int:
    """How many lines a stream has behind it."""
    position = stream.tell()
    stream.seek(0)
    return stream.read(position).count(b"\n")


class Counted:
    """The first lines of others that are not blank, with the blank ones between them.

    Attributes:
        passed: How many lines were given so far, blank ones among them.
    """

    def __init__(self, lines: Iterable[str], count: int) -> None:
        self._lines, self._left, self.passed = iter(lines), count, 0

    def __iter__(self) -> Iterator[str]:
        while self._left and (line := next(self._lines, None)) is not None:
            self.passed += 1
            self._left -= bool(line.strip())
            yield line


@dataclass(frozen=True, eq=False)
class Rows:
    """The numbers of N lines.

    Attributes:
        values: (N, C); NaN in the rows of damaged lines.
        lost: (N,) which these are.
        first: What is said of the first of them.
    """

    values: Array
    lost: Mask
    first: str = ""

    @property
    def told(self) -> tuple[str, ...]:
        """A sentence about damaged lines, where there are any."""
        count, width = int(self.lost.sum()), self.values.shape[1]
        text = f"left out {count:,} of {len(self.lost):,} lines, which are not {width} numbers each"
        return (f"{text}: {self.first}",) if count else ()


def read_rows(
    lines: Iterable[str],
    width: int,
    path: Path,
    *,
    layout: Layout = BLANKS,
    first: int = 1,
    more: bool = False,
    is_row: Callable[[str], object] = str.strip,
) -> Rows:
    """Read lines of numbers; those that are damaged are counted and become NaN.

    Args:
        lines: Of the file.
        width: Numbers in each.
        path: The file, for messages.
        layout: How they are written.
        first: Number of the first line in the file, from 1.
        more: Whether lines may go on after these numbers.
        is_row: What other lines are passed over.

    Raises:
        InputError: Half of the lines are damaged, or more.
    """
    rest, values, lost, said = iter(lines), [np.empty((0, width))], [np.empty(0, bool)], ""
    while chunk := list(islice(rest, _CHUNK)):
        kept = [line for line in chunk if is_row(line)]
        found = _sound(kept, width, layout, more)
        if found is None:
            found = np.full((len(kept), width), np.nan)
            damaged = np.zeros(len(kept), bool)
            numbered = ((n, line) for n, line in enumerate(chunk, first) if is_row(line))
            for row, (number, line) in enumerate(numbered):
                numbers = layout.numbers(line, width if more else None) or []
                damaged[row] = len(numbers) != width
                if not damaged[row]:
                    found[row] = numbers
                elif not said:
                    said = f"the first is line {number}, {line.strip()[:60]!r}"
            lost.append(damaged)
        else:
            lost.append(np.zeros(len(found), bool))
        values.append(found)
        first += len(chunk)
    rows = Rows(np.concatenate(values), np.concatenate(lost), said)
    if (bad := int(rows.lost.sum())) and 2 * bad >= len(rows.lost):
        raise broken(
            path,
            f"{bad:,} of {len(rows.lost):,} lines are not a row of {width} numbers: {said}",
            "look at that line in a text editor: each line needs the same columns of numbers",
        )
    return rows


def _sound(lines: list[str], width: int, layout: Layout, more: bool) -> Array | None:
    """(N, width) the numbers of lines without damage; None where there is some."""
    if not lines:
        return np.empty((0, width))
    try:
        found = layout.at_once(lines, width, more=more)
    except ValueError:
        return None
    return found if found.shape == (len(lines), width) else None
