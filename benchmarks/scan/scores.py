"""How far what was found in a scan is from what is true of it: rooms and openings."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.scan.results import FoundOpening, FoundRoom

# A floor is right within so many degrees and metres.
FLOOR: Final = (0.2, 0.01)
# A corner counts as found within this distance, metres.
CORNER: Final = 0.10
# An opening counts as found from this intersection over union on the wall's plane, where its own
# plane is not farther away, metres, nor turned by more, degrees.
OPENING_IOU: Final = 0.5
OPENING_AWAY: Final = 0.3
OPENING_TURN: Final = 30.0


@dataclass(frozen=True)
class Counts:
    """Things that were found, that are true, and that are both."""

    hits: int
    found: int
    true: int

    def __add__(self, other: "Counts") -> "Counts":
        return Counts(self.hits + other.hits, self.found + other.found, self.true + other.true)

    @property
    def precision(self) -> float:
        """Of what was found, the part that is true; 1 where nothing was found."""
        return self.hits / self.found if self.found else 1.0

    @property
    def recall(self) -> float:
        """Of what is true, the part that was found; 1 where nothing is."""
        return self.hits / self.true if self.true else 1.0

    @property
    def f1(self) -> float:
        """The harmonic mean of both."""
        return 2 * self.hits / (self.found + self.true) if self.found + self.true else 1.0


NOTHING: Final = Counts(0, 0, 0)


@dataclass(frozen=True)
class LayoutScore:
    """One room against the truth.

    Attributes:
        floor_degrees: Between the floors' normals; None where no room was found.
        floor_offset: Distance of the floors at the middle of the true room, metres.
        iou: Of the outlines.
        corners: Within `CORNER` of each other.
        edges: Between two corners that were both found and are neighbours in truth too.
        openings: At `OPENING_IOU`, of the same type.
        ceiling: Error of its height, metres; None where truth or report have none.
    """

    floor_degrees: float | None
    floor_offset: float | None
    iou: float
    corners: Counts
    edges: Counts
    openings: Counts
    ceiling: float | None


def score_rooms(found: Sequence[FoundRoom], true: Sequence[FoundRoom]) -> list[LayoutScore]:
    """Each true room against the room that was found in its place.

    A room that was not found scores as an empty one; rooms too many show in the precision of the
    first.
    """
    return [score_room(_in_place(found, room), room) for room in true]


def _in_place(found: Sequence[FoundRoom], true: FoundRoom) -> FoundRoom | None:
    ious = [iou(to_plan(room.corners, true), to_plan(true.corners, true)) for room in found]
    return found[int(np.argmax(ious))] if ious and max(ious) > 0 else None


def score_room(found: FoundRoom | None, true: FoundRoom) -> LayoutScore:
    """One room against the truth; without a room everything is missed."""
    if found is None:
        missed = Counts(0, 0, len(true.corners))
        holes = Counts(0, 0, len(true.openings))
        return LayoutScore(None, None, 0.0, missed, missed, holes, None)
    plan, truth = to_plan(found.corners, true), to_plan(true.corners, true)
    corners, edges = corner_counts(plan, truth)
    both = found.ceiling is not None and true.ceiling is not None
    return LayoutScore(
        *floor_error(found, true),
        iou(plan, truth),
        corners,
        edges,
        opening_counts(found.openings, true.openings),
        abs(found.ceiling - true.ceiling) if both else None,  # type: ignore[operator]
    )


def floor_error(found: FoundRoom, true: FoundRoom) -> tuple[float, float]:
    """Degrees between the floors, and their distance at the true room's middle, metres."""
    a, b = (room.normal / np.linalg.norm(room.normal) for room in (found, true))
    degrees = float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)))
    middle = true.corners.mean(axis=0)
    middle = middle - ((middle - true.point) @ b) * b
    return degrees, abs(float((middle - found.point) @ a / (a @ b)))


def to_plan(points: Array, room: FoundRoom) -> Array:
    """(N, 2) points in the plane of a room's floor."""
    up = room.normal / np.linalg.norm(room.normal)
    across = np.cross(up, (0.0, 1.0, 0.0) if abs(up[1]) < 0.9 else (1.0, 0.0, 0.0))
    across /= np.linalg.norm(across)
    return np.asarray((points - room.point) @ np.stack([across, np.cross(up, across)], axis=1))


def iou(a: Array, b: Array) -> float:
    """Intersection over union of two polygons (N, 2)."""
    from shapely import make_valid
    from shapely.geometry import Polygon

    p, q = (make_valid(Polygon(ring)) if len(ring) > 2 else Polygon() for ring in (a, b))
    union = p.union(q).area
    return float(p.intersection(q).area / union) if union else 0.0


def matched(cost: Array, limit: float) -> tuple[Ints, Ints]:
    """Pairs of rows and columns, each used once: as many as possible below a limit, then best."""
    from scipy.optimize import linear_sum_assignment

    if not cost.size:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    rows, columns = linear_sum_assignment(np.where(cost <= limit, cost, 1e6))
    kept = cost[rows, columns] <= limit
    return rows[kept], columns[kept]


def corner_counts(found: Array, true: Array, limit: float = CORNER) -> tuple[Counts, Counts]:
    """Corners and edges of a polygon (N, 2) that are those of the true one (M, 2)."""
    away = np.linalg.norm(found[:, None] - true[None], axis=2)
    rows, columns = matched(away, limit)
    partner = dict(zip(rows.tolist(), columns.tolist(), strict=True))
    count = len(true)
    pairs = [(partner.get(i), partner.get((i + 1) % len(found))) for i in range(len(found))]
    edges = sum(
        a is not None and b is not None and (a - b) % count in (1, count - 1) for a, b in pairs
    )
    return Counts(len(rows), len(found), count), Counts(edges, len(found), count)


def opening_counts(
    found: Sequence[FoundOpening], true: Sequence[FoundOpening], limit: float = OPENING_IOU
) -> Counts:
    """Openings of the right type in the right place."""
    overlap = np.array([[_overlap(a, b) for b in true] for a in found])
    overlap = overlap.reshape(len(found), len(true))
    rows, _ = matched(1.0 - overlap, 1.0 - limit)
    return Counts(len(rows), len(found), len(true))


def _overlap(found: FoundOpening, true: FoundOpening) -> float:
    """Intersection over union on the true one's plane; 0 where type or plane are others."""
    across, up, out = opening_frame(true.corners)
    away = (found.corners - true.corners[0]) @ out
    turned = abs(float(opening_frame(found.corners)[2] @ out))
    if found.type != true.type or abs(away.mean()) > OPENING_AWAY:
        return 0.0
    if turned < np.cos(np.radians(OPENING_TURN)):
        return 0.0
    axes = np.stack([across, up], axis=1)
    return iou((found.corners - true.corners[0]) @ axes, (true.corners - true.corners[0]) @ axes)


def opening_frame(corners: Array) -> tuple[Array, Array, Array]:
    """Unit vectors of an opening: to the right, upwards, and into the room."""
    across, up = corners[1] - corners[0], corners[3] - corners[0]
    across = across / np.linalg.norm(across)
    out = np.cross(across, up)
    out /= np.linalg.norm(out)
    return across, np.cross(out, across), out


def summary(scores: Sequence[LayoutScore]) -> dict[str, Any]:
    """Means over rooms; corners, edges and openings over all of them together."""
    ious = [score.iou for score in scores]
    floors = [(s.floor_degrees, s.floor_offset) for s in scores if s.floor_degrees is not None]
    good = sum(degrees <= FLOOR[0] and (away or 0.0) <= FLOOR[1] for degrees, away in floors)
    ceilings = [score.ceiling for score in scores if score.ceiling is not None]
    return {
        "rooms": len(scores),
        "iou": float(np.mean(ious)),
        "worst_iou": min(ious),
        **{
            f"{name}_{what}": getattr(sum((getattr(s, name) for s in scores), NOTHING), what)
            for name in ("corners", "edges", "openings")
            for what in ("precision", "recall")
        },
        "floor_right": good / len(scores),
        "floor_degrees": max((degrees for degrees, _ in floors), default=None),
        "floor_offset": max((away for _, away in floors if away is not None), default=None),
        "ceiling": max(ceilings, default=None),
    }
