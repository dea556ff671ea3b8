"""A composed room as a scene of OpenRooms, read as the published loaders read one."""

import pickle
import shutil
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom
from scipy.spatial.transform import Rotation

from openrooms_usd import imagefile
from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.composing import compose_room
from openrooms_usd.demo import copy_example
from openrooms_usd.errors import InputError, StageError
from openrooms_usd.exporters import Report, convert_stage
from openrooms_usd.importing import import_capture
from openrooms_usd.rendering.scene.pictures import Picture
from openrooms_usd.rendering.scene.surfaces import Surface
from openrooms_usd.rendering.scene.surroundings import passing, surroundings
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.usd.cameras import list_cameras, read_camera
from orusd_openrooms.readers import read_cameras
from orusd_openrooms.scenes.objects import Object, objects_of

KIND = "openrooms-xml"
SCENE = "scene0000_00"
# Our world from theirs: (x, y, z) is (x, -z, y).
OURS = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


class Loaded:
    """A dataset by the arithmetic of the 3D loaders: words of lines, steps one by one."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.scene = root / "scenes/xml" / SCENE
        self.tree = ElementTree.parse(self.scene / "main.xml").getroot()
        self.shapes = self.tree.findall("shape")

    def file(self, shape: ElementTree.Element) -> str:
        return shape.findall("string")[0].get("value")

    def mesh(self, name: str) -> tuple[np.ndarray, np.ndarray, set[str]]:
        """Vertices, the first corners of faces (from 1), and materials."""
        folder = next(f for f in ("uv_mapped/", "layoutMesh/") if f in name)
        lines = (self.root / folder / name.split(folder)[1]).read_text().splitlines()
        vertices = [list(map(float, one.split(" ")[1:4])) for one in lines if one[:2] == "v "]
        faces = [
            [int(word.split("/")[0]) for word in one.split(" ")[1:4]]
            for one in lines
            if one[:2] == "f "
        ]
        used = {one.split(" ")[1] for one in lines if one.startswith("usemtl")}
        return np.array(vertices), np.array(faces), used

    def placed(self, shape: ElementTree.Element) -> np.ndarray:
        points, _, _ = self.mesh(self.file(shape))
        for step in shape.find("transform"):
            at = {key: float(value) for key, value in step.items()}
            axis = np.array([at["x"], at["y"], at["z"]])
            if step.tag == "scale":
                assert min(axis) >= 0.0
                points = points * axis
            elif step.tag == "rotate":
                turn = Rotation.from_rotvec(at["angle"] / 180 * np.pi * axis).as_matrix()
                points = (turn @ points.T).T
            else:
                assert step.tag == "translate"
                points = points + axis
        return points

    def emitters(self) -> tuple[list[ElementTree.Element], list[ElementTree.Element]]:
        windows = [one for one in self.shapes if "window" in self.file(one)]
        lamps = [
            one
            for one in self.shapes
            if ("ceiling_lamp" in self.file(one) or "03636649" in self.file(one))
            and self.file(one).endswith(("aligned_light.obj", "alignedNew.obj"))
        ]
        return windows, lamps

    def lights(self) -> list[dict]:
        folder = self.root / "main_xml" / SCENE
        pairs = zip(
            sorted(folder.glob("light_3SG-SkyGrd_*.dat")),
            sorted(folder.glob("box*.dat")),
            strict=True,
        )
        # Our own files, so that they may be opened as loaders do.
        return [{**pickle.loads(a.read_bytes()), **pickle.loads(b.read_bytes())} for a, b in pairs]


@pytest.fixture(scope="module")
def exported(
    composed_demo: Path, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Loaded, Report]:
    root = tmp_path_factory.mktemp("exported") / "data"
    report = convert_stage(composed_demo, root, to=KIND)
    return Loaded(root), report


@pytest.fixture(scope="module")
def loaded(exported: tuple[Loaded, Report]) -> Loaded:
    return exported[0]


def members(path: Path) -> list[tuple[Object, np.ndarray]]:
    stage = Usd.Stage.Open(str(path))
    rows = []
    for one in objects_of(stage, translate(stage, outside=False)).members:
        parts = one.parts.values()
        corners = [own.corners.reshape(-1, 3) for part in parts for own in part.triangles]
        rows.append((one, np.concatenate(corners)))
    return rows


def test_what_loaders_take_for_granted(loaded: Loaded) -> None:
    assert "verion" in loaded.tree.attrib
    (sky,) = loaded.tree.findall("emitter")
    assert [one.get("name") for one in sky.findall("string")] == ["filename"]
    assert [one.get("name") for one in sky.findall("float")] == ["scale"]
    names = [loaded.file(shape) for shape in loaded.shapes]
    assert names[0].endswith(f"layoutMesh/{SCENE}/uv_mapped.obj")
    assert names[1].endswith("container.obj")
    sensor = loaded.tree.find("sensor")
    assert sensor.findall("float")[0].get("name") == "fov"
    for name in names:
        assert (loaded.scene / name).is_file(), "paths lead from the scene file to the meshes"


def test_every_material_of_a_mesh_is_one_of_its_shape(loaded: Loaded) -> None:
    known = {bsdf.get("id") for bsdf in loaded.tree.findall("bsdf")}
    for shape in loaded.shapes:
        refs = {ref.get("id") for ref in shape.findall("ref")}
        assert refs <= known
        if shape.find("emitter") is None:
            _, _, used = loaded.mesh(loaded.file(shape))
            assert used == refs or "layoutMesh" in loaded.file(shape)
    for texture in loaded.tree.iter("texture"):
        assert (loaded.scene / texture.find("string").get("value")).is_file()


def test_shapes_stand_where_objects_do(loaded: Loaded, composed_demo: Path) -> None:
    bounds = [(p.min(axis=0), p.max(axis=0)) for _, p in members(composed_demo)]
    groups: dict[str, list[np.ndarray]] = {}
    for number, shape in enumerate(loaded.shapes[2:]):
        name = loaded.file(shape)
        lamp = name.replace("aligned_light", "aligned_shape")
        key = lamp if "aligned_" in name else f"{number}"
        groups.setdefault(key, []).append(loaded.placed(shape) @ OURS.T)
    boxes = [np.concatenate(points) for points in groups.values()]
    assert len(boxes) == len(bounds) == 6  # four members, a door and a window
    for low, high in bounds:
        off = [max(np.abs(p.min(0) - low).max(), np.abs(p.max(0) - high).max()) for p in boxes]
        assert min(off) < 5e-6


def test_chairs_share_a_model(loaded: Loaded) -> None:
    chairs = [shape for shape in loaded.shapes if "/03001627/" in loaded.file(shape)]
    assert len(chairs) == 2 and len({loaded.file(one) for one in chairs}) == 1
    assert len({one.get("id") for one in chairs}) == 1, "identifiers repeat, as in the release"


def test_the_layout_is_thin_with_true_holes(loaded: Loaded) -> None:
    points, faces, used = loaded.mesh(loaded.file(loaded.shapes[0]))
    assert used == {f"{SCENE}_{part}" for part in ("wall", "ceiling", "floor")}
    corners = points[faces - 1]
    flat = np.ptp(corners[..., 2], axis=1) == 0.0
    assert flat.sum() == 4, "loaders expect two triangles of the floor and two of the ceiling"
    a, b, c = np.moveaxis(corners[~flat], 1, 0)
    normals = np.cross(b - a, c - a)
    area = 0.5 * np.linalg.norm(normals, axis=1).sum()
    assert area == pytest.approx(14.0 * 2.6 - 1.2 * 1.3 - 0.9 * 2.05, abs=1e-4)
    inwards = np.array([2.0, 1.5, 1.3]) - (a + b + c) / 3.0
    assert ((normals * inwards).sum(axis=1) > 0.0).all()
    outer, _, _ = loaded.mesh(loaded.file(loaded.shapes[1]))
    assert outer.min(axis=0) == pytest.approx([-0.2, -0.2, -0.2])
    assert outer.max(axis=0) == pytest.approx([4.2, 3.2, 2.8])


def test_light_boxes_agree_with_the_shapes(loaded: Loaded) -> None:
    windows, lamps = loaded.emitters()
    lights = loaded.lights()
    assert len(windows) == sum(one["isWindow"] for one in lights) == 1
    assert len(lamps) == sum(not one["isWindow"] for one in lights) == 1
    for light in lights:
        box = light["box3D_world"]
        axes = np.array([box["xAxis"], box["yAxis"], box["zAxis"]])
        assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-9)
        half = 0.5 * np.array([box["xLen"], box["yLen"], box["zLen"]])
        shape = windows[0] if light["isWindow"] else lamps[0]
        local = (loaded.placed(shape) - box["center"]) @ axes.T
        if light["isWindow"]:
            # The portal lies on the outer side of the wall; its frame fills the hole.
            assert np.abs(local[:, :2]).max(axis=0) == pytest.approx(half[:2], abs=0.1)
            for ending in ("", "Sky", "Grd"):
                assert np.linalg.norm(light[f"axis{ending}_world"]) == pytest.approx(1.0)
            assert light["envScale"] == float(loaded.tree.find("emitter/float").get("value"))
        else:
            assert np.abs(local).max(axis=0) == pytest.approx(half, abs=1e-5)
            text = shape.find("emitter").findall("rgb")[0].get("value")
            xml = [float(word) for word in text.split(" ")]
            assert max(abs(x - y) for x, y in zip(xml, light["intensity"], strict=True)) < 1e-3


def assert_lights_match(loaded: Loaded) -> None:
    """Loaders take one pair of files for each window and each lamp, and refuse any other number."""
    windows, lamps = loaded.emitters()
    kinds = [one["isWindow"] for one in loaded.lights()]
    assert (kinds.count(True), kinds.count(False)) == (len(windows), len(lamps))
    shining = [one["intensity"] for one in loaded.lights() if not one["isWindow"]]
    for lamp, intensity in zip(lamps, shining, strict=True):
        told = [float(word) for word in lamp.find("emitter/rgb").get("value").split(" ")]
        assert np.abs(np.array(told) - intensity).max() < 1e-3


def test_cameras_pass_the_loaders_check(loaded: Loaded, composed_demo: Path) -> None:
    stage = Usd.Stage.Open(str(composed_demo))
    cameras = [read_camera(prim, 640, 480) for prim in list_cameras(stage)]
    found = read_cameras(loaded.scene / "cam.txt")
    assert len(found) == len(cameras)
    for (origin, target, up), camera in zip(found, cameras, strict=True):
        view = target - origin
        assert abs(view @ up) < 2e-3
        # Right, down and forward, as loaders make a pose of it.
        turn = np.stack([np.cross(-up, view), -up, view], axis=1)
        assert OURS @ turn == pytest.approx(camera.world_from_camera[:3, :3], abs=5e-6)
        assert OURS @ origin == pytest.approx(camera.world_from_camera[:3, 3], abs=5e-6)


def test_nothing_is_lost_in_silence(exported: tuple[Loaded, Report]) -> None:
    rows = {prim: reason for prim, _, reason in exported[1].losses()}
    assert "without reveals" in rows["/World/Room/Walls/wall_0"]
    assert "no material" in next(v for k, v in rows.items() if "light_bulb" in k)
    assert any(reason == "nothing moves in a scene" for reason in rows.values())


def test_options_and_stages_that_cannot_be(composed_demo: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no option paint"):
        convert_stage(composed_demo, tmp_path / "a", to=KIND, options={"paint": "red"})
    for name in ("../x", "main_1", ""):
        with pytest.raises(InputError, match="cannot be the name of a scene"):
            convert_stage(composed_demo, tmp_path / "a", to=KIND, options={"scene": name})
    bare = Usd.Stage.CreateNew(str(tmp_path / "bare.usda"))
    UsdGeom.Cube.Define(bare, "/Cube")
    bare.Save()
    with pytest.raises(StageError, match="no room whose floor and height are known"):
        convert_stage(tmp_path / "bare.usda", tmp_path / "a", to=KIND)
    assert not (tmp_path / "a").exists()


@pytest.mark.slow
def test_matrices_that_are_no_steps_go_into_the_mesh(composed_demo: Path, tmp_path: Path) -> None:
    stage = Usd.Stage.Open(str(composed_demo))
    stage.SetEditTarget(stage.GetSessionLayer())
    desk = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Furniture/desk"))
    desk.AddScaleOp(opSuffix="mirror").Set(Gf.Vec3f(-1.0, 1.0, 1.0))
    flat = tmp_path / "mirrored.usda"
    stage.Flatten().Export(str(flat))
    report = convert_stage(flat, tmp_path / "data", to=KIND, include_outside=True)
    assert any("sheared or mirrored" in reason for _, _, reason in report.losses())
    loaded = Loaded(tmp_path / "data")
    (shape,) = (one for one in loaded.shapes if "_desk/" in loaded.file(one))
    points = loaded.placed(shape) @ OURS.T
    (expected,) = (p for one, p in members(flat) if one.path.endswith("/desk"))
    assert points.min(axis=0) == pytest.approx(expected.min(axis=0), abs=5e-6)
    assert points.max(axis=0) == pytest.approx(expected.max(axis=0), abs=5e-6)


def mean(value: object) -> np.ndarray:
    """A constant, or the mean of a picture."""
    if isinstance(value, Picture):
        return value.pixels.reshape(-1, value.channels).mean(axis=0)
    return np.asarray(value, dtype=float)


def means(surface: Surface) -> np.ndarray:
    """Base colour, roughness and metalness, in levels of the 8 bits that pictures keep of them."""
    color = srgb_from_linear(mean(surface.base_color))
    return 255.0 * np.array([*color, mean(surface.roughness).item(), mean(surface.metallic).item()])


def assert_there_and_back(scene: Path, folder: Path) -> None:
    """Export, import, compose: what stands where, made of what, and lit and seen how."""
    convert_stage(scene, folder / "data", to=KIND)
    imported = import_capture(KIND, folder / f"data/scenes/xml/{SCENE}/main.xml", folder / "room")
    assert [n for n in imported.notes if "container" not in n] == []
    again = compose_room(imported.file, folder / "out", workers=1).scene
    before, after = members(scene), members(again)
    assert len(before) == len(after)
    for one, points in before:
        low, high = points.min(axis=0), points.max(axis=0)
        near = [max(np.abs(p.min(0) - low).max(), np.abs(p.max(0) - high).max()) for _, p in after]
        other, _ = after[int(np.argmin(near))]
        assert min(near) < 5e-6, one.path
        if one.path.startswith("/World/Furniture"):
            assert other.world_from_object == pytest.approx(one.world_from_object, abs=5e-6)
            assert one.radiance is not None or other.category == one.category
        assert {name for name, _ in other.parts} == {name for name, _ in one.parts}
        if one.radiance is not None:
            assert other.radiance == pytest.approx(one.radiance, rel=1e-5)
        for part in one.parts.values():
            # Books are many, each of its own colour.
            alike = [p.patch.surface for p in other.parts.values() if p.name == part.name]
            if part.patch.radiance is None:
                # Pictures are rounded, by half a level at most.
                own = means(part.patch.surface)
                assert min(np.abs(means(read) - own).max() for read in alike) < 0.55
                assert {read.f0 for read in alike} == {part.patch.surface.f0}
    stages = [Usd.Stage.Open(str(path)) for path in (scene, again)]
    skies = [surroundings(translate(stage)) for stage in stages]
    lux = [passing(sky, np.array([0.0, -0.8, 0.6])) for sky in skies]
    assert lux[1] == pytest.approx(lux[0], rel=0.01)
    views = [[read_camera(prim, 640, 480) for prim in list_cameras(stage)] for stage in stages]
    for one, other in zip(*views, strict=True):
        assert other.world_from_camera == pytest.approx(one.world_from_camera, abs=5e-6)
    convert_stage(again, folder / "once more", to=KIND)
    assert_lights_match(Loaded(folder / "once more"))


@pytest.mark.slow
def test_there_and_back(composed_demo: Path, tmp_path: Path) -> None:
    assert_there_and_back(composed_demo, tmp_path)


@pytest.mark.slow
def test_the_example_there_and_back(tmp_path: Path) -> None:
    room = copy_example(tmp_path / "source")
    assert_there_and_back(compose_room(room, tmp_path / "first", workers=1).scene, tmp_path)


@pytest.mark.long
@pytest.mark.slow
def test_a_generated_room_there_and_back(tmp_path: Path) -> None:
    text = "room: bedroom\nseed: 4\nlayout: {from: generate}\nmaterials: {resolution: 64}\n"
    (tmp_path / "room.yaml").write_text(text)
    scene = compose_room(tmp_path / "room.yaml", tmp_path / "first", workers=1).scene
    assert_there_and_back(scene, tmp_path)


@pytest.mark.slow
def test_a_panorama_keeps_its_directions(composed_demo: Path, tmp_path: Path) -> None:
    shutil.copytree(composed_demo.parents[1], tmp_path / "room")
    pixels = np.full((32, 64, 3), 5.0, dtype=np.float32)
    pixels[10, 40] = [900.0, 500.0, 100.0]
    imagefile.write(tmp_path / "room/sky.hdr", pixels, "float", {})
    text = (tmp_path / "room/room.yaml").read_text()
    sky = "lights: {environment: {file: sky.hdr, rotate: 33, scale: 2}}\n"
    (tmp_path / "room/room.yaml").write_text(text + sky)
    scene = compose_room(tmp_path / "room/room.yaml", tmp_path / "room/out", workers=1).scene
    convert_stage(scene, tmp_path / "data", to=KIND)
    file = tmp_path / f"data/scenes/xml/{SCENE}/main.xml"
    imported = import_capture(KIND, file, tmp_path / "again")
    again = compose_room(imported.file, tmp_path / "again/out", workers=1).scene
    found = []
    for path in (scene, again):
        seen = surroundings(translate(Usd.Stage.Open(str(path))))
        light = seen.radiance[..., 0] * seen.weights * (seen.radiance[..., 0] > 100.0)
        way = (light[..., None] * seen.directions).sum(axis=(0, 1))
        found.append(way / np.linalg.norm(way))
    assert found[1] @ found[0] > np.cos(np.radians(1.5))
