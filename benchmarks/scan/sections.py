"""What is measured of every simulated scan: each section gathers rows and sums them up."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from statistics import mean
from typing import Any, Final, Protocol

from benchmarks.scan.baselines import manhattan, ransac_planes
from benchmarks.scan.cases import Case
from benchmarks.scan.methods import Reconstruction
from benchmarks.scan.scores import NOTHING, LayoutScore, opening_counts, score_rooms, summary
from openrooms_usd.errors import OrusdError
from openrooms_usd.scan.results import FoundRoom

Row = dict[str, Any]

OURS: Final = "ours"


class Section(Protocol):
    """Looks at scans one after the other, then says what it found."""

    def look(self, case: Case) -> None:
        """Measure one scan."""

    def rows(self) -> list[Row]:
        """One row for each method."""


def has_open3d() -> bool:
    """Whether the usual tool can be compared with."""
    try:
        import open3d  # type: ignore[import-not-found, unused-ignore]  # noqa: F401
    except (ImportError, OSError):
        return False
    return True


class Layout:
    """Rooms: outline, corners, edges, floor and ceiling; and openings by labels."""

    def __init__(self) -> None:
        self._scores: dict[str, list[tuple[str, LayoutScore, float]]] = {}

    def look(self, case: Case) -> None:
        """Measure one scan."""
        self._score(case, OURS, lambda: case.ours.rooms)
        self._score(case, "Manhattan histogram", lambda: _one(manhattan(case.ours.still)))
        if has_open3d():
            self._score(case, "Open3D: RANSAC planes", lambda: _one(ransac_planes(case.ours.still)))

    def _score(self, case: Case, method: str, find: Callable[[], Sequence[FoundRoom]]) -> None:
        true = case.level_truth.rooms
        began = time.perf_counter()
        try:
            found = find()
        except OrusdError:
            found = ()
        seconds = time.perf_counter() - began
        if method == OURS:
            steps = case.ours.seconds
            seconds = sum(steps.get(step, 0.0) for step in ("clean", "level", "layout"))
        rows = self._scores.setdefault(method, [])
        rows += [(case.name, score, seconds) for score in score_rooms(found, true)]

    def rows(self) -> list[Row]:
        """One row for each method."""
        return [
            {
                "method": method,
                **summary([score for _, score, _ in found]),
                "seconds": mean(seconds for *_, seconds in found),
            }
            for method, found in self._scores.items()
        ]

    def each(self) -> list[Row]:
        """One row for each scan, of our own method."""
        return [
            {
                "scan": name,
                "iou": score.iou,
                "corners": f"{score.corners.hits}/{score.corners.found}/{score.corners.true}",
                "edges": f"{score.edges.hits}/{score.edges.found}/{score.edges.true}",
                "openings": f"{score.openings.hits}/{score.openings.found}/{score.openings.true}",
                "floor_degrees": score.floor_degrees,
                "floor_offset": score.floor_offset,
                "ceiling": score.ceiling,
            }
            for name, score, _ in self._scores.get(OURS, ())
        ]


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


def _one(room: FoundRoom | None) -> tuple[FoundRoom, ...]:
    return () if room is None else (room,)
