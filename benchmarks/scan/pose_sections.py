"""What is measured of every simulated scan: poses of objects, and objects as bodies."""

from collections.abc import Sequence
from statistics import mean
from typing import Any, Final, Literal

from benchmarks.scan.cases import Case
from benchmarks.scan.contacts import contacts
from benchmarks.scan.hints import countable, rough
from benchmarks.scan.pose_scores import ObjectScore, pose_summary, score_objects
from benchmarks.scan.sections import Row

STARTS: Final[tuple[Literal["pose", "box"], ...]] = ("pose", "box")


class Alignment:
    """Poses from rough poses and from boxes, with the right model."""

    def __init__(self) -> None:
        self._scores: dict[str, list[ObjectScore]] = {start: [] for start in STARTS}
        self._seconds = dict.fromkeys(STARTS, 0.0)

    def look(self, case: Case) -> None:
        """Measure one scan."""
        truth = case.level_truth
        items = countable(truth, case.scan.cloud)
        for start in STARTS:
            found = case.ours.aligned(rough(items, truth.cads, 1, start), truth.cads).objects
            self._scores[start] += score_objects(found, items)
            self._seconds[start] += case.ours.seconds["alignment"]

    def rows(self) -> list[Row]:
        """One row for each kind of hint."""
        return [
            {
                "from": start,
                **{k: v for k, v in pose_summary(self._scores[start]).items() if "placed" not in k},
                "seconds_each": self._seconds[start] / max(len(self._scores[start]), 1),
            }
            for start in STARTS
        ]


class Placement:
    """What is wrong with objects as bodies before placement and after it, from rough poses."""

    def __init__(self) -> None:
        self._wrong: dict[str, list[dict[str, Any]]] = {"before": [], "after": []}
        self._scores: list[ObjectScore] = []
        self._unresolved = 0
        self._seconds: list[float] = []

    def look(self, case: Case) -> None:
        """Measure one scan."""
        truth = case.level_truth
        items = countable(truth, case.scan.cloud)
        ours = case.ours
        found = ours.aligned(rough(items, truth.cads, 1, "pose"), truth.cads).objects
        placed = ours.placed(found, truth.cads)
        for when, objects in (("before", found), ("after", placed.objects)):
            wrong = contacts(objects, truth.cads, truth.rooms, truth.objects)
            self._wrong[when].append(wrong.summary())
        self._scores += score_objects(placed.objects, items)
        self._unresolved += len(placed.unresolved)
        self._seconds.append(sum(ours.seconds.values()))

    def rows(self) -> list[Row]:
        """One row for each method."""
        poses = pose_summary(self._scores)
        return [
            {
                "when": when,
                **{key: _whole(key, [w[key] for w in wrong]) for key in (wrong or [{}])[0]},
                "tight": poses["tight" if when == "before" else "tight_placed"],
                "unresolved": self._unresolved if when == "after" else None,
                "seconds_room": mean(self._seconds) if self._seconds else None,
            }
            for when, wrong in self._wrong.items()
        ]


def _whole(key: str, values: Sequence[float]) -> float:
    return max(values) if key in ("deepest", "deepest_in_wall", "highest") else sum(values)
