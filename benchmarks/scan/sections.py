"""What is measured of every simulated scan: each section gathers rows and sums them up."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from statistics import mean
from typing import Any, Protocol

from benchmarks.scan.cases import Case, Reconstruction
from benchmarks.scan.scores import NOTHING, LayoutScore, opening_counts, score_rooms, summary
from openrooms_usd.errors import OrusdError
from openrooms_usd.scan.results import FoundRoom

Row = dict[str, Any]


class Section(Protocol):
    """Looks at scans one after the other, then says what it found."""

    def look(self, case: Case) -> None:
        """Measure one scan."""

    def rows(self) -> list[Row]:
        """What was found."""


class Layout:
    """Rooms: outline, corners, edges, floor and ceiling; and openings by labels."""

    def __init__(self) -> None:
        self._scores: list[tuple[str, LayoutScore, float]] = []

    def look(self, case: Case) -> None:
        """Measure one scan."""
        found: Sequence[FoundRoom] = ()
        with suppress(OrusdError):
            found = case.ours.rooms
        steps = case.ours.seconds
        seconds = sum(steps.get(step, 0.0) for step in ("clean", "level", "layout"))
        scores = score_rooms(found, case.level_truth.rooms)
        self._scores += [(case.name, score, seconds) for score in scores]

    def rows(self) -> list[Row]:
        """One row."""
        whole = summary([score for _, score, _ in self._scores])
        return [{**whole, "seconds": mean(seconds for *_, seconds in self._scores)}]


class Openings:
    """Doors and windows with labels and without, on our own walls."""

    def __init__(self) -> None:
        self._counts: dict[str, list[Any]] = {}
        self._seconds: dict[str, list[float]] = {}

    def look(self, case: Case) -> None:
        """Measure one scan."""
        bare = replace(case.scan.cloud, label=None, instance=None)
        for kind, ours in (("labels", case.ours), ("no labels", Reconstruction(bare))):
            true = case.scan.truth.rooms[0].openings
            holes = [hole for room in ours.scan_rooms for hole in room.openings]
            self._counts.setdefault(kind, []).append(opening_counts(holes, true))
            self._seconds.setdefault(kind, []).append(ours.seconds["openings"])

    def rows(self) -> list[Row]:
        """One row for each method."""
        rows = []
        for kind, counts in self._counts.items():
            whole = sum(counts, NOTHING)
            rows.append(
                {
                    "from": kind,
                    "true": whole.true,
                    "precision": whole.precision,
                    "recall": whole.recall,
                    "f1": whole.f1,
                    "seconds": mean(self._seconds[kind]),
                }
            )
        return rows
