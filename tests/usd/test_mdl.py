"""Materials of MDL: OmniPBR's constants and textures by its formulas, others by name."""

import math
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdShade

from openrooms_usd.imagefile import write_png
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.surfaces import (
    BARE,
    NORMAL_BIAS,
    NORMAL_SCALE,
    PreviewSurface,
    Texture,
    f0_of,
)

Inputs = dict[str, object]
KINDS = {bool: "Bool", int: "Int", float: "Float", tuple: "Color3f", str: "Asset"}


def read(
    folder: Path, inputs: Inputs, name: str = "OmniPBR"
) -> tuple[PreviewSurface, tuple[str, ...]]:
    (folder / "m.usda").write_text("#usda 1.0\n")
    stage = Usd.Stage.Open(str(folder / "m.usda"))
    stage.GetRootLayer().Clear()
    material = UsdShade.Material.Define(stage, "/M")
    shader = UsdShade.Shader.Define(stage, "/M/S")
    shader.CreateImplementationSourceAttr(UsdShade.Tokens.sourceAsset)
    shader.SetSourceAsset(Sdf.AssetPath(f"{name}.mdl"), "mdl")
    shader.SetSourceAssetSubIdentifier(name, "mdl")
    output = shader.CreateOutput("out", Sdf.ValueTypeNames.Token)
    material.CreateSurfaceOutput("mdl").ConnectToSource(output)
    for key, value in inputs.items():
        kind = "Float2" if isinstance(value, tuple) and len(value) == 2 else KINDS[type(value)]
        shader.CreateInput(key, getattr(Sdf.ValueTypeNames, kind)).Set(value)
    return read_preview_surface(material)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_png(tmp_path / "a.png", np.full((2, 2, 3), 100, np.uint8))
    return tmp_path


def test_constants(folder: Path) -> None:
    surface, losses = read(
        folder,
        {
            "diffuse_color_constant": (0.1, 0.6, 0.2),
            "diffuse_tint": (1.0, 0.5, 0.5),
            "reflection_roughness_constant": 0.25,
            "metallic_constant": 0.75,
            "specular_level": 0.25,
            "enable_emission": True,
            "emissive_color": (1.0, 0.5, 0.25),
            "emissive_intensity": 100.0,
            "enable_opacity": True,
            "opacity_constant": 0.5,
        },
    )
    assert surface.base_color == pytest.approx((0.1, 0.3, 0.1))
    assert (surface.roughness, surface.metallic, surface.opacity) == (0.25, 0.75, 0.5)
    assert f0_of(surface.ior) == pytest.approx(0.02)
    assert surface.emissive == pytest.approx(np.array([100.0, 50.0, 25.0]) / math.pi)
    assert len(losses) == 1 and "OmniPBR of MDL is approximated" in losses[0]


def test_what_nobody_says_is_as_omnipbr_has_it(folder: Path) -> None:
    surface, _ = read(folder, {"emissive_color": (1.0, 1.0, 1.0), "opacity_constant": 0.5})
    assert surface.base_color == pytest.approx((0.2, 0.2, 0.2))
    assert (surface.roughness, surface.metallic, surface.opacity) == (0.5, 0.0, 1.0)
    assert surface.emissive == (0.0, 0.0, 0.0)
    assert f0_of(surface.ior) == pytest.approx(0.04)


def test_textures(folder: Path) -> None:
    surface, losses = read(
        folder,
        {
            "diffuse_texture": "./a.png",
            "diffuse_color_constant": (1.0, 0.0, 0.0),
            "diffuse_tint": (1.0, 0.5, 0.25),
            "albedo_brightness": 0.5,
            "albedo_add": 0.125,
            "reflection_roughness_constant": 0.5,
            "reflection_roughness_texture_influence": 0.75,
            "reflectionroughness_texture": "./a.png",
            "metallic_texture": "./a.png",
            "normalmap_texture": "./a.png",
            "texture_scale": (2.0, 3.0),
        },
    )
    assert len(losses) == 1
    color, roughness, normal = surface.base_color, surface.roughness, surface.normal
    assert isinstance(color, Texture) and color.file == str(folder / "a.png")
    assert (color.color_space, color.uv_scale) == ("sRGB", (2.0, 3.0))
    assert color.scale[:3] == pytest.approx((0.5, 0.25, 0.125))
    assert color.bias[:3] == pytest.approx((0.125, 0.0625, 0.03125))
    assert isinstance(roughness, Texture) and (roughness.color_space, roughness.channel) == (
        "raw",
        "r",
    )
    assert (roughness.scale[0], roughness.bias[0]) == (0.75, 0.125)
    # A map without any influence is none.
    assert surface.metallic == 0.0
    assert isinstance(normal, Texture)
    assert (normal.scale, normal.bias) == (NORMAL_SCALE, NORMAL_BIAS)


def test_packed_textures(folder: Path) -> None:
    inputs: Inputs = {"enable_ORM_texture": True, "ORM_texture": "./a.png"}
    inputs |= {f"{n}_texture_influence": 1.0 for n in ("reflection_roughness", "metallic")}
    surface, _ = read(folder, inputs)
    assert isinstance(surface.roughness, Texture) and isinstance(surface.metallic, Texture)
    assert (surface.roughness.channel, surface.metallic.channel) == ("g", "b")


def test_what_is_left_out_is_told(folder: Path) -> None:
    left: Inputs = {
        "albedo_desaturation": 0.5,
        "bump_factor": 2.0,
        "opacity_texture": "./a.png",
        "project_uvw": True,
        "of_nobody": 3.0,
    }
    idle: Inputs = {"bump_factor": 1.0, "project_uvw": False, "detail_texture_scale": (1.0, 1.0)}
    assert len(read(folder, idle)[1]) == 1
    _, losses = read(folder, left)
    assert len(losses) == 1 + len(left)
    assert all(any(name in loss for loss in losses) for name in left)
    surface, losses = read(folder, {"diffuse_texture": "./none.png"})
    assert surface.base_color == pytest.approx((0.2, 0.2, 0.2))
    assert "none.png is missing" in losses[1]


def test_other_materials_are_named(folder: Path) -> None:
    surface, losses = read(folder, {"glass_color": (1.0, 1.0, 1.0)}, name="OmniGlass")
    assert surface.base_color == BARE.base_color
    assert len(losses) == 1 and "OmniGlass of MDL" in losses[0]


@pytest.mark.parametrize("kind", ["ND_realitykit_pbr_surfaceshader"])
def test_realitykit(folder: Path, kind: str) -> None:
    stage = Usd.Stage.CreateNew(str(folder / "r.usda"))
    material = UsdShade.Material.Define(stage, "/M")
    shader = UsdShade.Shader.Define(stage, "/M/S")
    shader.CreateIdAttr(kind)
    output = shader.CreateOutput("out", Sdf.ValueTypeNames.Token)
    material.CreateSurfaceOutput("mtlx").ConnectToSource(output)
    surface, losses = read_preview_surface(material)
    assert (surface.base_color, surface.pane, losses) == ((1.0, 1.0, 1.0), None, ())
    said: Inputs = {
        "baseColor": (0.1, 0.6, 0.2),
        "emissiveColor": (1.0, 2.0, 3.0),
        "roughness": 0.25,
        "metallic": 0.75,
        "specular": 0.25,
        "opacity": 0.5,
        "opacityThreshold": 0.125,
        "clearcoat": 0.5,
        "clearcoatRoughness": 0.375,
        "ambientOcclusion": 0.5,
        "hasPremultipliedAlpha": False,
    }
    for name, value in said.items():
        shader.CreateInput(name, getattr(Sdf.ValueTypeNames, KINDS[type(value)])).Set(value)
    surface, losses = read_preview_surface(material)
    assert losses == ()
    assert surface.base_color == pytest.approx((0.1, 0.6, 0.2))
    assert surface.emissive == (1.0, 2.0, 3.0)
    assert (surface.roughness, surface.metallic) == (0.25, 0.75)
    assert (surface.opacity, surface.opacity_threshold) == (0.5, 0.125)
    assert (surface.clearcoat, surface.clearcoat_roughness) == (0.5, 0.375)
    assert f0_of(surface.ior) == pytest.approx(0.02)
