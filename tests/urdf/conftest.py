"""Worlds of boxes and prisms, and the two engines to load them."""

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.physics.mass import MassProperties
from openrooms_usd.physics.world import Body, Contact, Joint, Link, Shape, Visual, World
from tests.engines import NO_PYBULLET

CUBE = np.array([[x, y, z] for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)])
FACES = [
    [0, 2, 1],
    [1, 2, 3],
    [4, 5, 6],
    [5, 7, 6],
    [0, 1, 4],
    [1, 5, 4],
    [2, 6, 3],
    [3, 6, 7],
    [0, 4, 2],
    [2, 4, 6],
    [1, 3, 5],
    [3, 7, 5],
]


def mesh(points: Array, faces: object) -> TriangleMesh:
    rows = np.array(faces, dtype=np.int32)
    return TriangleMesh(points, rows, np.arange(len(rows), dtype=np.int32))


def box(size: tuple[float, float, float], at: object = (0.0, 0.0, 0.0)) -> TriangleMesh:
    return mesh(CUBE * size + at, FACES)


def prism(radius: float, height: float, sides: int) -> TriangleMesh:
    """A closed prism about Z."""
    turn = 2.0 * np.pi * np.arange(sides) / sides
    ring = radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    low, high = (np.column_stack([ring, np.full(sides, z)]) for z in (-height / 2, height / 2))
    here, after = np.arange(sides), (np.arange(sides) + 1) % sides
    sides_1 = np.stack([here, after, after + sides], axis=1)
    sides_2 = np.stack([here, after + sides, here + sides], axis=1)
    fan = np.arange(1, sides - 1)
    bottom = np.stack([0 * fan, fan + 1, fan], axis=1)
    top = np.stack([0 * fan, fan, fan + 1], axis=1) + sides
    return mesh(np.concatenate([low, high]), np.concatenate([sides_1, sides_2, bottom, top]))


def box_mass(size: tuple[float, float, float], mass: float) -> MassProperties:
    """The closed form of a solid box about its middle."""
    x, y, z = np.square(size)
    return MassProperties(mass, np.zeros(3), mass / 12.0 * np.diag([y + z, x + z, x + y]))


def frame(at: object = (0.0, 0.0, 0.0), turn: Array | None = None) -> Array:
    M = np.eye(4)
    M[:3, :3] = np.eye(3) if turn is None else turn
    M[:3, 3] = at
    return M


def contact(mu: float, restitution: float = 0.0) -> Contact:
    return Contact(mu, 0.8 * mu, restitution, "thing")


def ground(mu: float, turn: Array | None = None, name: str = "Room") -> Body:
    """A fixed slab whose top is the plane z = 0 of its own frame."""
    slab = box((24.0, 24.0, 0.2), (0.0, 0.0, -0.1))
    seen = Visual("Floor", slab, "/World/Materials/oak")
    link = Link(
        name, f"/World/{name}", np.eye(4), None, (Shape("Floor", slab, contact(mu)),), (seen,)
    )
    return Body(name, f"/World/{name}", frame(turn=turn), (link,), (), True)


def block(name: str, at: Array, mu: float = 0.4, **changes: Any) -> Body:
    """A free box of 2 kg, 0.2 by 0.2 by 0.1 m; ``link`` changes its link, others the body."""
    size = (0.2, 0.2, 0.1)
    of_link: dict[str, Any] = {
        "mass": box_mass(size, 2.0),
        "shapes": (Shape("hull", box(size), contact(mu)),),
        "visuals": (Visual("skin", box(size), "/World/Materials/oak"),),
        **changes.pop("link", {}),
    }
    turn = changes.pop("turn", None)
    link = Link(name, f"/World/{name}", np.eye(4), **of_link)
    return Body(name, f"/World/{name}", frame(at, turn), (link,), **changes)


def cabinet(damping: float = 0.0, friction: float = 0.0) -> Body:
    """Fixed, with a door on its right edge that opens to the front, and a drawer."""
    door = frame((0.5, -0.26, 0.0))
    leaf = (1.0, 0.02, 1.0)
    swinging = box_mass(leaf, 3.0)
    swinging = MassProperties(3.0, np.array([-0.5, 0.0, 0.0]), swinging.inertia)
    wood = contact(0.4)
    links = (
        Link("Body", "/World/C/Body", np.eye(4), None, (Shape("b", box((1.0, 0.5, 1.0)), wood),)),
        Link(
            "Door",
            "/World/C/Door",
            door,
            swinging,
            (Shape("d", box(leaf, (-0.5, 0.0, 0.0)), wood),),
        ),
        Link(
            "Drawer",
            "/World/C/Drawer",
            frame((0.0, 0.0, 0.3)),
            box_mass((0.4, 0.4, 0.1), 1.5),
            (Shape("d", box((0.4, 0.4, 0.1)), contact(0.2)),),
        ),
    )
    z, front = np.array([0.0, 0.0, 1.0]), np.array([0.0, -1.0, 0.0])
    joints = (
        Joint("door", "hinge", "Body", "Door", z, (0.0, 1.5), damping, friction),
        Joint("drawer", "rail", "Body", "Drawer", front, (0.0, 0.3), damping, friction),
    )
    return Body("C", "/World/C", frame((3.0, 0.0, 0.6)), links, joints, True, "cabinet")


@pytest.fixture(scope="session")
def make() -> SimpleNamespace:
    """The functions of this file, and the World."""
    return SimpleNamespace(
        World=World,
        ground=ground,
        block=block,
        cabinet=cabinet,
        box=box,
        prism=prism,
        box_mass=box_mass,
        contact=contact,
        frame=frame,
        mesh=mesh,
    )


@pytest.fixture
def client() -> Iterator[int]:
    """A Bullet of one's own, with steps of 2 ms."""
    pybullet = pytest.importorskip("pybullet", reason=NO_PYBULLET)
    number = pybullet.connect(pybullet.DIRECT)
    pybullet.setPhysicsEngineParameter(
        fixedTimeStep=0.002,
        numSolverIterations=200,
        solverResidualThreshold=0.0,
        enableFileCaching=0,
        physicsClientId=number,
    )
    yield number
    pybullet.disconnect(number)


@pytest.fixture
def mujoco_model(tmp_path: Path) -> Any:
    """Write a world as MJCF and compile it."""
    import mujoco

    from orusd_urdf.mjcf import write_mjcf

    def load(world: World) -> Any:
        write_mjcf(world, tmp_path / "mjcf", looks={})
        return mujoco.MjModel.from_xml_path(str(tmp_path / "mjcf" / "scene.xml"))

    return load


@pytest.fixture
def bullet_bodies(tmp_path: Path, client: int) -> Any:
    """Write a world as URDF and load it."""
    from orusd_urdf.loading import load_bullet
    from orusd_urdf.urdf import write_urdf

    def load(world: World) -> Any:
        write_urdf(world, tmp_path / "urdf", looks={})
        return load_bullet(tmp_path / "urdf", client)

    return load
