"""Rooms made from nothing are exported thrice, and both engines load and simulate them."""

import json
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
import pytest

from openrooms_usd.composing import compose_room
from openrooms_usd.generation import generate, write
from openrooms_usd.physics.world import World
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.rigid.reading import read_world
from orusd_urdf import MjcfExporter, UrdfExporter, UsdPhysicsExporter
from orusd_urdf.loading import load_bullet
from tests.engines import NO_PYBULLET

pybullet = pytest.importorskip("pybullet", reason=NO_PYBULLET)

pytestmark = pytest.mark.slow

STEP = 0.002
STEPS = 250
# What stands may settle onto its hulls within half a second, not leap: m/s and metres.
FASTEST = 0.5
FARTHEST = 0.05


class Room(NamedTuple):
    world: World
    folder: Path


@pytest.fixture(
    scope="module",
    params=[
        ("closet", 3, 2.5),
        ("hallway", 5, 3.0),
        pytest.param(("bathroom", 7, 3.0), marks=pytest.mark.long),
    ],
    ids=str,
)
def room(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Room:
    """One hull a part: shapes that are made at once."""
    kind, seed, area = request.param
    folder: Path = tmp_path_factory.mktemp(kind)
    text = write(generate(kind, seed, area))
    (folder / "room.yaml").write_text(f"{text}\nphysics: {{shapes: hull}}\n")
    stage = open_stage(compose_room(folder / "room.yaml", folder / "out").scene)
    for name, exporter in (("urdf", UrdfExporter), ("usd", UsdPhysicsExporter)):
        exporter().convert(stage, folder / name, {})
    MjcfExporter().convert(stage, folder / "mjcf", {})
    return Room(read_world(stage), folder)


def masses(world: World) -> dict[str, float]:
    """Of every link that moves, by its prim."""
    links = (link for body in world.bodies for link in body.links)
    return {link.path: link.mass.mass for link in links if link.mass is not None}


def compiled(room: Room, monkeypatch: pytest.MonkeyPatch) -> Any:
    """MuJoCo writes its warnings to a file of the working folder."""
    monkeypatch.chdir(room.folder)
    model = mujoco.MjModel.from_xml_path(str(room.folder / "mjcf/scene.xml"))
    assert not (room.folder / "MUJOCO_LOG.TXT").exists()
    return model


@pytest.mark.one_in(9)
def test_masses_agree_and_loading_is_silent(
    room: Room, client: int, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    given = masses(room.world)
    bodies = load_bullet(room.folder / "urdf", client)
    model = compiled(room, monkeypatch)
    assert capfd.readouterr() == ("", "")
    assert masses(read_world(open_stage(room.folder / "usd/scene.usdc"))) == given
    prims = json.loads((room.folder / "mjcf/names.json").read_text())["bodies"]
    in_mujoco = {path: model.body(name).mass[0] for name, path in prims.items()}
    in_bullet = {
        link.path: pybullet.getDynamicsInfo(
            bodies[body.name].number, bodies[body.name].links[link.name], physicsClientId=client
        )[0]
        for body in room.world.bodies
        for link in body.links
    }
    assert given
    for found in (in_mujoco, in_bullet):
        assert {path: found[path] for path in given} == pytest.approx(given, rel=1e-6)


@pytest.mark.one_in(9)
def test_nothing_explodes_in_bullet(room: Room, client: int) -> None:
    bodies = load_bullet(room.folder / "urdf", client)
    free = [bodies[body.name].number for body in room.world.bodies if not body.fixed]

    def places() -> np.ndarray:
        return np.array(
            [pybullet.getBasePositionAndOrientation(n, physicsClientId=client)[0] for n in free]
        )

    begun = places()
    for _ in range(STEPS):
        pybullet.stepSimulation(physicsClientId=client)
    speeds = [pybullet.getBaseVelocity(n, physicsClientId=client)[0] for n in free]
    assert np.linalg.norm(speeds, axis=1).max() < FASTEST
    assert np.linalg.norm(places() - begun, axis=1).max() < FARTHEST


def test_nothing_explodes_in_mujoco(room: Room, monkeypatch: pytest.MonkeyPatch) -> None:
    data = mujoco.MjData(model := compiled(room, monkeypatch))
    assert model.opt.timestep == STEP
    mujoco.mj_forward(model, data)
    free = [model.body(body.name).id for body in room.world.bodies if not body.fixed]
    begun = data.xpos[free].copy()
    for _ in range(STEPS):
        mujoco.mj_step(model, data)
    starts = [model.body_dofadr[number] for number in free]
    assert max(np.linalg.norm(data.qvel[at : at + 3]) for at in starts) < FASTEST
    assert np.linalg.norm(data.xpos[free] - begun, axis=1).max() < FARTHEST
    assert not any(warning.number for warning in data.warning)
