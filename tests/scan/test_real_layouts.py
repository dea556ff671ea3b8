"""Rooms of real captures are those that people traced; skips where the captures are absent."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.scan.real_rooms import found_plans, iou, truth_of


@pytest.mark.long
@pytest.mark.slow
def test_two_rooms_of_a_laser_scan_without_the_yard_before_the_gate(real: Callable[[str], Path]):
    folder = real("real_dev")
    truth = truth_of(folder, "laser_offset")
    _, plans = found_plans(folder / "data/laser_offset/scan.ply", truth, {})
    hall, room = truth["rooms"]
    assert max(iou(plans[0], shape) for shape in [hall["polygon"], *hall["alternatives"]]) > 0.97
    assert iou(plans[1], room["polygon"]) > 0.97
