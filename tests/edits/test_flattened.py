"""Of a room that was saved as one file, what differs becomes an edit, and nothing else."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from pxr import Sdf, Usd, UsdGeom, UsdUtils

from openrooms_usd.edits.adopting import adopt
from openrooms_usd.errors import StageError
from openrooms_usd.usd.files.layers import relative_assets

SOFA, LAMP = "/World/Furniture/sofa", "/World/Furniture/lamp"
Values = Callable[[Usd.Stage], dict[str, object]]


def flatten(place: Any, change: Callable[[Usd.Stage], None], *, stack: bool = False) -> Path:
    """The room as one file: of all its arcs, or of its layer stack alone."""
    stage = place.stage()
    stage.SetEditTarget(stage.GetSessionLayer())
    change(stage)
    path: Path = place.out / "flat.usda"
    if stack:
        flat = UsdUtils.FlattenLayerStack(stage, relative_assets(place.out), "")
        for key in ("upAxis", "metersPerUnit", "defaultPrim"):
            flat.pseudoRoot.SetInfo(key, stage.GetRootLayer().pseudoRoot.GetInfo(key))
    else:
        flat = stage.Flatten(False)
    flat.Export(str(path))
    return path


def nothing(stage: Usd.Stage) -> None:
    """Changes nothing."""


def some(stage: Usd.Stage) -> None:
    UsdGeom.XformCommonAPI(stage.GetPrimAtPath(SOFA)).SetTranslate((1.0, 3.0, 0.0))
    stage.GetPrimAtPath("/World/Furniture/chair_a").SetActive(False)
    UsdGeom.Imageable(stage.GetPrimAtPath(f"{LAMP}/Geometry/lamp_shade")).MakeInvisible()
    UsdGeom.Cube.Define(stage, "/World/Crate").CreateSizeAttr(0.5)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("stack", [True, False])
def test_an_unchanged_room_gives_no_edit(place: Any, stack: bool) -> None:
    before = place.tree()
    adoption = adopt(place.scene, flatten(place, nothing, stack=stack))
    assert (adoption.changes, adoption.left) == ((), ())
    assert adoption.compared > 200
    (place.out / "flat.usda").unlink()
    assert place.tree() == before


@pytest.mark.one_in(4)
@pytest.mark.parametrize("stack", [True, False])
@pytest.mark.parametrize("over", [True, False])
def test_only_what_differs_moves(place: Any, values: Values, stack: bool, over: bool) -> None:
    wanted = place.scene.read_bytes()
    flat = flatten(place, some, stack=stack)
    shown = values(place.stage(flat))
    if over:
        flat = flat.replace(place.scene)
        with pytest.raises(StageError, match="another program has saved"):
            place.compose()
    adoption = adopt(place.scene, None if over else flat)
    assert {(change.path, change.new) for change in adoption.changes} == {
        (SOFA, False),
        ("/World/Furniture/chair_a", False),
        ("/World/Crate", True),
        (f"{LAMP}/Geometry/lamp_shade", False),
    }
    assert adoption.left == ()
    assert place.scene.read_bytes() == wanted
    now = values(place.stage())
    assert {path for path in shown if path in now and shown[path] != now[path]} == set()
    assert not place.stage().GetPrimAtPath("/World/Furniture/chair_a").IsActive()
    assert len(place.edits.read_text()) < 1500


@pytest.mark.slow
def test_a_prim_that_is_gone_is_switched_off(place: Any) -> None:
    flat = flatten(place, nothing)
    layer = Sdf.Layer.FindOrOpen(str(flat))
    furniture = layer.GetPrimAtPath("/World/Furniture")
    for name in ("sofa", "table"):
        del furniture.nameChildren[name]
    layer.Save()
    adoption = adopt(place.scene, flat)
    assert [(row.path, row.fields) for row in adoption.changes] == [
        (SOFA, ("active",)),
        ("/World/Furniture/table", ("active",)),
    ]
    assert adopt(place.scene, flat).changes == ()


@pytest.mark.slow
def test_an_instance_that_was_opened_and_changed_is_opened_here_too(
    place: Any, values: Values
) -> None:
    def paint(stage: Usd.Stage) -> None:
        stage.GetPrimAtPath(SOFA).SetInstanceable(False)
        part = next(p for p in Usd.PrimRange(stage.GetPrimAtPath(SOFA)) if p.IsA(UsdGeom.Mesh))
        UsdGeom.Imageable(part).MakeInvisible()

    flat = flatten(place, paint)
    shown = values(place.stage(flat))
    adoption = adopt(place.scene, flat)
    assert adoption.written
    assert not place.stage().GetPrimAtPath(SOFA).IsInstance()
    now = values(place.stage())
    hidden = [path for path in shown if shown[path] == "invisible"]
    assert len(hidden) == 1
    assert now[hidden[0]] == "invisible"
    assert place.compose().orphans == ()


@pytest.mark.slow
def test_what_has_no_place_of_its_own_is_left_and_said(place: Any) -> None:
    flat = flatten(place, nothing)
    layer = Sdf.Layer.FindOrOpen(str(flat))
    prototypes = [spec for spec in layer.rootPrims if spec.name.startswith("Flattened_Prototype")]
    mesh = next(m for p in prototypes if (m := _mesh(p)))
    mesh.attributes["subdivisionScheme"].default = "catmullClark"
    furniture = layer.GetPrimAtPath("/World/Furniture")
    Sdf.CopySpec(layer, SOFA, layer, "/World/Furniture/sofa_copy")
    assert furniture.nameChildren["sofa_copy"]
    layer.Save()
    adoption = adopt(place.scene, flat)
    assert adoption.changes == ()
    assert any("was changed inside an instance" in sentence for sentence in adoption.left)
    assert "/World/Furniture/sofa_copy is a copy of an instance" in " ".join(adoption.left)


def _mesh(spec: Sdf.PrimSpec) -> Sdf.PrimSpec | None:
    if spec.typeName == "Mesh":
        return spec
    return next((found for child in spec.nameChildren if (found := _mesh(child))), None)


def test_a_file_without_this_room_is_refused(place: Any) -> None:
    before = place.tree()
    blender = place.description.with_name("blender.usda")
    blender.write_text(
        '#usda 1.0\n(\n    upAxis = "Z"\n    metersPerUnit = 1\n)\ndef Xform "root"\n{\n}\n'
    )
    with pytest.raises(StageError, match="has no /World, but /root"):
        adopt(place.scene, blender)
    assert place.tree() == before
    blender.replace(place.scene)
    with pytest.raises(StageError, match="has no /World, but /root"):
        adopt(place.scene)


@pytest.mark.slow
def test_a_flattened_file_that_does_not_say_its_axes_is_refused(place: Any) -> None:
    flat = flatten(place, some)
    flat.write_text(flat.read_text().replace('    upAxis = "Z"\n', "", 1))
    with pytest.raises(StageError, match="upAxis = Y"):
        adopt(place.scene, flat)


def test_overrides_that_were_saved_alone_are_taken_as_they_are(place: Any) -> None:
    overrides = place.out / "overrides.usda"
    overrides.write_text(
        '#usda 1.0\nover "World" {\n    over "Furniture" {\n        over "sofa" {\n'
        "            double3 xformOp:translate = (1, 3, 0)\n        }\n    }\n}\n"
    )
    assert adopt(place.scene, overrides).written
    assert not adopt(place.scene, overrides).written
    stage = place.stage()
    position = stage.GetPrimAtPath(SOFA).GetAttribute("xformOp:translate").Get()
    assert tuple(position) == (1.0, 3.0, 0.0)
