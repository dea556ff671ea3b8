"""Poses come out of the layer as they went in, whatever operations the prims have."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from openrooms_usd.geometry.quaternions import pose_of
from openrooms_usd.usd.places.frames import TIME, local_to_world, world_from_stage
from openrooms_usd.usd.places.settled import Motion, author_motions

MOTION = pose_of([0.1, -0.02, 0.3], [0.1, -0.2, 0.3, 0.9])
OTHER = pose_of([-0.3, 0.2, 0.05], [0.4, 0.1, -0.2, 0.8])


def stage_with(y_up: bool = False, scale: float = 1.0) -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y if y_up else UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, scale)
    world = UsdGeom.Xform.Define(stage, "/World")
    world.AddRotateZOp().Set(20.0)
    thing = UsdGeom.Xform.Define(stage, "/World/thing")
    # As aligned things are: what corrects them stands before what was measured.
    thing.AddTranslateOp(opSuffix="placed").Set(Gf.Vec3d(1, 2, 3))
    thing.AddOrientOp(opSuffix="placed").Set(Gf.Quatf(0.8, 0.6, 0, 0))
    thing.AddTranslateOp().Set(Gf.Vec3d(0.5, 0, 0))
    thing.AddRotateXYZOp().Set(Gf.Vec3f(10, 20, 30))
    thing.AddScaleOp().Set(Gf.Vec3f(1, 2, -1))
    leaf = UsdGeom.Xform.Define(stage, "/World/thing/leaf")
    leaf.AddTranslateOp().Set(Gf.Vec3d(0.2, 0, 0))
    return stage


def poses(stage: Usd.Stage, *paths: str) -> list[np.ndarray]:
    cache = UsdGeom.XformCache(TIME)
    S = world_from_stage(stage)
    return [S @ local_to_world(stage.GetPrimAtPath(path), cache) for path in paths]


@pytest.mark.parametrize(("y_up", "scale"), [(False, 1.0), (True, 0.01)])
@pytest.mark.parametrize("side", ["before", "after"])
def test_a_thing_and_its_part_move_as_they_should(y_up: bool, scale: float, side: str) -> None:
    stage = stage_with(y_up, scale)
    paths = "/World/thing", "/World/thing/leaf"
    before = poses(stage, *paths)
    motions = [Motion(paths[1], OTHER, "after"), Motion(paths[0], MOTION, side)]  # type: ignore[arg-type]
    assert author_motions(stage, motions) == []
    after = poses(stage, *paths)
    assert after[0] == pytest.approx(MOTION @ before[0], abs=1e-6)
    assert after[1] == pytest.approx(OTHER @ before[1], abs=1e-6)


def test_a_prims_own_operations_stay() -> None:
    stage = stage_with()
    prim = stage.GetPrimAtPath("/World/thing")
    own = list(UsdGeom.Xformable(prim).GetXformOpOrderAttr().Get())
    author_motions(stage, [Motion("/World/thing", MOTION, "before")])
    order = list(UsdGeom.Xformable(prim).GetXformOpOrderAttr().Get())
    assert order == ["xformOp:translate:settled", "xformOp:orient:settled", *own]


def test_what_has_not_moved_gets_no_opinion(tmp_path: Path) -> None:
    stage = stage_with()
    layer = Sdf.Layer.CreateAnonymous(".usda")
    stage.GetSessionLayer().subLayerPaths.append(layer.identifier)
    with Usd.EditContext(stage, layer):
        author_motions(stage, [Motion("/World/thing", np.eye(4), "before")])
    assert not layer.GetPrimAtPath("/World/thing")


def test_a_stronger_order_of_operations_is_told() -> None:
    stage = stage_with()
    edits = Sdf.Layer.CreateAnonymous(".usda")
    stage.GetSessionLayer().subLayerPaths.append(edits.identifier)
    with Usd.EditContext(stage, edits):
        prim = stage.GetPrimAtPath("/World/thing")
        UsdGeom.Xformable(prim).CreateXformOpOrderAttr(["xformOp:translate"])
    assert author_motions(stage, [Motion("/World/thing", MOTION, "before")]) == ["/World/thing"]
