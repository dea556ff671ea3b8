"""What the sections of a report are made of: tables, and charts with their numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

MOST_ROWS: Final = 60
"""Of a table; what is beyond is told to be there."""


@dataclass(frozen=True)
class Table:
    """A table; the first column names the rows.

    Attributes:
        heads: Of the columns.
        rows: As text.
        left: How many rows more there are.
    """

    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    left: int = 0

    @classmethod
    def of(cls, heads: Sequence[str], rows: Sequence[Sequence[str]]) -> "Table":
        """A table that is no longer than people read."""
        kept = tuple(tuple(row) for row in rows[:MOST_ROWS])
        return cls(tuple(heads), kept, max(0, len(rows) - MOST_ROWS))


@dataclass(frozen=True)
class Chart:
    """A chart, with its numbers as a table for those who cannot see it.

    Attributes:
        title: What it shows.
        svg: The drawing.
        table: Its numbers.
        note: What must be known to read it.
    """

    title: str
    svg: str
    table: Table
    note: str = ""
