"""The lights step: lux and lumen that were asked for arrive, and lamps are found or missed."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdLux
from pydantic import ValidationError

from openrooms_usd import names
from openrooms_usd.colorimetry import luminance
from openrooms_usd.description.lights import Lamp
from openrooms_usd.description.room import Room
from openrooms_usd.errors import DescriptionError, InputError, StageError
from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.imagefile import write_png
from openrooms_usd.library.pictures import write_exr
from openrooms_usd.library.styles.beams import beam_profile, profile_text
from openrooms_usd.steps import runner
from openrooms_usd.steps.alignment.step import AlignmentStep
from openrooms_usd.steps.draft import drafting
from openrooms_usd.steps.layout.step import LayoutStep
from openrooms_usd.steps.lights.step import LightsStep
from openrooms_usd.usd.light.lights import DomeLight, MeshLight, read_lights
from openrooms_usd.usd.shading.textures import read_texture
from openrooms_usd.usd.shapes.meshes import read_meshes

WEIGHTS = np.array([0.2126, 0.7152, 0.0722])
OBJECTS = [
    {"name": "reading", "category": "floor_lamp", "at": [1, 1]},
    {"name": "table", "category": "table", "at": [3, 1.5]},
    {"name": "desk_lamp", "category": "table_lamp", "at": [3, 1.5], "on": "table", "yaw": 30},
]


def room(objects: list[dict[str, Any]] = OBJECTS, **lights: object) -> Room:
    return Room.model_validate({"seed": 5, "furniture": {"objects": objects}, "lights": lights})


def compose(folder: Path, described: Room) -> tuple[Usd.Stage, list[str]]:
    notes: list[str] = []
    with drafting(folder) as draft:
        runner.create_edits(draft)
        for step in (LayoutStep(), AlignmentStep(), LightsStep()):
            notes = list(runner.run(step, described, folder, draft, "fingerprint", 1))
        runner.write_scene(draft)
    stage = Usd.Stage.Open(str(folder / names.SCENE))
    stage.Reload()
    return stage, notes


def dome(stage: Usd.Stage) -> DomeLight:
    [found] = [light for light in read_lights(stage) if isinstance(light, DomeLight)]
    assert found.path == names.ENVIRONMENT and found.losses == ()
    return found


def lamps(stage: Usd.Stage) -> dict[str, MeshLight]:
    found = [light for light in read_lights(stage) if isinstance(light, MeshLight)]
    return {light.path.split("/")[3]: light for light in found}


def panorama(path: Path, seed: int = 0, brightest: float = 1.0) -> np.ndarray:
    pixels = np.random.default_rng(seed).random((16, 32, 3), np.float32) * np.float32(brightest)
    write_exr(path, pixels)
    return pixels


def lux(pixels: np.ndarray) -> float:
    """Sum of luminance times cosine times solid angle, pixel by pixel."""
    height = len(pixels)
    total = 0.0
    for row in range(height // 2):
        top, low = (math.pi * (0.5 - (row + k) / height) for k in (0, 1))
        share = (math.sin(top) - math.sin(low)) * math.sin((top + low) / 2) * math.pi / height
        total += share * float((pixels[row] @ WEIGHTS).sum())
    return total


def test_a_constant_sky_gives_its_lux(tmp_path: Path) -> None:
    sky = {"from": "constant", "illuminance": 8000, "color": [0.5, 0.7, 1.0]}
    stage, _ = compose(tmp_path, room(environment=sky))
    radiance = dome(stage).radiance
    assert math.pi * float(radiance @ WEIGHTS) == pytest.approx(8000.0)
    np.testing.assert_allclose(radiance / radiance[2], [0.5, 0.7, 1.0], rtol=1e-6)


def test_an_edit_that_lays_the_sky_on_its_side_is_noted(tmp_path: Path) -> None:
    described = room(environment={"illuminance": 100.0})
    _, notes = compose(tmp_path, described)
    assert not any("lies on its side" in note for note in notes)
    edits = Usd.Stage.Open(str(tmp_path / "layers/edits.usda"))
    sky = UsdGeom.Xformable(edits.OverridePrim(names.ENVIRONMENT))
    sky.GetPrim().CreateAttribute("xformOp:rotateZ", Sdf.ValueTypeNames.Double).Set(30.0)
    order = sky.GetPrim().CreateAttribute("xformOpOrder", Sdf.ValueTypeNames.TokenArray)
    order.Set(["xformOp:rotateZ"])
    edits.Save()
    _, notes = compose(tmp_path, described)
    [note] = [note for note in notes if "lies on its side" in note]
    assert "xformOp:rotateX:orientToStageUpAxis" in note
    order.Set(["xformOp:rotateZ", "xformOp:rotateX:orientToStageUpAxis"])
    edits.Save()
    _, notes = compose(tmp_path, described)
    assert not any("lies on its side" in note for note in notes)


def test_a_black_night(tmp_path: Path) -> None:
    stage, _ = compose(tmp_path, room(environment={"from": "constant", "illuminance": 0}))
    assert dome(stage).radiance.tolist() == [0.0, 0.0, 0.0]
    with pytest.raises(ValidationError, match="a black sky gives no light"):
        room(environment={"from": "constant", "illuminance": 5, "color": [0, 0, 0]})


def test_a_panorama_gives_its_lux(tmp_path: Path) -> None:
    pixels = panorama(tmp_path / "My sky!.exr")
    sky = {"from": "file", "file": "My sky!.exr", "illuminance": 20_000, "rotate": 90}
    stage, _ = compose(tmp_path, room(environment=sky))
    light = dome(stage)
    assert light.texture is not None and Path(light.texture).name.startswith("My_sky_")
    stored = read_texture(light.texture)
    assert lux(stored) * float(light.radiance @ WEIGHTS) == pytest.approx(20_000.0, rel=0.01)
    np.testing.assert_allclose(stored / stored[0, 0], pixels / pixels[0, 0], rtol=1e-5)
    # Counter-clockwise from above: what looked along +X looks along +Y.
    np.testing.assert_allclose(light.world_from_light[:3, :3] @ [1, 0, 0], [0, 1, 0], atol=1e-7)


def test_only_the_layer_refers_to_its_picture(tmp_path: Path) -> None:
    panorama(tmp_path / "sky.exr")
    stage, _ = compose(tmp_path, room(environment={"from": "file", "file": "sky.exr", "scale": 3}))
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "layers/lights.usda"))
    prim = layer.GetAttributeAtPath(f"{names.ENVIRONMENT}.inputs:texture:file")
    assert prim.default.path.startswith("./lights/sky_")
    assert len(list((tmp_path / "layers/lights").iterdir())) == 1
    first = dome(stage).texture
    stage, _ = compose(tmp_path, room(environment={"from": "file", "file": "sky.exr", "scale": 4}))
    # Another factor is another file, and the old one is gone.
    assert dome(stage).texture != first
    assert len(list((tmp_path / "layers/lights").iterdir())) == 1


def test_a_sun_survives(tmp_path: Path) -> None:
    pixels = panorama(tmp_path / "sky.exr", brightest=1.6e9)
    stage, _ = compose(tmp_path, room(environment={"from": "file", "file": "sky.exr"}))
    texture = dome(stage).texture
    assert texture is not None
    np.testing.assert_array_equal(read_texture(texture), pixels)


def test_bad_panoramas_are_refused_with_their_place(tmp_path: Path) -> None:
    sky = {"from": "file", "file": "sky.exr"}
    with pytest.raises(InputError, match="no such file"):
        compose(tmp_path, room(environment=sky))
    pixels = np.ones((4, 8, 3), np.float32)
    pixels[1, 2] = np.nan
    write_exr(tmp_path / "sky.exr", pixels)
    with pytest.raises(InputError, match=r"pixel \(2, 1\)"):
        compose(tmp_path, room(environment=sky))
    (tmp_path / "sky.exr").write_bytes(b"")
    with pytest.raises(InputError, match="picture"):
        compose(tmp_path, room(environment=sky))
    write_png(tmp_path / "sky.png", np.full((4, 8, 3), 128, np.uint8))
    with pytest.raises(InputError, match="for displays"):
        compose(tmp_path, room(environment=sky | {"file": "sky.png"}))
    assert not (tmp_path / "layers/lights.usda").exists()
    assert not list((tmp_path / "layers").glob("lights/*"))


def test_lumen_arrive_from_the_meshes_in_the_world(tmp_path: Path) -> None:
    """Flux = pi times radiance times area; area from the triangles that a renderer would see."""
    stage, _ = compose(tmp_path, room(lamps={"reading": {"lumen": 1234, "kelvin": 3000}}))
    found = lamps(stage)
    assert set(found) == {"reading", "desk_lamp"}
    areas = {}
    for mesh in read_meshes(stage):
        if mesh.path.endswith("light_bulb"):
            a, b, c = np.moveaxis(mesh.world_points()[mesh.mesh.triangles], 1, 0)
            areas[mesh.path.split("/")[3]] = (
                np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
            )
    flux = {name: math.pi * areas[name] * float(x.radiance @ WEIGHTS) for name, x in found.items()}
    usual = CATEGORIES["table_lamp"].lumen
    assert flux == pytest.approx({"reading": 1234.0, "desk_lamp": usual}, rel=1e-5)
    assert all(light.losses == () for light in found.values())
    red, _, blue = found["reading"].radiance
    assert red > blue


def test_a_lamp_that_is_off_is_dark_and_still_a_lamp(tmp_path: Path) -> None:
    stage, _ = compose(tmp_path, room(lamps={"reading": {"on": False}}))
    assert lamps(stage)["reading"].radiance.tolist() == [0.0, 0.0, 0.0]


def kelvin(stage: Usd.Stage, name: str) -> float:
    path = f"{names.FURNITURE}/{name}/Geometry/light_bulb"
    return float(UsdLux.LightAPI(stage.GetPrimAtPath(path)).GetColorTemperatureAttr().Get())


def test_color_temperatures_are_drawn_by_name(tmp_path: Path) -> None:
    more = [{"name": "extra", "category": "ceiling_lamp", "at": [2, 2]}, *OBJECTS]
    one, _ = compose(tmp_path / "one", room())
    two, _ = compose(tmp_path / "two", room(more))
    drawn = [kelvin(two, name) for name in ("reading", "desk_lamp", "extra")]
    assert drawn[:2] == [kelvin(one, "reading"), kelvin(one, "desk_lamp")]
    assert len(set(drawn)) == 3 and all(2700 <= value <= 3000 for value in drawn)


def test_a_coloured_lamp_keeps_its_lumens(tmp_path: Path) -> None:
    white, _ = compose(tmp_path / "white", room(lamps={"reading": {"lumen": 500}}))
    pink = {"lumen": 500, "color": [2.0, 0.5, 1.0]}
    stage, _ = compose(tmp_path / "pink", room(lamps={"reading": pink}))
    radiance = lamps(stage)["reading"].radiance
    np.testing.assert_allclose(radiance / radiance[1], [4.0, 1.0, 2.0], rtol=1e-5)
    assert luminance(radiance) == pytest.approx(
        luminance(lamps(white)["reading"].radiance), rel=1e-4
    )
    black = {"lumen": 500, "color": [0, 0, 0]}
    with pytest.raises(ValidationError, match="gives no light"):
        room(lamps={"reading": black})


def test_beyond_what_usd_knows_is_noted(tmp_path: Path) -> None:
    stage, notes = compose(tmp_path, room(lamps={"reading": {"kelvin": 15_000}}))
    assert kelvin(stage, "reading") == 15_000
    assert notes == ["reading: UsdLux clamps 15000 K to 10000 K"]


def test_lamps_that_are_not_there_are_refused(tmp_path: Path) -> None:
    described = room()
    for name, words in (
        ("readin", r"no lamp 'readin' \(did you mean 'reading'\?\)"),
        ("table", "table has no part light_bulb"),
    ):
        lights = described.lights.model_copy(update={"lamps": {name: Lamp()}})
        with pytest.raises(DescriptionError, match=words):
            compose(tmp_path, described.model_copy(update={"lights": lights}))


def lamp_by_hand(
    folder: Path, *, points: list[tuple[float, float, float]], instanceable: bool = False
) -> None:
    """A lamp that a person added in the edits."""
    layers = folder / names.LAYERS
    layers.mkdir(exist_ok=True)
    stage = Usd.Stage.CreateNew(str(layers / "edits.usda"))
    UsdGeom.Xform.Define(stage, "/Lamp")
    stage.OverridePrim(f"{names.WORLD}")
    for name in ("bulb_a", "bulb_b"):
        mesh = UsdGeom.Mesh.Define(stage, f"/Lamp/{name}")
        mesh.CreatePointsAttr(points)
        mesh.CreateFaceVertexCountsAttr([3])
        mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
        from openrooms_usd.usd.semantics import label_part

        label_part(mesh.GetPrim(), names.LIGHT_BULB)
    prim = stage.DefinePrim(f"{names.FURNITURE}/found")
    prim.GetReferences().AddInternalReference("/Lamp")
    prim.SetInstanceable(instanceable)
    UsdGeom.Xform(prim).AddScaleOp().Set((2.0, 2.0, 2.0))
    stage.Save()


def test_several_bulbs_share_the_flux(tmp_path: Path) -> None:
    lamp_by_hand(tmp_path, points=[(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    stage, _ = compose(tmp_path, room())
    found = [x for x in read_lights(stage) if x.path.startswith(f"{names.FURNITURE}/found")]
    assert len(found) == 2
    # Two triangles of 2 m2 each, 800 lm together.
    for light in found:
        assert float(light.radiance @ WEIGHTS) == pytest.approx(800.0 / (4.0 * math.pi), rel=1e-6)


def test_instances_are_opened_or_refused(tmp_path: Path) -> None:
    triangle = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
    lamp_by_hand(tmp_path, points=triangle, instanceable=True)
    with pytest.raises(StageError, match="the lamp is an instance"):
        compose(tmp_path, room())
    # In a weaker layer the stage itself opens it.
    layers = tmp_path / names.LAYERS
    (layers / "edits.usda").replace(layers / "materials.usda")
    stage, _ = compose(tmp_path, room())
    assert len([x for x in read_lights(stage) if "/found/" in x.path]) == 2


def test_bulbs_without_area_are_refused(tmp_path: Path) -> None:
    lamp_by_hand(tmp_path, points=[(0, 0, 0), (1, 0, 0), (2, 0, 0)])
    with pytest.raises(StageError, match="no area"):
        compose(tmp_path, room())


def test_equal_bytes(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        panorama(tmp_path / name / "sky.exr")
        compose(tmp_path / name, room(environment={"from": "file", "file": "sky.exr"}))
    one, two = ((tmp_path / name / "layers") for name in ("one", "two"))
    assert (one / "lights.usda").read_bytes() == (two / "lights.usda").read_bytes()
    for path in (one / "lights").iterdir():
        assert path.read_bytes() == (two / "lights" / path.name).read_bytes()


@pytest.mark.one_in(3)
@pytest.mark.parametrize("profile", ["spot", "bare bulb", "lamp.ies"])
def test_a_profiled_lamp_keeps_its_lumens(tmp_path: Path, profile: str) -> None:
    (tmp_path / "lamp.ies").write_text(profile_text(beam_profile("batwing"), "batwing"))
    lamp = {"lumen": 700, "profile": profile}
    stage, _ = compose(tmp_path, room(lamps={"reading": lamp}))
    light = lamps(stage)["reading"]
    assert light.losses == () and light.shaping is not None
    mesh = next(mesh for mesh in read_meshes(stage) if mesh.path == light.path)
    corners = mesh.world_points()[mesh.mesh.triangles]
    crosses = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # By chance: the mean over even directions of what all faces send there.
    ways = np.random.default_rng(0).normal(size=(20_000, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    seen = np.maximum(ways @ crosses.T, 0.0).sum(axis=1)
    lumen = 4.0 * np.pi * (seen * light.shaping.factor(ways)).mean() * (WEIGHTS @ light.radiance)
    assert lumen == pytest.approx(700.0, rel=0.05)
    [file] = (tmp_path / names.LAYERS / "lights").glob("*.ies")
    assert file.name.startswith(profile.partition(".")[0].replace(" ", "_"))


def test_profiles_that_are_none_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.ies"):
        compose(tmp_path / "a", room(lamps={"reading": {"profile": "none.ies"}}))
    for wrong in ({"beam": 30}, {"profile": "spot", "beam": 120}, {"profile": "x.ies", "beam": 9}):
        with pytest.raises(ValueError, match="beam"):
            room(lamps={"reading": wrong})
