"""What people decide about physics: in the description, by looks, and in the edits."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from openrooms_usd import names
from openrooms_usd.composing import compose_room
from openrooms_usd.description.room import Room
from openrooms_usd.errors import DescriptionError
from openrooms_usd.physics.world import Body
from openrooms_usd.steps import runner
from openrooms_usd.steps.alignment.step import AlignmentStep
from openrooms_usd.steps.draft import drafting
from openrooms_usd.steps.layout.step import LayoutStep
from openrooms_usd.steps.materials.step import MaterialsStep
from openrooms_usd.steps.physics.step import PhysicsStep
from openrooms_usd.usd.rigid.reading import read_world
from openrooms_usd.usd.shapes.meshes import read_meshes

CHAIR = {"category": "chair", "style": "slat"}
NAMES = ("one", "two")
FURNITURE = names.FURNITURE


def described(
    materials: dict[str, Any] | None = None, repeats: int = 0, **section: Any
) -> dict[str, Any]:
    objects = [{**CHAIR, "name": name, "at": [i + 1, 1]} for i, name in enumerate(NAMES)]
    objects += [{**CHAIR, "name": f"more_{i}", "at": [1, 2]} for i in range(repeats)]
    return {
        "furniture": {"objects": objects},
        "materials": {"resolution": 16, **(materials or {})},
        "physics": {"shapes": "hull", **section},
    }


def compose(folder: Path, room: dict[str, Any], workers: int = 1) -> tuple[Usd.Stage, list[str]]:
    found = Room.model_validate(room)
    with drafting(folder) as draft:
        runner.create_edits(draft)
        for step in (LayoutStep(), AlignmentStep(), MaterialsStep(), PhysicsStep()):
            notes = runner.run(step, found, folder, draft, "fingerprint", workers)
        runner.write_scene(draft)
    made = Usd.Stage.Open(str(folder / names.SCENE))
    made.Reload()
    return made, list(notes)


def bodies(stage: Usd.Stage) -> dict[str, Body]:
    return {body.name: body for body in read_world(stage).bodies}


def edited(folder: Path, stage: Usd.Stage) -> Sdf.Layer:
    layer = Sdf.Layer.FindOrOpen(str(folder / "layers" / "edits.usda"))
    stage.SetEditTarget(layer)
    return layer


@pytest.mark.slow
def test_an_object_weighs_grips_and_stays_as_it_is_told(tmp_path: Path) -> None:
    objects = {"one": {"mass": "12 kg", "friction": 0.2}, "two": {"body": "fixed"}}
    usual = bodies(compose(tmp_path / "usual", described())[0])["one"].links[0]
    found = bodies(compose(tmp_path / "told", described(objects=objects))[0])
    told = found["one"].links[0]
    assert usual.mass is not None and told.mass is not None
    assert told.mass.mass == pytest.approx(12.0)
    np.testing.assert_allclose(told.mass.centre, usual.mass.centre, atol=1e-6)
    growth = 12.0 / usual.mass.mass
    np.testing.assert_allclose(told.mass.inertia, usual.mass.inertia * growth, rtol=1e-5, atol=1e-9)
    assert {round(shape.contact.static_friction, 6) for shape in told.shapes} == {0.2}
    assert all(s.contact.dynamic_friction < 0.2 for s in told.shapes)
    assert found["two"].fixed and found["two"].links[0].mass is None
    assert not found["one"].fixed


@pytest.mark.slow
def test_boxes_are_boxes(tmp_path: Path) -> None:
    objects = {"one": {"shapes": "box"}}
    found = bodies(compose(tmp_path, described(objects=objects))[0])["one"].links[0]
    assert all(len(shape.mesh.points) == 8 for shape in found.shapes)


def test_names_that_are_not_there_are_refused(tmp_path: Path) -> None:
    room = described()
    room["furniture"] = {"objects": []}
    room["physics"] = {"objects": {}}
    found = Room.model_validate(room)
    wrong = found.model_copy(
        update={"physics": Room.model_validate(described(objects={"one": {}})).physics}
    )
    with drafting(tmp_path) as draft:
        runner.create_edits(draft)
        for step in (LayoutStep(), AlignmentStep(), MaterialsStep()):
            runner.run(step, found, tmp_path, draft, "fingerprint", 1)
        with pytest.raises(DescriptionError, match="there is no object 'one'"):
            runner.run(PhysicsStep(), wrong, tmp_path, draft, "fingerprint", 1)


@pytest.mark.slow
def test_another_look_has_another_mass_and_friction(tmp_path: Path) -> None:
    stage, _ = compose(tmp_path, described({"looks": 2, "overrides": {}}))
    root = stage.GetPrimAtPath(f"{FURNITURE}/one")
    weights, contacts = [], []
    for look in root.GetVariantSet("look").GetVariantNames():
        root.GetVariantSet("look").SetVariantSelection(look)
        link = bodies(stage)["one"].links[0]
        assert link.mass is not None
        weights.append(link.mass.mass)
        contacts.append({shape.contact for shape in link.shapes})
    assert contacts[0] != contacts[1]
    assert all(weight > 0.0 for weight in weights)
    # Chosen on the root: the other one is as it was.
    assert bodies(stage)["two"].links[0].mass is not None


@pytest.mark.one_in(9)
@pytest.mark.parametrize("scale", [(2.0, 1.0, 1.0), (-1.0, 1.0, 1.0), (1.0, -2.0, 0.5)])
def test_scaled_and_mirrored_roots_weigh_what_their_meshes_do(
    tmp_path: Path, scale: tuple[float, float, float]
) -> None:
    stage, _ = compose(tmp_path, described())
    layer = edited(tmp_path, stage)
    xform = UsdGeom.Xformable(stage.GetPrimAtPath(f"{FURNITURE}/one"))
    xform.AddScaleOp().Set(Gf.Vec3f(*scale))
    layer.Save()
    again, _ = compose(tmp_path, described())
    found = bodies(again)["one"]
    (link,) = found.links
    assert link.mass is not None
    corners = {True: [], False: []}
    for mesh in read_meshes(again):
        if mesh.path.startswith(f"{FURNITURE}/one/"):
            corners[True].append(mesh.world_points())
    for shape in link.shapes:
        M = found.world_from_body
        corners[False].append(shape.mesh.points @ M[:3, :3].T + M[:3, 3])
    seen, hit = (np.concatenate(corners[key]) for key in (True, False))
    np.testing.assert_allclose(hit.min(axis=0), seen.min(axis=0), atol=2e-3)
    np.testing.assert_allclose(hit.max(axis=0), seen.max(axis=0), atol=2e-3)
    middle = found.world_from_body[:3, :3] @ link.mass.centre + found.world_from_body[:3, 3]
    assert (middle > seen.min(axis=0)).all() and (middle < seen.max(axis=0)).all()
    # USD's own rules say the same, in the body's frame.
    api = UsdPhysics.RigidBodyAPI(again.GetPrimAtPath(f"{FURNITURE}/one"))
    mass, moments, centre, _ = api.ComputeMassProperties(
        lambda prim: UsdPhysics.RigidBodyAPI.MassInformation()
    )
    assert mass == pytest.approx(link.mass.mass, rel=1e-6)
    np.testing.assert_allclose(np.array(centre), link.mass.centre, atol=1e-6)
    np.testing.assert_allclose(np.sort(moments), np.linalg.eigvalsh(link.mass.inertia), rtol=1e-4)


@pytest.mark.slow
def test_what_people_edit_survives_the_next_run(tmp_path: Path) -> None:
    stage, _ = compose(tmp_path, described(repeats=2))
    layer = edited(tmp_path, stage)
    stage.GetPrimAtPath(f"{FURNITURE}/two").SetActive(False)
    UsdPhysics.MassAPI(stage.GetPrimAtPath(f"{FURNITURE}/one")).CreateMassAttr(30.0)
    still = stage.GetPrimAtPath(f"{FURNITURE}/more_0")
    UsdPhysics.RigidBodyAPI(still).CreateRigidBodyEnabledAttr(False)
    before = bodies(stage)["more_1"].links[0].mass
    layer.Save()
    again, _ = compose(tmp_path, described(repeats=2))
    found = bodies(again)
    assert "two" not in found and found["more_0"].fixed
    weight = found["one"].links[0].mass
    assert weight is not None and before is not None
    assert weight.mass == pytest.approx(30.0)
    # Its inertia goes with its mass.
    np.testing.assert_allclose(
        weight.inertia, before.inertia * (30.0 / before.mass), rtol=1e-4, atol=1e-7
    )
    deactivated = described(repeats=2, objects={"two": {"mass": 3}})
    _, notes = compose(tmp_path, deactivated)
    assert notes == ["two: deactivated, so it has no physics"]


@pytest.mark.slow
def test_repeats_are_worked_out_once_and_the_workers_change_no_byte(tmp_path: Path) -> None:
    contents = []
    for workers in (1, 3):
        folder = tmp_path / str(workers)
        compose(folder, described({"looks": 2}, repeats=20), workers)
        files = sorted(folder.rglob("layers/physics*")) + sorted(folder.rglob("physics/**/*"))
        contents.append(
            {f.relative_to(folder): f.read_bytes() for f in sorted(set(files)) if f.is_file()}
        )
    assert contents[0] == contents[1]
    assert sum(path.suffix == ".usda" and "bodies" in path.parts for path in contents[0]) == 1
    stage = Usd.Stage.Open(str(tmp_path / "1" / names.SCENE))
    roots = stage.GetPrimAtPath(FURNITURE).GetChildren()
    assert len({root.GetPrototype().GetPath() for root in roots}) == 1


@pytest.mark.slow
def test_poses_of_a_simulation_are_stacked_and_said_to_be_old(tmp_path: Path) -> None:
    source = tmp_path / "room.yaml"
    source.write_text("furniture: {objects: []}\nphysics: {shapes: hull}\n")
    out = tmp_path / "out"
    first = compose_room(source, out, workers=1)
    assert not [note for note in first.notes if "settled" in note]
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString((out / "layers" / "edits.usda").read_text())
    gone = Sdf.CreatePrimInLayer(layer, f"{FURNITURE}/gone")
    Sdf.AttributeSpec(gone, "xformOp:translate:settled", Sdf.ValueTypeNames.Double3)
    layer.Export(str(out / "layers" / "settled.usda"))
    held = (out / "layers" / "settled.usda").read_bytes()
    second = compose_room(source, out, workers=1)
    scene = Sdf.Layer.OpenAsAnonymous(str(out / names.SCENE))
    stacked = list(scene.subLayerPaths)
    assert [path.rpartition("/")[2] for path in stacked][:3] == [
        "edits.usda",
        "settled.usda",
        "physics.usda",
    ]
    said = [note for note in second.notes if note not in first.notes]
    assert len(said) == 1 and "1 opinions without effect" in said[0]
    source.write_text("furniture: {objects: []}\nphysics: {gravity: 1.6}\n")
    third = compose_room(source, out, workers=1)
    assert "older than the physics" in third.notes[0]
    assert (out / "layers" / "settled.usda").read_bytes() == held
