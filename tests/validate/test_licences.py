"""Whose terms hold for which asset and which texture."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner
from pxr import Kind, Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd.cli.validating import validate
from openrooms_usd.usd.light.lights import define_dome
from openrooms_usd.validation.licences import Licence, licences

Rows = set[tuple[str, str, str, int]]


def _texture(stage: Usd.Stage, path: str, file: str) -> None:
    UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, f"{path}/color")
    shader.CreateIdAttr("UsdUVTexture")
    shader.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(Sdf.AssetPath(file))


def _asset(path: Path, licence: str = "") -> None:
    stage = Usd.Stage.CreateNew(str(path))
    root = UsdGeom.Xform.Define(stage, "/Thing").GetPrim()
    stage.SetDefaultPrim(root)
    Usd.ModelAPI(root).SetKind(Kind.Tokens.component)
    _texture(stage, "/Thing/Materials/wood", "./wood.png")
    if licence:
        root.SetAssetInfoByKey("license", licence)
        _texture(stage, "/Thing/Materials/tile", "./tile.png")
        stage.GetPrimAtPath("/Thing/Materials/tile").SetAssetInfoByKey("license", "ISC")
    stage.Save()


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """Two copies of a licensed asset, an unlicensed one, and textures of every provenance."""
    for name, licence in (("bought", "CC-BY-4.0"), ("found", "")):
        (tmp_path / name).mkdir()
        for picture in ("wood", "tile"):
            (tmp_path / name / f"{picture}.png").write_bytes(b"")
        _asset(tmp_path / name / "asset.usda", licence)
    stage = Usd.Stage.CreateNew(str(tmp_path / "scene.usda"))
    UsdGeom.Xform.Define(stage, "/World")
    for name, file in (("a", "bought"), ("b", "bought"), ("c", "found")):
        prim = UsdGeom.Xform.Define(stage, f"/World/{name}").GetPrim()
        prim.GetReferences().AddReference(f"./{file}/asset.usda")
        prim.SetInstanceable(True)
        prim.SetAssetInfoByKey("name", file)
    _texture(stage, "/World/Materials/own", "./own.png")
    stage.GetPrimAtPath("/World/Materials/own").SetAssetInfoByKey("license", "CC0-1.0")
    _texture(stage, "/World/Materials/sidecar", "./sidecar.png")
    _texture(stage, "/World/Materials/bare", "./bare.png")
    for name in ("own", "sidecar", "bare", "sky"):
        (tmp_path / f"{name}.png").write_bytes(b"")
    (tmp_path / "sidecar.png.license").write_text("Me, 2026\nSPDX-License-Identifier: MIT\n")
    define_dome(stage, "/World/Sky", texture="./sky.png")
    stage.GetPrimAtPath("/World/Sky").SetAssetInfoByKey("license", "CC0-1.0")
    stage.Save()
    return tmp_path / "scene.usda"


def _rows(scene: Path) -> Rows:
    return {(t.licence, t.kind, t.name, t.prims) for t in licences(Usd.Stage.Open(str(scene)))}


def test_every_asset_and_texture_has_the_nearest_terms(scene: Path) -> None:
    assert _rows(scene) == {
        ("CC-BY-4.0", "asset", "bought", 2),
        ("CC-BY-4.0", "texture", "bought/wood.png", 2),
        ("ISC", "texture", "bought/tile.png", 2),
        ("unknown", "asset", "found", 1),
        ("unknown", "texture", "found/wood.png", 1),
        ("CC0-1.0", "texture", "own.png", 1),
        ("CC0-1.0", "texture", "sky.png", 1),
        ("MIT", "texture", "sidecar.png", 1),
        ("unknown", "texture", "bare.png", 1),
    }


def test_a_sidecar_without_spdx_gives_its_first_line(scene: Path) -> None:
    scene.with_name("bare.png.license").write_text("for my friends\nand nobody else\n")
    assert ("for my friends", "texture", "bare.png", 1) in _rows(scene)


def test_the_order_is_stable() -> None:
    stage = Usd.Stage.CreateInMemory()
    for name in "cab":
        prim = UsdGeom.Xform.Define(stage, f"/{name}").GetPrim()
        prim.SetAssetInfoByKey("license", "MIT")
    assert licences(stage) == [Licence("MIT", "asset", name, 1) for name in "abc"]


def test_the_command_lists_them_and_warns_of_the_unknown(scene: Path) -> None:
    plain = CliRunner().invoke(validate, [str(scene)], env={"COLUMNS": "160"})
    assert "sidecar.png" in plain.stdout and "CC-BY-4.0" in plain.stdout
    assert "warning: 3 assets and textures do not say" in plain.stderr
    report = json.loads(CliRunner().invoke(validate, [str(scene), "--json"]).stdout)
    rows = {(t["licence"], t["kind"], t["name"], t["prims"]) for t in report["licences"]}
    assert rows == _rows(scene)
