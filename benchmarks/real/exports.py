"""Whether a room made of a RoomPlan capture has all that its export has."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from benchmarks.real.things import PlacedObject, things_of
from benchmarks.real.truth import Truth

# The groups of an export, and the kinds of openings that they become.
OPENINGS: Final = {"doors": "door", "windows": "window", "passages": "opening"}
NEAR: Final = 0.35  # metres in the plan
OPEN: Final = 5.0  # degrees; a leaf that is turned by more stands open
_SIZE: Final = (0.6, 1.6)
_THINNEST: Final = 0.02  # metres


@dataclass(frozen=True)
class ExportScore:
    """A composed room against its export.

    Attributes:
        made: Identifiers of what was made, by group.
        same: Whether each group has the export's identifiers, and no others.
        states: Doors that stand open or closed as captured.
        doors: Doors of the export.
        category: Objects whose category does for their label.
        size: Objects of the right size.
        place: Objects in their place.
        objects: Objects of the export that were made.
    """

    made: Mapping[str, frozenset[str]]
    same: Mapping[str, bool]
    states: int
    doors: int
    category: int
    size: int
    place: int
    objects: int

    @property
    def equal(self) -> bool:
        """Doors, windows and objects are the export's; a mesh export has no passages."""
        return all(same for group, same in self.same.items() if group != "passages")


def export_score(
    scene: Path | None, truth: Truth, substitutes: Mapping[str, Sequence[str] | None]
) -> ExportScore:
    """Score a composed stage; without one nothing was made."""
    raw = truth.raw
    wanted = {group: {entry["id"] for entry in raw[group]} for group in (*OPENINGS, "objects")}
    openings = _openings(scene) if scene else {}
    things = things_of(scene) if scene else {}
    made = {
        group: {key for key, (found, _) in openings.items() if found == kind}
        for group, kind in OPENINGS.items()
    }
    made["objects"] = set(things)
    states = sum(
        door["id"] in made["doors"] and door["open"] == (openings[door["id"]][1] > OPEN)
        for door in raw["doors"]
    )
    right = [
        _right(things[entry["id"]], entry, substitutes)
        for entry in raw["objects"]
        if entry["id"] in things
    ]
    category, size, place = (sum(r[k] for r in right) for k in range(3))
    return ExportScore(
        {group: frozenset(keys) for group, keys in made.items()},
        {group: bool(scene) and made[group] == wanted[group] for group in wanted},
        states,
        len(raw["doors"]),
        category,
        size,
        place,
        len(right),
    )


def _right(
    thing: PlacedObject, entry: Mapping[str, Any], substitutes: Mapping[str, Sequence[str] | None]
) -> tuple[bool, bool, bool]:
    """Whether category, size and place of an object are the export's."""
    accepted = substitutes.get(entry["label"]) or [entry["label"]]
    width, height, depth = entry["size"]
    ratios = [
        a / max(b, _THINNEST)
        for a, b in zip(thing.size, (max(width, depth), min(width, depth), height), strict=True)
    ]
    place = np.array(entry["transform"][12:15])
    away = np.linalg.norm((thing.middle - place)[[0, 2]])
    return (
        any(thing.prim.startswith(category) for category in accepted),
        all(_SIZE[0] <= ratio <= _SIZE[1] for ratio in ratios),
        bool(away < NEAR),
    )


def _openings(scene: Path) -> dict[str, tuple[str, float]]:
    """Kind of each opening of a stage, and the degrees by which its leaf is turned."""
    from pxr import Usd

    stage = Usd.Stage.Open(str(scene))
    group = stage.GetPrimAtPath("/World/Room/Openings")
    found: dict[str, tuple[str, float]] = {}
    for prim in group.GetChildren() if group else ():
        key = str(prim.GetAttribute("openrooms:source:id").Get())
        leaf = prim.GetChild("Leaf")
        turns = [
            float(np.max(np.abs(np.atleast_1d(attribute.Get()))))
            for attribute in (leaf.GetAttributes() if leaf else ())
            if attribute.GetName().startswith("xformOp:rotate")
        ]
        kind = str(prim.GetAttribute("openrooms:opening:kind").Get())
        found[key] = (kind, max(turns, default=0.0))
    return found
