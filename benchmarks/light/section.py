"""What every section of the benchmark has: a setting to be measured in, and what comes of it."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.report import table


@dataclass(frozen=True)
class Setting:
    """How a section shall measure.

    Attributes:
        quick: Small pictures, few samples, few rooms.
        folder: For what is needed meanwhile.
    """

    quick: bool
    folder: Path


@dataclass(frozen=True)
class Section:
    """A part of the benchmark: numbers for programs, and text for people."""

    data: Any
    markdown: str


Measure = Callable[[Setting], Section]


def section(rows: list[dict[str, Any]]) -> Section:
    """A section that is one table; all rows have the keys of the first."""
    return Section(rows, table(tuple(rows[0]), [list(row.values()) for row in rows]))
