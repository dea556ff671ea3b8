"""Composed and generated rooms in three forms: they agree, and both engines simulate them."""

import json
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom
from scipy.spatial.transform import Rotation

from openrooms_usd.composing import compose_room
from openrooms_usd.generation import generate, write
from openrooms_usd.physics.world import World
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.rigid.reading import read_world
from openrooms_usd.usd.shapes.meshes import read_meshes
from orusd_urdf import MjcfExporter, UrdfExporter, UsdPhysicsExporter
from orusd_urdf.loading import load_bullet
from tests.engines import NO_PYBULLET

pybullet = pytest.importorskip("pybullet", reason=NO_PYBULLET)

FURNITURE = "/World/Furniture"


@pytest.fixture(scope="module")
def stage(composed_bodies: Path) -> Usd.Stage:
    """The small room; one chair is mirrored and stretched, in the session alone."""
    stage = open_stage(composed_bodies)
    chairs = [
        prim for prim in stage.GetPrimAtPath(FURNITURE).GetChildren() if "chair" in prim.GetName()
    ]
    stage.SetEditTarget(stage.GetSessionLayer())
    UsdGeom.Xformable(chairs[1]).AddScaleOp(opSuffix="bent").Set(Gf.Vec3f(-1.2, 1.0, 0.9))
    return stage


@pytest.fixture(scope="module")
def world(stage: Usd.Stage) -> World:
    return read_world(stage)


@pytest.fixture(scope="module")
def exported(stage: Usd.Stage, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("room")
    UrdfExporter().convert(stage, folder / "urdf", {})
    MjcfExporter().convert(stage, folder / "mjcf", {})
    return folder


@pytest.fixture(scope="module")
def model(exported: Path) -> Any:
    return mujoco.MjModel.from_xml_path(str(exported / "mjcf/scene.xml"))


def test_masses_agree_in_both_engines(
    world: World, exported: Path, model: Any, client: int
) -> None:
    bodies = load_bullet(exported / "urdf", client)
    names = json.loads((exported / "mjcf/names.json").read_text())["bodies"]
    by_prim = {prim: name for name, prim in names.items()}
    moving = 0
    for body in world.bodies:
        loaded = bodies[body.name]
        for link in body.links:
            if link.mass is None:
                continue
            moving += 1
            given = link.mass
            index = loaded.links[link.name]
            found = pybullet.getDynamicsInfo(loaded.number, index, physicsClientId=client)
            at = model.body(by_prim[link.path]).id
            tolerance = 1e-5 * np.trace(given.inertia)
            for mass, centre, moments, axes in (
                (found[0], found[3], found[2], found[4]),
                (
                    model.body_mass[at],
                    model.body_ipos[at],
                    model.body_inertia[at],
                    np.roll(model.body_iquat[at], -1),
                ),
            ):
                assert mass == pytest.approx(given.mass, rel=1e-6)
                np.testing.assert_allclose(centre, given.centre, atol=1e-6)
                turn = Rotation.from_quat(axes).as_matrix()
                tensor = turn @ np.diag(moments) @ turn.T
                np.testing.assert_allclose(tensor, given.inertia, atol=tolerance)
    assert moving >= 4


def test_what_is_seen_lies_where_the_stage_has_it(
    stage: Usd.Stage, world: World, exported: Path, model: Any
) -> None:
    """Bounds of each body's meshes: in MuJoCo, and by the walk over the stage that renders."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    placed = read_meshes(stage)
    for body in world.bodies:
        of_stage = np.concatenate(
            [m.world_points() for m in placed if f"{m.path}/".startswith(f"{body.path}/")]
        )
        geoms = [
            geom
            for geom in range(model.ngeom)
            if model.geom(geom).name.startswith(f"{body.name}:")
            or (model.geom(geom).name.startswith(f"{body.name}.") and model.geom_group[geom] == 2)
        ]
        if body.name == "Room":
            continue
        points = []
        for geom in geoms:
            mesh = model.geom_dataid[geom]
            first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
            turn = data.geom_xmat[geom].reshape(3, 3)
            points.append(model.mesh_vert[first : first + count] @ turn.T + data.geom_xpos[geom])
        bounds = np.concatenate(points)
        np.testing.assert_allclose(bounds.min(axis=0), of_stage.min(axis=0), atol=2e-5)
        np.testing.assert_allclose(bounds.max(axis=0), of_stage.max(axis=0), atol=2e-5)


@pytest.mark.slow
def test_rest_poses_agree(exported: Path, world: World, model: Any, client: int) -> None:
    """After a second neither engine has moved anything that stands on the floor by 2 mm."""
    bodies = load_bullet(exported / "urdf", client)
    data = mujoco.MjData(model)
    for _ in range(500):
        pybullet.stepSimulation(physicsClientId=client)
        mujoco.mj_step(model, data)
    for body in world.bodies:
        if body.fixed:
            continue
        number = bodies[body.name].number
        centre = pybullet.getBasePositionAndOrientation(number, physicsClientId=client)[0]
        np.testing.assert_allclose(centre, data.xipos[model.body(body.name).id], atol=2e-3)


def test_textures_lie_beside_and_materials_find_them(exported: Path) -> None:
    libraries = list((exported / "urdf/meshes").glob("*.mtl"))
    pictures = [
        file.parent / line.split(" ", 1)[1]
        for file in libraries
        for line in file.read_text().splitlines()
        if line.startswith("map_Kd")
    ]
    assert pictures
    assert all(picture.is_file() for picture in pictures)
    for file in (exported / "urdf/meshes").glob("*.obj"):
        first = file.read_text().splitlines()[0]
        assert first.startswith("v ") or (file.parent / first.split(" ")[1]).is_file()


def test_repeats_share_their_files(exported: Path, world: World) -> None:
    names = [file.name for file in (exported / "urdf/meshes").glob("*.obj")]
    assert len(names) == len({(exported / "urdf/meshes" / name).read_bytes() for name in names})


def test_the_report_names_what_has_no_place(stage: Usd.Stage, tmp_path: Path) -> None:
    report = UrdfExporter().convert(stage, tmp_path, {})
    rows = {path: outcome for path, outcome, _ in report.rows}
    assert rows["/World/Lights/Environment"] == "skipped"
    assert rows["/World/Room"] == "translated"
    assert sum(outcome == "approximated" for outcome in rows.values()) > 0


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


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.slow
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
