"""Doors swing and drawers slide, about their axes and to their limits, in both engines."""

from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

from openrooms_usd.physics.world import World
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
