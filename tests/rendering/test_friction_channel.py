"""The friction channel: of any renderer's channels, by the stage's substances."""

import json

import numpy as np
from pxr import Sdf, Usd, UsdShade
from scipy.interpolate import RegularGridInterpolator

from openrooms_usd import names
from openrooms_usd.channels import CHANNELS
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.library.friction import table
from openrooms_usd.library.friction.references import SUBSTANCES
from openrooms_usd.rendering import Legend, exr, render_stage
from openrooms_usd.rendering.friction import (
    FRICTION,
    FrictionMap,
    Material,
    derivable,
    read_materials,
)
from openrooms_usd.rendering.given import available
from openrooms_usd.usd.shading import physics
from openrooms_usd.usd.shading.physics import MaterialPhysics

SIZE = (20, 30)


def expected(substance: str | None, albedo: np.ndarray, roughness: np.ndarray) -> np.ndarray:
    """The table as SciPy interpolates it."""
    number = len(SUBSTANCES) if substance is None else SUBSTANCES.index(substance)
    static = np.load(table.FILE)[number, ..., 0].astype(np.float64)
    nodes = (*[table.ALBEDO] * 3, table.ROUGHNESS)
    return RegularGridInterpolator(nodes, static)(np.concatenate([albedo, roughness], axis=-1))


def looks(seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return tuple(rng.random((*SIZE, depth)).astype(np.float32) for depth in (3, 1))


def test_every_pixel_by_its_material():
    albedo, roughness = looks()
    material = np.random.default_rng(1).integers(0, 6, (*SIZE, 1)).astype(np.float32)
    valid = np.ones((*SIZE, 1), np.float32)
    valid[3:5] = 0
    kinds = {
        1: Material("wood"),
        2: Material("metal"),
        3: Material(authored=0.25),
        4: Material(),
        5: Material("wood"),
    }
    found = FrictionMap(kinds).pixels(albedo, roughness, material, valid)
    assert found.shape == (*SIZE, 1) and found.dtype == np.float32
    for number, substance in {0: None, 1: "wood", 2: "metal", 4: None, 5: "wood"}.items():
        mine = (material[..., 0] == number) & (valid[..., 0] > 0)
        value = expected(substance, albedo[mine], roughness[mine])
        np.testing.assert_allclose(found[mine][:, 0], value, atol=1e-6)
    assert (found[(material == 3) & (valid > 0)] == 0.25).all()
    assert (found[valid == 0] == 0).all()


def test_nothing_is_seen():
    albedo, roughness = looks()
    nothing = np.zeros((*SIZE, 1), np.float32)
    assert not FrictionMap({}).pixels(albedo, roughness, nothing, nothing).any()


def a_stage() -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    for name, category in (("oak", "wood"), ("odd", "cheese"), ("plain", None), ("both", "paint")):
        prim = UsdShade.Material.Define(stage, f"/M/{name}").GetPrim()
        if category:
            prim.CreateAttribute(names.MATERIAL_CATEGORY, Sdf.ValueTypeNames.Token).Set(category)
    for name in ("odd", "both"):
        prim = stage.GetPrimAtPath(f"/M/{name}")
        physics.author(prim, MaterialPhysics(0.75, 0.5, 0.1, 10.0))
    return stage


def test_what_a_stage_says():
    paths = {1: "/M/oak", 2: "/M/odd", 3: "/M/plain", 4: "/M/both", 5: "/M/gone"}
    assert read_materials(a_stage(), paths) == {
        1: Material("wood"),
        2: Material(authored=0.75),
        3: Material(),
        4: Material("paint"),
        5: Material(),
    }


def test_the_files_of_a_run(renderer, tmp_path, numbers, monkeypatch):
    stage = a_stage()
    for name in ("left", "right"):
        stage.DefinePrim(f"/World/Cameras/{name}", "Camera")
    stage.GetRootLayer().Export(str(tmp_path / "scene.usda"))
    monkeypatch.setattr(renderer, "legend", Legend(material={1: "/M/oak", 2: "/M/odd"}))

    def few_materials(name: str, pixels: np.ndarray) -> np.ndarray:
        return (
            pixels % 3
            if name == "material"
            else np.ceil(pixels - 0.2)
            if name == "valid"
            else pixels
        )

    renderer.spoil = few_materials
    out = tmp_path / "out"
    render_stage(tmp_path / "scene.usda", out, RenderSettings(channels=["friction", "depth"]))
    stored = exr.read_channels(out / "left" / "channels.exr")
    assert set(stored) == {"depth", "friction"}, "sources that nobody asked for are not written"
    assert set(renderer.requests[0].channels) == {
        "depth",
        "base_color",
        "roughness",
        "material",
        "valid",
    }
    raw = {
        name: few_materials(name, numbers(name, 30, 40, 0))
        for name in ("base_color", "roughness", "material", "valid")
    }
    mine = (raw["material"][..., 0] == 1) & (raw["valid"][..., 0] > 0)
    value = expected("wood", raw["base_color"][mine], raw["roughness"][mine])
    np.testing.assert_allclose(stored["friction"][mine][:, 0], value, atol=1e-3)
    said = json.loads((out / "manifest.json").read_text())
    assert said["friction"]["materials"] == {
        "1": {"from": "substance and looks", "substance": "wood"},
        "2": {"from": "UsdPhysicsMaterialAPI", "static": 0.75},
    }
    assert said["channels"]["friction"]["meaning"] == CHANNELS["friction"].meaning
    assert (out / "left" / "friction.png").is_file()


def test_every_renderer_has_it(renderer, scene, tmp_path, monkeypatch):
    """What it is made of is exact, and so the core's."""
    monkeypatch.setattr(type(renderer), "channels", ("radiance",))
    assert derivable(("radiance",)) == () and FRICTION in available(("radiance",))
    render_stage(scene, tmp_path / "out", RenderSettings(channels=["friction"]))
    assert set(exr.read_channels(tmp_path / "out" / "left" / "channels.exr")) == {"friction"}
