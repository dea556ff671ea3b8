"""Rooms of real captures are those that people traced; skips where the captures are absent."""

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from openrooms_usd.arrays import Array
from openrooms_usd.capture import read_capture
from openrooms_usd.scan.openings.detection import find_openings
from openrooms_usd.scan.points.thinning import thin
from openrooms_usd.scan.reconstruction import VOXEL_M, FoundLayout, find_rooms
from openrooms_usd.scan.results import FoundOpening
from openrooms_usd.steps.layout.scanned import in_metres


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


# An opening is found if its middle is so near to that of a true one, metres.
NEAR_M = 0.4


@pytest.mark.long
@pytest.mark.slow
def test_two_rooms_of_a_laser_scan_without_the_yard_before_the_gate(real: Callable[[str], Path]):
    folder = real("real_dev")
    truth = truth_of(folder, "laser_offset")
    _, plans = found_plans(folder / "data/laser_offset/scan.ply", truth, {})
    hall, room = truth["rooms"]
    assert max(iou(plans[0], shape) for shape in [hall["polygon"], *hall["alternatives"]]) > 0.97
    assert iou(plans[1], room["polygon"]) > 0.97


def found_in(
    real: Callable[[str], Path], name: str, *, labels: bool, room: int = 0
) -> tuple[Sequence[FoundOpening], list[dict[str, Any]]]:
    """What is found in the true room of a capture, in the frame of its truth; and its truth."""
    cloud = read_capture("scan", real(f"real_dev/data/{name}/scan.ply")).cloud
    truth = json.loads(real(f"real_dev/truth/{name}.json").read_text())
    assert cloud is not None
    if not labels:
        cloud = replace(cloud, label=None, instance=None)
    frame, traced = truth["frame"], truth["rooms"][room]
    level = np.eye(4)
    level[:3, :3] = [frame["x"], frame["y"], frame["up"]]
    level[:3, 3] = -level[:3, :3] @ frame["origin"]
    corners = np.array(traced["polygon"])
    found = find_openings(thin(cloud, VOXEL_M).moved(level), corners, traced["ceiling_height"])
    return found, [opening for opening in traced["openings"] if opening["certain"]]


def right(found: Sequence[FoundOpening], truths: list[dict[str, Any]]) -> int:
    """The number of openings that are where one of their kind is."""
    middles = {k: np.mean(t["segment"], axis=0) for k, t in enumerate(truths)}
    hits = set()
    for opening in found:
        for k, middle in middles.items():
            away = np.linalg.norm(opening.corners.mean(axis=0)[:2] - middle)
            if away < NEAR_M and truths[k]["type"] == opening.type:
                hits.add(k)
    return len(hits)


@pytest.mark.slow
@pytest.mark.parametrize(("labels", "least"), [(True, 5), (False, 3)])
def test_drifted_scan_of_a_phone(real: Callable[[str], Path], labels: bool, least: int) -> None:
    found, truths = found_in(real, "scannet_0002_00", labels=labels)
    hits = right(found, truths)
    assert hits >= least
    assert len(found) - hits <= 1


@pytest.mark.slow
def test_sparse_laser_scan(real: Callable[[str], Path]) -> None:
    found, truths = found_in(real, "laser_offset", labels=False)
    assert right(found, truths) >= 2
