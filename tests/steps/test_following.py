"""What belongs to an object goes along when somebody moves that object in the edits."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.composing import compose_room

ROOM = """\
layout: {polygon: [[0, 0], [6, 0], [6, 5], [0, 5]]}
furniture:
  objects:
    - {name: sofa, category: sofa, at: [2.5, 3.2], yaw: 20}
    - {name: side, category: table, size: [0.5, 0.5, 0.5], at: [1.4, 0.1], yaw: 5,
       relative_to: sofa}
    - {name: lamp, category: table_lamp, at: [1.4, 0.1], relative_to: sofa, on: side}
    - {name: clock, category: cabinet, size: [0.4, 0.1, 0.4], at: [0, 1.7, 1.5], on: wall,
       relative_to: sofa}
    - {name: desk, category: table, at: [4.5, 1]}
    - {name: reading, category: table_lamp, at: [4.5, 1]}
materials: {resolution: 16}
cameras: {resolution: [16, 12], views: [{name: eye, eye: [1, 1, 1.5], target: [3, 3, 1]}]}
"""
Edit = Callable[[Usd.Stage], None]


def compose(folder: Path) -> tuple[Usd.Stage, list[str]]:
    (folder / "room.yaml").write_text(ROOM)
    summary = compose_room(folder / "room.yaml", folder / "out", workers=1)
    stage = Usd.Stage.Open(str(summary.scene))
    stage.Reload()
    return stage, [note for row in summary.stages for note in row.notes]


def poses(stage: Usd.Stage) -> dict[str, Array]:
    """(4, 4) world_from_object of all furniture, column vectors."""
    children = stage.GetPrimAtPath(names.FURNITURE).GetChildren()
    time = Usd.TimeCode.EarliestTime()
    return {
        prim.GetName(): np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(time)).T
        for prim in children
    }


def around(folder: Path, edit: Edit) -> tuple[dict[str, Array], dict[str, Array], list[str]]:
    """The poses before an edit and after the next compose, and the notes of that."""
    stage, _ = compose(folder)
    before = poses(stage)
    stage.SetEditTarget(Sdf.Layer.FindOrOpen(str(folder / "out/layers/edits.usda")))
    edit(stage)
    stage.GetEditTarget().GetLayer().Save()
    del stage
    after, notes = compose(folder)
    return before, poses(after), notes


def prim(stage: Usd.Stage, name: str) -> Usd.Prim:
    return stage.GetPrimAtPath(f"{names.FURNITURE}/{name}")


def common(stage: Usd.Stage, name: str) -> UsdGeom.XformCommonAPI:
    return UsdGeom.XformCommonAPI(prim(stage, name))


def move(stage: Usd.Stage) -> None:
    common(stage, "sofa").SetTranslate((3.0, 2.2, 0.0))
    common(stage, "sofa").SetRotate((0.0, 0.0, 65.0))


def by_matrix(stage: Usd.Stage) -> None:
    turn = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(0, 0, 1), 65.0))
    matrix = turn * Gf.Matrix4d().SetTranslate(Gf.Vec3d(3.0, 2.2, 0.0))
    UsdGeom.Xformable(prim(stage, "sofa")).MakeMatrixXform().Set(matrix)


def by_orient_about_a_pivot(stage: Usd.Stage) -> None:
    xform = UsdGeom.Xformable(prim(stage, "sofa"))
    xform.ClearXformOpOrder()
    pivot = Gf.Vec3d(0.3, -0.2, 0.0)
    turn = Gf.Rotation(Gf.Vec3d(0, 0, 1), 65.0)
    # p -> T + pivot + R (p - pivot): its origin shall land at (3, 2.2).
    offset = Gf.Vec3d(3.0, 2.2, 0.0) - pivot + turn.TransformDir(pivot)
    xform.AddTranslateOp(opSuffix="byHand").Set(offset)
    xform.AddTranslateOp(UsdGeom.XformOp.PrecisionFloat, "pivot").Set(Gf.Vec3f(pivot))
    xform.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Quatd(turn.GetQuat()))
    xform.AddTranslateOp(UsdGeom.XformOp.PrecisionFloat, "pivot", isInverseOp=True)


@pytest.mark.parametrize("edit", [move, by_matrix, by_orient_about_a_pivot])
def test_a_motion_takes_along_what_belongs_to_the_object(tmp_path: Path, edit: Edit) -> None:
    before, after, notes = around(tmp_path, edit)
    assert notes == []
    motion = after["sofa"] @ np.linalg.inv(before["sofa"])
    np.testing.assert_allclose(after["sofa"][:2, 3], [3.0, 2.2], atol=1e-6)
    for name in ("side", "lamp"):
        np.testing.assert_allclose(after[name], motion @ before[name], atol=1e-6)
    for name in ("desk", "reading"):
        assert (after[name] == before[name]).all()
    # What hangs on a wall stays flush with one: with the wall that is near it now.
    assert after["clock"][0, 3] == pytest.approx(0.05)
    np.testing.assert_allclose(after["clock"][:2, 1], [-1.0, 0.0], atol=1e-6)
    assert after["clock"][2, 3] == before["clock"][2, 3] == 1.5


def test_height_and_tilt_go_on_to_what_is_carried_and_not_to_what_stands_beside(
    tmp_path: Path,
) -> None:
    def tilt(stage: Usd.Stage) -> None:
        for name in ("sofa", "desk"):
            x, y, z = prim(stage, name).GetAttribute("xformOp:translate").Get()
            common(stage, name).SetTranslate((x, y, z + 0.2))
            common(stage, name).SetRotate((10.0, 15.0, 20.0))

    before, after, _ = around(tmp_path, tilt)
    assert after["side"][2, 3] == after["lamp"][2, 3] - before["lamp"][2, 3] == 0.0
    np.testing.assert_allclose(after["side"][:3, 2], [0, 0, 1], atol=1e-12)
    motion = after["desk"] @ np.linalg.inv(before["desk"])
    np.testing.assert_allclose(after["reading"], motion @ before["reading"], atol=1e-6)


def test_a_scaled_support_moves_places_and_leaves_sizes(tmp_path: Path) -> None:
    def stretch(stage: Usd.Stage) -> None:
        common(stage, "desk").SetScale((2.0, 1.0, 1.5))
        common(stage, "sofa").SetScale((2.0, 1.0, 1.0))

    before, after, _ = around(tmp_path, stretch)
    assert after["reading"][2, 3] == pytest.approx(1.5 * before["reading"][2, 3])
    for name in ("side", "reading"):
        np.testing.assert_allclose(np.linalg.det(after[name]), 1.0, atol=1e-6)
    in_sofa = np.linalg.inv(before["sofa"]) @ before["side"][:, 3]
    np.testing.assert_allclose(after["side"][:, 3], after["sofa"] @ in_sofa, atol=1e-6)


def test_an_own_edit_is_stronger_than_following(tmp_path: Path) -> None:
    def both(stage: Usd.Stage) -> None:
        move(stage)
        common(stage, "side").SetTranslate((5.0, 4.0, 0.0))

    before, after, _ = around(tmp_path, both)
    np.testing.assert_allclose(after["side"][:3, 3], [5.0, 4.0, 0.0])
    # The lamp stands on the table, wherever that went.
    np.testing.assert_allclose(after["lamp"][:2, 3], [5.0, 4.0], atol=1e-6)
    assert after["lamp"][2, 3] == before["lamp"][2, 3]


@pytest.mark.one_in(3)
@pytest.mark.parametrize("how", ["deactivated", "hidden", "flat"])
def test_nothing_follows_what_is_off(tmp_path: Path, how: str) -> None:
    def off(stage: Usd.Stage) -> None:
        move(stage)
        if how == "deactivated":
            prim(stage, "sofa").SetActive(False)
        elif how == "hidden":
            UsdGeom.Imageable(prim(stage, "sofa")).MakeInvisible()
        else:
            common(stage, "sofa").SetScale((0.0, 0.0, 0.0))

    before, after, notes = around(tmp_path, off)
    for name in ("side", "lamp", "clock"):
        assert (after[name] == before[name]).all()
    said = "sofa has a scale of zero" if how == "flat" else "sofa is switched off"
    assert any(said in note for note in notes)


def test_the_room_carries_its_furniture_where_it_is(tmp_path: Path) -> None:
    def lower(stage: Usd.Stage) -> None:
        room = UsdGeom.XformCommonAPI(stage.GetPrimAtPath(names.ROOM))
        room.SetTranslate((0.5, 0.0, -0.3))

    before, after, _ = around(tmp_path, lower)
    for name in ("sofa", "side", "lamp", "desk"):
        np.testing.assert_allclose(after[name][:3, 3] - before[name][:3, 3], [0, 0, -0.3])
    assert after["clock"][2, 3] == 1.5


def test_moving_the_whole_world_moves_nothing_inside_it(tmp_path: Path) -> None:
    def shift(stage: Usd.Stage) -> None:
        world = UsdGeom.XformCommonAPI(stage.GetPrimAtPath(names.WORLD))
        world.SetTranslate((10.0, 0.0, 1.0))

    before, after, _ = around(tmp_path, shift)
    for name, pose in before.items():
        np.testing.assert_allclose(after[name][:3, 3] - pose[:3, 3], [10.0, 0.0, 1.0])


def test_taking_an_edit_back_brings_everything_back(tmp_path: Path) -> None:
    stage, _ = compose(tmp_path)
    first = (tmp_path / "out/layers/alignment.usda").read_bytes()
    edits = tmp_path / "out/layers/edits.usda"
    empty = edits.read_bytes()
    del stage
    around(tmp_path, move)
    assert (tmp_path / "out/layers/alignment.usda").read_bytes() != first
    edits.write_bytes(empty)
    compose(tmp_path)
    assert (tmp_path / "out/layers/alignment.usda").read_bytes() == first
