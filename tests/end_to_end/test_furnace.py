"""A furnished room whose every surface glows alike shows no surface: the white furnace."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdLux, UsdShade

from openrooms_usd.composing import compose_room
from openrooms_usd.description import dump_room, load_room
from tests.commands import output_of

ALBEDO, EMISSION, BOUNCES = 0.5, (3.0, 2.0, 1.0), 3


def closed_room(kind: str, seed: int, folder: Path) -> Path:
    """A generated room without its openings, composed."""
    call = ["generate", "--type", kind, "--seed", str(seed), "-o", str(folder / "source")]
    output_of(*call)
    room = load_room(folder / "source" / "room.yaml")
    layout = room.layout.model_copy(update={"openings": ()})
    description = folder / "room.yaml"
    description.write_text(dump_room(room.model_copy(update={"layout": layout})))
    return compose_room(description, folder / "out").scene


def glowing(scene: Path, target: Path) -> None:
    """The scene with one glowing Lambertian material, and no other light."""
    layer = Sdf.Layer.CreateNew(str(target))
    layer.subLayerPaths = [str(scene)]
    stage = Usd.Stage.Open(layer)
    material = UsdShade.Material.Define(stage, "/World/Glow")
    shader = UsdShade.Shader.Define(stage, "/World/Glow/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    color = Sdf.ValueTypeNames.Color3f
    shader.CreateInput("diffuseColor", color).Set((ALBEDO,) * 3)
    shader.CreateInput("emissiveColor", color).Set(EMISSION)
    shader.CreateInput("ior", Sdf.ValueTypeNames.Float).Set(1.0)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    world = stage.GetPrimAtPath("/World")
    stronger = UsdShade.Tokens.strongerThanDescendants
    UsdShade.MaterialBindingAPI.Apply(world).Bind(material, stronger)
    for prim in stage.Traverse():
        if prim.HasAPI(UsdLux.MeshLightAPI):
            prim.RemoveAPI(UsdLux.MeshLightAPI)
    stage.GetPrimAtPath("/World/Lights").SetActive(False)
    stage.SetMetadata("upAxis", "Z")
    stage.SetMetadata("metersPerUnit", 1.0)
    stage.SetDefaultPrim(world)
    stage.Save()


OTHERS = (("bedroom", 2), ("office", 4))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "seed"),
    [("kitchen", 3), *(pytest.param(*room, marks=pytest.mark.long) for room in OTHERS)],
)
def test_a_glowing_room_shows_no_furniture(kind, seed, tmp_path: Path, show, fastest) -> None:
    scene = closed_room(kind, seed, tmp_path)
    glowing(scene, scene.with_name("glowing.usda"))
    how = {
        "samples": 16,
        "bounces": BOUNCES,
        "options": {"variant": fastest},
        "channels": ["radiance", "depth"],
    }
    shown = show(scene.with_name("glowing.usda"), **how)
    expected = np.array(EMISSION) * (1 - ALBEDO ** (BOUNCES + 1)) / (1 - ALBEDO)
    for view in shown.views:
        image = shown[view]
        assert np.ptp(image["depth"]) > 0.5, "there is something to see"
        ratio = (image["radiance"].astype(np.float64) / expected).mean(axis=2)
        assert ratio.std() < 0.05
        # Smooth normals on narrow folds lose the paths that would leave below the surface.
        assert abs(ratio.mean() - 1) < 1e-2
        # Nor is any part of the picture darker: 8 by 8 pixels each.
        blocks = ratio.reshape(3, 8, 4, 8).mean(axis=(1, 3))
        assert np.abs(blocks - 1).max() < 0.06
