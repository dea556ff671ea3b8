"""What is wrong with the objects of a room as bodies: outside, in each other, in the air."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any, Final

import numpy as np

from benchmarks.real.things import PlacedObject, things_of
from benchmarks.real.truth import Frame, Truth
from benchmarks.scan.contacts import penetration
from openrooms_usd.arrays import Array, Ints

# What counts as wrong, metres: in another thing, and above what carries it.
DEEP: Final = 0.02
ABOVE: Final = 0.05
# A thing hangs where a wall or the ceiling is this near, metres.
HELD: Final = 0.10
_LOWEST: Final = 0.02  # the lowest points are those within this height, metres
_START: Final = 0.03  # a ray down starts this much above them
_LOOKS: Final = 400  # of them at most


@dataclass(frozen=True)
class BodyScore:
    """How many things are wrong.

    Attributes:
        things: All of them.
        outside: Those whose middle is outside of the outline that was found.
        pairs: Pairs that are deeper than `DEEP` in each other.
        floating: Those that are more than `ABOVE` above anything, and hang on nothing.
    """

    things: int = 0
    outside: int = 0
    pairs: int = 0
    floating: int = 0

    def __add__(self, more: "BodyScore") -> "BodyScore":
        return BodyScore(
            self.things + more.things,
            self.outside + more.outside,
            self.pairs + more.pairs,
            self.floating + more.floating,
        )


def body_score(
    things: Sequence[PlacedObject], outlines: Sequence[Array], frame: Frame, ceiling: float | None
) -> BodyScore:
    """Measure the meshes of a room.

    Args:
        things: In the capture's axes.
        outlines: (N, 2) of the rooms that were found, in the plan of `frame`.
        frame: A plan whose floor is at 0.
        ceiling: Its height, metres, if known.
    """
    import shapely

    area = shapely.union_all([shapely.make_valid(shapely.Polygon(ring)) for ring in outlines])
    bodies = [(frame.plan(t.points), t.faces) for t in things if len(t.faces)]
    middles = [frame.plan(thing.middle)[0, :2] for thing in things]
    pairs = sum(
        penetration(a, a_faces, b, b_faces) > DEEP
        for (a, a_faces), (b, b_faces) in combinations(bodies, 2)
    )
    floating = 0
    for k, (points, _) in enumerate(bodies):
        others = [body for j, body in enumerate(bodies) if j != k]
        held = area.boundary.distance(shapely.MultiPoint(points[:, :2]).convex_hull) < HELD
        hung = ceiling is not None and points[:, 2].max() > ceiling - HELD
        floating += not held and not hung and gap_below(points, others) > ABOVE
    return BodyScore(
        len(things),
        sum(not area.contains(shapely.Point(middle)) for middle in middles),
        pairs,
        floating,
    )


def gap_below(points: Array, others: Sequence[tuple[Array, Ints]]) -> float:
    """How far down the first thing below some points is, or the floor at 0; metres."""
    from openrooms_usd.geometry.raycast import RayCaster

    low = points[points[:, 2] < points[:, 2].min() + _LOWEST]
    low = low[np.linspace(0, len(low) - 1, min(len(low), _LOOKS)).astype(int)]
    ground = max(float(low[:, 2].min()), 0.0)
    if ground == 0.0 or not others:
        return ground
    sizes = np.cumsum([0, *[len(some) for some, _ in others]])
    faces = [rows + start for (_, rows), start in zip(others, sizes[:-1], strict=True)]
    caster = RayCaster(np.concatenate([some for some, _ in others]), np.concatenate(faces))
    starts, down = low + np.array([0.0, 0.0, _START]), np.broadcast_to((0.0, 0.0, -1.0), low.shape)
    hits = caster.first_hit(starts, down)
    return min(ground, max(float(hits.distance.min()) - _START, 0.0))


# Whether a room made of a RoomPlan capture has all that its export has.

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
