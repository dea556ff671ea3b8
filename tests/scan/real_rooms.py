"""Rooms found in captures of real rooms, in the plan of their traced truth."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from openrooms_usd.capture import read_capture
from openrooms_usd.scan.reconstruction import FoundLayout, find_rooms
from openrooms_usd.stages.layout.scanned import in_metres

Array = NDArray[np.float64]


def truth_of(folder: Path, name: str) -> dict[str, Any]:
    """What is true of a capture."""
    truth: dict[str, Any] = json.loads((folder / "truth" / f"{name}.json").read_text())
    return truth


def found_plans(
    scan: Path, truth: dict[str, Any], options: dict[str, str]
) -> tuple[FoundLayout, list[Array]]:
    """The rooms of a scan, and (N, 2) the corners of each in the plan of the truth."""
    capture = read_capture("scan", scan, options)
    assert capture.cloud is not None
    found = find_rooms(capture.cloud)
    back = in_metres(capture.source_from_world) @ found.level.scan_from_level
    frame = truth["frame"]
    axes = np.column_stack([frame["x"], frame["y"]])
    plans = [
        (room.corners @ back[:3, :3].T + back[:3, 3] - frame["origin"]) @ axes
        for room in found.rooms
    ]
    return found, plans


def iou(plan: Array, true: Any) -> float:
    """Intersection over union of two outlines."""
    a, b = shapely.Polygon(plan), shapely.Polygon(true)
    return float(a.intersection(b).area / a.union(b).area)
