"""What is measured of every simulated scan: poses of objects, and objects as bodies."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from statistics import mean
from typing import Any, Final, Literal

import numpy as np

from benchmarks.scan.cases import Case
from benchmarks.scan.contacts import contacts
from benchmarks.scan.sections import Row
from benchmarks.scan.truth import countable, rough
from openrooms_usd.arrays import Array
from openrooms_usd.scan.results import FoundObject, Pose

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


# How far the poses of aligned CADs are from the true ones (Avetisyan et al., Scan2CAD, 2019).

# Turns about the CAD's vertical that a symmetry does not notice, degrees.
TURNS: Final = {"none": (0,), "2": (0, 180), "4": (0, 90, 180, 270)}


@dataclass(frozen=True)
class Limits:
    """What counts as right.

    Attributes:
        translation: Metres.
        degrees: Of the rotation, symmetry taken into account.
        scale: A part; Scan2CAD takes the mean over the axes, where errors cancel.
        every_axis: Whether each axis counts instead.
    """

    translation: float
    degrees: float
    scale: float
    every_axis: bool


SCAN2CAD: Final = Limits(0.20, 20.0, 0.20, every_axis=False)
TIGHT: Final = Limits(0.05, 5.0, 0.05, every_axis=True)


@dataclass(frozen=True)
class PoseError:
    """A pose against the true one.

    Attributes:
        translation: Metres.
        degrees: The smallest over the turns that the symmetry allows.
        mean_scale: |mean over axes of found / true - 1|.
        axis_scale: The largest |found / true - 1|.
    """

    translation: float
    degrees: float
    mean_scale: float
    axis_scale: float

    def within(self, limits: Limits) -> bool:
        """Whether it counts as right."""
        scale = self.axis_scale if limits.every_axis else self.mean_scale
        return bool(
            self.translation <= limits.translation
            and self.degrees <= limits.degrees
            and scale <= limits.scale
        )


def pose_error(found: Pose, true: Pose, symmetry: str, up: int = 2) -> PoseError:
    """The error of a pose.

    Args:
        found: The pose.
        true: The true one.
        symmetry: ``none``, ``2``, ``4`` or ``inf``, about the CAD's vertical.
        up: The number of the CAD's vertical axis.
    """
    from scipy.spatial.transform import Rotation

    A, B = (Rotation.from_quat(p.rotation, scalar_first=True) for p in (found, true))
    away = float(np.linalg.norm(found.translation - true.translation))
    axis = np.eye(3)[up]
    if symmetry == "inf":
        a, b = A.apply(axis), B.apply(axis)
        degrees = float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)))
        return PoseError(away, degrees, *_scale_error(found.scale, true.scale))
    errors = []
    for turn in TURNS[symmetry]:
        S = Rotation.from_rotvec(np.radians(turn) * axis)
        degrees = float(np.degrees((B.inv() * A * S).magnitude()))
        # After a quarter turn the CAD's axes lie along each other.
        scale = np.abs(S.inv().apply(found.scale))
        errors.append(PoseError(away, degrees, *_scale_error(scale, true.scale)))
    return min(errors, key=lambda error: error.degrees)


def _scale_error(found: Array, true: Array) -> tuple[float, float]:
    ratio = found / true - 1.0
    return abs(float(ratio.mean())), float(np.abs(ratio).max())


@dataclass(frozen=True)
class ObjectScore:
    """One true object, and what was found of it; without an error it was not found."""

    instance: int
    category: str
    error: PoseError | None
    placed: PoseError | None


def score_objects(
    found: Iterable[FoundObject], true: Sequence[FoundObject], *, any_cad: bool = False
) -> list[ObjectScore]:
    """Each true object against what was found of its instance.

    Args:
        found: With the instances' true numbers.
        true: What should be found.
        any_cad: Whether another CAD of the same category counts.
    """
    by_instance = {item.instance: item for item in found}
    scores = []
    for item in true:
        got = by_instance.get(item.instance)
        if got is not None and got.cad != item.cad and not any_cad:
            got = None
        poses = () if got is None else (got.pose, got.placed or got.pose)
        errors = [pose_error(pose, item.pose, item.symmetry) for pose in poses]
        scores.append(ObjectScore(item.instance, item.category, *(errors or (None, None))))
    return scores


def pose_summary(scores: Sequence[ObjectScore]) -> dict[str, Any]:
    """Parts of the objects that count as right, before and after placement."""

    def part(limits: Limits, which: str) -> float:
        errors: list[PoseError | None] = [getattr(score, which) for score in scores]
        return sum(e is not None and e.within(limits) for e in errors) / max(len(scores), 1)

    return {
        "objects": len(scores),
        "found": sum(score.error is not None for score in scores) / max(len(scores), 1),
        "scan2cad": part(SCAN2CAD, "error"),
        "tight": part(TIGHT, "error"),
        "scan2cad_placed": part(SCAN2CAD, "placed"),
        "tight_placed": part(TIGHT, "placed"),
    }
