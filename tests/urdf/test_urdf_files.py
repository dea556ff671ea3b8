"""What lies in an exported folder, and what its surfaces look like."""

import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from openrooms_usd.errors import InputError, StageError
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.imagefile import write_png
from openrooms_usd.physics.world import Body, Link, Visual, World
from openrooms_usd.usd.shading.surfaces import PreviewSurface, Texture
from openrooms_usd.usd.shading.textures import read_texture
from orusd_urdf import MjcfExporter, UrdfExporter, UsdPhysicsExporter
from orusd_urdf.assets import Assets, picture_bytes
from orusd_urdf.looks import RobotMaterial, look_of
from orusd_urdf.mjcf import write_mjcf
from orusd_urdf.urdf import write_urdf
from tests.engines import NO_PYBULLET, needs_pybullet
from tests.folders import contents

LOAD = """
import sys, pybullet
from pathlib import Path
from orusd_urdf.loading import load_bullet
client = pybullet.connect(pybullet.DIRECT)
print("loading", flush=True)
print(len(load_bullet(Path(sys.argv[1]), client)), flush=True)
pybullet.disconnect(client)
"""


@pytest.fixture
def world(make: SimpleNamespace) -> World:
    prism = make.prism(0.1, 0.1, 12)
    from openrooms_usd.physics.world import Shape

    round_thing = {"shapes": (Shape("hull", prism, make.contact(0.3, 0.2)),)}
    return World(
        (
            make.ground(0.5),
            make.block("chair_1", np.array([0.0, 0.0, 0.05])),
            make.block("chair_2", np.array([1.0, 0.0, 0.05])),
            make.block("bücherstütze", np.array([0.0, 1.0, 0.05]), link=round_thing),
            make.block("Bücherstütze", np.array([0.0, 2.0, 0.05]), link=round_thing),
            make.cabinet(0.1, 0.2),
        )
    )


@needs_pybullet
def test_bullet_loads_everything_in_silence(world: World, tmp_path: Path) -> None:
    """Its warnings go to the C library's standard output, so that another process is asked."""
    write_urdf(world, tmp_path, looks={})
    command = [sys.executable, "-c", LOAD, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    said = done.stdout.splitlines()
    assert said[said.index("loading") :] == ["loading", str(len(world.bodies))]
    # It tells when it was built, always.
    assert [line for line in done.stderr.splitlines() if "build time" not in line] == []


def test_all_references_are_relative_and_lead_to_files(world: World, tmp_path: Path) -> None:
    write_urdf(world, tmp_path, looks={})
    files = list(tmp_path.rglob("*.urdf"))
    assert len(files) == len(world.bodies)
    for file in files:
        for element in ElementTree.parse(file).getroot().iter("mesh"):
            name = element.get("filename", "")
            assert not Path(name).is_absolute()
            assert (file.parent / name).is_file()
    scene = json.loads((tmp_path / "scene.json").read_text())
    assert [entry["name"] for entry in scene["bodies"]] == [body.name for body in world.bodies]
    assert all((tmp_path / entry["urdf"]).is_file() for entry in scene["bodies"])
    assert scene["bodies"][0]["urdf"] == "room/room.urdf"


def test_a_ros_package_is_named_on_request(world: World, tmp_path: Path) -> None:
    write_urdf(world, tmp_path, looks={}, package="my_room")
    named = [
        element.get("filename", "")
        for file in tmp_path.rglob("*.urdf")
        for element in ElementTree.parse(file).getroot().iter("mesh")
    ]
    assert named and all(name.startswith("package://my_room/") for name in named)
    assert all((tmp_path / name.removeprefix("package://my_room/")).is_file() for name in named)


def test_equal_meshes_are_written_once(world: World, tmp_path: Path) -> None:
    write_urdf(world, tmp_path, looks={})
    # The floor, one block for all, and one prism; boxes that collide need no mesh.
    assert len(list((tmp_path / "meshes").glob("*.obj"))) == 3


def test_visuals_and_colliders_are_apart(world: World, tmp_path: Path) -> None:
    write_urdf(world, tmp_path, looks={})
    roots = [ElementTree.parse(file).getroot() for file in tmp_path.rglob("*.urdf")]
    seen = {e.get("filename") for root in roots for e in root.iterfind("link/visual/geometry/mesh")}
    hit = {e.get("filename") for root in roots for e in root.iterfind("link/collision/*/mesh")}
    assert seen and hit and not seen & hit
    assert all("mtllib" not in f.read_text() for f in (tmp_path / "meshes").glob("*_collision.obj"))


def test_names_are_plain_and_unique_in_any_case(world: World, tmp_path: Path) -> None:
    write_urdf(world, tmp_path / "urdf", looks={})
    folders = [path.name for path in (tmp_path / "urdf/objects").iterdir()]
    assert len({name.lower() for name in folders}) == len(folders)
    assert all(name.isascii() and name.isidentifier() for name in folders)
    write_mjcf(world, tmp_path / "mjcf", looks={})
    names = json.loads((tmp_path / "mjcf/names.json").read_text())
    assert len(names["bodies"]) == sum(len(body.links) for body in world.bodies)
    assert {"/World/Bücherstütze", "/World/C/Door"} <= set(names["bodies"].values())
    assert all(name.isascii() for kind in names.values() for name in kind)


def test_words_that_formats_keep_for_themselves_are_no_names(
    make: SimpleNamespace, tmp_path: Path, mujoco_model: Any
) -> None:
    """MuJoCo calls what never moves ``world``, and refuses another one."""
    places = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [2.0, 0.0, 1.0]])
    called = ("world", "World", "__world__")
    bodies = tuple(make.block(name, at) for name, at in zip(called, places, strict=True))
    world = World((make.ground(0.5, name="world_1"), make.cabinet(), *bodies))
    model = mujoco_model(world)
    names = json.loads((tmp_path / "mjcf/names.json").read_text())["bodies"]
    for body, at in zip(bodies, places, strict=True):
        (name,) = (name for name, path in names.items() if path == body.path)
        np.testing.assert_allclose(model.body(name).pos, at)
        assert name == "World" or name != body.name
    write_urdf(world, tmp_path / "urdf", looks={})
    scene = json.loads((tmp_path / "urdf/scene.json").read_text())
    assert not {"world", "__world__"} & {name for e in scene["bodies"] for name in e["links"]}


@pytest.mark.parametrize("write", [write_urdf, write_mjcf])
def test_the_same_world_gives_the_same_bytes(world: World, tmp_path: Path, write: object) -> None:
    for name in ("a", "b"):
        write(world, tmp_path / name, looks={})  # type: ignore[operator]
    assert contents(tmp_path / "a") == contents(tmp_path / "b")


@pytest.mark.parametrize("write", [write_urdf, write_mjcf])
def test_a_refused_world_leaves_the_folder_as_it_was(
    make: SimpleNamespace, tmp_path: Path, write: object
) -> None:
    (tmp_path / "scene.xml").write_text("old")
    clash = World((make.block("A", np.zeros(3)), make.block("A", np.ones(3))))
    with pytest.raises(StageError, match="same name: A"):
        write(clash, tmp_path, looks={})  # type: ignore[operator]
    assert contents(tmp_path) == {"scene.xml": b"old"}


@pytest.mark.parametrize("exporter", [UrdfExporter, MjcfExporter, UsdPhysicsExporter])
def test_options_that_nobody_knows_are_refused(exporter: type, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no option 'colour'"):
        exporter().convert(None, tmp_path / "out", {"colour": "red"})
    wrong = {"roots": 3} if exporter is UsdPhysicsExporter else {"friction": "wet"}
    with pytest.raises(InputError, match=r"is ('wet'|3)"):
        exporter().convert(None, tmp_path / "out", wrong)
    assert not (tmp_path / "out").exists()


def test_a_folder_without_a_scene_is_refused(tmp_path: Path, client: int) -> None:
    from orusd_urdf.loading import load_bullet

    with pytest.raises(InputError, match="not a readable scene"):
        load_bullet(tmp_path, client)
    (tmp_path / "scene.json").write_text('{"format": 9}')
    with pytest.raises(InputError, match="another format"):
        load_bullet(tmp_path, client)


pybullet = pytest.importorskip("pybullet", reason=NO_PYBULLET)

QUAD = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
ROWS = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
RED, GREEN, BLUE, YELLOW = (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 0)


def quad(st: np.ndarray) -> Visual:
    corners = {"st": st[ROWS].astype(np.float32)}
    surface = TriangleMesh(QUAD, ROWS, np.zeros(2, dtype=np.int32), None, corners)
    return Visual("quad", surface, "/World/Materials/four")


@pytest.fixture
def four(tmp_path: Path) -> str:
    """A picture of four colours: red and green above, blue and yellow below."""
    pixels = np.zeros((32, 32, 3), dtype=np.uint8)
    pixels[:16, :16], pixels[:16, 16:] = RED, GREEN
    pixels[16:, :16], pixels[16:, 16:] = BLUE, YELLOW
    write_png(tmp_path / "four.png", pixels)
    return str(tmp_path / "four.png")


def seen_from_above(client: int) -> np.ndarray:
    view = pybullet.computeViewMatrix([0, 0, 5], [0, 0, 0], [0, 1, 0])
    lens = pybullet.computeProjectionMatrix(-1, 1, -1, 1, 4.9, 6)
    found = pybullet.getCameraImage(
        64,
        64,
        view,
        lens,
        lightDirection=[0, 0, 10],
        shadow=0,
        renderer=pybullet.ER_TINY_RENDERER,
        physicsClientId=client,
    )
    return np.reshape(found[2], (64, 64, 4))[..., :3]


def test_a_picture_in_metres_repeats_as_often_as_it_should(
    four: str, tmp_path: Path, client: int
) -> None:
    """The quad is 2 m wide and the picture 1 m: in Bullet's own renderer it shows 2 by 2 times."""
    from orusd_urdf.loading import load_bullet

    metres = QUAD[:, :2] + 7.0
    texture = Texture(four, color_space="sRGB", uv_scale=(1.0, 1.0))
    link = Link("Room", "/World/Room", np.eye(4), None, (), (quad(metres),))
    world = World((Body("Room", "/World/Room", np.eye(4), (link,), (), True),))
    looks = {"/World/Materials/four": RobotMaterial((1.0, 1.0, 1.0), texture=texture)}
    write_urdf(world, tmp_path / "urdf", looks=looks)
    load_bullet(tmp_path / "urdf", client)
    picture = seen_from_above(client).astype(int)
    for row, column in ((0, 0), (0, 2), (2, 0), (2, 2)):
        for step, color in (((0, 0), RED), ((0, 1), GREEN), ((1, 0), BLUE), ((1, 1), YELLOW)):
            y, x = 16 * np.array([row + step[0], column + step[1]]) + 8
            shown = picture[y, x] / max(1, picture[y, x].max())
            np.testing.assert_allclose(shown, np.array(color) / 255, atol=0.1)


def test_the_mapping_of_a_texture_is_worked_in(four: str) -> None:
    texture = Texture(four, uv_scale=(2.0, 0.5), uv_rotation=30.0, uv_translation=(3.2, -9.7))
    st = np.random.default_rng(1).uniform(-40.0, 40.0, (4, 2))
    found = RobotMaterial((1.0, 1.0, 1.0), texture=texture).coordinates(quad(st))
    turn = np.radians(30.0)
    scaled = st * [2.0, 0.5]
    s = np.cos(turn) * scaled[:, 0] - np.sin(turn) * scaled[:, 1] + 3.2
    t = np.sin(turn) * scaled[:, 0] + np.cos(turn) * scaled[:, 1] - 9.7
    away = found - np.stack([s, t], axis=1)[ROWS]
    # Moved by whole repeats, all corners by the same.
    np.testing.assert_allclose(away, np.broadcast_to(np.round(away[0, 0]), away.shape), atol=1e-4)
    assert found.min() >= 0.0
    assert (found.min(axis=(0, 1)) < 1.0).all()


def test_a_clamped_picture_is_not_moved(four: str) -> None:
    texture = Texture(four, wrap_s="clamp", wrap_t="clamp")
    st = np.array([[-2.0, -2.0], [3.0, -2.0], [3.0, 3.0], [-2.0, 3.0]])
    found = RobotMaterial((1.0, 1.0, 1.0), texture=texture).coordinates(quad(st))
    np.testing.assert_allclose(found, st[ROWS])


def test_a_plain_picture_keeps_its_bytes(four: str) -> None:
    assert picture_bytes(Texture(four, color_space="sRGB")) == Path(four).read_bytes()


def test_scale_bias_and_colour_space_are_worked_into_the_picture(four: str, tmp_path: Path) -> None:
    """Linear 1 times 0.5 is 0.5, which sRGB encodes as 0.7354 (IEC 61966-2-1)."""
    texture = Texture(four, color_space="sRGB", scale=(0.5, 0.5, 0.5, 1.0))
    (tmp_path / "out.png").write_bytes(picture_bytes(texture))
    found = read_texture(str(tmp_path / "out.png"))
    np.testing.assert_allclose(found[0, 0], [0.7354, 0.0, 0.0], atol=1 / 255)
    raw = picture_bytes(Texture(four, color_space="raw", bias=(0.0, 0.2140, 0.0, 0.0)))
    (tmp_path / "raw.png").write_bytes(raw)
    found = read_texture(str(tmp_path / "raw.png"))
    np.testing.assert_allclose(found[0, 0], [1.0, 0.5, 0.0], atol=1 / 255)


def test_constant_colours_are_as_screens_show_them() -> None:
    look = look_of(PreviewSurface(base_color=(0.2140, 1.0, 0.0), opacity=0.4, metallic=1.0))
    np.testing.assert_allclose(look.color, [0.5, 1.0, 0.0], atol=1e-3)
    assert (look.opacity, look.metallic, look.texture) == (0.4, 1.0, None)


def test_a_picture_that_is_missing_is_reported(tmp_path: Path) -> None:
    assets = Assets(tmp_path)
    look = RobotMaterial((1.0, 1.0, 1.0), texture=Texture(str(tmp_path / "gone.png")))
    assets.visual("quad", quad(QUAD[:, :2]), look)
    assert [outcome for _, outcome, _ in assets.losses] == ["skipped"]
    assert "map_Kd" not in (tmp_path / "meshes/four.mtl").read_text()


def test_equal_pictures_under_two_names_are_one_file(four: str, tmp_path: Path) -> None:
    twin = tmp_path / "twin.png"
    twin.write_bytes(Path(four).read_bytes())
    assets = Assets(tmp_path / "out")
    for number, file in enumerate((four, str(twin))):
        look = RobotMaterial((1.0, 1.0, 1.0), texture=Texture(file, color_space="sRGB"))
        assets.visual(f"quad_{number}", quad(QUAD[:, :2]), look)
    assert len(list((tmp_path / "out/textures").iterdir())) == 1


def test_mujoco_gets_the_picture_and_the_coordinates(
    make: SimpleNamespace, four: str, tmp_path: Path
) -> None:
    import mujoco

    from orusd_urdf.mjcf import write_mjcf

    link = Link("Room", "/World/Room", np.eye(4), None, (), (quad(QUAD[:, :2] / 2 + 0.5),))
    world = World((Body("Room", "/World/Room", np.eye(4), (link,), (), True),))
    texture = Texture(four, color_space="sRGB")
    looks: dict[str, Any] = {
        "/World/Materials/four": RobotMaterial((1.0, 1.0, 1.0), texture=texture)
    }
    write_mjcf(world, tmp_path / "mjcf", looks=looks)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "mjcf/scene.xml"))
    assert model.geom_contype.tolist() == [0] and model.geom_conaffinity.tolist() == [0]
    assert model.geom_group.tolist() == [2]
    assert model.tex_data[:3].tolist() == list(RED)
    # MuJoCo turns v round when it reads OBJ: its pictures begin above.
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    turn = data.geom_xmat[0].reshape(3, 3)
    points = model.mesh_vert @ turn.T + data.geom_xpos[0]
    for face, places in zip(model.mesh_face, model.mesh_facetexcoord, strict=True):
        st = model.mesh_texcoord[places]
        np.testing.assert_allclose(st[:, 0], points[face][:, 0] / 2 + 0.5, atol=1e-6)
        np.testing.assert_allclose(st[:, 1], 0.5 - points[face][:, 1] / 2, atol=1e-6)
