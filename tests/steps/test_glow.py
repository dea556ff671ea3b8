"""Bulbs glow in their materials as they do as mesh lights, whatever decides how bright they are."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdLux, UsdShade

from openrooms_usd import names
from openrooms_usd.description.room import Room
from openrooms_usd.steps import runner
from openrooms_usd.steps.alignment.step import AlignmentStep
from openrooms_usd.steps.draft import drafting
from openrooms_usd.steps.layout.step import LayoutStep
from openrooms_usd.steps.lights.step import LightsStep
from openrooms_usd.steps.materials.step import MaterialsStep
from openrooms_usd.usd.light.lights import MeshLight, read_lights
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.materials import bound_material

LAMPS = {"bright": 2000.0, "faint": 100.0, "dark": 800.0}


def room(looks: int = 1, **materials: Any) -> Room:
    objects = [
        {"name": name, "category": "floor_lamp", "style": "drum", "at": [1 + i, 1]}
        for i, name in enumerate(LAMPS)
    ]
    lamps = {name: {"lumen": lumen, "kelvin": 3000} for name, lumen in LAMPS.items()}
    lamps["dark"]["on"] = False  # type: ignore[assignment]
    return Room.model_validate(
        {
            "furniture": {"objects": objects},
            "materials": {"resolution": 16, "looks": looks, **materials},
            "lights": {"lamps": lamps},
        }
    )


def compose(folder: Path, described: Room, edits: str = "") -> tuple[Usd.Stage, list[str]]:
    with drafting(folder) as draft:
        runner.create_edits(draft)
    path = folder / names.LAYERS / "edits.usda"
    path.write_text(path.read_text() + edits)
    notes: list[str] = []
    with drafting(folder) as draft:
        for step in (LayoutStep(), AlignmentStep(), MaterialsStep(), LightsStep()):
            notes = list(runner.run(step, described, folder, draft, "fingerprint", 1))
        runner.write_scene(draft)
    stage = Usd.Stage.Open(str(folder / names.SCENE))
    stage.Reload()
    return stage, notes


def glow(prim: Usd.Prim) -> Any:
    material = bound_material(prim)
    return np.zeros(3) if material is None else np.array(read_preview_surface(material)[0].emissive)


def check(stage: Usd.Stage) -> dict[str, MeshLight]:
    """Every mesh glows as it lights, and nothing glows that is no light."""
    lights = {x.path: x for x in read_lights(stage) if isinstance(x, MeshLight)}
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()):
        if prim.GetTypeName() == "Mesh":
            light = lights.get(str(prim.GetPath()))
            expected = np.zeros(3) if light is None else np.float32(light.radiance)
            np.testing.assert_array_equal(np.float32(glow(prim)), expected, str(prim.GetPath()))
    return {path.split("/")[3]: light for path, light in lights.items()}


def over(part: str, inside: str) -> str:
    """An edit of one part of the bright lamp."""
    path = ("World", "Furniture", "bright", "Geometry", part)
    opened = "".join(f'over "{name}"\n{{\n' for name in path)
    return opened + inside + "\n}" * len(path) + "\n"


def test_lamps_of_one_look_glow_each_as_bright_as_it_is(tmp_path: Path) -> None:
    stage, notes = compose(tmp_path, room())
    lights = check(stage)
    assert set(lights) == set(LAMPS) and notes == []
    ratio = lights["bright"].radiance / lights["faint"].radiance
    np.testing.assert_allclose(ratio, 20.0, rtol=1e-6)
    assert glow(stage.GetPrimAtPath(lights["dark"].path)).tolist() == [0.0, 0.0, 0.0]
    # Sparse: a lamp that is off needs no word about what it does not do.
    text = (tmp_path / "layers/lights.usda").read_text()
    assert text.count("inputs:emissiveColor") == 2


def test_every_look_glows(tmp_path: Path) -> None:
    stage, _ = compose(tmp_path, room(looks=3))
    seen = set()
    for look in ("default", "look_1", "look_2"):
        for name in LAMPS:
            prim = stage.GetPrimAtPath(f"{names.FURNITURE}/{name}")
            prim.GetVariantSets().SetSelection(names.LOOK, look)
        lights = check(stage)
        bulb = stage.GetPrimAtPath(lights["bright"].path)
        seen.add(bound_material(bulb).GetPath())  # type: ignore[union-attr]
        assert glow(bulb).min() > 0
    assert len(seen) > 1, "the looks have bulbs of one material: they test nothing"


@pytest.mark.parametrize(
    "edit",
    [
        "float inputs:intensity = 0",
        "float inputs:intensity = 77",
        "float inputs:colorTemperature = 8000",
        "color3f inputs:color = (1, 0, 0)",
        "float inputs:exposure = -2",
    ],
)
def test_an_edit_of_the_light_is_an_edit_of_the_glow(tmp_path: Path, edit: str) -> None:
    plain = check(compose(tmp_path / "plain", room())[0])
    lights = check(compose(tmp_path / "edited", room(), over("light_bulb", edit))[0])
    assert not np.allclose(lights["bright"].radiance, plain["bright"].radiance)
    np.testing.assert_array_equal(lights["faint"].radiance, plain["faint"].radiance)


def test_who_lets_the_material_tint_the_light_keeps_it_black(tmp_path: Path) -> None:
    mode = 'uniform token light:materialSyncMode = "materialGlowTintsLight"'
    stage, _ = compose(tmp_path, room(), over("light_bulb", mode))
    bulb = stage.GetPrimAtPath(f"{names.FURNITURE}/bright/Geometry/light_bulb")
    assert glow(bulb).tolist() == [0.0, 0.0, 0.0]


def test_what_others_wear_too_does_not_glow(tmp_path: Path) -> None:
    """In our pictures a material that glows is a light: the pole must not become one."""
    root = f"{names.FURNITURE}/bright"
    stage, _ = compose(tmp_path / "plain", room())
    worn = bound_material(stage.GetPrimAtPath(f"{root}/Geometry/light_bulb"))
    assert worn is not None
    binding = f"rel material:binding = <{worn.GetPath()}>"
    edit = over("lamp_pole", binding)
    stage, notes = compose(tmp_path / "shared", room(), edit)
    pole = stage.GetPrimAtPath(f"{root}/Geometry/lamp_pole")
    assert bound_material(pole).GetPath() == worn.GetPath()  # type: ignore[union-attr]
    assert glow(pole).tolist() == [0.0, 0.0, 0.0]
    assert len(notes) == 1 and notes[0].startswith("bright: ") and str(worn.GetPath()) in notes[0]


def test_a_glow_of_ones_own_stays(tmp_path: Path) -> None:
    """What drives the emission already, a picture say, is not replaced."""
    stage, _ = compose(tmp_path / "plain", room())
    bulb = stage.GetPrimAtPath(f"{names.FURNITURE}/faint/Geometry/light_bulb")
    material = bound_material(bulb)
    assert material is not None
    layer = Sdf.Layer.CreateAnonymous(".usda")
    edited = Usd.Stage.Open(layer)
    shader = UsdShade.Shader(edited.OverridePrim(f"{material.GetPath()}/Surface"))
    picture = UsdShade.Shader(edited.DefinePrim("/World/Picture", "Shader"))
    picture.CreateIdAttr("UsdUVTexture")
    output = picture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3)
    shader.CreateInput("emissiveColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(output)
    text = layer.ExportToString().partition("#usda 1.0")[2]
    stage, notes = compose(tmp_path / "edited", room(), text)
    assert notes == []
    lights = (tmp_path / "edited/layers/lights.usda").read_text()
    assert lights.count("inputs:emissiveColor") == 1


def test_who_knows_both_counts_one(tmp_path: Path) -> None:
    stage, _ = compose(tmp_path, room())
    for prim in stage.Traverse():
        if prim.HasAPI(UsdLux.MeshLightAPI):
            mode = UsdLux.LightAPI(prim).GetMaterialSyncModeAttr().Get()
            assert mode == UsdLux.Tokens.noMaterialResponse
    before = {x.path: x.radiance.tolist() for x in read_lights(stage)}
    for prim in stage.Traverse():
        if prim.GetName() == "Surface" and prim.GetAttribute("inputs:emissiveColor"):
            prim.GetAttribute("inputs:emissiveColor").Set(Gf.Vec3f(0.0))
    assert {x.path: x.radiance.tolist() for x in read_lights(stage)} == before
