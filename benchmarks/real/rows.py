"""One run of a capture, scored: the numbers, and a line of the table."""

import json
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from benchmarks.real.bodies import BodyScore, ExportScore, body_score, export_score
from benchmarks.real.captures import Capture, Run
from benchmarks.real.plans import OpeningScore, PlanScore, missed, plan_score
from benchmarks.real.running import ON_ITS_SIDE, Outcome
from benchmarks.real.things import ThingScore, thing_score, things_of
from benchmarks.real.truth import Frame
from benchmarks.scan.scores import Counts

# An axis is right below the first, and nonsense above the second; degrees.
AXIS: Final = (10.0, 20.0)
# From this intersection over union a changed scan has the right axis and unit; how good its outline
# is, is scored elsewhere.
CORRECTED: Final = 0.5
# Words by which a refusal names what would help.
_NAMES_UP: Final = ("--up", " up ", "`up`", "up:", "'up'", "upright", "gravity")

_NAMES_UNIT: Final = ("unit", "millimet")


@dataclass(frozen=True)
class Row:
    """A run and what became of it; what was not scored is None.

    Attributes:
        capture: Its name.
        kind: ``scan`` or ``roomplan``.
        run: As it is declared.
        seconds: Import and compose together.
        refusal: What was said where no room was composed.
        degrees: Between the floor's normal and the true vertical.
        plan: Outline and openings.
        things: Labelled objects.
        bodies: All objects, as bodies.
        export: Of a RoomPlan capture.
        tilted: The room lies on its side.
        unit_named: The unit was spoken of, in a note or a refusal.
    """

    capture: str
    kind: str
    run: Run
    seconds: float
    refusal: str | None = None
    degrees: float | None = None
    plan: PlanScore | None = None
    things: ThingScore | None = None
    bodies: BodyScore | None = None
    export: ExportScore | None = None
    tilted: bool = False
    unit_named: bool = False

    @property
    def names_up(self) -> bool:
        """Whether a refusal says that the vertical may be another."""
        return not self.crashed and any(w in (self.refusal or "").lower() for w in _NAMES_UP)

    @property
    def crashed(self) -> bool:
        """Whether it ended in a traceback."""
        return (self.refusal or "").startswith("crashed")

    @property
    def honest(self) -> bool:
        """Of a changed scan: corrected, or refused with the remedy that helps."""
        if self.refusal is None:
            return self.plan is not None and self.plan.iou > CORRECTED
        if self.run.change == "on its side":
            return self.names_up
        return self.unit_named


def score(capture: Capture, run: Run, outcome: Outcome) -> Row:
    """Score what a run left."""
    named = any(word in outcome.said.lower() for word in _NAMES_UNIT)
    row = Row(
        capture.name,
        capture.truth.kind,
        run,
        outcome.seconds,
        outcome.refusal,
        unit_named=named and not (outcome.refusal or "").startswith("crashed"),
    )
    if capture.truth.kind == "roomplan":
        scene = outcome.folder / "scene.usda"
        made = export_score(
            scene if row.refusal is None else None, capture.truth, capture.substitutes
        )
        return replace(row, export=made)
    return replace(row, **_scan(capture, run, outcome))


def _scan(capture: Capture, run: Run, outcome: Outcome) -> dict[str, Any]:
    truth = capture.truth
    assert truth.frame is not None
    frame = truth.frame.turned(ON_ITS_SIDE) if run.change == "on its side" else truth.frame
    if outcome.refusal is not None:
        return {} if truth.axis_only else {"plan": missed(truth.rooms[0], None)}
    report = json.loads((outcome.folder / "report.json").read_text(encoding="utf-8"))
    rooms = report["layout"]["rooms"]
    normal = np.array(rooms[0]["floor"]["normal"])
    cosine = normal @ frame.axes[2] / np.linalg.norm(normal)
    found: dict[str, Any] = {"degrees": float(np.degrees(np.arccos(np.clip(cosine, -1, 1))))}
    found["tilted"] = found["degrees"] > AXIS[1]
    if truth.axis_only:
        return found
    if found["tilted"]:
        return found | {"plan": missed(truth.rooms[0], rooms[0])}
    found["plan"] = plan_score(rooms, replace(truth, frame=frame))
    if run.derived:
        return found
    things = things_of(outcome.folder / "scene.usda")
    said = {
        str(item["instance"]): item["category"]
        for item in report.get("alignment", {}).get("objects", ())
    }
    if truth.things and run.labels:
        found["things"] = thing_score(said, things, truth, capture.substitutes)
    level = _level(frame, rooms[0])
    outlines = [level.plan(room["corners"])[:, :2] for room in rooms]
    heights = [h for room in rooms if (h := room.get("ceiling_height")) is not None]
    found["bodies"] = body_score(
        list(things.values()), outlines, level, max(heights) if heights else None
    )
    return found


def _level(frame: Frame, room: dict[str, Any]) -> Frame:
    """The plan on the floor that was found: bodies stand on that, not on the true one."""
    up = np.array(room["floor"]["normal"]) / np.linalg.norm(room["floor"]["normal"])
    across = frame.axes[0] - (frame.axes[0] @ up) * up
    across /= np.linalg.norm(across)
    return Frame(np.array(room["floor"]["point"]), np.stack([across, np.cross(up, across), up]))


def cells(row: Row) -> dict[str, object]:
    """A row for people."""
    line: dict[str, object] = {"capture": row.capture, "run": row.run.name, "s": row.seconds}
    if row.refusal is not None:
        return line | {"said": row.refusal[:80]}
    if row.export is not None:
        return line | _export_cells(row.export)
    line["up"] = None if row.degrees is None else f"{row.degrees:.1f}{' !' if row.tilted else ''}"
    if row.plan is not None:
        line |= {"iou": row.plan.iou, "corners": _counts(row.plan.corners)}
        line["openings"] = _openings(row.plan.openings)
    if row.things is not None:
        t = row.things
        line |= {"category": f"{t.category}/{t.present}/{t.listed}", "size": f"{t.size}/{t.sized}"}
        line["invented"] = f"{t.invented}/{t.other}"
    if row.bodies is not None:
        b = row.bodies
        line["out/in/air"] = f"{b.outside}/{b.pairs}/{b.floating} of {b.things}"
    return line


def _counts(counts: Counts) -> str:
    return f"{counts.hits}/{counts.found}/{counts.true}"


def _openings(found: OpeningScore | None) -> str | None:
    return None if found is None else _counts(found.typed)


def _export_cells(export: ExportScore) -> dict[str, object]:
    missing = [group for group, same in export.same.items() if not same]
    return {
        "category": f"{export.category}/{export.objects}",
        "size": f"{export.size}/{export.objects}",
        "said": f"equal, states {export.states}/{export.doors}"
        if not missing
        else f"not the export's {', '.join(missing)}; states {export.states}/{export.doors}",
    }
