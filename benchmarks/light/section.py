"""What every section of the benchmark has: a setting to be measured in, and what comes of it."""

import json
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from benchmarks.light.references import References
from benchmarks.light.targets import Target
from benchmarks.report import table


@dataclass(frozen=True)
class Setting:
    """How a section shall measure.

    Attributes:
        quick: Small pictures, few samples, few rooms.
        folder: For what is needed meanwhile.
        references: What is true of the rooms.
        rooms: The names of those that shall be measured; all of a section's where none is named.
    """

    quick: bool
    folder: Path
    references: References
    rooms: tuple[str, ...] = ()

    def chosen(self, names: Iterable[str]) -> tuple[str, ...]:
        """Those of a section's rooms that shall be measured; the first one where it is quick."""
        found = tuple(name for name in names if name in self.rooms or not self.rooms)
        return found[:1] if self.quick else found


@dataclass(frozen=True)
class Section:
    """A part of the benchmark.

    Attributes:
        data: Numbers for programs.
        markdown: Text for people.
        targets: What shall be reached, and is or is not.
    """

    data: Any
    markdown: str
    targets: tuple[Target, ...] = ()

    def keep(self, path: Path) -> None:
        """Write it to a file."""
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(asdict(self), indent=1), encoding="utf-8")

    @classmethod
    def kept(cls, path: Path) -> "Section | None":
        """The one of a file; None where there is none."""
        if not path.is_file():
            return None
        found = json.loads(path.read_text(encoding="utf-8"))
        targets = tuple(Target(**target) for target in found["targets"])
        return cls(found["data"], found["markdown"], targets)


Measure = Callable[[Setting], Section]


def section(rows: list[dict[str, Any]], targets: Iterable[Target] = ()) -> Section:
    """A section that is one table; all rows have the keys of the first."""
    if not rows:
        return Section(rows, "None of the chosen rooms is measured here.")
    shown = table(tuple(rows[0]), [list(row.values()) for row in rows])
    return Section(rows, shown, tuple(targets))
