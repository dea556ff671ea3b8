"""Walls of RoomPlan inside the floor: partitions with their doors and windows."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

from openrooms_usd import names
from openrooms_usd.adapters import IMPORTERS, load
from openrooms_usd.compose import compose_room
from openrooms_usd.usd.partitions import read_partitions


@pytest.mark.slow
def test_a_real_one_is_built_with_its_door_and_window(
    real: Callable[[str], Path], tmp_path: Path
) -> None:
    file = real("real_dev/data/roomplan_library/Room.json")
    (tmp_path / "room.yaml").write_text(f"layout: {{from: roomplan, file: '{file}'}}\n")
    compose_room(tmp_path / "room.yaml", tmp_path / "out", only="layout")
    stage = Usd.Stage.Open(str(tmp_path / "out" / names.SCENE))
    [wall] = read_partitions(stage)
    walls = {
        prim.GetAttribute(names.SOURCE_ID).Get()[:8]: prim.GetRelationship(
            names.OPENING_WALL
        ).GetTargets()
        for prim in stage.GetPrimAtPath(names.OPENINGS).GetChildren()
    }
    assert len(walls) == 4
    # The export names this wall as the parent of one door and of its window.
    assert {key for key, targets in walls.items() if targets == [wall.path]} == {
        "8FE05A62",
        "50A692E7",
    }


def test_a_wall_inside_the_floor_is_a_partition_with_its_door(scanner) -> None:
    """And one outside of it is left out, which is said; the door's own wall wins."""
    corners = np.array([[0, 0], [5, 0], [5, 4], [0, 4]], dtype=float)
    data = scanner.room(corners, 2.5)
    inner = scanner.surface("wall", (4.7, 0), (4.7, 4), 0.0, 2.5, identifier="inner")
    outer = scanner.surface("wall", (6, 1), (6, 3), 0.0, 2.5, identifier="outer")
    data["walls"] += [inner, outer]
    # Nearer to the wall of the outline than to its own.
    data["doors"] = [
        scanner.surface("door", (4.9, 1), (4.9, 1.9), 0.0, 2.0, parentIdentifier="inner")
    ]
    path = scanner.write(data)
    capture = load(IMPORTERS, "roomplan").read(path)
    [one] = capture.partitions
    assert one.id == "inner"
    assert np.linalg.norm(one.ends[1] - one.ends[0]) == pytest.approx(4.0)
    assert one.height == pytest.approx(2.5)
    assert capture.notes == ("left out 1 wall that is outside the floor: outer (2.00 m)",)
    (path.parent / "room.yaml").write_text(f"layout: {{from: roomplan, file: {path.name}}}\n")
    compose_room(path.parent / "room.yaml", path.parent / "out", only="layout")
    stage = Usd.Stage.Open(str(path.parent / "out" / names.SCENE))
    [wall] = read_partitions(stage)
    [door] = stage.GetPrimAtPath(names.OPENINGS).GetChildren()
    assert door.GetRelationship(names.OPENING_WALL).GetTargets() == [wall.path]
    assert stage.GetPrimAtPath(wall.path).GetAttribute(names.SOURCE_ID).Get() == "inner"
