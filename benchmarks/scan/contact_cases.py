"""Hard cases of furniture as bodies: scanned, aligned from rough poses, and put in their places."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final, NamedTuple

import numpy as np

from benchmarks.scan.built import Hole, Placed, built
from benchmarks.scan.contacts import contacts
from benchmarks.scan.hints import rough
from benchmarks.scan.methods import Reconstruction
from benchmarks.scan.pose_scores import TIGHT, PoseError, score_objects
from benchmarks.scan.scanner import Scanner, simulate
from openrooms_usd.scan.results import FoundObject

SCANNER: Final = Scanner(frames=60, reduce=3, voxel=0.016, wrong_labels=0.05)
OUTLINE: Final = ((0.0, 0.0), (5.0, 0.0), (5.0, 4.0), (0.0, 4.0))
DOOR: Final = Hole(0, 3.9, 0.9, 0.0, 2.0, "door")


class ContactCase(NamedTuple):
    """Things in a room of 5 x 4 m.

    Attributes:
        things: Of `benchmarks.scan.built.CADS`; instances are numbered from 1.
        ceiling: Whether the scan shows one.
        impossible: Instances that stand in truth where nothing can: their errors do not count.
    """

    things: tuple[Placed, ...]
    ceiling: bool = True
    impossible: frozenset[int] = frozenset()


CONTACT_CASES: Final[Mapping[str, ContactCase]] = {
    "seen from one side": ContactCase((
        Placed("cabinet", (0.51, 3.79, 0)), Placed("sofa", (2.5, 3.59, 0)),
        Placed("shelf", (4.84, 2.5, 0), -90), Placed("cube", (0.31, 0.31, 0)),
    )),
    "symmetric": ContactCase((
        Placed("cube", (1.5, 1.5, 0), 20), Placed("cube", (4.0, 0.8, 0), 45),
        Placed("table", (3.0, 2.2, 0), 65), Placed("cabinet", (1.5, 3.79, 0)),
    )),
    "chairs under a table": ContactCase((
        Placed("table", (2.5, 2.0, 0)), Placed("chair", (2.2, 1.75, 0), 180),
        Placed("chair", (2.8, 2.25, 0)), Placed("chair", (1.65, 2.0, 0), 90),
    )),
    "stacked shelves": ContactCase((
        Placed("shelf", (2.5, 3.85, 0)), Placed("shelf", (2.5, 3.85, 1.0)),
        Placed("shelf", (3.31, 3.85, 0)),
    )),
    "boxes in a shelf": ContactCase((
        Placed("shelf", (2.5, 3.85, 0)), Placed("carton", (2.3, 3.84, 0.02)),
        Placed("carton", (2.6, 3.84, 0.35)), Placed("carton", (2.35, 3.84, 0.68)),
        Placed("carton", (2.6, 3.84, 1.0)),
    )),
    "table through a wall": ContactCase((
        Placed("table", (2.5, 3.66, 0)), Placed("chair", (2.5, 2.9, 0), 180),
    ), impossible=frozenset({1})),
    "counters in a row": ContactCase((
        Placed("counter", (0.32, 3.69, 0)), Placed("counter", (0.93, 3.69, 0)),
        Placed("counter", (1.54, 3.69, 0)), Placed("counter", (2.15, 3.69, 0)),
    )),
    "L-shaped sofa around a table": ContactCase((
        Placed("sectional", (3.99, 2.99, 0)), Placed("cube", (3.6, 2.55, 0)),
        Placed("chair", (2.2, 1.0, 0), 30),
    )),
    "table and chairs on a rug": ContactCase((
        Placed("rug", (2.5, 2.0, 0)), Placed("table", (2.5, 2.0, 0.012)),
        Placed("chair", (2.2, 1.75, 0.012), 180), Placed("chair", (2.8, 2.3, 0.012)),
    )),
    "television on its wall above a cabinet": ContactCase((
        Placed("cabinet", (2.5, 3.79, 0)), Placed("television", (2.5, 3.965, 0.95)),
    )),
    "pendant lamp, ceiling not seen": ContactCase((
        Placed("pendant", (2.5, 2.0, 1.7)), Placed("table", (2.5, 2.0, 0)),
    ), ceiling=False),
}  # fmt: skip


def contact_cases(quick: bool, seed: int = 1) -> list[dict[str, Any]]:
    """One row for each case: errors before placement and after it, and what is wrong then."""
    names = list(CONTACT_CASES)[:2] if quick else list(CONTACT_CASES)
    return [{"case": name, **_row(CONTACT_CASES[name], seed)} for name in names]


def _row(case: ContactCase, seed: int) -> dict[str, Any]:
    room = built(OUTLINE, holes=(DOOR,), things=case.things)
    scan = simulate(room, seed, replace(SCANNER, ceiling=case.ceiling))
    ours = Reconstruction(scan.cloud)
    truth = scan.truth.moved(ours.level.level_from_scan)
    hints = rough(truth.objects, truth.cads, seed, "pose")
    found = ours.aligned(hints, truth.cads).objects
    placed = ours.placed(found, truth.cads)
    possible = [item for item in truth.objects if item.instance not in case.impossible]
    scores = [s for s in score_objects(placed.objects, possible) if s.error and s.placed]
    wrong = contacts(placed.objects, truth.cads, truth.rooms, possible).summary()
    return {
        "objects": len(truth.objects),
        "found": len(found),
        **_errors("measured", [score.error for score in scores if score.error]),
        **_errors("placed", [score.placed for score in scores if score.placed]),
        **{key: wrong[key] for key in ("pairs_deep", "in_walls", "floating")},
        "unresolved": len(placed.unresolved),
        "farthest_moved": max(map(_moved, placed.objects), default=0.0),
    }


def _errors(when: str, errors: list[PoseError]) -> dict[str, Any]:
    return {
        f"{when}_metres": max((error.translation for error in errors), default=None),
        f"{when}_degrees": max((error.degrees for error in errors), default=None),
        f"{when}_tight": sum(error.within(TIGHT) for error in errors) / max(len(errors), 1),
    }


def _moved(item: FoundObject) -> float:
    placed = item.placed or item.pose
    return float(np.linalg.norm(placed.translation - item.pose.translation))
