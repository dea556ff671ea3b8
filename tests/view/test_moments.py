"""Lightmaps of one or several moments: what belongs together, and which files are shown."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from pxr import Sdf, Usd, UsdGeom, UsdLux

from openrooms_usd.cli.viewing import view
from openrooms_usd.errors import InputError, StageError
from openrooms_usd.rendering import exr
from openrooms_usd.rendering.bake.layer import (
    ATLAS,
    IRRADIANCE,
    LIGHT_IRRADIANCE,
    LIGHT_NAMES,
    LIGHTS,
    SCALE_OFFSET,
)
from openrooms_usd.view.room import room_app
from tests.small import Stage

ATLAS_PATH = "/Lightmaps/atlas_0"
ST = [(0, 0), (1, 0), (1, 1), (0, 1)]


def room(folder: Path, sky: str | None = None) -> Path:
    """A floor, a lamp and a sky."""
    folder.mkdir(parents=True, exist_ok=True)
    made = Stage(path=folder / "scene.usda")
    made.quad("/Floor", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    UsdLux.SphereLight.Define(made.stage, "/lamp")
    dome = UsdLux.DomeLight.Define(made.stage, "/Sky")
    if sky is not None:
        dome.CreateTextureFileAttr(sky)
    made.stage.Save()
    return folder / "scene.usda"


def picture(file: Path, value: float = 1.0, size: int = 4) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    exr.write_rgb(file, np.full((size, size, 3), value, np.float32))


def bake(
    scene: Path,
    folder: Path,
    *,
    lights: Sequence[str] = ("lamp", "elsewhere"),
    lux: float = 1.0,
    size: int = 4,
    files: str = ".",
    scale: float = 1.0,
) -> Path:
    """Lightmaps as `orusd bake` writes them, each of one value: the number of its light x lux."""
    folder.mkdir()
    maps = [f"{files}/{name}.exr" for name in lights]
    for number, file in enumerate(maps):
        picture(folder / file, (number + 1) * lux, size)
    layer = Sdf.Layer.CreateNew(str(folder / "lightmaps.usda"))
    stage = Usd.Stage.Open(layer)
    atlas = stage.DefinePrim(ATLAS_PATH, "Scope")
    kinds = Sdf.ValueTypeNames
    atlas.CreateAttribute(IRRADIANCE, kinds.Asset).Set(maps[0])
    atlas.CreateAttribute(LIGHT_IRRADIANCE, kinds.AssetArray).Set(maps)
    atlas.CreateAttribute(LIGHT_NAMES, kinds.StringArray).Set(list(lights))
    atlas.CreateRelationship(LIGHTS).SetTargets(["/lamp"] if "lamp" in lights else [])
    floor = stage.OverridePrim("/Floor")
    floor.CreateAttribute(SCALE_OFFSET, kinds.Float4).Set((scale, scale, 0, 0))
    floor.CreateRelationship(ATLAS).SetTargets([ATLAS_PATH])
    st = UsdGeom.PrimvarsAPI(floor).CreatePrimvar("st1", kinds.TexCoord2fArray, "faceVarying")
    st.Set(ST)
    layer.Save()
    lit = Sdf.Layer.CreateNew(str(folder / "baked.usda"))
    lit.subLayerPaths = ["./lightmaps.usda", str(scene)]
    lit.Save()
    return folder


def test_moments_share_the_controls_of_lights_that_are_called_alike(tmp_path: Path) -> None:
    scene = room(tmp_path / "out")
    other = room(tmp_path / "out/night")
    noon = bake(scene, tmp_path / "noon", lux=100.0)
    night = bake(other, tmp_path / "night", lights=("elsewhere",), lux=0.5)
    app = room_app(scene, light=[noon, night])
    light = app.state()["light"]
    assert light["moments"] == ["noon", "night"]
    assert [(one["name"], one["kind"]) for one in light["lights"]] == [
        ("lamp", "lamp"),
        ("elsewhere", "elsewhere"),
    ]
    # Of light and moment.
    assert light["layers"] == [[0, 0], [1, 0], [1, 1]]
    told = light["atlases"][ATLAS_PATH]
    held = np.frombuffer(app.resources[told["resource"]](), "<f2").reshape(3, 4, 4, 4)
    assert np.array_equal(held[:, 0, 0, 0] * told["scale"], [100.0, 200.0, 0.5])
    assert [sky["moment"] for sky in light["skies"]] == [0, 1]
    assert app.watched[0] == scene and app.resources["room.glb"]()[:4] == b"glTF"


def test_one_moment_alone_is_named_and_its_stage_may_be_looked_at_itself(tmp_path: Path) -> None:
    scene = room(tmp_path / "out")
    lit = bake(scene, tmp_path / "lit")
    target = tmp_path / "page.html"
    done = CliRunner().invoke(view, [str(scene), "--lightmaps", str(lit), "--export", str(target)])
    assert done.exit_code == 0, done.output
    assert "light_0.half" in target.read_text()
    assert room_app(lit / "baked.usda").state()["light"]["moments"] == [""]
    assert room_app(scene).state()["light"] is None


def test_what_does_not_belong_together_is_refused(tmp_path: Path) -> None:
    scene, other = room(tmp_path / "out"), room(tmp_path / "other")
    lit = bake(scene, tmp_path / "lit")
    cases = {
        "another stage": [bake(other, tmp_path / "of_another")],
        "another room": [lit, bake(scene, tmp_path / "scaled", scale=0.5)],
        "differ in size": [lit, bake(scene, tmp_path / "finer", size=8)],
        "no lightmaps": [tmp_path / "out"],
    }
    for message, folders in cases.items():
        with pytest.raises(InputError, match=message) as refused:
            room_app(scene, light=folders)
        assert folders[-1].name in str(refused.value)
        assert refused.value.remedy
    with pytest.raises(InputError, match="--texel"):
        room_app(scene, light=cases["differ in size"])


def test_a_browser_does_not_get_more_lightmaps_than_it_can_have(tmp_path: Path) -> None:
    scene = room(tmp_path / "out")
    names = ["lamp", *(f"lamp_{number}" for number in range(128))]
    lit = bake(scene, tmp_path / "a", lights=names), bake(scene, tmp_path / "b", lights=names)
    with pytest.raises(InputError, match="258 lightmaps"):
        room_app(scene, light=lit)


@pytest.mark.parametrize("what", ["sky", "lightmap"])
def test_no_picture_outside_of_the_named_folders_is_shown(tmp_path: Path, what: str) -> None:
    picture(tmp_path / "private/sky.exr")
    sky, files = ("../private/sky.exr", ".") if what == "sky" else (None, "../private")
    scene = room(tmp_path / "out", sky)
    lit = bake(scene, tmp_path / "lit", files=files)
    with pytest.raises(StageError, match="private/") as refused:
        room_app(scene, light=[lit])
    assert "the page" in str(refused.value) and "orusd-view" not in str(refused.value)
    assert room_app(scene, light=[lit], include_outside=True).state()["light"]


def test_a_bake_that_is_looked_at_itself_says_how_its_stage_is_shown(tmp_path: Path) -> None:
    picture(tmp_path / "out/sky.exr")
    scene = room(tmp_path / "out", "./sky.exr")
    lit = bake(scene, tmp_path / "lit")
    with pytest.raises(StageError, match=r"out/sky\.exr") as refused:
        room_app(lit / "baked.usda")
    assert "orusd view STAGE --lightmaps FOLDER" in str(refused.value)
    assert room_app(scene, light=[lit]).state()["light"]["skies"]


def test_a_stage_that_names_a_private_picture_later_is_refused_then(tmp_path: Path) -> None:
    picture(tmp_path / "private/sky.exr")
    scene = room(tmp_path / "out")
    app = room_app(scene)
    assert app.resources["room.glb"]()[:4] == b"glTF"
    stage = Usd.Stage.Open(str(scene))
    UsdLux.DomeLight.Get(stage, "/Sky").CreateTextureFileAttr("../private/sky.exr")
    stage.Save()
    with pytest.raises(StageError, match="would go into the page") as refused:
        app.resources["room.glb"]()
    assert "/orusd-" not in str(refused.value)
