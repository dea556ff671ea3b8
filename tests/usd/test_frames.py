"""Frames against USD's own matrices."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from openrooms_usd.usd.places.frames import (
    gf_matrix,
    local_to_world,
    matrix,
    meters_per_unit,
    odd_frame,
    world_from_stage,
)


@pytest.mark.parametrize(
    ("axis", "unit", "point", "expected"),
    [
        ("Z", 1.0, (1, 2, 3), (1, 2, 3)),
        ("Z", 0.01, (100, 200, 300), (1, 2, 3)),
        ("Y", 1.0, (1, 2, 3), (1, -3, 2)),  # up becomes up; what faced the viewer faces -Y
        ("Y", 0.001, (1000, 2000, 3000), (1, -3, 2)),
    ],
)
def test_stages_turn_to_z_up_and_metres(
    axis: str, unit: float, point: tuple[int, ...], expected: tuple[int, ...]
) -> None:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, axis)
    UsdGeom.SetStageMetersPerUnit(stage, unit)
    world = world_from_stage(stage)
    np.testing.assert_allclose(world @ [*point, 1.0], [*expected, 1.0])
    assert np.linalg.det(world[:3, :3]) == pytest.approx(unit**3)


def test_the_turn_is_a_quarter_about_x() -> None:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, "Y")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    turn = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 0, 0), 90.0))
    np.testing.assert_allclose(world_from_stage(stage), matrix(turn), atol=1e-12)


def test_matrices_act_on_columns_as_usds_do_on_rows() -> None:
    stage = Usd.Stage.CreateInMemory()
    outer = UsdGeom.Xform.Define(stage, "/outer")
    outer.AddTranslateOp().Set((1, 2, 3))
    outer.AddRotateXYZOp().Set((10, 20, 30))
    inner = UsdGeom.Xform.Define(stage, "/outer/inner")
    inner.AddScaleOp().Set((1, 2, 3))
    placed = inner.ComputeLocalToWorldTransform(Usd.TimeCode.Default())
    point = Gf.Vec3d(0.3, -0.4, 0.5)
    found = local_to_world(inner.GetPrim(), UsdGeom.XformCache()) @ [*point, 1.0]
    np.testing.assert_allclose(found[:3], placed.Transform(point))
    assert gf_matrix(matrix(placed)) == placed


@pytest.mark.parametrize("written", [np.float32(0.25), 1, 0.25])
def test_units_of_any_number_are_read(tmp_path: Path, written: Any) -> None:
    """USD's own function raises where a crate holds a float, as Blender 2.8 wrote it."""
    file = tmp_path / "stage.usdc"
    layer = Sdf.Layer.CreateNew(str(file))
    root = layer.pseudoRoot
    value = Vt.Float(float(written)) if isinstance(written, np.floating) else written
    root.SetInfo("metersPerUnit", value)
    layer.Save()
    stage = Usd.Stage.Open(str(file))
    assert meters_per_unit(stage) == float(written)
    assert world_from_stage(stage)[0, 0] == float(written)
    assert odd_frame(stage) == []


def test_units_that_are_no_number_are_told() -> None:
    # USD would not let anybody write these, but reads them.
    said = {"metersPerUnit": "an inch", "upAxis": "X"}
    stage: Any = SimpleNamespace(GetMetadata=said.__getitem__)
    assert meters_per_unit(stage) == 0.01
    metres, up = odd_frame(stage)
    assert "is not a length" in metres and "'X' is not an axis" in up
