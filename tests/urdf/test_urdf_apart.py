"""What shall not collide does not: filtered pairs of a stage, and the links of one body."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from openrooms_usd import adapters, names
from openrooms_usd.physics.world import World
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.rigid.reading import read_world
from orusd_urdf import MjcfExporter, UrdfExporter, UsdPhysicsExporter
from orusd_urdf.loading import load_bullet
from tests.engines import ENGINES, NO_PYBULLET

pybullet = pytest.importorskip("pybullet", reason=NO_PYBULLET)

STEPS = 250
# Half a second of free fall; what lies on something is still there.
FALLEN = 9.81 * 0.5**2 / 2.0
DAMPING, FRICTION = 3.0, 2.0


def cube(stage: Usd.Stage, path: str, at: tuple[float, ...], size: tuple[float, ...]) -> Usd.Prim:
    """An Xform with a box that collides below it, perhaps scaled."""
    xform = UsdGeom.Xform.Define(stage, path)
    xform.AddTranslateOp().Set(Gf.Vec3d(*at))
    shape = UsdGeom.Cube.Define(stage, f"{path}/shape")
    shape.CreateSizeAttr(1.0)
    shape.AddScaleOp().Set(Gf.Vec3f(*size))
    UsdPhysics.CollisionAPI.Apply(shape.GetPrim())
    return xform.GetPrim()


def body(stage: Usd.Stage, path: str, at: tuple[float, ...], size: tuple[float, ...]) -> Usd.Prim:
    prim = cube(stage, path, at, size)
    UsdPhysics.RigidBodyAPI.Apply(prim)
    UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(2.0)
    return prim


def rubbing(stage: Usd.Stage, path: str, mu: float) -> None:
    """Its own coefficient, so that MuJoCo is given explicit pairs."""
    material = UsdShade.Material.Define(stage, f"{path}/rubber")
    api = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
    api.CreateStaticFrictionAttr(mu)
    api.CreateDynamicFrictionAttr(mu)
    shape = stage.GetPrimAtPath(f"{path}/shape")
    binding = UsdShade.MaterialBindingAPI.Apply(shape)
    binding.Bind(material, materialPurpose="physics")


@pytest.fixture
def stage(tmp_path: Path) -> Usd.Stage:
    """A ghost that a slab lets through, a block that it carries, and a chest of two drawers.

    The drawers overlap each other and their chest, which is fixed, by less along their rails than
    across: that is where contacts would push them.
    """
    stage = Usd.Stage.CreateNew(str(tmp_path / "stage.usda"))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, "Z")
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    UsdPhysics.Scene.Define(stage, "/World/Scene").CreateGravityMagnitudeAttr(9.81)
    cube(stage, "/World/Slab", (0, 0, -0.1), (4, 4, 0.2))
    ghost = body(stage, "/World/Ghost", (0, 0, 0.05), (0.2, 0.2, 0.1))
    body(stage, "/World/Block", (1, 0, 0.05), (0.2, 0.2, 0.1))
    UsdPhysics.FilteredPairsAPI.Apply(ghost).CreateFilteredPairsRel().AddTarget("/World/Slab")
    for name, mu in (("Slab", 0.3), ("Ghost", 0.6), ("Block", 0.9)):
        rubbing(stage, f"/World/{name}", mu)
    chest = cube(stage, "/World/Chest", (0, 3, 1), (0.8, 0.5, 0.8))
    Usd.ModelAPI(chest).SetKind("component")
    for number, depth in enumerate((-0.2, -0.65)):
        path = f"/World/Chest/Drawer_{number}"
        body(stage, path, (0, depth, 0), (0.6, 0.5, 0.3))
        joint = UsdPhysics.PrismaticJoint.Define(stage, f"/World/Chest/Rail_{number}")
        joint.CreateBody0Rel().SetTargets(["/World/Chest"])
        joint.CreateBody1Rel().SetTargets([path])
        joint.CreateLocalPos0Attr(Gf.Vec3f(0, depth, 0))
        joint.CreateAxisAttr("Y")
        joint.CreateLowerLimitAttr(-0.4)
        joint.CreateUpperLimitAttr(0.4)
        drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), "linear")
        drive.CreateDampingAttr(DAMPING)
        named = (names.JOINT_FRICTION, Sdf.ValueTypeNames.Float)
        joint.GetPrim().CreateAttribute(*named).Set(FRICTION)
    stage.GetRootLayer().Save()
    return stage


@pytest.fixture
def world(stage: Usd.Stage) -> World:
    return read_world(stage)


def check(heights: dict[str, float], ways: list[float]) -> None:
    """Where the ghost and the block are after half a second, and how far drawers have moved."""
    assert heights["Ghost"] == pytest.approx(0.05 - FALLEN, abs=0.01)
    assert heights["Block"] == pytest.approx(0.05, abs=1e-3)
    np.testing.assert_allclose(ways, 0.0, atol=1e-5)


def test_the_reader_finds_pairs_and_leaves_siblings(world: World) -> None:
    assert world.apart == ((("Slab", "Slab"), ("Ghost", "Ghost")),)
    assert [len(found.joints) for found in world.bodies] == [0, 0, 0, 2]
    assert not world.losses


def test_single_shapes_and_groups_are_told(stage: Usd.Stage) -> None:
    more = UsdGeom.Cube.Define(stage, "/World/Block/more")
    UsdPhysics.CollisionAPI.Apply(more.GetPrim())
    relation = UsdPhysics.FilteredPairsAPI.Apply(more.GetPrim()).CreateFilteredPairsRel()
    relation.AddTarget("/World/Ghost")
    UsdPhysics.CollisionGroup.Define(stage, "/World/Group")
    world = read_world(stage)
    assert len(world.apart) == 1
    assert {path for path, *_ in world.losses} == {"/World/Block/more", "/World/Group"}


def test_the_whole_shape_of_a_link_is_the_link(stage: Usd.Stage) -> None:
    """Also said by the collider, and said twice."""
    relation = UsdPhysics.FilteredPairsAPI.Apply(stage.GetPrimAtPath("/World/Slab/shape"))
    relation.CreateFilteredPairsRel().SetTargets(["/World/Ghost/shape", "/World/Block"])
    found = read_world(stage).apart
    slab = ("Slab", "Slab")
    assert found == ((slab, ("Ghost", "Ghost")), (slab, ("Block", "Block")))


@pytest.mark.parametrize("engine", ENGINES)
def test_engines_obey(world: World, engine: str) -> None:
    simulation = adapters.load(adapters.ENGINES, engine).open(world)
    simulation.step(STEPS * simulation.timestep)
    poses = simulation.poses()
    heights = {name: pose.world_from_body[2, 3] for name, pose in poses.items()}
    check(heights, list(poses["Chest"].joints.values()))
    simulation.close()


def test_bullet_obeys_the_export(stage: Usd.Stage, tmp_path: Path) -> None:
    from pybullet_utils.bullet_client import BulletClient

    UrdfExporter().convert(stage, tmp_path / "urdf", {})
    opened = BulletClient(pybullet.DIRECT)
    opened.setPhysicsEngineParameter(
        fixedTimeStep=0.002, numSolverIterations=200, solverResidualThreshold=0.0
    )
    client = opened._client
    bodies = load_bullet(str(tmp_path / "urdf"), opened)
    for _ in range(STEPS):
        pybullet.stepSimulation(client)
    heights = {
        name: pybullet.getBasePositionAndOrientation(bodies[name].number, client)[0][2]
        for name in ("Ghost", "Block")
    }
    chest = bodies["Chest"]
    check(heights, [pybullet.getJointState(chest.number, j, client)[0] for j in (0, 1)])
    for joint in chest.joints.values():
        assert pybullet.getJointInfo(chest.number, joint, client)[6] == DAMPING
    file = ElementTree.parse(tmp_path / "urdf/objects/Chest/Chest.urdf")
    said = [dynamics.attrib for dynamics in file.iterfind("joint/dynamics")]
    assert said == 2 * [{"damping": "3", "friction": "2"}]


@pytest.mark.parametrize("pairs", ["all", "near", "none"])
def test_mujoco_obeys_the_export(stage: Usd.Stage, tmp_path: Path, pairs: str) -> None:
    """An explicit pair would collide in spite of an exclusion."""
    MjcfExporter().convert(stage, tmp_path / "mjcf", {"pairs": pairs})
    data = mujoco.MjData(model := mujoco.MjModel.from_xml_path(str(tmp_path / "mjcf/scene.xml")))
    for _ in range(STEPS):
        mujoco.mj_step(model, data)
    heights = {name: data.body(name).xpos[2] for name in ("Ghost", "Block")}
    check(heights, [data.joint(f"Chest.Rail_{n}").qpos[0] for n in (0, 1)])
    rails = [model.joint(f"Chest.Rail_{n}") for n in (0, 1)]
    assert [(rail.damping[0], rail.frictionloss[0]) for rail in rails] == 2 * [(DAMPING, FRICTION)]


def targets(stage: Usd.Stage) -> Iterator[frozenset[str]]:
    for prim in stage.Traverse():
        if prim.HasAPI(UsdPhysics.FilteredPairsAPI):
            for path in UsdPhysics.FilteredPairsAPI(prim).GetFilteredPairsRel().GetTargets():
                yield frozenset((str(prim.GetPath()), str(path)))


def test_the_usd_export_says_it_of_siblings(stage: Usd.Stage, tmp_path: Path) -> None:
    UsdPhysicsExporter().convert(stage, tmp_path / "usd", {})
    copy: Any = open_stage(tmp_path / "usd/scene.usdc")
    drawers = [f"/World/Chest/Drawer_{n}" for n in (0, 1)]
    assert set(targets(copy)) == {
        frozenset(("/World/Ghost", "/World/Slab")),
        frozenset(drawers),
        *(frozenset((drawer, "/World/Chest/shape")) for drawer in drawers),
    }
    world = read_world(copy)
    assert world.apart == read_world(stage).apart
    assert not world.losses
    joints = [joint for found in world.bodies for joint in found.joints]
    assert [(joint.damping, joint.friction) for joint in joints] == 2 * [(DAMPING, FRICTION)]
