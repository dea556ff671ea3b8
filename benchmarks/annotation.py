"""How many operations of `orusd annotate layout` lead from what is found to what is true.

A hand that errs by centimetres takes, one after the other, the operation that brings the plan most
of the way to the traced truth, until the scorer of real captures counts every corner and opening,
and none that is not there. Clicks are those of the page: a drag is one, a double-click two, and a
wall, a corner or an opening must be selected first where the page wants it.
"""

import statistics
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import click
import numpy as np
from numpy.typing import NDArray

from benchmarks.real.__main__ import DATA
from benchmarks.real.captures import Capture, Run, captures_of
from benchmarks.real.plans import OPENING_IOU, opening_score, overlap
from benchmarks.real.truth import Hole as TrueHole
from benchmarks.real.truth import TrueRoom, Truth
from benchmarks.real.variants import variant
from benchmarks.report import publish, table
from benchmarks.scan.scores import corner_counts, iou, matched
from benchmarks.scenes import orusd
from openrooms_usd.description import load_room
from openrooms_usd.description.layout import ScanLayout
from openrooms_usd.geometry.polygons import defect
from openrooms_usd.geometry.shell import Hole
from openrooms_usd.geometry.walls import Wall
from openrooms_usd.stages.layout.scanned import scanned
from openrooms_usd.view.plan import corners, fittings
from openrooms_usd.view.plan.document import Document
from openrooms_usd.view.plan.drawing import Drawing
from openrooms_usd.view.plan.underlay import boxed

Array = NDArray[np.float64]

# How far a hand is off, metres.
HAND: Final = 0.015
TARGET: Final = 60
_MOST: Final = 200
# Walls that nobody splits, metres.
_SHORT: Final = 0.5


@dataclass(frozen=True)
class Tolerance:
    """When a plan is right.

    Attributes:
        name: For people.
        corner: Farthest that a corner may be off, metres.
        opening: Least intersection over union of an opening with the true one.
        ceiling: Farthest that the ceiling may be off, metres.
        nothing: Whether the plan begins as a box around the points, without any opening.
    """

    name: str
    corner: float
    opening: float
    ceiling: float
    nothing: bool = False


TOLERANCES: Final = (
    Tolerance("as the scorer counts", 0.20, OPENING_IOU, 0.10),
    Tolerance("strictly", 0.06, 0.70, 0.05),
    Tolerance("from nothing, strictly", 0.06, 0.70, 0.05, nothing=True),
)


@dataclass
class Hand:
    """Somebody who corrects a plan, and what it took.

    Attributes:
        plan: As it is now.
        level: (4, 4) from the plan of the truth to that of the room.
        operations: How many were done.
        clicks: How many it took.
    """

    plan: Drawing
    level: Array
    operations: int = 0
    clicks: int = 0
    _wall: int | None = None
    _rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))

    def shaken(self, point: Array) -> tuple[float, float]:
        """Where the hand puts what should be at a point."""
        x, y = point + self._rng.normal(0.0, HAND, 2)
        return float(x), float(y)

    def do(self, plan: Drawing, clicks: int, wall: int | None = None) -> None:
        """Take over what an operation made of the plan."""
        if wall is not None and wall != self._wall:
            clicks, self._wall = clicks + 1, wall
        self.plan, self.operations, self.clicks = plan, self.operations + 1, self.clicks + clicks

    def place(self, points: Any, heights: float = 0.0) -> Array:
        """(N, 2) points of the truth in the plan of the room."""
        flat = np.asarray(points, float).reshape(-1, 2)
        whole = np.column_stack([flat, np.full(len(flat), heights)])
        return np.asarray((whole @ self.level[:3, :3].T + self.level[:3, 3])[:, :2])

    def holes(self) -> list[TrueHole]:
        """The openings in the plan of the truth."""
        back = np.linalg.inv(self.level)
        found = []
        for one in self.plan.openings:
            start, end = self.plan.line(one)
            along = (end - start) / float(np.linalg.norm(end - start))
            half, at, sill = 0.5 * (one.width or 0.0), one.at or 0.0, one.sill or 0.0
            ends = np.array([start + along * (at - half), start + along * (at + half)])
            flat = np.column_stack([ends, np.zeros(2)]) @ back[:3, :3].T + back[:3, 3]
            (a, b), (c, d) = flat[:, :2].tolist()
            found.append(TrueHole(one.kind, ((a, b), (c, d)), sill, sill + (one.height or 0.0)))
        return found


def draw_outline(hand: Hand, ring: Array, limit: float) -> bool:
    """Bring the corners to those of a ring; whether all are there in the end."""
    while hand.operations < _MOST and not _same(hand.plan.polygon, ring, limit):
        ways = [
            (_away(plan.polygon, ring, limit), number, plan, clicks, operations)
            for number, (plan, clicks, operations) in enumerate(_outlines(hand, ring))
            if defect(plan.polygon) is None
        ]
        best = min(ways)
        if best[0] >= _away(hand.plan.polygon, ring, limit) - 1e-6:
            return False
        hand.do(best[2], best[3])
        hand.operations += best[4] - 1
    return _same(hand.plan.polygon, ring, limit)


def _outlines(hand: Hand, ring: Array) -> Iterator[tuple[Drawing, int, int]]:
    """What an operation, or a split and a drag, make of the outline; clicks and operations."""
    plan, count = hand.plan, len(hand.plan.corners)
    ends = np.roll(ring, -1, axis=0)
    for number in range(count):
        for goal in ring:
            yield corners.move_corner(plan, number, hand.shaken(goal)), 1, 1
        if count > 3:
            yield corners.remove_corner(plan, number), 1, 1
        if count > 4:
            yield corners.remove_wall(plan, number), 1, 1
        start, end = plan.ends(number)
        length = max(float(np.linalg.norm(end - start)), 1e-9)
        along = (end - start) / length
        outward = np.array([along[1], -along[0]]) * (-1.0 if plan.clockwise else 1.0)
        for a, b in zip(ring, ends, strict=True):
            if abs(float((b - a) @ along)) > 0.97 * float(np.linalg.norm(b - a)):
                middle = np.array(hand.shaken(0.5 * (a + b)))
                yield corners.move_wall(plan, number, float((middle - start) @ outward)), 1, 1
            if length < _SHORT:
                continue
            at = np.clip(float((a - start) @ along), 0.2 * length, 0.8 * length)
            split = corners.split_wall(plan, number, hand.shaken(start + at * along))
            yield corners.move_corner(split, number + 1, hand.shaken(a)), 3, 2


def _same(found: Array, true: Array, limit: float) -> bool:
    points, edges = corner_counts(found, true, limit)
    return points.hits == edges.hits == len(found) == len(true)


def _away(found: Array, true: Array, limit: float) -> float:
    """How far an outline is from another: what is left to do, and how much of the floor is off."""
    away = np.linalg.norm(found[:, None] - true[None], axis=2)
    rows, columns = matched(away, 0.6)
    off = away[rows, columns]
    left = len(found) + len(true) - 2 * len(rows)
    _, edges = corner_counts(found, true, 0.6)
    apart = edges.found + edges.true - 2 * edges.hits
    far = float(np.where(off > limit, 0.3 + off, 0.0).sum())
    return far + 0.8 * left + 0.2 * apart + 2.0 * (1.0 - iou(found, true))


def draw_openings(hand: Hand, true: Sequence[TrueHole], limit: float) -> bool:
    """Cut, change and close openings until they are the true ones; whether they are."""
    sure = [hole for hole in true if hole.certain]

    def left(plan: Drawing) -> tuple[int, float]:
        holes = Hand(plan, hand.level).holes()
        counts = opening_score(holes, true).typed
        best = [max((overlap(one, hole)[0] for one in holes), default=0.0) for hole in sure]
        rough = sum(share < limit for share in best)
        return counts.found + counts.true - 2 * counts.hits + rough, -sum(best)

    while hand.operations < _MOST and left(hand.plan)[0]:
        ways = [(left(plan), n, plan, clicks, wall)
                for n, (plan, clicks, wall) in enumerate(_cuts(hand, sure))]  # fmt: skip
        best = min(ways, default=None)
        if best is None or best[0][0] >= left(hand.plan)[0]:
            return False
        hand.do(*best[2:])
    return left(hand.plan)[0] == 0


def _cuts(hand: Hand, true: Sequence[TrueHole]) -> Iterator[tuple[Drawing, int, int | None]]:
    """What one operation can make of the openings: its clicks, and the wall that it is done on."""
    plan = hand.plan
    for number, one in enumerate(plan.openings):
        yield fittings.remove_opening(plan, number), 1, one.wall
        for kind in ("window", "door"):
            if kind != one.kind:
                yield fittings.set_opening(plan, number, kind=kind), 2, one.wall
    walls = plan.walls()
    for hole in true:
        ends = hand.place(hole.ends)
        nearest = _wall_of(ends, walls)
        if nearest is None:
            continue
        left, right = np.sort(nearest.from_plan(ends)[:, 0])
        (left, bottom), (right, top) = (
            hand.shaken(np.array([left, hole.bottom])),
            hand.shaken(np.array([right, hole.top])),
        )
        rectangle = Hole(left, right, max(bottom, 0.0), top)
        kind = "window" if hole.type == "window" else "door"
        yield (
            fittings.add_opening(plan, rectangle, wall=nearest.number, kind=kind, snap=True),
            1, nearest.number,
        )  # fmt: skip
        for number, one in enumerate(plan.openings):
            if one.wall == nearest.number:
                # Two opposite corners are dragged.
                changed = fittings.set_opening(plan, number, hole=rectangle, snap=True)
                yield changed, 2, one.wall


def _wall_of(ends: Array, walls: Sequence[Wall]) -> Wall | None:
    """The wall along an opening that is nearest to its middle."""
    way = (ends[1] - ends[0]) / max(float(np.linalg.norm(ends[1] - ends[0])), 1e-9)

    def away(wall: Wall) -> float:
        x, y = wall.from_plan(ends.mean(axis=0))
        return float(np.hypot(x - np.clip(x, 0.0, wall.length), y))

    along = [wall for wall in walls if abs(float(wall.along @ way)) > 0.87]
    return min(along, key=away, default=None)


def corrected(capture: Capture, file: Path, tolerance: Tolerance) -> list[object]:
    """A row of the table: what it takes for one capture, by the outline that takes least."""
    truth, document = capture.truth, Document(file)
    begun = boxed(document.under) if tolerance.nothing else document.saved
    level = _level_from_truth(truth, file)
    room = _meant(truth, Hand(begun, level))
    tries = []
    for ring in room.outlines:
        hand = Hand(begun, level)
        right = truth.loose or draw_outline(hand, hand.place(ring), tolerance.corner)
        outline = hand.operations
        if room.ceiling is not None and abs(hand.plan.height - room.ceiling) > tolerance.ceiling:
            hand.do(fittings.set_height(hand.plan, room.ceiling), 1)
        if room.openings is not None:
            right &= draw_openings(hand, room.openings, tolerance.opening)
        said = document.refusal(hand.plan)
        state = "right" if right and said is None else "not right" if said is None else str(said)
        tries.append((state != "right", hand.operations, outline, hand.clicks, state))
    _, operations, outline, clicks, state = min(tries)
    return [capture.name, outline, operations - outline, operations, clicks, state]


def _meant(truth: Truth, hand: Hand) -> TrueRoom:
    rooms = truth.rooms if truth.many else truth.rooms[:1]
    return max(rooms, key=lambda room: max(
        iou(hand.plan.polygon, hand.place(ring)) for ring in room.outlines))  # fmt: skip


def _level_from_truth(truth: Truth, file: Path) -> Array:
    """(4, 4) from the plan of the truth to the level frame of the composed room."""
    layout = load_room(file).layout
    assert isinstance(layout, ScanLayout) and truth.frame is not None, "a scan"
    back = scanned(layout, file.parent / layout.file, file.parent).scan_from_level
    scan_from_truth = np.eye(4)
    scan_from_truth[:3, :3] = truth.frame.axes.T
    scan_from_truth[:3, 3] = truth.frame.origin
    return np.asarray(np.linalg.inv(back) @ scan_from_truth)


def _imported(run: Run, folder: Path) -> Path:
    words = list(run.words)
    if run.change:
        words[1] = str(folder / "scan.ply")
        folder.mkdir(parents=True)
        variant(Path(run.words[1]), run.change, Path(words[1]))
    orusd("import", *words, "-o", folder / "room")
    return folder / "room/room.yaml"


@click.command()
@click.option("--data", type=click.Path(path_type=Path), default=DATA)
@click.option("--only", multiple=True, metavar="CAPTURE", help="This capture alone; repeated.")
@click.option("--save", "--json", "target", type=click.Path(path_type=Path))
def main(data: Path, only: tuple[str, ...], target: Path | None) -> None:
    """Print what it takes to correct each scan of a room whose truth is traced."""
    if not (data / "captures.json").exists():
        click.echo(f"skipped: there is no captures.json in {data}", err=True)
        return
    titles = ["capture", "outline", "height and openings", "operations", "clicks", "in the end"]
    rows: dict[str, list[list[object]]] = {one.name: [] for one in TOLERANCES}
    with tempfile.TemporaryDirectory() as scratch:
        for capture in captures_of(data, only, derived=False):
            if capture.truth.kind != "scan" or capture.truth.axis_only:
                continue
            for run in capture.runs:
                if run.name == "told":
                    continue
                file = _imported(run, Path(scratch) / capture.name / run.name)
                for tolerance in TOLERANCES:
                    row = corrected(capture, file, tolerance)
                    row[0] = f"{capture.name}, {run.name}"
                    rows[tolerance.name].append(row)
                    click.echo(f"{tolerance.name}: {row}", err=True)
    medians = {
        name: [statistics.median(int(str(row[at])) for row in found) for at in (3, 4)]
        for name, found in rows.items()
        if found
    }
    text = "\n\n".join(
        f"{name}: median {medians[name][0]:g} operations, {medians[name][1]:g} clicks "
        f"(target: below {TARGET})\n\n{table(titles, found)}"
        for name, found in rows.items()
        if found
    )
    publish("annotation", {"median": medians, "rows": rows}, text, target)


if __name__ == "__main__":
    main()
