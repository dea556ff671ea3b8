"""People move things in the edits layer; every step runs again over that without a word."""

from pathlib import Path

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from openrooms_usd.composing import compose_room

ROOM = """\
seed: {seed}
layout:
  openings:
    - {{name: door, kind: door, wall: 0, open: 60}}
furniture:
  objects:
    - {{name: sofa, category: sofa, at: [2, 3], yaw: 20}}
cameras:
  views:
    - {{name: eye, eye: [1, 1, 1.5], target: [3, 3, 1]}}
"""
MOVED = [
    "/World/Room/Openings/door",
    "/World/Room/Openings/door/Leaf",
    "/World/Furniture/sofa",
    "/World/Cameras/eye",
    "/World/Lights/Portals/door",
]


@pytest.mark.slow
@pytest.mark.parametrize("path", MOVED)
def test_a_moved_prim_stays_where_it_was_put(tmp_path: Path, path: str) -> None:
    description = tmp_path / "room.yaml"
    description.write_text(ROOM.format(seed=1))
    scene = compose_room(description, tmp_path).scene
    stage = Usd.Stage.Open(str(scene))
    stage.SetEditTarget(Sdf.Layer.FindOrOpen(str(tmp_path / "layers" / "edits.usda")))
    moved = UsdGeom.Xformable(stage.GetPrimAtPath(path))
    operation = moved.AddTranslateOp(opSuffix="byHand")
    operation.Set(Gf.Vec3d(0.1, 0.2, 0.0))
    wanted = moved.ComputeLocalToWorldTransform(Usd.TimeCode.Default())
    stage.GetEditTarget().GetLayer().Save()
    del stage

    description.write_text(ROOM.format(seed=2))
    summary = compose_room(description, tmp_path)
    assert [row.state for row in summary.stages] == ["written"] * 6
    again = Usd.Stage.Open(str(scene))
    found = UsdGeom.Xformable(again.GetPrimAtPath(path)).ComputeLocalToWorldTransform(
        Usd.TimeCode.Default()
    )
    assert Gf.IsClose(found, wanted, 1e-9)
