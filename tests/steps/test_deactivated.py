"""People deactivate or hide things in the edits layer; compose goes on, and they stay off."""

from pathlib import Path

import pytest
from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.composing import ComposeSummary, compose_room
from openrooms_usd.usd.files.layers import is_deactivated

ROOM = """\
seed: {seed}
layout:
  openings:
    - {{name: door, kind: door, wall: 0, open: {open}}}
    - {{name: window, kind: window, wall: 1}}
furniture:
  objects:
    - {{name: sofa, category: sofa, at: [2, 3], yaw: 20}}
    - {{name: lamp, category: floor_lamp, at: [1, 1]}}
materials:
  resolution: 16
  overrides: {{sofa: {{all: {{family: wood}}}}, lamp: {{lamp_shade: {{family: fabric}}}}}}
lights:
  lamps: {{lamp: {{lumen: 500}}}}
cameras:
  views:
    - {{name: eye, eye: [1, 1, 1.5], target: [3, 3, 1]}}
"""
DOOR = f"{names.OPENINGS}/door"
PORTAL = f"{names.PORTALS}/door"


def compose(folder: Path, seed: int, *, angle: int = 60, text: str = ROOM) -> ComposeSummary:
    description = folder / "room.yaml"
    description.write_text(text.format(seed=seed, open=angle))
    return compose_room(description, folder, workers=1)


def edit(folder: Path, path: str, *, hide: bool = False, active: bool = False) -> None:
    layer = Sdf.Layer.FindOrOpen(str(folder / "layers" / "edits.usda"))
    layer.Reload()
    spec = Sdf.CreatePrimInLayer(layer, path)
    if hide:
        token = Sdf.ValueTypeNames.Token
        Sdf.AttributeSpec(spec, UsdGeom.Tokens.visibility, token).default = "invisible"
    else:
        spec.active = active
    layer.Save()


def scene(folder: Path) -> Usd.Stage:
    stage = Usd.Stage.Open(str(folder / names.SCENE))
    stage.Reload()
    return stage


def portal_values(folder: Path) -> dict[str, object]:
    layer = Sdf.Layer.OpenAsAnonymous(str(folder / "layers" / "lights.usda"))
    return {spec.name: spec.default for spec in layer.GetPrimAtPath(PORTAL).attributes}


def prims_off(stage: Usd.Stage) -> list[str]:
    return [
        str(p.GetPath()) for p in Usd.PrimRange.AllPrims(stage.GetPseudoRoot()) if not p.IsActive()
    ]


@pytest.mark.one_in(392)
@pytest.mark.parametrize(
    "path",
    [
        f"{names.OPENINGS}/window",
        f"{DOOR}/Leaf",
        names.WORLD,
        names.ROOM,
        names.FURNITURE,
        f"{names.FURNITURE}/sofa",
        f"{names.FURNITURE}/lamp",
        names.MATERIALS,
        names.LIGHTS,
        names.ENVIRONMENT,
        PORTAL,
        names.CAMERAS,
        f"{names.CAMERAS}/eye",
        names.RENDER,
    ],
)
def test_what_is_deactivated_stays_so(tmp_path: Path, path: str) -> None:
    compose(tmp_path, 1)
    edit(tmp_path, path)
    edited = (tmp_path / "layers" / "edits.usda").read_bytes()
    assert {row.state for row in compose(tmp_path, 2).stages} == {"written"}
    stage = scene(tmp_path)
    assert prims_off(stage) == [path]
    assert (tmp_path / "layers" / "edits.usda").read_bytes() == edited
    assert not list((tmp_path / "layers").glob(".*"))
    stage.SetEditTarget(stage.GetSessionLayer())
    stage.GetPrimAtPath(path).SetActive(True)
    # All that was there before is there below it.
    assert stage.GetPrimAtPath(path).GetSpecifier() == Sdf.SpecifierDef


@pytest.mark.one_in(4)
@pytest.mark.parametrize("path", [names.ROOM, DOOR, f"{names.FURNITURE}/lamp", names.LIGHTS])
def test_what_is_hidden_stays_so(tmp_path: Path, path: str) -> None:
    compose(tmp_path, 1)
    edit(tmp_path, path, hide=True)
    compose(tmp_path, 2)
    stage = scene(tmp_path)
    prim = UsdGeom.Imageable(stage.GetPrimAtPath(path))
    assert prim.ComputeVisibility() == UsdGeom.Tokens.invisible


@pytest.mark.slow
def test_other_steps_do_not_see_it_and_say_so(tmp_path: Path) -> None:
    compose(tmp_path, 1)
    edit(tmp_path, f"{names.FURNITURE}/lamp/Geometry/lamp_shade")
    notes = {row.stage: " ".join(row.notes) for row in compose(tmp_path, 1).stages}
    assert "lamp: parts are deactivated" in notes["materials"]
    for name in ("sofa", "lamp"):
        edit(tmp_path, f"{names.FURNITURE}/{name}")
    notes = {row.stage: " ".join(row.notes) for row in compose(tmp_path, 2).stages}
    assert "lamp: deactivated" in notes["lights"]
    assert "sofa: deactivated" in notes["materials"]
    lights = Sdf.Layer.OpenAsAnonymous(str(tmp_path / "layers" / "lights.usda"))
    assert not lights.GetPrimAtPath(f"{names.FURNITURE}/lamp")


def test_only_what_was_deactivated_counts_as_such() -> None:
    stage = Usd.Stage.CreateInMemory()
    for path in ("/World/Furniture/sofa", "/World/Furniture/lamp/bulb", "/World/Furniture/table"):
        UsdGeom.Xform.Define(stage, path)
    for path in ("/World/Furniture/sofa", "/World/Furniture/lamp/bulb"):
        stage.GetPrimAtPath(path).SetActive(False)
    off = [
        name
        for name in ("sofa", "sofa/seat", "lamp", "table", "sofaa")
        if is_deactivated(stage, f"{names.FURNITURE}/{name}")
    ]
    assert off == ["sofa", "sofa/seat", "lamp"]


@pytest.mark.one_in(5)
@pytest.mark.parametrize(
    ("path", "hide"),
    [
        (f"{DOOR}/Leaf", False),
        (f"{DOOR}/Leaf", True),
        (f"{DOOR}/Leaf/Panel", False),
        (f"{DOOR}/Leaf/Panel", True),
        (DOOR, False),
    ],
)
def test_a_door_without_its_leaf_lets_light_in(tmp_path: Path, path: str, hide: bool) -> None:
    compose(tmp_path, 1, angle=0)
    assert not scene(tmp_path).GetPrimAtPath(PORTAL)
    edit(tmp_path, path, hide=hide)
    compose(tmp_path, 1, angle=0)
    assert scene(tmp_path).GetPrimAtPath(PORTAL).IsDefined()


@pytest.mark.slow
def test_the_hole_of_a_deactivated_opening_keeps_its_portal(tmp_path: Path) -> None:
    compose(tmp_path, 1)
    before = portal_values(tmp_path)
    edit(tmp_path, DOOR)
    compose(tmp_path, 1)
    assert before
    assert portal_values(tmp_path) == before


@pytest.mark.slow
def test_people_s_own_files_stay_when_the_edits_are_reset(tmp_path: Path) -> None:
    compose(tmp_path, 1)
    picture = tmp_path / "layers" / "edits" / "picture.png"
    picture.parent.mkdir()
    picture.write_bytes(b"mine")
    (tmp_path / "layers" / "edits.usda").unlink()
    compose(tmp_path, 2)
    assert picture.read_bytes() == b"mine"


@pytest.mark.slow
def test_relative_paths_of_the_edits_hold_while_a_step_runs(tmp_path: Path) -> None:
    compose(tmp_path, 1)
    edit(tmp_path, f"{names.FURNITURE}/sofa")
    below = Sdf.Layer.CreateNew(str(tmp_path / "layers" / "edits_too.usda"))
    Sdf.CreatePrimInLayer(below, f"{names.OPENINGS}/window").active = True
    below.Save()
    edits = Sdf.Layer.FindOrOpen(str(tmp_path / "layers" / "edits.usda"))
    edits.subLayerPaths.append("./edits_too.usda")
    edits.Save()
    compose(tmp_path, 2)
    assert prims_off(scene(tmp_path)) == [f"{names.FURNITURE}/sofa"]
