"""What another program saved over the scene moves into the edits, and nothing is lost."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux

from openrooms_usd.edits.adopting import adopt
from openrooms_usd.errors import InputError, OutputError, StageError
from openrooms_usd.rules import validate_stage
from tests.commands import run

SOFA = "/World/Furniture/sofa"
Values = Callable[[Usd.Stage], dict[str, object]]


def save_over(place: Any) -> None:
    """Edits of many kinds in the root layer, as a program does that knows no other."""
    with place.saving(place.scene) as stage:
        UsdGeom.Xform.Define(stage, "/World")
        UsdGeom.XformCommonAPI(stage.GetPrimAtPath(SOFA)).SetTranslate((1.0, 3.0, 0.0))
        looks = stage.GetPrimAtPath(SOFA).GetVariantSet("look")
        looks.SetVariantSelection(looks.GetVariantNames()[0])
        stage.GetPrimAtPath("/World/Furniture/chair_a").SetActive(False)
        shade = stage.GetPrimAtPath("/World/Furniture/lamp/Geometry/light_bulb")
        UsdLux.LightAPI(shade).GetIntensityAttr().Set(12.5)
        UsdGeom.Cube.Define(stage, "/World/Crate").AddTranslateOp().Set((3, 3, 0.5))
        turn = stage.GetPrimAtPath("/World/Furniture/table").CreateAttribute(
            "xformOp:rotateXYZ", Sdf.ValueTypeNames.Float3
        )
        turn.Set(Gf.Vec3f(0, 0, 10), 1.0)
        turn.Set(Gf.Vec3f(0, 0, 20), 2.0)
        stage.GetRootLayer().customLayerData = {"cameraSettings": "seen from above"}


def test_opinions_move_and_the_scene_is_as_compose_writes_it(place: Any, values: Values) -> None:
    wanted = place.scene.read_bytes()
    save_over(place)
    shown = values(place.stage())
    adoption = adopt(place.scene)
    assert adoption.written
    assert place.scene.read_bytes() == wanted
    assert values(place.stage()) == shown
    rows = {change.path: change for change in adoption.changes}
    assert rows["/World/Crate"].new
    assert rows[SOFA].fields == ("xformOp:translate", "variantSelection")
    assert not any(row.new for path, row in rows.items() if path != "/World/Crate")
    assert "/World" not in rows
    assert adoption.left == ("metadata of the file is not adopted: customLayerData",)
    place.compose()
    stage = place.stage()
    assert stage.GetPrimAtPath("/World/Crate").IsDefined()
    assert not stage.GetPrimAtPath("/World/Furniture/chair_a").IsActive()
    bulb = UsdLux.LightAPI(stage.GetPrimAtPath("/World/Furniture/lamp/Geometry/light_bulb"))
    assert bulb.GetIntensityAttr().Get() == 12.5
    assert not any(finding.severity == "error" for finding in validate_stage(place.scene))
    warned = {f.code for f in validate_stage(place.scene) if f.place == "/World/Crate"}
    assert {"label", "material"} <= warned


def test_a_second_time_there_is_nothing_to_do(place: Any) -> None:
    save_over(place)
    adopt(place.scene)
    before = place.tree()
    again = adopt(place.scene)
    assert (again.written, again.changes) == (False, ())
    assert place.tree() == before


def test_compose_refuses_to_write_over_it(place: Any) -> None:
    save_over(place)
    before = place.tree()
    for text in ("seed: 1\n", "seed: 2\n"):
        place.description.write_text(text + place.description.read_text().removeprefix("seed: 1\n"))
        with pytest.raises(StageError, match="another program has saved") as caught:
            place.compose()
        assert f"orusd edit import-changes {place.scene}" in str(caught.value.remedy)
        assert place.tree() == before
    adopt(place.scene)
    assert not place.compose().unchanged


def test_a_file_that_was_only_written_anew_is_not_foreign(place: Any) -> None:
    layer = Sdf.Layer.FindOrOpen(str(place.scene))
    # Sublayers by absolute paths, as some programs write them, say nothing new.
    layer.subLayerPaths = [str(place.out / path) for path in layer.subLayerPaths]
    layer.Save()
    assert place.compose().unchanged
    assert "./layers/edits.usda" in place.scene.read_text()


def test_stronger_opinions_win_one_by_one(place: Any) -> None:
    with place.saving(place.edits) as stage:
        sofa = UsdGeom.XformCommonAPI(stage.GetPrimAtPath(SOFA))
        sofa.SetTranslate((4.0, 4.0, 0.0))
        sofa.SetRotate((0.0, 0.0, 45.0))
        stage.GetPrimAtPath("/World").SetCustomDataByKey("mine", 7)
    with place.saving(place.scene) as stage:
        UsdGeom.XformCommonAPI(stage.GetPrimAtPath(SOFA)).SetTranslate((1.0, 3.0, 0.0))
    adopt(place.scene)
    layer = Sdf.Layer.OpenAsAnonymous(str(place.edits))
    sofa = layer.GetPrimAtPath(SOFA)
    assert tuple(sofa.attributes["xformOp:translate"].default) == (1.0, 3.0, 0.0)
    assert tuple(sofa.attributes["xformOp:rotateXYZ"].default) == (0.0, 0.0, 45.0)
    assert layer.GetPrimAtPath("/World").customData["mine"] == 7


def test_paths_start_at_the_layers_and_strangers_are_named(place: Any, tmp_path: Path) -> None:
    inside, outside = place.out / "props" / "a.usda", tmp_path / "elsewhere" / "b.usda"
    for path in (inside, outside):
        path.parent.mkdir()
        layer = Sdf.Layer.CreateNew(str(path))
        spec = Sdf.CreatePrimInLayer(layer, "/Thing")
        spec.specifier, layer.defaultPrim = Sdf.SpecifierDef, "Thing"
        layer.Save()
    with place.saving(place.scene) as stage:
        for name, path in (("a", "./props/a.usda"), ("b", str(outside))):
            stage.DefinePrim(f"/World/{name}", "Xform").GetReferences().AddReference(path)
    adoption = adopt(place.scene)
    text = place.edits.read_text()
    assert "@../props/a.usda@" in text
    assert "@../../elsewhere/b.usda@" in text
    assert adoption.left == (
        f"{outside} is outside the room's folder: copy it there to move both together",
    )


def test_layers_that_were_put_on_top_are_merged(place: Any) -> None:
    extra = Sdf.Layer.CreateNew(str(place.out / "mine.usda"))
    Sdf.CreatePrimInLayer(extra, "/World/Furniture/chair_b").active = False
    extra.Save()
    with place.saving(place.edits) as stage:
        # Weaker than what lies on top.
        stage.GetPrimAtPath("/World/Furniture/chair_b").SetActive(True)
    root = Sdf.Layer.FindOrOpen(str(place.scene))
    root.subLayerPaths.insert(0, "./mine.usda")
    root.Save()
    with pytest.raises(StageError, match="1 sublayers"):
        place.compose()
    adopt(place.scene)
    assert not place.stage().GetPrimAtPath("/World/Furniture/chair_b").IsActive()
    assert "mine.usda" not in place.scene.read_text()


@pytest.mark.parametrize(("key", "value"), [("upAxis", "Y"), ("metersPerUnit", 0.01)])
def test_other_axes_and_units_are_refused(place: Any, key: str, value: object) -> None:
    save_over(place)
    layer = Sdf.Layer.FindOrOpen(str(place.scene))
    layer.pseudoRoot.SetInfo(key, value)
    layer.Save()
    before = place.tree()
    with pytest.raises(StageError, match=f"saved with {key}"):
        adopt(place.scene)
    assert place.tree() == before


def test_what_cannot_be_composed_changes_nothing(
    place: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    with place.saving(place.scene) as stage:
        stage.DefinePrim("/World/gone").GetReferences().AddReference("./missing.usda")
    before = place.tree()
    with pytest.raises(StageError, match=r"missing\.usda"):
        adopt(place.scene)
    assert place.tree() == before

    def refuse(path: Path, target: Path) -> None:
        raise PermissionError(13, "Permission denied")

    place.scene.write_bytes(before["scene.usda"].replace(b"missing", b"layers/layout"))
    before = place.tree()
    monkeypatch.setattr(Path, "replace", refuse)
    with pytest.raises(OutputError, match="cannot write"):
        adopt(place.scene)
    assert place.tree() == before


@pytest.mark.parametrize("name", ["nothing.usda", "room.yaml"])
def test_what_is_no_usd_is_refused(place: Any, name: str) -> None:
    with pytest.raises(InputError):
        adopt(place.scene, place.description.with_name(name))


def test_the_command_tells_what_it_does(place: Any) -> None:
    save_over(place)
    before = place.tree()
    call = ["edit", "import-changes", str(place.out)]
    tried = run(*call, "--dry-run").output
    assert f"changed  {SOFA}: xformOp:translate, variantSelection\n" in tried
    assert "would move what is said about 5 prims" in tried
    assert place.tree() == before
    done = json.loads(run(*call, "--json").output)
    assert done["written"]
    assert len(done["changes"]) == 5
    assert run(*call).output == "no changes to import\n"
