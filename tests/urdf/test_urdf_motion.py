"""Joints swing and slide, and friction is Coulomb's, against closed forms in both engines."""

import math
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from openrooms_usd.physics.world import Shape, World
from tests.engines import NO_PYBULLET

pybullet = pytest.importorskip("pybullet", reason=NO_PYBULLET)

STEP = 0.002
# Of the door about its hinge: a thin plate about its edge, m w^2 / 3, and its thickness.
ABOUT_THE_EDGE = 3.0 * (1.0 / 12.0 + 0.02**2 / 12.0 + 0.25)


@pytest.fixture
def opened(make: SimpleNamespace, bullet_bodies: Any, client: int, mujoco_model: Any) -> Any:
    """Give both joints a speed; how far they are after some seconds, in both engines."""

    def run(speeds: dict[str, float], seconds: float, **cabinet: float) -> dict[str, np.ndarray]:
        world = World((make.cabinet(**cabinet),))
        pybullet.resetSimulation(client)
        loaded = bullet_bodies(world)["C"]
        for name, speed in speeds.items():
            pybullet.resetJointState(
                loaded.number, loaded.joints[name], 0.0, speed, physicsClientId=client
            )
        data = mujoco.MjData(model := mujoco_model(world))
        for name, speed in speeds.items():
            data.qvel[model.joint(f"C.{name}").dofadr[0]] = speed
        for _ in range(round(seconds / STEP)):
            pybullet.stepSimulation(physicsClientId=client)
            mujoco.mj_step(model, data)
        found = {}
        for name, index in loaded.joints.items():
            state = pybullet.getJointState(loaded.number, index, physicsClientId=client)
            at = data.qpos[model.joint(f"C.{name}").qposadr[0]]
            found[name] = np.array([state[0], at])
        return found

    return run


def test_joints_move_freely_and_stop_at_their_limits(opened: Any) -> None:
    free = opened({"door": 1.0, "drawer": 0.2}, 0.5)
    np.testing.assert_allclose(free["door"], 0.5, atol=0.01)
    np.testing.assert_allclose(free["drawer"], 0.1, atol=0.002)
    stopped = opened({"door": 1.0, "drawer": 0.2}, 4.0)
    assert (stopped["door"] < 1.5 + 0.02).all()
    assert (stopped["drawer"] < 0.3 + 0.005).all()
    shut = opened({"door": -1.0, "drawer": -0.2}, 0.5)
    # MuJoCo's limits are springs: a sixth of the speed comes back.
    assert (np.abs(shut["door"]) < 0.2 * 0.5).all()
    assert (np.abs(shut["drawer"]) < 0.2 * 0.1).all()


def test_damping_stops_a_door_after_the_way_of_the_closed_form(opened: Any) -> None:
    """I w' = -d w: the way is I w0 / d (1 - exp(-d t / I))."""
    damping, seconds = 2.0, 1.5
    rate = damping / ABOUT_THE_EDGE
    expected = 1.0 / rate * (1.0 - np.exp(-rate * seconds))
    found = opened({"door": 1.0}, seconds, damping=damping)["door"]
    np.testing.assert_allclose(found, expected, rtol=0.02)


def test_dry_friction_stops_a_drawer_after_the_way_of_the_closed_form(opened: Any) -> None:
    """F = f: the way is m v^2 / (2 f)."""
    found = opened({"drawer": 0.5}, 2.0, friction=1.0)["drawer"]
    np.testing.assert_allclose(found, 1.5 * 0.25 / 2.0, rtol=0.03)


def test_dry_friction_holds_without_the_sweeps_against_slip(
    make: SimpleNamespace, mujoco_model: Any
) -> None:
    """In a full room they do not reach every joint: 4.5 N do not open a drawer that 5 N hold."""
    model = mujoco_model(World((make.cabinet(friction=5.0),), np.array([0.0, -3.0, -9.0])))
    model.opt.noslip_iterations = 0
    mujoco.mj_step(model, data := mujoco.MjData(model), 500)
    assert abs(data.qpos[model.joint("C.drawer").qposadr[0]]) < 1e-4


def test_a_door_opens_to_the_side_that_it_opens_to(
    make: SimpleNamespace, bullet_bodies: Any, client: int, mujoco_model: Any
) -> None:
    """Counter-clockwise about Z through its right edge: its left edge comes to the front."""
    world = World((make.cabinet(),))
    loaded = bullet_bodies(world)["C"]
    pybullet.resetJointState(loaded.number, loaded.joints["door"], 0.5, physicsClientId=client)
    state = pybullet.getLinkState(loaded.number, loaded.links["Door"], physicsClientId=client)
    data = mujoco.MjData(model := mujoco_model(world))
    data.qpos[model.joint("C.door").qposadr[0]] = 0.5
    mujoco.mj_forward(model, data)
    edge = np.array([3.0 + 0.5, -0.26, 0.6])
    expected = edge + 0.5 * np.array([-np.cos(0.5), -np.sin(0.5), 0.0])
    np.testing.assert_allclose(state[0], expected, atol=1e-6)
    np.testing.assert_allclose(data.xipos[model.body("C.Door").id], expected, atol=1e-9)


FLOOR, THING = 0.6, 0.24
# The geometric mean; the product is 0.144, the larger 0.6, the mean 0.42.
MU = math.sqrt(FLOOR * THING)
G = 9.81
STEPS = 1000
SECONDS = 2.0


def on_a_slope(make: SimpleNamespace, angle: float, shape: Any) -> World:
    """A ramp that goes down along +X, and a block on it."""
    turn = Rotation.from_rotvec([0.0, angle, 0.0]).as_matrix()
    link = {"shapes": (Shape("hull", shape, make.contact(THING)),)}
    at = turn @ np.array([-6.0, 0.0, 0.05])
    return World((make.ground(FLOOR, turn), make.block("B", at, turn=turn, link=link)))


def bullet_speed(bodies: Any, client: int) -> float:
    number = bodies["B"].number
    for _ in range(STEPS):
        pybullet.stepSimulation(physicsClientId=client)
    return float(np.linalg.norm(pybullet.getBaseVelocity(number, physicsClientId=client)[0]))


def mujoco_speed(model: Any) -> float:
    data = mujoco.MjData(model)
    for _ in range(STEPS):
        mujoco.mj_step(model, data)
    return float(np.linalg.norm(data.qvel[:3]))


@pytest.mark.parametrize("shape", ["box", "prism"])
@pytest.mark.parametrize(("share", "slides"), [(0.98, False), (1.02, True)])
def test_a_block_slides_from_atan_mu_on(
    make: SimpleNamespace,
    bullet_bodies: Any,
    client: int,
    mujoco_model: Any,
    shape: str,
    share: float,
    slides: bool,
) -> None:
    hull = make.box((0.2, 0.2, 0.1)) if shape == "box" else make.prism(0.12, 0.1, 16)
    world = on_a_slope(make, math.atan(MU * share), hull)
    speeds = [bullet_speed(bullet_bodies(world), client), mujoco_speed(mujoco_model(world))]
    angle = math.atan(MU * share)
    if slides:
        assert min(speeds) > 0.05
        # What the end speed says of the coefficient: g (sin - mu cos) t.
        realised = math.tan(angle) - np.array(speeds) / (G * math.cos(angle) * SECONDS)
        np.testing.assert_allclose(realised, MU, rtol=0.01)
    else:
        assert max(speeds) < 1e-3


@pytest.mark.parametrize("direction", [0.0, 45.0])
def test_what_is_pushed_slides_v2_by_2_mu_g(
    make: SimpleNamespace, bullet_bodies: Any, client: int, mujoco_model: Any, direction: float
) -> None:
    world = World((make.ground(FLOOR), make.block("B", np.array([0.0, 0.0, 0.05]), THING)))
    turn = math.radians(direction)
    speed = 2.0 * np.array([math.cos(turn), math.sin(turn), 0.0])
    expected = 4.0 / (2.0 * MU * G)
    number = bullet_bodies(world)["B"].number
    pybullet.resetBaseVelocity(number, speed.tolist(), [0, 0, 0], physicsClientId=client)
    for _ in range(STEPS):
        pybullet.stepSimulation(physicsClientId=client)
    at = pybullet.getBasePositionAndOrientation(number, physicsClientId=client)[0]
    assert np.linalg.norm(at[:2]) == pytest.approx(expected, rel=0.02)
    data = mujoco.MjData(model := mujoco_model(world))
    data.qvel[:3] = speed
    for _ in range(STEPS):
        mujoco.mj_step(model, data)
    assert np.linalg.norm(data.qpos[:2]) == pytest.approx(expected, rel=0.02)


def test_every_side_of_a_thing_has_its_own_friction(
    make: SimpleNamespace, bullet_bodies: Any, client: int, mujoco_model: Any
) -> None:
    """A box with a rubber pad below: URDF has one contact a link, so the pad is a link."""
    pad = Shape("pad", make.box((0.2, 0.2, 0.02), (0.0, 0.0, -0.06)), make.contact(0.9))
    hull = Shape("hull", make.box((0.2, 0.2, 0.1)), make.contact(0.1))
    body = make.block("B", np.array([0.0, 0.0, 0.07]), link={"shapes": (hull, pad)})
    world = World((make.ground(FLOOR), body))
    expected = 4.0 / (2.0 * math.sqrt(FLOOR * 0.9) * G)
    number = bullet_bodies(world)["B"].number
    pybullet.resetBaseVelocity(number, [2.0, 0, 0], [0, 0, 0], physicsClientId=client)
    for _ in range(STEPS):
        pybullet.stepSimulation(physicsClientId=client)
    at = pybullet.getBasePositionAndOrientation(number, physicsClientId=client)[0]
    assert at[0] == pytest.approx(expected, rel=0.03)
    assert pybullet.getDynamicsInfo(number, -1, physicsClientId=client)[0] == pytest.approx(2.0)
    assert pybullet.getDynamicsInfo(number, 0, physicsClientId=client)[0] == 0.0
    data = mujoco.MjData(model := mujoco_model(world))
    data.qvel[0] = 2.0
    for _ in range(STEPS):
        mujoco.mj_step(model, data)
    assert data.qpos[0] == pytest.approx(expected, rel=0.03)


def test_the_dynamic_coefficient_on_request(make: SimpleNamespace, tmp_path: Any) -> None:
    from xml.etree import ElementTree

    from orusd_urdf.urdf import write_urdf

    world = World((make.block("B", np.zeros(3), 0.5),))
    write_urdf(world, tmp_path, looks={}, friction="dynamic")
    root = ElementTree.parse(tmp_path / "objects/B/B.urdf").getroot()
    written = root.find("link/contact/lateral_friction")
    assert written is not None
    assert float(written.get("value", "")) ** 2 == pytest.approx(0.4)
