"""The lines of a plan are those of the description that the room was composed from."""

import math
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from openrooms_usd.composing import compose_room
from openrooms_usd.description import load_room
from openrooms_usd.view.room import plan_of

ROOM = """\
layout:
  from: polygon
  polygon: [[0, 0], [5, 0], [5, 3], [4, 4], [0, 4]]
  openings:
    - {kind: window, wall: 0, at: 1.5, width: 1.2, height: 1.1, sill: 0.9}
    - {kind: door, wall: 2, width: 0.8, height: 2.1}
"""


def test_outline_and_openings_are_those_that_were_described(tmp_path: Path) -> None:
    (tmp_path / "room.yaml").write_text(ROOM)
    layout = load_room(tmp_path / "room.yaml").layout
    scene = compose_room(tmp_path / "room.yaml", tmp_path / "out").scene
    lines = np.array(plan_of(Usd.Stage.Open(str(scene)))).reshape(-1, 2, 3)
    corners = np.array(layout.polygon)
    floor, openings = lines[: len(corners)], lines[len(corners) :].reshape(-1, 4, 2, 3)
    assert np.abs(floor[:, 0, :2] - corners).max() < 1e-9 and not floor[..., 2].any()
    assert np.abs(floor[:, 1] - np.roll(floor[:, 0], -1, axis=0)).max() == 0.0
    assert len(openings) == len(layout.openings) > 0
    # Prims are in the order of their names: door_0, window_0.
    described = sorted(layout.openings, key=lambda opening: opening.kind)
    for rectangle, opening in zip(openings, described, strict=True):
        start = corners[opening.wall]
        along = np.roll(corners, -1, axis=0)[opening.wall] - start
        length = math.hypot(*along)
        along, outwards = along / length, np.array([along[1], -along[0]]) / length
        places = rectangle[:, 0]
        middle = 0.5 * length if opening.at is None else opening.at
        across = sorted((places[:, :2] - start) @ along - middle)
        half = 0.5 * opening.width
        assert np.abs(np.array(across) - [-half, -half, half, half]).max() < 1e-6
        assert np.abs((places[:, :2] - start) @ outwards).max() < 1e-9
        sill = opening.sill or 0.0
        assert sorted(places[:, 2].round(9)) == pytest.approx(
            [sill, sill, sill + opening.height, sill + opening.height]
        )


def test_a_stage_in_centimetres_with_y_up_has_the_same_plan(composed_demo: Path) -> None:
    flat = Usd.Stage.Open(str(composed_demo)).Flatten()
    stage = Usd.Stage.Open(flat)
    expected = np.array(plan_of(stage))
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    found = np.array(plan_of(stage))
    x, y, z = expected.T * 0.01
    assert np.abs(found - np.column_stack([x, -z, y])).max() < 1e-9


def test_a_stage_without_a_room_has_none() -> None:
    assert plan_of(Usd.Stage.CreateInMemory()) == []
