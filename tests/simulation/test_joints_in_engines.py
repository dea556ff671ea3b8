"""Joints, drives, loops and first velocities of foreign stages, in both engines, in closed form."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from openrooms_usd import adapters
from openrooms_usd.engines import Simulation
from openrooms_usd.geometry.rotations import about_axis, pose
from openrooms_usd.physics.world import World
from openrooms_usd.usd.rigid.reading import read_world
from orusd_urdf.mjcf import write_mjcf
from orusd_urdf.urdf import write_urdf

Place = tuple[float, float, float]
OFF, LENGTH = 0.3, 0.5
DIRECTIONS = ("transX", "transY", "transZ", "rotX", "rotY", "rotZ")
# A bar of 1 kg, 0.5 m long and 2 cm thick, about its end, and what gravity turns it with.
INERTIA = (LENGTH**2 + 0.02**2) / 12.0 + (LENGTH / 2.0) ** 2
TORQUE = 9.81 * LENGTH / 2.0


def bar(stage: Usd.Stage, name: str, at: Place, size: Place = (LENGTH, 0.4, 0.02)) -> Usd.Prim:
    cube = UsdGeom.Cube.Define(stage, f"/World/{name}")
    cube.CreateSizeAttr(1.0)
    cube.AddTranslateOp().Set(Gf.Vec3d(*at))
    cube.AddScaleOp().Set(Gf.Vec3f(*size))
    prim = cube.GetPrim()
    UsdPhysics.RigidBodyAPI.Apply(prim)
    UsdPhysics.CollisionAPI.Apply(prim)
    UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(1.0)
    return prim


def joined(
    stage: Usd.Stage, schema: type, ends: tuple[str, str], at: tuple[Place, Place], name: str = "J"
) -> UsdPhysics.Joint:
    """A joint; places are fractions of the scaled cubes, or metres of the world."""
    joint = schema.Define(stage, f"/World/{name}")  # type: ignore[attr-defined]
    for side, (end, place) in enumerate(zip(ends, at, strict=True)):
        if end:
            getattr(joint, f"CreateBody{side}Rel")().SetTargets([f"/World/{end}"])
        getattr(joint, f"CreateLocalPos{side}Attr")(Gf.Vec3f(*place))
    return joint


@pytest.fixture
def stage() -> Usd.Stage:
    """A bar that begins in the middle of the world, without a joint."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, "Z")
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    UsdPhysics.Scene.Define(stage, "/World/Scene")
    bar(stage, "bar", (LENGTH / 2.0, 0.0, 1.0))
    return stage


HELD = (("", "bar"), ((0.0, 0.0, 1.0), (-0.5, 0.0, 0.0)))


def several(stage: Usd.Stage, *free: str, **limits: tuple[float, float]) -> UsdPhysics.Joint:
    """A joint that locks all other directions."""
    joint = joined(stage, UsdPhysics.Joint, *HELD)
    for name in DIRECTIONS:
        low, high = limits.get(name, (1.0, -1.0))
        if name not in free:
            made = UsdPhysics.LimitAPI.Apply(joint.GetPrim(), name)
            made.CreateLowAttr(low)
            made.CreateHighAttr(high)
    return joint


def limited(joint: UsdPhysics.Joint, axis: str, limits: tuple[float, float]) -> UsdPhysics.Joint:
    joint.CreateAxisAttr(axis)
    joint.CreateLowerLimitAttr(limits[0])
    joint.CreateUpperLimitAttr(limits[1])
    return joint


PLAIN: dict[str, tuple[Callable[..., object], Callable[..., object]]] = {
    "weld": (several, lambda s: joined(s, UsdPhysics.FixedJoint, *HELD)),
    "hinge": (
        lambda s: several(s, rotY=(-10.0, 80.0)),
        lambda s: limited(joined(s, UsdPhysics.RevoluteJoint, *HELD), "Y", (-10.0, 80.0)),
    ),
    "rail": (
        lambda s: several(s, transZ=(-0.2, 0.1)),
        lambda s: limited(joined(s, UsdPhysics.PrismaticJoint, *HELD), "Z", (-0.2, 0.1)),
    ),
    "ball": (
        lambda s: several(s, "rotX", "rotY", "rotZ"),
        lambda s: joined(s, UsdPhysics.SphericalJoint, *HELD),
    ),
}


def model_of(world: World, folder: Path) -> "mujoco.MjModel":
    write_mjcf(world, folder, looks={})
    return mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))


@pytest.mark.parametrize("kind", list(PLAIN))
def test_a_joint_of_six_directions_is_the_plain_one_of_those_that_are_free(
    stage: Usd.Stage, kind: str, tmp_path: Path
) -> None:
    """MuJoCo moves both alike."""
    plain = Usd.Stage.CreateInMemory()
    plain.GetRootLayer().TransferContent(stage.GetRootLayer())
    found = []
    for number, (make, one) in enumerate(zip(PLAIN[kind], (stage, plain), strict=True)):
        make(one)
        model = model_of(read_world(one), tmp_path / str(number))
        data = mujoco.MjData(model)
        mujoco.mj_step(model, data, 150)
        name = "bar" if kind == "weld" else "J.bar"
        found.append((model.jnt_type.tolist(), data.body(name).xpos, data.body(name).xquat))
    assert found[0][0] == found[1][0]
    assert found[0][0] == {"weld": [], "hinge": [3], "rail": [2], "ball": [1]}[kind]
    for a, b in zip(found[0][1:], found[1][1:], strict=True):
        np.testing.assert_allclose(a, b, atol=1e-6)


@pytest.mark.parametrize("backward", [False, True])
@pytest.mark.parametrize(
    "free", [("rotX", "rotZ"), ("rotY", "rotZ"), ("transY", "rotX", "rotY"), DIRECTIONS[1:]]
)
def test_several_directions_lead_back_to_where_the_frames_meet(
    stage: Usd.Stage, free: tuple[str, ...], backward: bool, tmp_path: Path
) -> None:
    """Each joint has a middle; moved there, MuJoCo has both frames of the joint in one place."""
    values = {name: 0.1 + 0.11 * DIRECTIONS.index(name) for name in free}
    bar(stage, "base", (0.0, 0.0, 1.0), (0.1, 0.1, 0.1))
    joint = several(stage, *(), **dict.fromkeys(free, (-720.0, 720.0)))
    ends = [Sdf.Path("/World/base"), Sdf.Path("/World/bar")]
    places = [Gf.Vec3f(0.0), Gf.Vec3f(-0.5, 0.0, 0.0)]
    if backward:
        ends.reverse()
        places.reverse()
    for side in (0, 1):
        getattr(joint, f"CreateBody{side}Rel")().SetTargets([ends[side]])
        getattr(joint, f"CreateLocalPos{side}Attr")(places[side])
    joined(stage, UsdPhysics.FixedJoint, ("", "base"), ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0)), "Held")
    moved: NDArray[Any] = np.eye(4)
    for name, value in values.items():
        axis = "XYZ".index(name[-1])
        turn = name.startswith("rot")
        step = pose(about_axis(axis, value)) if turn else pose(np.eye(3), value * np.eye(3)[axis])
        moved = moved @ step
    moved = np.linalg.inv(moved) if backward else moved
    at = pose(np.eye(3), (0.0, 0.0, 1.0)) @ moved @ pose(np.eye(3), (LENGTH / 2.0, 0.0, 0.0))
    prim = UsdGeom.Xformable(stage.GetPrimAtPath("/World/bar"))
    prim.ClearXformOpOrder()
    prim.AddTransformOp().Set(Gf.Matrix4d(at.T.tolist()))
    prim.AddScaleOp(opSuffix="own").Set(Gf.Vec3f(LENGTH, 0.4, 0.02))
    world = read_world(stage)
    assert world.losses == ()
    model = model_of(world, tmp_path / "mjcf")
    data = mujoco.MjData(model)
    assert model.nbody == 3 and model.nv == len(free)
    for body in world.bodies:
        for joint_ in body.joints:
            now = values[f"{joint_.name.rpartition('_')[2]}"]
            number = model.joint(f"{body.name}.{joint_.name}").qposadr[0]
            data.qpos[number] = -now
    mujoco.mj_kinematics(model, data)
    R = data.body("base.bar").xmat.reshape(3, 3)
    np.testing.assert_allclose(R, np.eye(3), atol=1e-5)
    # The end of the bar is in the base's middle.
    np.testing.assert_allclose(data.body("base.bar").xipos, (LENGTH / 2.0, 0.0, 1.0), atol=1e-5)


def test_urdf_and_mjcf_tell_what_they_cannot(stage: Usd.Stage, tmp_path: Path) -> None:
    joint = joined(stage, UsdPhysics.SphericalJoint, *HELD)
    joint.CreateConeAngle0LimitAttr(20.0)
    joint.CreateConeAngle1LimitAttr(30.0)
    world = read_world(stage)
    assert [row[2] for row in world.losses] == ["the cone of its limits is a pyramid"]
    # The first angle is from X towards Y: about Z.
    joints = next(body.joints for body in world.bodies if body.joints)
    found = {tuple(np.round(joint.axis).astype(int)): joint.limits[1] for joint in joints}
    assert np.degrees(found[0, 0, 1]) == pytest.approx(20.0)
    assert np.degrees(found[0, 1, 0]) == pytest.approx(30.0)
    assert found[1, 0, 0] == np.inf
    (told,) = write_urdf(world, tmp_path, looks={})
    assert told[0] == "/World/bar" and "one direction a joint" in told[2]


def drive(joint: UsdPhysics.Joint, kind: str = "angular", **says: float) -> None:
    made = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), kind)
    for name, value in says.items():
        getattr(made, f"Create{name}Attr")(value)


@pytest.fixture
def run(engine: str, stage: Usd.Stage) -> Iterator[Callable[[float], Simulation]]:
    opened: list[Simulation] = []

    def after(seconds: float) -> Simulation:
        opened.append(adapters.load(adapters.ENGINES, engine).open(read_world(stage)))
        opened[-1].step(seconds)
        return opened[-1]

    yield after
    for simulation in opened:
        simulation.close()


def angle(simulation: Simulation) -> float:
    (found,) = (pose.joints for pose in simulation.poses().values() if pose.joints)
    return next(iter(found.values()))


DEGREE = np.pi / 180.0


@pytest.mark.parametrize("stiffness", [1.0, 20.0, 1e3, 1e6])
def test_a_spring_sags_by_what_it_holds(
    stage: Usd.Stage, run: Callable[[float], Simulation], stiffness: float
) -> None:
    """Steps of 2 ms follow some springs; those that are stiffer hold all the same."""
    joint = limited(joined(stage, UsdPhysics.RevoluteJoint, *HELD), "Y", (-90.0, 90.0))
    drive(joint, Stiffness=stiffness, Damping=0.05, TargetPosition=0.0)
    # As the torque gets less with the angle.
    sag = 0.0
    for _ in range(20):
        sag = TORQUE * np.cos(sag) / (stiffness / DEGREE)
    assert angle(run(1.0)) == pytest.approx(sag, rel=0.02, abs=3e-5)


def test_a_spring_draws_to_its_target(stage: Usd.Stage, run: Callable[[float], Simulation]) -> None:
    stage.GetPrimAtPath("/World/Scene").GetAttribute("physics:gravityMagnitude").Set(0.0)
    joint = limited(joined(stage, UsdPhysics.RevoluteJoint, *HELD), "Y", (-90.0, 90.0))
    drive(joint, Stiffness=1.0, Damping=0.1, TargetPosition=-30.0)
    assert angle(run(2.0)) == pytest.approx(-30.0 * DEGREE, rel=1e-3)


@pytest.mark.parametrize("force", [np.inf, 0.05])
def test_a_motor_reaches_its_speed_with_no_more_than_its_force(
    stage: Usd.Stage, run: Callable[[float], Simulation], force: float
) -> None:
    """What damps draws with d (v' - v): v = v' (1 - exp(-d t / I)); or F t / I with F at most."""
    stage.GetPrimAtPath("/World/Scene").GetAttribute("physics:gravityMagnitude").Set(0.0)
    joint = joined(stage, UsdPhysics.RevoluteJoint, *HELD)
    joint.CreateAxisAttr("Y")
    drive(joint, Damping=1.0 * DEGREE, TargetVelocity=90.0, MaxForce=force)
    time, goal = 0.1, np.pi / 2.0
    speed = goal * (1.0 - np.exp(-time / INERTIA)) if force == np.inf else force * time / INERTIA
    simulation = run(time)
    (found,) = (v.joints for v in simulation.velocities().values() if v.joints)
    assert next(iter(found.values())) == pytest.approx(speed, rel=0.02)


def test_first_velocities_are_in_the_world(
    stage: Usd.Stage, run: Callable[[float], Simulation], tmp_path: Path
) -> None:
    """Those of a prim are along its parent's axes, turns in degrees."""
    stage.GetPrimAtPath("/World/Scene").GetAttribute("physics:gravityMagnitude").Set(0.0)
    UsdGeom.Xformable(stage.GetPrimAtPath("/World")).AddRotateZOp().Set(90.0)
    api = UsdPhysics.RigidBodyAPI(stage.GetPrimAtPath("/World/bar"))
    api.CreateVelocityAttr(Gf.Vec3f(1.0, 0.0, 0.0))
    api.CreateAngularVelocityAttr(Gf.Vec3f(90.0, 0.0, 0.0))
    velocity = run(0.1).velocities()["bar"]
    np.testing.assert_allclose(velocity.linear, (0.0, 1.0, 0.0), atol=1e-3)
    np.testing.assert_allclose(velocity.angular, (0.0, np.pi / 2.0, 0.0), atol=1e-3)
    for write in (write_mjcf, write_urdf):
        (told,) = write(read_world(stage), tmp_path, looks={})
        assert told[0] == "/World/bar" and "initial velocity" in told[2]


def test_a_first_turn_of_a_link_is_the_speed_of_its_joint(
    stage: Usd.Stage, run: Callable[[float], Simulation]
) -> None:
    stage.GetPrimAtPath("/World/Scene").GetAttribute("physics:gravityMagnitude").Set(0.0)
    joined(stage, UsdPhysics.RevoluteJoint, *HELD).CreateAxisAttr("Y")
    api = UsdPhysics.RigidBodyAPI(stage.GetPrimAtPath("/World/bar"))
    api.CreateAngularVelocityAttr(Gf.Vec3f(0.0, 90.0, 0.0))
    assert angle(run(0.1)) == pytest.approx(0.1 * np.pi / 2.0, rel=1e-3)


@pytest.fixture
def linkage(stage: Usd.Stage) -> Usd.Stage:
    """Two bars that hang from the world level with each other, and one that joins their ends."""
    bar(stage, "other", (LENGTH / 2.0, 0.0, 0.5))
    bar(stage, "coupler", (LENGTH, 0.0, 0.75), (0.02, 0.4, 0.5))
    hinges = {
        "A": (("", "bar"), ((0.0, 0.0, 1.0), (-0.5, 0.0, 0.0))),
        "B": (("", "other"), ((0.0, 0.0, 0.5), (-0.5, 0.0, 0.0))),
        "C": (("bar", "coupler"), ((0.5, 0.0, 0.0), (0.0, 0.0, 0.5))),
        "D": (("other", "coupler"), ((0.5, 0.0, 0.0), (0.0, 0.0, -0.5))),
    }
    for name, (ends, at) in hinges.items():
        joined(stage, UsdPhysics.RevoluteJoint, ends, at, name).CreateAxisAttr("Y")
    return stage


def test_a_linkage_is_a_loop_of_parallel_bars(
    linkage: Usd.Stage, run: Callable[[float], Simulation], tmp_path: Path
) -> None:
    """Both bars swing alike: 2 I + m L2 is turned by m g L (two halves and the coupler's)."""
    world = read_world(linkage)
    assert [loop.path for loop in world.loops] == ["/World/D"]
    assert any(
        row[0] == "/World/D" and "loop" in row[2] for row in write_urdf(world, tmp_path, looks={})
    )
    time = 0.1
    simulation = run(time)
    poses = {link: M for body in world.bodies for link, M in simulation.links(body.name).items()}
    for name in ("bar", "other"):
        fallen = np.arcsin(-poses[name][2, 0])
        rate = 2.0 * TORQUE + 9.81 * LENGTH
        expected = -0.5 * rate / (2.0 * INERTIA + LENGTH**2) * time**2
        assert abs(fallen) == pytest.approx(abs(expected), rel=0.03)
    ends = [poses["other"] @ [LENGTH, 0, 0, 1], poses["coupler"] @ [0, 0, -0.5, 1]]
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-3)


@pytest.mark.parametrize(
    ("schema", "drive"),
    [(UsdPhysics.RevoluteJoint, "rotY"), (UsdPhysics.PrismaticJoint, "angular")],
)
def test_drives_of_another_kind_of_joint_are_told(
    stage: Usd.Stage, schema: type, drive: str
) -> None:
    joint = joined(stage, schema, *HELD)
    UsdPhysics.DriveAPI.Apply(joint.GetPrim(), drive).CreateStiffnessAttr(10.0)
    assert [row[2] for row in read_world(stage).losses] == [
        f"a joint of its kind cannot have the drive {drive!r}"
    ]


def test_a_joint_to_what_is_missing_says_so(stage: Usd.Stage) -> None:
    joined(stage, UsdPhysics.RevoluteJoint, ("nobody", "bar"), HELD[1])
    told = [row[2] for row in read_world(stage).losses]
    assert told[0].startswith("it joins /World/nobody, which is missing")


def test_first_speeds_of_joints_are_against_the_parent(stage: Usd.Stage) -> None:
    """What says nothing moves as its parent does, and so does all that it carries."""
    names = ("bar", "middle", "end")
    for number, name in enumerate(names[1:], start=1):
        bar(stage, name, (LENGTH / 2.0 + 0.6 * number, 0.0, 1.0))
        ends = (names[number - 1], name)
        at = ((0.6, 0.0, 0.0), (-0.6, 0.0, 0.0))
        rail = joined(stage, UsdPhysics.PrismaticJoint, ends, at, f"{name}_rail")
        limited(rail, "X", (-1.0, 1.0))
    for name in ("bar", "end"):
        prim = stage.GetPrimAtPath(f"/World/{name}")
        UsdPhysics.RigidBodyAPI(prim).CreateVelocityAttr(Gf.Vec3f(1.0, 0.0, 0.0))
    (body,) = read_world(stage).bodies
    assert body.velocity[0] == pytest.approx([1.0, 0.0, 0.0])
    assert [joint.speed for joint in body.joints] == pytest.approx([0.0, 0.0])


def test_a_ball_turns_as_it_is_told_at_first(
    stage: Usd.Stage, run: Callable[[float], Simulation]
) -> None:
    joined(stage, UsdPhysics.SphericalJoint, *HELD)
    prim = stage.GetPrimAtPath("/World/bar")
    UsdPhysics.RigidBodyAPI(prim).CreateAngularVelocityAttr(Gf.Vec3f(0.0, 0.0, 90.0))
    simulation, time = run(0.01), 0.01
    (body,) = (name for name in simulation.poses() if "bar" in simulation.links(name))
    M = simulation.links(body)["bar"]
    assert np.degrees(np.arctan2(M[1, 0], M[0, 0])) == pytest.approx(90.0 * time, rel=0.05)
    simulation.place(body, simulation.poses()[body].world_from_body, {})
    before = simulation.links(body)["bar"]
    simulation.step(0.002)
    still = np.linalg.inv(before[:3, :3]) @ simulation.links(body)["bar"][:3, :3]
    assert abs(np.degrees(np.arctan2(still[1, 0], still[0, 0]))) < 0.02
