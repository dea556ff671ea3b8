"""Layers are split, stacked and saved without changing what is composed."""

from pathlib import Path

import pytest
from pxr import Sdf, Usd, UsdGeom, Vt

from openrooms_usd.errors import InputError
from openrooms_usd.usd.files import layers


def authored() -> Sdf.Layer:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layers.apply_metadata(layer)
    stage = Usd.Stage.Open(layer)
    UsdGeom.Xform.Define(stage, "/World")
    mesh = UsdGeom.Mesh.Define(stage, "/World/Grid")
    mesh.CreatePointsAttr([(float(i), 0.0, 0.0) for i in range(300)])
    mesh.CreateFaceVertexCountsAttr([3])
    UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex
    ).Set([(0.0, float(i)) for i in range(300)])
    return layer


def test_long_arrays_move_to_a_sublayer_and_compose_to_the_same(tmp_path: Path) -> None:
    layer = authored()
    binary = layers.arrays_file(layer, tmp_path / "grid")
    layers.export(layer, tmp_path / "grid.usda")
    assert binary is not None
    assert binary.suffix == ".usdc"
    assert len((tmp_path / "grid.usda").read_text()) < 1000
    stage = layers.open_stage(tmp_path / "grid.usda")
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Grid"))
    assert len(mesh.GetPointsAttr().Get()) == 300
    assert mesh.GetFaceVertexCountsAttr().Get() == Vt.IntArray([3])
    st = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
    assert (st.GetInterpolation(), len(st.Get())) == (UsdGeom.Tokens.vertex, 300)


def test_the_binary_file_is_named_by_its_bytes(tmp_path: Path) -> None:
    first = layers.arrays_file(authored(), tmp_path / "a")
    again = layers.arrays_file(authored(), tmp_path / "b")
    assert first is not None
    assert again is not None
    assert (first.name, first.read_bytes()) == (again.name, again.read_bytes())
    assert [path.name for path in (tmp_path / "a").iterdir()] == [first.name]


def test_a_stacked_stage_writes_only_to_its_target(tmp_path: Path) -> None:
    weak, strong, target = (tmp_path / f"{name}.usda" for name in ("weak", "strong", "target"))
    layers.export(authored(), weak)
    over = Sdf.Layer.CreateAnonymous(".usda")
    spec = Sdf.CreatePrimInLayer(over, "/World/Grid")
    Sdf.AttributeSpec(spec, "mark", Sdf.ValueTypeNames.Int).default = 7
    layers.export(over, strong)
    layer = Sdf.Layer.CreateNew(str(target))
    with layers.stacked(layer, [strong, tmp_path / "missing.usda"], [weak]) as stage:
        prim = stage.GetPrimAtPath("/World/Grid")
        assert prim.GetAttribute("mark").Get() == 7
        stage.OverridePrim("/World/Grid").SetCustomDataByKey("seen", True)
    assert layer.GetPrimAtPath("/World/Grid").specifier == Sdf.SpecifierOver
    below = Sdf.Layer.FindOrOpen(str(weak))
    assert not below.GetPrimAtPath("/World/Grid").HasInfo("customData")


def test_a_replaced_file_is_read_again(tmp_path: Path) -> None:
    weak = tmp_path / "weak.usda"
    layers.export(authored(), weak)
    held = Sdf.Layer.FindOrOpen(str(weak))
    assert held
    changed = authored()
    Sdf.CreatePrimInLayer(changed, "/World/New")
    layers.export(changed, weak)
    with layers.stacked(Sdf.Layer.CreateAnonymous(".usda"), [], [weak]) as stage:
        assert stage.GetPrimAtPath("/World/New")


@pytest.mark.parametrize("text", ["", "#usda 1.0\ndef Mesh {", "not usd at all"])
def test_a_file_that_is_no_usd_is_an_input_error(tmp_path: Path, text: str) -> None:
    path = tmp_path / "broken.usda"
    path.write_text(text)
    with pytest.raises(InputError, match="not a readable USD file"):
        layers.open_stage(path)


def test_a_missing_file_is_an_input_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        layers.open_stage(tmp_path / "none.usda")
