"""A scene of OpenRooms becomes a room: what it names, and what stands for what is not there."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdLux

from openrooms_usd.capture import Capture, read_capture
from openrooms_usd.composing import compose_room
from openrooms_usd.description import load_room
from openrooms_usd.importing import import_capture
from openrooms_usd.usd.cameras import list_cameras, read_camera
from openrooms_usd.usd.light.lights import MeshLight, read_lights
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.materials import Texture, bound_material
from openrooms_usd.usd.shapes.meshes import read_meshes
from orusd_openrooms.pickles import write_pickled
from orusd_openrooms.scenes.reading import read_scene
from orusd_openrooms.scenes.records import whole
from orusd_openrooms.scenes.scene import scene_frame
from tests.openrooms.scenefiles import DOOR, FOV, RADIANCE, WINDOW, scene, write_dataset

KIND = "openrooms-xml"


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_dataset(tmp_path_factory.mktemp("dataset"))


@pytest.fixture(scope="module")
def capture(dataset: Path) -> Capture:
    return read_capture(KIND, dataset)


def scene_from_room(dataset: Path) -> np.ndarray:
    return scene_frame(read_scene(dataset).shapes[0].steps)


def test_the_layout_is_a_plan_with_its_holes(capture: Capture) -> None:
    corners = {tuple(np.round(corner, 6)) for corner in capture.floor}
    assert corners == {(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)}
    assert capture.height == pytest.approx(3.0)
    door, window = sorted(capture.openings, key=lambda one: one.center[2])
    # The door's own mesh fills its hole; the window's is not there.
    assert (door.kind, window.kind) == ("opening", "window")
    for found, (x0, z0, x1, z1), start in ((door, DOOR, (0, 0)), (window, WINDOW, (4, 0))):
        across = np.array([*start, 0.0]) + found.direction * 0.5 * (x0 + x1)
        assert found.center == pytest.approx([*across[:2], 0.5 * (z0 + z1)], abs=1e-6)
        assert (found.width, found.height) == pytest.approx((x1 - x0, z1 - z0), abs=1e-6)


def test_what_stands_for_what_is_not_there_is_listed(capture: Capture) -> None:
    text = "\n".join(capture.notes)
    for words in (
        "04379243/none is missing: the library's table replaces it",
        "window/3 is missing: the library's window fills its opening",
        "gold_leaf is missing: metal of the library replaces it",
        "clay_large is missing: rough_stone of the library replaces it",
        "container.obj is left out",
    ):
        assert words in text
    assert capture.shell["walls"] == {"substance": "rough_stone"}
    ceiling = {"color": [0.55, 0.4, 1.0], "roughness": 0.4, "metallic": 0.0}
    assert capture.shell["ceiling"] == ceiling
    # Texture coordinates have 4 units in a metre, and uvScale is 1.3.
    assert capture.shell["floor"] == {"file": "materials/floor", "size": 0.1923}


def test_a_model_that_is_not_there_is_as_high_as_it_stood(capture: Capture) -> None:
    (table,) = (model for model in capture.models if model.label == "table")
    assert table.file is None
    low = table.stands @ [0.0, table.center[1] - table.half[1], 0.0, 1.0]
    assert low[2] == pytest.approx(0.0, abs=1e-9)


def test_environments_off_on_and_missing(dataset: Path, tmp_path: Path) -> None:
    assert read_capture(KIND, dataset).environment == {"from": "constant", "illuminance": 0}
    on = tmp_path / "on.xml"
    on.write_text(scene(sky="164.1757"))
    root = {"root": str(dataset.parents[3]), "cameras": str(dataset.parent / "cam.txt")}
    found = read_capture(KIND, on, root).environment
    assert found == {"file": "environment.hdr", "scale": 164.1757, "rotate": 0.0}
    (tmp_path / "none").mkdir()
    lost = read_capture(KIND, on, {**root, "environments": str(tmp_path / "none")})
    assert lost.environment == {"from": "constant", "illuminance": pytest.approx(515.773)}
    assert any("173L.hdr is missing: an even sky of 164.176 nits" in n for n in lost.notes)


def test_without_the_dataset_the_room_is_rebuilt_around_its_things(tmp_path: Path) -> None:
    lone = tmp_path / "main.xml"
    lone.write_text(scene())
    found = read_capture(KIND, lone)
    assert (found.height, found.fov) == (3.0, FOV)
    assert any("a rectangle around the objects" in note for note in found.notes)
    assert all(model.file is None for model in found.models)
    low, high = found.floor.min(axis=0), found.floor.max(axis=0)
    for model in found.models:
        assert (low < model.stands[:2, 3]).all() and (model.stands[:2, 3] < high).all()


def test_a_layout_that_was_moved_otherwise_is_told(dataset: Path, tmp_path: Path) -> None:
    (tmp_path / "main.xml").write_text(scene())
    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    moved = np.array([-2.0, -1.3, 1.75])
    steps = [("s", np.ones(3)), ("rot", turn), ("t", moved)]
    write_pickled(tmp_path / "transform.dat", [steps])
    found = read_capture(KIND, tmp_path / "main.xml", {"root": str(dataset.parents[3])})
    assert any("moves the layout by 0.25 m otherwise than the scene" in n for n in found.notes)


def test_a_released_scene(real: Callable[[str], Path], tmp_path: Path) -> None:
    """The scene that mengsong16/openvrooms publishes, alone: everything has a stand-in."""
    path = real("openrooms/scene0420_01/main.xml")
    read = read_scene(path)
    assert (len(read.bsdfs), len(read.shapes), read.notes) == (29, 30, ())
    assert (read.fov, read.environment_scale) == (58.2327, 1e-8)
    imported = import_capture(KIND, path, tmp_path / "room")
    chairs = [model for model in imported.capture.models if "9231ef" in model.id]
    # Five copies of one model stand at heights that agree in its height, to the last digit.
    heights = [model.half[1] for model in chairs]
    assert len(chairs) == 5 and np.ptp(heights) < 1e-6
    assert sum("is missing" in note for note in imported.notes) > 10


LAMP = """<shape id="03636649_x_object" type="obj">
<string name="filename" value="uv_mapped/03636649/x/{file}.obj"/>{emitter}
<transform name="toWorld"><scale value="{scale}"/><translate x="0" y="-0.5" z="0"/></transform>
</shape>"""
LIT = '<emitter type="area"><rgb value="9 8 7"/></emitter>'


@pytest.mark.parametrize("scale", ["0.3", "1.6", "40"])
@pytest.mark.parametrize("emitter", ["", LIT])
@pytest.mark.parametrize("there", [True, False])
def test_lamps_off_and_lamps_that_are_not_there(
    scale: str, emitter: str, there: bool, dataset: Path, tmp_path: Path
) -> None:
    """Whatever stands for a lamp, the description names no lamp that is none."""
    text = scene()
    more = LAMP.format(file="alignedNew", emitter=emitter, scale=scale)
    (tmp_path / "main.xml").write_text(text.replace("<sensor", f"{more}<sensor"))
    if there:
        mesh = (dataset.parents[3] / "uv_mapped/03001627/abc/alignedNew.obj").read_text()
        folder = tmp_path / "uv_mapped/03636649/x"
        folder.mkdir(parents=True)
        (folder / "alignedNew.obj").write_text(mesh)
    imported = import_capture(KIND, tmp_path / "main.xml", tmp_path / "room")
    (lamp,) = (one for one in imported.capture.models if "03636649" in one.id)
    assert lamp.radiance == ((9.0, 8.0, 7.0) if emitter else None if there else (0.0, 0.0, 0.0))
    named = [
        one.radiance for name, one in imported.room.lights.lamps.items() if "ceiling" not in name
    ]
    if there and not emitter:
        assert named == []
    elif there or scale != "40":
        assert named == [lamp.radiance]
    else:
        assert named == [], "a box of 40 m has no bulb"


@pytest.fixture(scope="module")
def composed(dataset: Path, tmp_path_factory: pytest.TempPathFactory) -> Usd.Stage:
    folder = tmp_path_factory.mktemp("room")
    import_capture(KIND, dataset, folder)
    compose_room(folder / "room.yaml", folder / "out", workers=1)
    return Usd.Stage.Open(str(folder / "out/scene.usda"))


@pytest.mark.slow
def test_meshes_stand_where_the_scene_has_them(composed: Usd.Stage, dataset: Path) -> None:
    room_from_scene = np.linalg.inv(scene_from_room(dataset))
    steps = read_scene(dataset).shapes[2].steps
    corners = np.array(list(np.ndindex(2, 2, 2))) * [0.5, 0.5, 0.5] + [-0.25, -0.5, -0.25]
    expected = room_from_scene @ whole(steps) @ np.vstack([corners.T, np.ones(8)])
    points = np.concatenate(
        [
            placed.world_points()
            for placed in read_meshes(composed)
            if str(placed.path).startswith("/World/Furniture/chair_e4ea79")
        ]
    )
    near = np.linalg.norm(points[:, None] - expected[:3].T, axis=2).min(axis=0)
    assert near.max() < 1e-6


@pytest.mark.slow
def test_fixes_are_operations_of_their_own(composed: Usd.Stage) -> None:
    chair = UsdGeom.Xformable(composed.GetPrimAtPath("/World/Furniture/chair_e4ea79"))
    ops = {op.GetOpName(): op.Get() for op in chair.GetOrderedXformOps()}
    assert list(ops) == [
        "xformOp:translate:placed_1",
        "xformOp:translate:placed",
        "xformOp:translate",
        "xformOp:rotateXYZ",
        "xformOp:scale",
    ]
    assert list(ops["xformOp:translate:placed"]) == pytest.approx([0.0, 0.0, -0.07])
    assert list(ops["xformOp:translate:placed_1"]) == pytest.approx([0.02, 0.03, 0.0])


@pytest.mark.slow
def test_materials_keep_maps_and_factors(composed: Usd.Stage) -> None:
    furniture = "/World/Furniture/chair_676c35/Geometry"
    oak, _ = read_preview_surface(bound_material(composed.GetPrimAtPath(f"{furniture}/part0")))
    assert isinstance(oak.base_color, Texture) and isinstance(oak.normal, Texture)
    assert oak.base_color.scale == pytest.approx((1.2, 0.8, 1.0, 1.0))
    assert oak.base_color.uv_scale == pytest.approx((1.3, 1.3))
    assert oak.roughness.scale[0] == pytest.approx(0.9)
    assert oak.f0 == pytest.approx(0.05)
    plain, _ = read_preview_surface(bound_material(composed.GetPrimAtPath(f"{furniture}/part1")))
    assert plain.base_color == pytest.approx((0.55, 0.4, 1.0))
    assert (plain.roughness, plain.f0) == pytest.approx((0.4, 0.05))


@pytest.mark.slow
def test_lamps_and_cameras(composed: Usd.Stage, dataset: Path) -> None:
    (lamp,) = (light for light in read_lights(composed) if isinstance(light, MeshLight))
    assert lamp.radiance == pytest.approx(RADIANCE, rel=1e-5)
    dome = UsdLux.DomeLight(composed.GetPrimAtPath("/World/Lights/Environment"))
    assert dome.GetIntensityAttr().Get() == 0.0
    cameras = [read_camera(prim, 640, 480) for prim in list_cameras(composed)]
    assert len(cameras) == 2
    first = cameras[0]
    assert 2 * np.degrees(np.arctan(320 / first.K[0, 0])) == pytest.approx(FOV, abs=1e-3)
    origin = scene_from_room(dataset) @ first.world_from_camera[:, 3]
    assert origin[:3] == pytest.approx([0.0, 0.3, 1.0], abs=1e-6)
    view = scene_from_room(dataset)[:3, :3] @ first.world_from_camera[:3, 2]
    assert view == pytest.approx([0.0, 0.0, -1.0], abs=1e-6)


def test_the_description_can_be_read_again(dataset: Path, tmp_path: Path) -> None:
    imported = import_capture(KIND, dataset, tmp_path / "room")
    room = load_room(imported.file)
    (lamp,) = room.lights.lamps.values()
    assert lamp.radiance == RADIANCE
    again = read_capture(KIND, tmp_path / "room/main.xml", room.layout.asked, tmp_path / "room")
    assert [m.id for m in again.models] == [m.id for m in imported.capture.models]
    for one, other in zip(again.models, imported.capture.models, strict=True):
        assert one.half == pytest.approx(other.half, abs=1e-6)
        assert one.stands == pytest.approx(other.stands)
    assert not any("of the library replaces it, without" in note for note in again.notes)
