"""Masses, centres, inertia and frames arrive in the engines as they were given."""

from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from openrooms_usd.arrays import Array
from openrooms_usd.physics.mass import MassProperties
from openrooms_usd.physics.world import World
from tests.engines import NO_PYBULLET

pybullet = pytest.importorskip("pybullet", reason=NO_PYBULLET)

TURN = Rotation.from_euler("xyz", [40.0, -25.0, 110.0], degrees=True).as_matrix()
TILT = Rotation.from_euler("xyz", [-10.0, 65.0, 30.0], degrees=True).as_matrix()

# Something skewed, a sheet whose moments add up exactly, and a thing of a gram.
MASSES = {
    "skewed": MassProperties(
        2.0, np.array([0.03, -0.02, 0.01]), TILT @ np.diag([0.011, 0.024, 0.031]) @ TILT.T
    ),
    "sheet": MassProperties(0.7, np.zeros(3), TILT @ np.diag([0.01, 0.02, 0.03]) @ TILT.T),
    "gram": MassProperties(1e-3, np.array([0.0, 0.0, 1e-3]), np.diag([2e-9, 3e-9, 4e-9])),
}


def tensor(moments: object, quaternion: object) -> Array:
    """The tensor of principal moments along the axes of a quaternion x, y, z, w."""
    turn = Rotation.from_quat(np.array(quaternion)).as_matrix()
    return np.asarray(turn @ np.diag(np.array(moments)) @ turn.T)


@pytest.mark.parametrize("kind", list(MASSES))
def test_engines_have_the_mass_that_was_given(
    make: SimpleNamespace, bullet_bodies: Any, client: int, mujoco_model: Any, kind: str
) -> None:
    mass = MASSES[kind]
    world = World((make.block("B", np.array([1.0, 2.0, 3.0]), turn=TURN, link={"mass": mass}),))
    number, model = bullet_bodies(world)["B"].number, mujoco_model(world)
    found = pybullet.getDynamicsInfo(number, -1, physicsClientId=client)
    bullet = found[0], found[3], tensor(found[2], found[4])
    at = model.body("B").id
    turned = np.roll(model.body_iquat[at], -1)
    other = model.body_mass[at], model.body_ipos[at], tensor(model.body_inertia[at], turned)
    for weight, centre, inertia in (bullet, other):
        assert weight == pytest.approx(mass.mass)
        np.testing.assert_allclose(centre, mass.centre, atol=1e-12)
        np.testing.assert_allclose(inertia, mass.inertia, atol=2e-6 * np.trace(mass.inertia))


def test_things_stand_where_they_stood(
    make: SimpleNamespace, bullet_bodies: Any, client: int, mujoco_model: Any
) -> None:
    """Rays meet the faces in Bullet; in MuJoCo the corners come out of its own transforms."""
    at = np.array([1.0, 2.0, 3.0])
    body = make.block("B", at, turn=TURN, link={"mass": MASSES["skewed"]})
    world = World((body,))
    assert bullet_bodies(world)
    for axis, half_length in zip(np.eye(3), (0.1, 0.1, 0.05), strict=True):
        for outwards in (TURN @ axis, -TURN @ axis):
            ends = (at + outwards).tolist(), at.tolist()
            hit = pybullet.rayTest(*ends, physicsClientId=client)[0]
            np.testing.assert_allclose(hit[3], at + half_length * outwards, atol=1e-5)
    corners = make.box((0.2, 0.2, 0.1)).points @ TURN.T + at
    data = mujoco.MjData(model := mujoco_model(world))
    mujoco.mj_forward(model, data)
    geom = model.geom("B.hull").id
    turn, half = data.geom_xmat[geom].reshape(3, 3), model.geom_size[geom]
    signs = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)])
    found = (signs * half) @ turn.T + data.geom_xpos[geom]
    order = [np.lexsort(np.round(points.T, 6)) for points in (found, corners)]
    np.testing.assert_allclose(found[order[0]], corners[order[1]], atol=1e-9)


@pytest.mark.parametrize("turn", [np.eye(3), TURN], ids=["upright", "turned"])
def test_a_tilted_box_is_the_same_box(make: SimpleNamespace, turn: Array) -> None:
    from orusd_urdf.boxes import as_box

    size = (1.7, 0.003, 0.4)
    points = (make.box(size).points @ turn.T + [3.0, 1.0, -2.0]).astype(np.float32)
    found = as_box(make.mesh(points.astype(np.float64), make.box(size).triangles))
    assert found is not None
    assert np.linalg.det(found.frame[:3, :3]) == pytest.approx(1.0)
    np.testing.assert_allclose(np.sort(found.size), np.sort(size), atol=1e-6)
    signs = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)])
    corners = (signs * found.size / 2.0) @ found.frame[:3, :3].T + found.frame[:3, 3]
    gaps = np.linalg.norm(corners[:, None] - points[None], axis=2)
    assert gaps.min(axis=1).max() < 2e-6


def test_what_is_no_box_is_none(make: SimpleNamespace) -> None:
    from orusd_urdf.boxes import as_box

    assert as_box(make.prism(0.1, 0.2, 4)) is not None
    assert as_box(make.prism(0.1, 0.2, 6)) is None
    sheared = make.box((1.0, 1.0, 1.0))
    slanted = sheared.points + np.outer(sheared.points[:, 2], [0.001, 0.0, 0.0])
    assert as_box(make.mesh(slanted, sheared.triangles)) is None


@pytest.mark.parametrize("angles", [(0.3, -0.4, 2.0), (0.3, np.pi / 2, 0.1), (1.0, -np.pi / 2, 0)])
def test_roll_pitch_yaw_are_about_the_fixed_axes(angles: tuple[float, float, float]) -> None:
    from orusd_urdf.frames import rpy

    turn = Rotation.from_euler("xyz", angles).as_matrix()
    roll, pitch, yaw = rpy(turn)
    x, y, z = np.eye(3)
    again = (
        Rotation.from_rotvec(yaw * z) * Rotation.from_rotvec(pitch * y)
    ) * Rotation.from_rotvec(roll * x)
    np.testing.assert_allclose(again.as_matrix(), turn, atol=1e-8)
