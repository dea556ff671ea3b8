"""Furniture that people move, copy, take away and exchange: opinions in the edits alone."""

import math
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.composing import compose_room
from openrooms_usd.edits.arranging import beside, duplicate, place, relabel, remove, standing
from openrooms_usd.edits.editing import History
from openrooms_usd.edits.orphans import orphans_of
from openrooms_usd.edits.remaking import remake
from openrooms_usd.edits.snapping import PlanPoint
from openrooms_usd.edits.targets import furniture
from openrooms_usd.errors import DescriptionError, InputError, OrusdError
from openrooms_usd.usd.semantics import read_label
from tests.edits.test_assigning import others

CHANGES: dict[str, Callable[[Path], object]] = {
    "move": lambda scene: place(scene, "chair_1", PlanPoint(3.0, 2.2, 45.0)),
    "resize": lambda scene: place(scene, "desk", PlanPoint(1.5, 1.5, 0.0), size=(1.8, 0.7, 0.9)),
    "duplicate": lambda scene: duplicate(scene, "chair_1"),
    "remove": lambda scene: remove(scene, "table_lamp_0"),
    "relabel": lambda scene: relabel(scene, "chair_1", "stool"),
    "remake": lambda scene: remake(scene, "chair_1", "shell"),
    "exchange": lambda scene: remake(scene, "chair_1", "drawers", "night_stand", keep_size=False),
}


@pytest.fixture
def scene(composed_demo: Path, tmp_path: Path) -> Path:
    shutil.copytree(composed_demo.parents[1], tmp_path / "room")
    return tmp_path / "room/out/scene.usda"


def stage_of(scene: Path) -> Usd.Stage:
    stage = Usd.Stage.Open(str(scene))
    stage.Reload()
    return stage


def objects(scene: Path) -> dict[str, bool]:
    """All objects, and whether they are there."""
    stage = stage_of(scene)
    return {
        child.GetName(): child.IsActive()
        for child in stage.GetPrimAtPath("/World/Furniture").GetAllChildren()
    }


def is_a(scene: Path, name: str) -> tuple[str | None, set[str]]:
    """The category of an object, and its meshes."""
    stage = stage_of(scene)
    prim = stage.GetPrimAtPath(f"/World/Furniture/{name}")
    inner = Usd.PrimRange(prim, Usd.TraverseInstanceProxies())
    return read_label(prim, "category"), {one.GetName() for one in inner if one.IsA(UsdGeom.Mesh)}


def box(scene: Path, name: str) -> np.ndarray:
    """(2, 3) the box of an object by its points in the world."""
    stage, cache = stage_of(scene), UsdGeom.XformCache()
    points = []
    root = stage.GetPrimAtPath(f"/World/Furniture/{name}")
    for prim in Usd.PrimRange(root, Usd.TraverseInstanceProxies()):
        if prim.IsA(UsdGeom.Mesh):
            local = np.array(UsdGeom.Mesh(prim).GetPointsAttr().Get())
            world = np.array(cache.GetLocalToWorldTransform(prim))
            points.append(local @ world[:3, :3] + world[3, :3])
    every = np.concatenate(points)
    return np.stack([every.min(axis=0), every.max(axis=0)])


@pytest.mark.one_in(7)
@pytest.mark.parametrize("kind", CHANGES)
def test_a_change_survives_compositions_and_writes_no_other_layer(
    kind: str, scene: Path, assert_valid: Callable[..., None]
) -> None:
    edits, before = scene.parent / "layers/edits.usda", others(scene)
    CHANGES[kind](scene)
    changed = edits.read_bytes()
    assert others(scene) == before and b"Furniture" in changed
    seen = objects(scene)
    done = compose_room(scene.parents[1] / "room.yaml", scene.parent)
    assert not done.orphans and edits.read_bytes() == changed
    assert objects(scene) == seen
    assert_valid(scene)


def test_it_stands_where_it_was_put_and_what_is_on_it_follows(scene: Path) -> None:
    lamp = box(scene, "table_lamp_0")
    place(scene, "desk", PlanPoint(2.5, 1.9, 0.0))
    assert box(scene, "desk").mean(axis=0)[:2] == pytest.approx((2.5, 1.9), abs=1e-5)
    compose_room(scene.parents[1] / "room.yaml", scene.parent)
    assert box(scene, "table_lamp_0") - lamp == pytest.approx(
        np.tile([1.0, 0.4, 0.0], (2, 1)), abs=1e-5
    )


def test_it_turns_about_itself_and_gets_its_size(scene: Path) -> None:
    before = np.ptp(box(scene, "desk"), axis=0)
    place(scene, "desk", PlanPoint(2.0, 1.5, 90.0), snap=False)
    assert np.ptp(box(scene, "desk"), axis=0) == pytest.approx(before[[1, 0, 2]], abs=1e-4)
    place(scene, "desk", PlanPoint(2.0, 1.5, 90.0), size=(2.0, 0.6, 0.5), snap=False)
    assert np.ptp(box(scene, "desk"), axis=0) == pytest.approx((0.6, 2.0, 0.5), abs=1e-4)
    assert box(scene, "desk")[0, 2] == pytest.approx(0.0, abs=1e-6)


def test_it_comes_flush_to_walls_that_are_near(scene: Path) -> None:
    # The room is 4 m by 3 m, its inner corner in the origin.
    place(scene, "chair_1", PlanPoint(0.33, 0.4, 4.0))
    low = box(scene, "chair_1")[0]
    assert low[:2] == pytest.approx((0.0, 0.0), abs=1e-5)
    place(scene, "chair_1", PlanPoint(4.1, 1.5, 85.0))
    low, high = box(scene, "chair_1")
    assert high[0] == pytest.approx(4.0, abs=1e-5) and (low[1] + high[1]) / 2 == pytest.approx(
        1.5, abs=1e-5
    )
    done = place(scene, "chair_1", PlanPoint(2.0, 1.0, 30.0))
    assert (done.x, done.y, done.yaw) == pytest.approx((2.0, 1.0, 30.0), abs=1e-5)


def test_a_copy_stands_beside_and_outlives_the_original(scene: Path) -> None:
    copy = duplicate(scene, "chair_1").name
    apart = box(scene, copy).mean(axis=0)[:2] - box(scene, "chair_1").mean(axis=0)[:2]
    assert math.hypot(*apart) > 0.4
    remove(scene, "chair_1")
    compose_room(scene.parents[1] / "room.yaml", scene.parent)
    assert len(box(scene, copy)) and objects(scene)["chair_1"] is False


def test_a_copy_keeps_its_place_when_it_is_made_anew(scene: Path) -> None:
    copy = duplicate(scene, "chair_1").name
    before = box(scene, copy).mean(axis=0)[:2]
    remake(scene, copy, "shell")
    assert box(scene, copy).mean(axis=0)[:2] == pytest.approx(before, abs=0.02)
    assert not orphans_of(scene.parent)


def test_another_category_has_its_labels_and_its_model(scene: Path) -> None:
    before = is_a(scene, "chair_1")[1]
    relabel(scene, "chair_1", "stool")
    assert is_a(scene, "chair_1") == ("stool", before)
    remake(scene, "chair_1", "drawers", "night_stand", keep_size=False)
    category, meshes = is_a(scene, "chair_1")
    assert category == "night_stand" and "drawer_front_0" in meshes and "seat" not in meshes


@pytest.mark.parametrize(
    "change",
    [
        lambda scene: place(scene, "chair_9", PlanPoint(1, 1, 0)),
        lambda scene: duplicate(scene, "../x"),
        lambda scene: relabel(scene, "chair_1", "chiar"),
        lambda scene: remake(scene, "chair_1", "rococo"),
        lambda scene: remake(scene, "chair_1", "slat", "dragon"),
    ],
)
def test_what_cannot_be_is_refused_and_nothing_written(
    change: Callable[[Path], object], scene: Path
) -> None:
    before = (scene.parent / "layers/edits.usda").read_bytes()
    with pytest.raises(OrusdError) as error:
        change(scene)
    assert (scene.parent / "layers/edits.usda").read_bytes() == before
    if isinstance(error.value, DescriptionError):
        assert "did you mean 'chair'" in str(error.value)


def test_changes_are_taken_back_and_made_again(scene: Path) -> None:
    history = History(scene.parent / "layers/edits.usda")
    versions = [history.file.read_bytes()]
    for change in ("move", "duplicate", "remove"):
        with history.step():
            CHANGES[change](scene)
        versions.append(history.file.read_bytes())
    for wanted in versions[-2::-1]:
        history.undo()
        assert history.file.read_bytes() == wanted
    with pytest.raises(InputError, match="nothing to undo"):
        history.undo()
    for wanted in versions[1:]:
        history.redo()
        assert history.file.read_bytes() == wanted
    with pytest.raises(InputError, match="nothing to redo"):
        history.redo()


def test_what_another_program_has_written_is_not_taken_back(scene: Path) -> None:
    history = History(scene.parent / "layers/edits.usda")
    with history.step():
        CHANGES["move"](scene)
    theirs = history.file.read_text().replace("(3, 2.2, 0)", "(3.1, 2.2, 0)")
    history.file.write_text(theirs)
    with pytest.raises(InputError, match="another program"):
        history.undo()
    assert history.file.read_text() == theirs and history.told()["undo"] == 0


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        ({}, (0.55, 0.0)),
        ({"rug": ((0.0, 0.0, 0.005), (3.0, 3.0, 0.01))}, (0.55, 0.0)),
        ({"lamp": ((0.55, 0.0, 2.0), (0.5, 0.5, 0.5))}, (0.55, 0.0)),
        ({"box": ((0.55, 0.0, 0.25), (0.5, 0.5, 0.5))}, (-0.55, 0.0)),
        ({"wall": ((0.0, 0.0, 0.25), (1.0, 5.0, 0.5))}, (0.8, 0.0)),
    ],
)
def test_a_copy_goes_to_the_nearest_free_place(
    more: dict[str, tuple[tuple[float, ...], tuple[float, ...]]], expected: tuple[float, float]
) -> None:
    """Beside a cube of half a metre; what lies flat or hangs above is in nobody's way."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    for name, (at, size) in {"cube": ((0.0, 0.0, 0.25), (0.5, 0.5, 0.5)), **more}.items():
        cube = UsdGeom.Cube.Define(stage, f"{names.FURNITURE}/{name}")
        cube.CreateSizeAttr(1.0)
        cube.AddTranslateOp().Set(Gf.Vec3d(*at))
        cube.AddScaleOp().Set(Gf.Vec3f(*size))
    spot = beside(stage, standing(furniture(stage, "cube")))
    assert (spot.x, spot.y) == pytest.approx(expected)
