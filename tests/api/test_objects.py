"""What stands in a scene, read and changed from Python: opinions that survive compositions."""

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdLux

import openrooms_usd as ou
from openrooms_usd.errors import DescriptionError, InputError, UnknownNameError

ROOM = {
    "seed": 3,
    "layout": {
        "polygon": [[0, 0], [4, 0], [4, 3], [0, 3]],
        "openings": [{"kind": "door", "wall": 0}],
    },
    "furniture": {
        "objects": [
            {"name": "table", "category": "table", "at": [2, 1.5], "size": [1.2, 0.8, 0.7]},
            {"name": "chair", "category": "chair", "at": [1, 0.8], "yaw": 30},
            {"name": "lamp", "category": "table_lamp", "at": [2.2, 1.6], "on": "table"},
        ]
    },
    "materials": {"resolution": 16},
    "cameras": {
        "resolution": [16, 12],
        "views": [{"name": "eye", "eye": [1, 1, 1.5], "target": [3, 2, 1]}],
    },
}


@pytest.fixture(scope="module")
def composed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return ou.compose(ROOM, tmp_path_factory.mktemp("objects") / "out").folder


@pytest.fixture
def scene(composed: Path, tmp_path: Path) -> ou.Scene:
    shutil.copytree(composed, tmp_path / "out")
    return ou.compose(ROOM, tmp_path / "out")


def test_objects_say_where_they_stand(scene: ou.Scene) -> None:
    assert list(scene.objects) == ["table", "chair", "lamp"]
    chair, table = scene.objects["chair"], scene.objects["/World/Furniture/table"]
    assert (chair.category, chair.name) == ("chair", "chair")
    cos, sin = np.cos(np.radians(30)), np.sin(np.radians(30))
    wanted = [[cos, -sin, 0, 1], [sin, cos, 0, 0.8], [0, 0, 1, 0], [0, 0, 0, 1]]
    assert chair.pose == pytest.approx(np.array(wanted), abs=1e-6)
    assert table.bounds == pytest.approx(np.array([[1.4, 1.1, 0], [2.6, 1.9, 0.7]]), abs=1e-5)
    assert table.size == pytest.approx((1.2, 0.8, 0.7), abs=1e-5)
    # The box of a turned object is that of its points, not of its turned box.
    seat = chair.parts["seat"]
    assert seat.part == "seat" and seat.materials and seat.bounds[0, 2] > chair.bounds[0, 2]
    assert chair.size == pytest.approx(scene.objects["chair"].turn(-30).size, abs=1e-5)


def test_cameras_lights_materials_and_the_shell(scene: ou.Scene) -> None:
    eye = scene.cameras["eye"]
    assert eye.resolution == (16, 12) and eye.K[0, 2] == 8
    assert eye.world_from_camera[:3, 3] == pytest.approx((1, 1, 1.5))
    lamp = scene.lights["lamp"]
    assert lamp.kind == "mesh" and lamp.luminance > 100
    assert scene.lights["Environment"].kind == "dome"
    assert {"Floor", "Ceiling", "door_0", "wall_0"} <= set(scene.shell)
    assert scene.shell["wall_0"].category == "wall"
    # As legends of pictures name them.
    assert scene.objects["/World/Room/Walls/wall_0"] == scene.shell["wall_0"]
    names = {one.name for row in scene.objects.values() for one in row.materials}
    assert names <= set(scene.materials) | {m.name for m in scene.materials.values()}
    assert all(m.textures or m.base_color for m in scene.materials.values())


CHANGES: dict[str, Callable[[ou.Scene], object]] = {
    "move": lambda scene: scene.objects["table"].move(0.5, -0.2),
    "turn": lambda scene: scene.objects["chair"].turn(45),
    "place": lambda scene: scene.objects["chair"].place((3, 2, 0.1), 10, size=(0.5, 0.6, 1.0)),
    "color": lambda scene: scene.objects["chair"].set_color((0.5, 0.1, 0.1)),
    "part": lambda scene: scene.objects["chair"].parts["seat"].set_material("leather"),
    "wall": lambda scene: scene.shell["wall_1"].set_color((0.2, 0.4, 0.2)),
    "remove": lambda scene: scene.objects["chair"].remove(),
    "duplicate": lambda scene: scene.objects["chair"].duplicate(),
    "relabel": lambda scene: scene.objects["chair"].relabel("stool"),
    "remake": lambda scene: scene.objects["chair"].remake("shell"),
    "add": lambda scene: scene.add("floor_lamp", (3.4, 2.4), yaw=20),
    "add on": lambda scene: scene.add("vase", (1.8, 1.4), on="table"),
    "add file": lambda scene: scene.add("box", (3, 0.6), file=_box(scene.folder.parent)),
}


def _box(folder: Path) -> Path:
    """A box of 0.4 m, as a file."""
    file = folder / "box.obj"
    corners = [(x, y, z) for x in (0, 0.4) for y in (0, 0.4) for z in (0, 0.4)]
    faces = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    rows = [f"v {x} {y} {z}" for x, y, z in corners] + [
        f"f {a} {b} {c} {d}" for a, b, c, d in faces
    ]
    file.write_text("\n".join(rows) + "\n")
    return file


def state(scene: ou.Scene) -> dict[str, object]:
    """All that objects and walls say of themselves."""
    everything = [*scene.objects.values(), *scene.shell.values()]
    return {
        one.path: (
            one.category,
            one.pose.round(5).tolist(),
            one.bounds.round(5).tolist(),
            [(m.base_color, sorted(m.textures)) for m in one.materials],
        )
        for one in everything
    }


@pytest.mark.one_in(5)
@pytest.mark.parametrize("kind", CHANGES)
def test_a_change_lies_in_the_edits_and_survives(
    kind: str, scene: ou.Scene, assert_valid: Callable[..., None]
) -> None:
    layers = {path: path.read_bytes() for path in scene.edits.parent.glob("*.usda")}
    before = state(scene)
    CHANGES[kind](scene)
    changed = state(scene)
    assert changed != before
    assert [path for path, content in layers.items() if path.read_bytes() != content] == [
        scene.edits
    ]
    edits = scene.edits.read_bytes()
    scene.recompose()
    assert scene.edits.read_bytes() == edits and not scene.orphans
    after = state(scene)
    # What stands on the table has followed it.
    follows = {"/World/Furniture/lamp"} if kind == "move" else set()
    assert {path for path in changed if after[path] != changed[path]} == follows
    assert_valid(scene.path)


def test_what_stands_on_it_follows_with_its_light(scene: ou.Scene) -> None:
    lamp, light = scene.objects["lamp"], scene.lights["lamp"].pose[:3, 3]
    before = lamp.pose
    scene.objects["table"].move(0.5, -0.2)
    assert lamp.pose == pytest.approx(before)
    assert "alignment" in {row.stage for row in scene.recompose().stages if row.state == "written"}
    assert lamp.pose[:3, 3] - before[:3, 3] == pytest.approx((0.5, -0.2, 0), abs=1e-5)
    assert scene.lights["lamp"].pose[:3, 3] - light == pytest.approx((0.5, -0.2, 0), abs=1e-5)


def test_what_is_added_stands_shines_and_weighs(here: Path) -> None:
    scene = ou.compose({**ROOM, "physics": {}}, "out")
    vase = scene.add("vase", (1.8, 1.4), on="table")
    beside = scene.add("stool", (0.9, 0), relative_to="table", name="beside")
    box = scene.add("box", (3, 0.6), file=_box(here))
    lamp = scene.add("floor_lamp", (0.5, 2.4))
    assert vase.bounds[0, 2] == pytest.approx(0.7, abs=1e-4)
    assert beside.pose[:2, 3] == pytest.approx((2.9, 1.5))
    assert box.size == pytest.approx((0.4, 0.4, 0.4)) and box.category == "box"
    assert lamp.name == "floor_lamp_added" and lamp.name not in scene.lights
    scene.recompose()
    assert scene.lights[lamp.name].luminance > 100
    stage = scene.stage()
    for thing in (vase, beside, box, lamp):
        assert "PhysicsMassAPI" in stage.GetPrimAtPath(thing.path).GetAppliedSchemas(), thing


def test_many_changes_are_one_or_none(scene: ou.Scene) -> None:
    untouched, chair = scene.edits.read_bytes(), scene.objects["chair"]
    before = chair.pose
    with pytest.raises(ZeroDivisionError), scene.editing():
        assert chair.move(0.5).pose[0, 3] == pytest.approx(before[0, 3] + 0.5)
        raise ZeroDivisionError
    assert scene.edits.read_bytes() == untouched and chair.pose == pytest.approx(before)
    with scene.editing():
        chair.move(0.5).turn(10)
        scene.objects["table"].set_color((0.1, 0.1, 0.1))
        assert scene.edits.read_bytes() == untouched
    assert chair.pose[0, 3] == pytest.approx(before[0, 3] + 0.5)
    assert scene.objects["table"].materials[0].base_color == pytest.approx((0.1, 0.1, 0.1))
    scene.objects["table"].reset_material()
    assert scene.objects["table"].materials[0].base_color != pytest.approx((0.1, 0.1, 0.1))


WRONG: dict[str, tuple[type[Exception], Callable[[ou.Scene], object]]] = {
    "no object is named 'chiar'.*'chair'": (UnknownNameError, lambda s: s.objects["chiar"]),
    "part of the room's shell": (InputError, lambda s: s.shell["wall_0"].move(1)),
    "expected 2 or 3 finite numbers": (InputError, lambda s: s.objects["chair"].place((1,))),
    "a size must be positive": (
        InputError,
        lambda s: s.objects["chair"].place((1, 1), size=(1, 1, 0)),
    ),
    r"color\[0\]: expected at most 1": (
        DescriptionError,
        lambda s: s.objects["chair"].set_color((255, 0, 0)),
    ),
    "category.*did you mean 'chair'": (DescriptionError, lambda s: s.add("chiar", (1, 1))),
    "table is not below": (InputError, lambda s: s.add("vase", (0.2, 0.2), on="table")),
    "an object 'chair' already exists": (
        InputError,
        lambda s: s.add("chair", (1, 1), name="chair"),
    ),
    "no such file": (InputError, lambda s: s.add("box", (1, 1), file="nowhere.obj")),
    "description of this scene is not known": (InputError, lambda s: ou.open_scene(s).recompose()),
}


@pytest.mark.parametrize("said", WRONG)
def test_what_cannot_be_is_refused_and_nothing_written(said: str, scene: ou.Scene) -> None:
    untouched = scene.edits.read_bytes()
    error, change = WRONG[said]
    with pytest.raises(error, match=said):
        change(scene)
    assert scene.edits.read_bytes() == untouched


def test_what_was_removed_says_so(scene: ou.Scene) -> None:
    chair = scene.objects["chair"]
    chair.remove()
    assert "chair" not in scene.objects
    with pytest.raises(InputError, match="no longer in the scene"):
        chair.turn(10)


def foreign(file: Path) -> ou.Scene:
    """A box of 1 m by 2 m by 3 m, in centimetres with Y up, twice: labelled by nothing."""
    stage = Usd.Stage.CreateNew(str(file))
    UsdGeom.SetStageUpAxis(stage, "Y")
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    for number, x in enumerate((0.0, 500.0)):
        cube = UsdGeom.Cube.Define(stage, f"/Root/Group{number}/Box")
        cube.AddTranslateOp().Set(Gf.Vec3d(x, 150, 0))
        cube.AddScaleOp().Set(Gf.Vec3f(50, 150, 100))
    UsdLux.SphereLight.Define(stage, "/Root/Bulb")
    stage.Save()
    return ou.open_scene(file)


def test_any_scene_is_read_and_says_why_it_is_not_edited(tmp_path: Path) -> None:
    scene = foreign(tmp_path / "foreign.usda")
    assert list(scene.objects) == ["/Root/Group0/Box", "/Root/Group1/Box"]
    box = scene.objects["/Root/Group1/Box"]
    assert box.bounds == pytest.approx(np.array([[4.5, -1, 0], [5.5, 1, 3]]))
    # Its own axes are the file's: Y up.
    assert box.size == pytest.approx((1, 3, 2)) and box.category == "" and box.materials == ()
    assert box.pose[:3, 3] == pytest.approx((5, 0, 1.5))
    assert list(scene.lights) == ["Bulb"] and not scene.cameras and not scene.shell
    before = {path.name for path in tmp_path.iterdir()}
    for change in (
        lambda: box.move(1),
        lambda: box.set_color((1, 0, 0)),
        lambda: scene.add("chair", (1, 1)),
    ):
        with pytest.raises(InputError, match=r"cannot .*: this is not a composed room") as refused:
            change()
        assert "compose a room" in (refused.value.remedy or "")
    assert {path.name for path in tmp_path.iterdir()} == before


def test_what_another_program_changes_is_read_again(scene: ou.Scene) -> None:
    chair = scene.objects["chair"]
    x = chair.pose[0, 3]
    with scene.editing() as stage:
        UsdGeom.XformCommonAPI(stage.GetPrimAtPath(chair.path)).SetTranslate((x + 1, 0.8, 0))
    assert chair.pose[0, 3] == pytest.approx(x + 1)
    text = scene.edits.read_text()
    assert "translate = (2, 0.8, 0)" in text
    scene.edits.write_text(text.replace("(2, 0.8, 0)", "(2.25, 0.8, 0)"))
    assert chair.pose[0, 3] == pytest.approx(2.25)


def test_one_of_many_that_an_instancer_draws_is_found_by_its_number() -> None:
    from openrooms_usd.edits.scenefile import ByName

    chairs = ByName("object", Path("scene.usda"), {"/World/Chairs": "chairs"})
    assert chairs["/World/Chairs[3]"] == chairs["/World/Chairs"] == "chairs"
    with pytest.raises(ou.OrusdError, match="no object is named"):
        chairs["/World/Tables[3]"]
