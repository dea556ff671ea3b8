"""The captures of a folder, and how each of them is run."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal

from benchmarks.real.truth import Truth, truth_of

# What is done to a scan before it is imported.
Change = Literal["", "strip", "on its side", "millimetres"]

# Every upright scan of points is also run like this: it may not become a wrong room in silence.
DERIVED: Final[tuple[Change, ...]] = ("on its side", "millimetres")
_POINTS: Final = (".ply", ".xyz", ".pcd")


@dataclass(frozen=True)
class Run:
    """One way to import a capture.

    Attributes:
        name: For people.
        words: What follows ``orusd import``; paths are absolute.
        labels: Whether the scan says what its points are.
        partial: Whether the room is told that the scan shows a part of it.
        change: What is done to the scan first; it is the second word.
        derived: The run is about axis and unit alone.
    """

    name: str
    words: tuple[str, ...]
    labels: bool = False
    partial: bool = False
    change: Change = ""
    derived: bool = False


@dataclass(frozen=True)
class Capture:
    """A capture with what is true of it."""

    name: str
    truth: Truth
    runs: tuple[Run, ...]
    substitutes: Mapping[str, Sequence[str] | None]


def captures_of(folder: Path, only: Sequence[str] = (), derived: bool = True) -> Iterator[Capture]:
    """The captures of a folder.

    Args:
        folder: Holds ``captures.json``, ``data`` and ``truth``.
        only: Their names; all without.
        derived: Also run each scan on its side and in millimetres.
    """
    listed = json.loads((folder / "captures.json").read_text(encoding="utf-8"))
    table = json.loads((folder / "truth" / "substitutes.json").read_text(encoding="utf-8"))["table"]
    for name, entry in listed.items():
        path = folder / "truth" / f"{name}.json"
        if (only and name not in only) or not path.exists():
            continue
        truth = truth_of(path)
        runs = [_run(folder, run, spec) for run, spec in entry["runs"].items()]
        more = _derived(runs, truth) if derived else []
        yield Capture(name, truth, (*runs, *more), table)


def _run(folder: Path, name: str, spec: Mapping[str, Any]) -> Run:
    words = [str((folder / w).resolve()) if w.startswith("data/") else w for w in spec["import"]]
    change: Change = "strip" if spec.get("strip") else ""
    return Run(
        name, tuple(words), bool(spec.get("labels")), bool(spec.get("partial")), change=change
    )


def _derived(runs: Sequence[Run], truth: Truth) -> list[Run]:
    """The first run of an upright, whole scan of points, changed."""
    first = runs[0]
    upright = truth.kind == "scan" and truth.up_axis == "z" and not truth.axis_only
    plain = first.words[0] == "scan" and Path(first.words[1]).suffix.lower() in _POINTS
    if not (upright and plain and truth.unit == 1.0):
        return []
    return [Run(change, first.words[:2], change=change, derived=True) for change in DERIVED]
