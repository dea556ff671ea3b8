"""What lies in an exported folder: whole, relative, each mesh once, the same bytes again."""

import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest

from openrooms_usd.errors import InputError, StageError
from openrooms_usd.physics.world import World
from orusd_urdf import MjcfExporter, UrdfExporter, UsdPhysicsExporter
from orusd_urdf.mjcf import write_mjcf
from orusd_urdf.urdf import write_urdf
from tests.engines import needs_pybullet

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


def contents(folder: Path) -> dict[str, bytes]:
    return {str(f.relative_to(folder)): f.read_bytes() for f in folder.rglob("*") if f.is_file()}


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

    with pytest.raises(InputError, match="no readable scene"):
        load_bullet(tmp_path, client)
    (tmp_path / "scene.json").write_text('{"format": 9}')
    with pytest.raises(InputError, match="another format"):
        load_bullet(tmp_path, client)
