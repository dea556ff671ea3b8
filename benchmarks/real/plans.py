"""How far found outlines and openings are from the true ones, in the plan of the truth."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import numpy as np

from benchmarks.real.truth import Frame, Hole, TrueRoom, Truth
from benchmarks.scan.scores import NOTHING, Counts, iou, matched

# A corner counts as found within this distance, metres.
CORNER: Final = 0.20
# An opening counts as found from this intersection over union on the true one's wall, where its
# own plane is not farther away, metres, nor turned by more, degrees.
OPENING_IOU: Final = 0.30
OPENING_AWAY: Final = 0.45
OPENING_TURN: Final = 30.0
# What lies on an uncertain opening to these shares (of the union, of itself) counts neither way.
_ON_UNCERTAIN: Final = (0.15, 0.5)
# Steps of confidence in which claimed and true are compared.
STEPS: Final = (0.5, 0.6, 0.7, 0.8, 0.9)
_PANE: Final = 0.6  # share of itself, on a true opening of several panes


@dataclass(frozen=True)
class Calibration:
    """Confidences that were claimed of openings, each with whether the opening is true."""

    claims: tuple[tuple[float, bool], ...] = ()

    def __add__(self, other: "Calibration") -> "Calibration":
        return Calibration(self.claims + other.claims)

    @property
    def gap(self) -> float | None:
        """Mean confidence less the share that is true; None without any."""
        if not self.claims:
            return None
        return sum(claimed - true for claimed, true in self.claims) / len(self.claims)

    def steps(self, edges: Sequence[float] = STEPS) -> list[tuple[str, int, float, float]]:
        """Claimed against true: each step of confidence, how many, their mean, the true share."""
        lines = []
        for low, high in pairwise((0.0, *edges, 1.0)):
            some = [c for c in self.claims if low <= c[0] < high or c[0] == high == 1.0]
            if some:
                claimed, true = (sum(column) / len(some) for column in zip(*some, strict=True))
                lines.append((f"{low:g} to {high:g}", len(some), claimed, true))
        return lines


@dataclass(frozen=True)
class OpeningScore:
    """Openings of a room: of the right type, of any, and what their confidences were worth."""

    typed: Counts = NOTHING
    untyped: Counts = NOTHING
    calibration: Calibration = Calibration()

    def __add__(self, other: "OpeningScore") -> "OpeningScore":
        return OpeningScore(
            self.typed + other.typed,
            self.untyped + other.untyped,
            self.calibration + other.calibration,
        )


@dataclass(frozen=True)
class PlanScore:
    """The first found room against the true one.

    Attributes:
        iou: With the outline that fits best.
        corners: Within `CORNER` of that outline's.
        openings: None where the truth has none traced.
        ceiling: Error of its height, metres; None where one of both has none.
        each: IoU of every true room with the found one that fits best.
    """

    iou: float
    corners: Counts
    openings: OpeningScore | None
    ceiling: float | None = None
    each: tuple[float, ...] = ()


def plan_score(found: Sequence[Mapping[str, Any]], truth: Truth) -> PlanScore:
    """The rooms of a report against the truth of an upright result."""
    assert truth.frame is not None
    plans = [truth.frame.plan(room["corners"])[:, :2] for room in found]
    meant = truth.rooms if truth.many else truth.rooms[:1]
    best, room, outline = max(
        ((iou(plans[0], ring), room, ring) for room in meant for ring in room.outlines),
        key=lambda entry: entry[0],
    )
    away = np.linalg.norm(plans[0][:, None] - outline[None], axis=2)
    hits, _ = matched(away, CORNER)
    holes = [hole_of(entry, truth.frame) for entry in found[0]["openings"]]
    height = found[0].get("ceiling_height")
    return PlanScore(
        best,
        Counts(len(hits), len(plans[0]), len(outline)),
        None if room.openings is None else opening_score(holes, room.openings),
        None if height is None or room.ceiling is None else abs(height - room.ceiling),
        tuple(
            max(iou(plan, ring) for plan in plans for ring in true.outlines) for true in truth.rooms
        ),
    )


def missed(room: TrueRoom, found: Mapping[str, Any] | None) -> PlanScore:
    """The score of nothing, or of a room that lies on its side: nothing of it is right."""
    corners, holes = (len(found[name]) if found else 0 for name in ("corners", "openings"))
    openings = None
    if room.openings is not None:
        none = Counts(0, holes, sum(hole.certain for hole in room.openings))
        openings = OpeningScore(none, none)
    return PlanScore(0.0, Counts(0, corners, len(room.outlines[0])), openings)


def hole_of(raw: Mapping[str, Any], frame: Frame) -> Hole:
    """An opening of a report in the plan: its ends, bottom and top."""
    corners = frame.plan(raw["corners"])
    heights = np.sort(corners[:, 2])
    middle = corners[:, :2].mean(axis=0)
    out = corners[:, :2] - middle
    way = out[np.argmax(np.abs(out).sum(axis=1))]
    way = way / (np.linalg.norm(way) + 1e-12)
    along = out @ way
    a, b = (tuple(map(float, middle + way * end)) for end in (along.min(), along.max()))
    return Hole(
        raw["type"],
        ((a[0], a[1]), (b[0], b[1])),
        float(heights[:2].mean()),
        float(heights[2:].mean()),
        confidence=raw.get("confidence"),
    )


def opening_score(found: Sequence[Hole], true: Sequence[Hole]) -> OpeningScore:
    """Openings against the true ones; what is uncertain counts neither for nor against."""
    sure = [hole for hole in true if hole.certain]
    unsure = [hole for hole in true if not hole.certain]
    shared = {
        (i, j): overlap(a, b) for i, a in enumerate(found) for j, b in enumerate((*sure, *unsure))
    }

    def neutral(i: int) -> bool:
        on_unsure = (shared[i, j + len(sure)] for j in range(len(unsure)))
        panes = (shared[i, j][1] > _PANE for j, hole in enumerate(sure) if hole.divided)
        return any(panes) or any(a > _ON_UNCERTAIN[0] or b > _ON_UNCERTAIN[1] for a, b in on_unsure)

    def count(same: Callable[[Hole, Hole], bool]) -> tuple[set[int], set[int]]:
        gain = np.array(
            [
                [shared[i, j][0] if same(a, b) else 0.0 for j, b in enumerate(sure)]
                for i, a in enumerate(found)
            ]
        ).reshape(len(found), len(sure))
        hits = set(matched(1.0 - gain, 1.0 - OPENING_IOU)[0].tolist())
        return hits, {i for i in range(len(found)) if i in hits or not neutral(i)}

    typed, counted = count(_same_type)
    untyped, counted_too = count(lambda a, b: True)
    sworn = tuple(
        (confidence, i in typed)
        for i in sorted(counted)
        if (confidence := found[i].confidence) is not None
    )
    return OpeningScore(
        Counts(len(typed), len(counted), len(sure)),
        Counts(len(untyped), len(counted_too), len(sure)),
        Calibration(sworn),
    )


def _same_type(found: Hole, true: Hole) -> bool:
    return found.type == true.type or (true.passage and found.type in ("door", "opening"))


def overlap(found: Hole, true: Hole) -> tuple[float, float]:
    """IoU of two rectangles on the wall of the true one, and the share of the found one in it."""
    (a, b), (c, d) = (np.array(hole.ends, float) for hole in (true, found))
    length, width = float(np.linalg.norm(b - a)), float(np.linalg.norm(d - c))
    if length == 0.0 or width == 0.0:
        return 0.0, 0.0
    along = (b - a) / length
    across = np.array([-along[1], along[0]])
    turned = abs(float((d - c) @ along)) / width < np.cos(np.radians(OPENING_TURN))
    if turned or abs(float(((c + d) / 2 - a) @ across)) > OPENING_AWAY:
        return 0.0, 0.0
    low, high = sorted((float((c - a) @ along), float((d - a) @ along)))
    wide = max(0.0, min(high, length) - max(low, 0.0))
    tall = max(0.0, min(found.top, true.top) - max(found.bottom, true.bottom))
    both = wide * tall
    area = (high - low) * (found.top - found.bottom)
    union = area + length * (true.top - true.bottom) - both
    return (both / union if union else 0.0), (both / area if area else 0.0)
