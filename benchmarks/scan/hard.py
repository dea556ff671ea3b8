"""Hard cases and bad input: what each gives, and how far it is from the truth."""

from typing import Any, Final

import numpy as np

from benchmarks.scan.contacts import contacts
from benchmarks.scan.hard_scans import CASES, HardCase
from benchmarks.scan.hints import countable, rough
from benchmarks.scan.methods import Reconstruction
from benchmarks.scan.pose_scores import pose_summary, score_objects
from benchmarks.scan.scores import score_rooms
from openrooms_usd.errors import OrusdError

QUICK_CASES: Final = ("empty cloud", "one wall", "bathroom, 2 m")


def hard_cases(quick: bool, seed: int = 1) -> list[dict[str, Any]]:
    """One row for each case."""
    names = QUICK_CASES if quick else tuple(CASES)
    return [{"case": name, **_row(CASES[name](seed))} for name in names]


def _row(case: HardCase) -> dict[str, Any]:
    cloud = case.scan.cloud.moved(_metres(case.unit)) if case.unit != 1.0 else case.scan.cloud
    ours = Reconstruction(cloud)
    try:
        rooms = ours.scan_rooms
    except OrusdError as error:
        return {"as_it_should": not case.usable, "outcome": f"refused: {error.message}"}
    if not rooms:
        return {"as_it_should": not case.usable, "outcome": "no room"}
    score = min(score_rooms(rooms, case.scan.truth.rooms), key=lambda room: room.iou)
    return {
        "as_it_should": case.usable,
        "outcome": f"{len(rooms)} room{'s' * (len(rooms) > 1)}",
        "iou": score.iou,
        "corners": f"{score.corners.hits}/{score.corners.found}/{score.corners.true}",
        "openings": f"{score.openings.hits}/{score.openings.found}/{score.openings.true}",
        "floor_degrees": score.floor_degrees,
        "floor_offset": score.floor_offset,
        **_objects(case, ours),
        "seconds": sum(ours.seconds.values()),
    }


def _objects(case: HardCase, ours: Reconstruction) -> dict[str, Any]:
    """The furniture from rough poses, aligned and placed."""
    truth = case.scan.truth.moved(ours.level.level_from_scan)
    if case.scan.cloud.instance is None:
        return {}
    items = countable(truth, case.scan.cloud)
    found = ours.aligned(rough(items, truth.cads, 1, "pose"), truth.cads).objects
    placed = ours.placed(found, truth.cads)
    poses = pose_summary(score_objects(placed.objects, items))
    wrong = contacts(placed.objects, truth.cads, truth.rooms, truth.objects).summary()
    return {
        "objects": len(items),
        **{key: poses[key] for key in ("tight", "tight_placed")},
        **{key: wrong[key] for key in ("pairs_deep", "in_walls", "floating")},
        "unresolved": len(placed.unresolved),
    }


def _metres(unit: float) -> np.ndarray:
    return np.diag([unit, unit, unit, 1.0])
