"""What is measured of every simulated scan: poses of objects, and objects as bodies."""

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from statistics import mean
from typing import Any, Final, Literal

from benchmarks.scan.cases import Case
from benchmarks.scan.contacts import contacts
from benchmarks.scan.hints import RoughHint, countable, rough
from benchmarks.scan.pose_baselines import features, grid_in_box, icp, seven_degrees
from benchmarks.scan.pose_scores import ObjectScore, pose_summary, score_objects
from benchmarks.scan.sections import OURS, Row, has_open3d
from openrooms_usd.scan.results import FoundObject, Pose

STARTS: Final[tuple[Literal["pose", "box"], ...]] = ("pose", "box")

# Methods to compare with, by what they start from.
Fit = Callable[[Any, Any, RoughHint], Pose | None]
BASELINES: Final[dict[str, dict[str, Fit]]] = {
    "pose": {
        "hint as it is": lambda points, cad, hint: hint.pose,
        "point-to-plane ICP": lambda points, cad, hint: icp(points, cad, _given(hint.pose)),
        "plain 7-DoF fit": lambda points, cad, hint: seven_degrees(points, cad, _given(hint.pose)),
    },
    "box": {
        "grid in the box": lambda points, cad, hint: grid_in_box(points, cad, _given(hint.box)),
    },
}


class Alignment:
    """Poses from rough poses and from boxes, with the right model."""

    def __init__(self, baselines: bool = True) -> None:
        self._baselines = baselines
        self._scores: dict[tuple[str, str], list[ObjectScore]] = {}
        self._seconds: dict[tuple[str, str], float] = {}

    def look(self, case: Case) -> None:
        """Measure one scan."""
        truth = case.level_truth
        items = countable(truth, case.scan.cloud)
        for start in STARTS:
            hints = rough(items, truth.cads, 1, start)
            found = case.ours.aligned(hints, truth.cads).objects
            self._add(start, OURS, found, items, case.ours.seconds["alignment"])
            for name, fit in BASELINES[start].items() if self._baselines else ():
                self._compare(case, start, name, fit, hints, items)
        if self._baselines and has_open3d():
            free: Fit = lambda points, cad, hint: features(points, cad)  # noqa: E731
            hints = rough(items, truth.cads, 1, "pose")
            self._compare(case, "nothing", "Open3D: FPFH, RANSAC, ICP", free, hints, items)

    def _compare(
        self, case: Case, start: str, name: str, fit: Fit, hints: Sequence[RoughHint],
        items: Sequence[FoundObject],
    ) -> None:  # fmt: skip
        cloud, cads = case.ours.still, case.level_truth.cads
        began, found = time.perf_counter(), []
        for hint, item in zip(hints, items, strict=True):
            assert cloud.instance is not None
            points = cloud.points[cloud.instance == hint.instance]
            pose = fit(points, cads[hint.cad], hint)
            if pose is not None:
                found.append(replace(item, pose=pose, placed=None))
        self._add(start, name, found, items, time.perf_counter() - began)

    def _add(
        self, start: str, method: str, found: Iterable[FoundObject],
        true: Sequence[FoundObject], seconds: float,
    ) -> None:  # fmt: skip
        key = start, method
        self._scores.setdefault(key, []).extend(score_objects(found, true))
        self._seconds[key] = self._seconds.get(key, 0.0) + seconds

    def rows(self) -> list[Row]:
        """One row for each method."""
        return [
            {
                "from": start,
                "method": method,
                **{k: v for k, v in pose_summary(scores).items() if "placed" not in k},
                "seconds_each": self._seconds[start, method] / max(len(scores), 1),
            }
            for (start, method), scores in self._scores.items()
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


def _given(value: Any) -> Any:
    assert value is not None
    return value
