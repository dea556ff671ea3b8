"""What a person does with a room in the browser: opens doors, measures, chooses looks."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

import openrooms_usd as ou
from openrooms_usd.edits.editing import editing
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.view.room import room_app
from tests.chromium import Page, needs_chromium
from tests.conftest import SMALL_ROOM
from tests.view.conftest import Shown

pytestmark = [pytest.mark.slow, needs_chromium]

ROOM = "document.getElementById('view').room"
DESK = "/World/Furniture/desk"


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The small room with a chest of drawers and two looks."""
    folder = tmp_path_factory.mktemp("looks")
    chest = "    - {category: dresser, at: [3.4, 2.4], name: chest}\n"
    (folder / "room.yaml").write_text(f"{SMALL_ROOM}{chest}materials: {{looks: 2}}\n")
    return Path(ou.compose(folder / "room.yaml", folder / "out"))


@pytest.fixture(scope="module")
def page(scene: Path, shown: Shown) -> Page:
    return shown(room_app(scene))


def bounds(page: Page, path: str) -> np.ndarray:
    return np.array(page.evaluate(f"{ROOM}.bounds(['{path}'])"))


def box(stage: Usd.Stage, path: str) -> np.ndarray:
    found = UsdGeom.BBoxCache(TIME, ["default"]).ComputeWorldBound(stage.GetPrimAtPath(path))
    aligned = found.ComputeAlignedRange()
    return np.array([aligned.GetMin(), aligned.GetMax()])


def test_sliders_open_doors_and_drawers_as_joints_say(page: Page, scene: Path) -> None:
    """Beside the same pose in USD."""
    stage = Usd.Stage.Open(str(scene))
    joints = {one["path"]: one for one in page.evaluate(f"{ROOM}.page.state.joints")}
    leaf = "/World/Room/Openings/door_1/Leaf"
    leaf = leaf if leaf in joints else next(p for p in joints if p.endswith("Leaf"))
    drawer = next(path for path, one in joints.items() if one["type"] == "rail")
    assert joints[leaf]["now"] == pytest.approx(40.0, abs=1e-3)
    for path, value in ((leaf, 75.0), (drawer, 0.2)):
        joint, shut = joints[path], bounds(page, path)
        page.evaluate(
            f"import('orusd/panel.js').then(panel => panel.slide('joint-{path}', {value}))"
        )
        local = UsdGeom.Xformable(stage.GetPrimAtPath(path)).GetLocalTransformation(TIME)
        axis = Gf.Vec3d(*joint["axis"])
        by = value - joint["now"]
        step = Gf.Matrix4d(1.0)
        if joint["type"] == "hinge":
            step.SetRotate(Gf.Rotation(axis, by))
        else:
            step.SetTranslate(axis * by)
        prim = stage.GetPrimAtPath(path)
        with Usd.EditContext(stage, stage.GetSessionLayer()):
            while prim.IsInstanceProxy():
                owner = prim
                while not owner.IsInstance():
                    owner = owner.GetParent()
                owner.SetInstanceable(False)
                prim = stage.GetPrimAtPath(path)
            UsdGeom.Xformable(prim).MakeMatrixXform().Set(step * local)
        opened = bounds(page, path)
        assert np.abs(opened - shut).max() > 0.1
        # The page bounds boxes of meshes, which is looser where they are turned.
        if joint["type"] == "rail":
            assert np.abs(opened - box(stage, path)).max() < 1e-4
        else:
            middle = opened.mean(axis=0) - box(stage, path).mean(axis=0)
            assert np.abs(middle).max() < 0.03


def test_two_clicks_measure_a_distance(page: Page) -> None:
    page.click_on("#overview")
    page.click_on("#measure")
    spots = [(250.0, 330.0), (330.0, 300.0)]
    points = [page.evaluate(f"{ROOM}.at({x}, {y}).point") for x, y in spots]
    for spot in spots:
        page.click(*spot)
    told = page.evaluate("document.getElementById('distance').textContent")
    expected = np.linalg.norm(np.subtract(*points))
    assert float(told.split(" m")[0]) == pytest.approx(expected, abs=2e-3)
    page.click_on("#measure")
    assert page.evaluate("document.getElementById('distance').textContent") == ""


def test_a_look_is_shown_and_no_file_changes(page: Page, scene: Path) -> None:
    before = {path: path.read_bytes() for path in scene.parent.rglob("*.usda")}
    chosen = f"document.getElementById('look-{DESK}')"
    assert page.evaluate(f"[...{chosen}.options].map(o => o.value)") == ["default", "look_1"]
    materials = f"{ROOM}.surfaces.materials.map(one => one.name).sort().join()"
    first = page.evaluate(materials)
    page.evaluate(f"{chosen}.value = 'look_1'; {chosen}.dispatchEvent(new Event('change'))")
    page.wait(f"{materials} != {first!r}")
    told = page.evaluate(
        "import('orusd/source.js').then(s => s.send('look', {path: '/World', look: 'blue'}))"
        ".catch(error => [error.message, error.place])"
    )
    assert told == ["it has no look 'blue'", "/World"]
    assert {path: path.read_bytes() for path in scene.parent.rglob("*.usda")} == before


def test_what_another_program_changes_shows_in_the_page(
    composed_demo: Path, shown: Shown, tmp_path: Path
) -> None:
    shutil.copytree(composed_demo.parent, tmp_path / "out")
    scene = tmp_path / "out" / composed_demo.name
    page = shown(room_app(scene))
    before = bounds(page, DESK)
    with editing(scene) as stage:
        operation = UsdGeom.Xformable(stage.GetPrimAtPath(DESK)).GetOrderedXformOps()[0]
        operation.Set(operation.Get() + Gf.Vec3d(0.25, 0.0, 0.0))
    page.wait("document.body.dataset.changes == 1")
    assert np.abs(bounds(page, DESK) - before - [0.25, 0.0, 0.0]).max() < 1e-5
