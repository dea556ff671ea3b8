"""Robots of our own: bodies like any other, so that every exporter writes them too.

Forward is +X, left is +Y. A link named `CAMERA` sees along its own +X.
"""

from dataclasses import replace
from math import inf, pi
from typing import Final

import numpy as np

from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.rotations import about_z, pose
from openrooms_usd.geometry.solids import box
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.physics.mass import MassProperties
from openrooms_usd.physics.world import Body, Contact, Joint, Link, Shape, Visual, World

CAMERA: Final = "camera"
# The pusher's rails, and the wheels of the rover.
ALONG: Final = "along"
ACROSS: Final = "across"
LEFT: Final = "left_wheel"
RIGHT: Final = "right_wheel"

# Linear base colours of what robots are made of, by the paths of the materials.
ORANGE: Final = "/World/Robots/Materials/Orange"
DARK: Final = "/World/Robots/Materials/Dark"
BLUE: Final = "/World/Robots/Materials/Blue"
COLORS: Final = {BLUE: (0.05, 0.15, 0.35), ORANGE: (0.75, 0.18, 0.02), DARK: (0.02, 0.02, 0.025)}

PUSHER_SIZE: Final = 0.2
WHEEL_RADIUS: Final = 0.05
WHEEL_DISTANCE: Final = 0.26
_TYRE_M: Final = 0.015

_SMOOTH: Final = Contact(0.0, 0.0, name="smooth")
_RUBBER: Final = Contact(1.0, 0.9, name="rubber")
# Sides of what is round: a wheel of 5 cm is then nowhere more than 0.06 mm too thin.
_ROUND_SIDES: Final = 64


def pusher(
    position: tuple[float, float], *, mass: float = 0.27, bumper: tuple[float, float] = (0.05, 0.15)
) -> Body:
    """A square robot that two rails carry over the floor, always facing +X.

    It touches neither the floor nor feels friction against what it pushes: all that it gives is the
    force of its motors. It has a mast with a camera.

    Args:
        position: Its middle on the floor, metres.
        mass: Kilograms of what slides, carriage included.
        bumper: Where what pushes begins and ends above the floor, metres.
    """
    low, high = bumper
    middle = 0.5 * (low + high)
    size = (PUSHER_SIZE, PUSHER_SIZE, high - low)
    trunk = box(size, (0.0, 0.0, middle))
    foot = box((0.1, 0.1, low - 0.005), (0.0, 0.0, 0.5 * low + 0.0025))
    mast = box((0.03, 0.03, 0.5), (0.0, 0.0, high + 0.25))
    # Some engines want a mass of all that moves: the carriage and the camera take little of it.
    light = 1e-3 * mass
    carriage = Link("carriage", "", np.eye(4), _solid_box(light, (0.2, 0.2, 0.2)))
    robot = Link(
        "robot",
        "",
        np.eye(4),
        _at(_solid_box(mass - 2.0 * light, size), middle),
        (Shape("trunk", triangles(trunk), _SMOOTH),),
        (
            Visual("trunk", triangles(trunk), ORANGE),
            Visual("foot", triangles(foot), DARK),
            Visual("mast", triangles(mast), DARK),
        ),
    )
    rails = (
        Joint(ALONG, "rail", "base", "carriage", np.array([1.0, 0.0, 0.0]), (-50.0, 50.0)),
        Joint(ACROSS, "rail", "carriage", "robot", np.array([0.0, 1.0, 0.0]), (-50.0, 50.0)),
    )
    eye, mount = _camera("robot", (0.0, 0.0, high + 0.5), light)
    base = Link("base", "", np.eye(4), None)
    place = pose(np.eye(3), (*position, 0.0))
    links = (base, carriage, robot, eye)
    return Body("pusher", "", place, links, (*rails, mount), True, "robot")


def rover(position: tuple[float, float], yaw: float = 0.0) -> Body:
    """A robot on two wheels and a smooth skid behind, with a camera on a mast: 4 kg.

    It stands on three points, so that the wheels carry their share whatever the floor; another skid
    in front floats 2 mm above the floor and only catches it when it nods.

    Args:
        position: The middle between its wheels on the floor, metres.
        yaw: Where it looks, radians counter-clockwise from +X.
    """
    r = WHEEL_RADIUS
    trunk = _upright(0.16, 0.14).moved((0.0, 0.0, 0.12))
    mast = box((0.03, 0.03, 0.36), (-0.06, 0.0, 0.37))
    plate = box((0.02, 0.3, 0.08), (0.17, 0.0, 0.1))
    head = box((0.07, 0.14, 0.06), (-0.05, 0.0, 0.56))
    skids = [_bead(0.02).moved((x, 0.0, z)) for x, z in ((-0.13, 0.02), (0.13, 0.022))]
    stands = [box((0.02, 0.02, 0.03), (x, 0.0, 0.04)) for x in (-0.13, 0.13)]
    smooth = {"front": skids[1], "rear": skids[0]}
    bare = {"trunk": trunk, "plate": plate, "mast": mast, "head": head}
    seen = {**bare, **smooth, "stand_0": stands[0], "stand_1": stands[1]}
    base = Link(
        "base",
        "",
        np.eye(4),
        _at(_solid_cylinder(3.4, 0.16, 0.14), 0.08, -0.04),
        (
            Shape("trunk", triangles(trunk), _SMOOTH),
            Shape("plate", triangles(plate), _SMOOTH),
            *(Shape(name, triangles(mesh), _SMOOTH) for name, mesh in smooth.items()),
        ),
        tuple(
            Visual(name, triangles(mesh), ORANGE if name in ("trunk", "head") else DARK)
            for name, mesh in seen.items()
        ),
    )
    eye, mount = _camera("base", (-0.01, 0.0, 0.56), 0.01)
    place = pose(about_z(yaw), (*position, 0.0))
    wheels = [_wheel(LEFT, 0.5 * WHEEL_DISTANCE, r), _wheel(RIGHT, -0.5 * WHEEL_DISTANCE, r)]
    links = (base, *(link for link, _ in wheels), eye)
    return Body("rover", "", place, links, (*(joint for _, joint in wheels), mount), False, "robot")


def with_robot(world: World, robot: Body) -> World:
    """The world with one more body."""
    return replace(world, bodies=(*world.bodies, robot))


def triangles(mesh: Mesh) -> TriangleMesh:
    """A mesh of convex faces as triangles with its own normals."""
    corners, faces = mesh.triangles()
    normals = None if mesh.normals is None else mesh.normals[corners]
    return TriangleMesh(mesh.points, mesh.indices[corners].astype(np.int32), faces, normals)


def _wheel(name: str, y: float, radius: float) -> tuple[Link, Joint]:
    """A wheel that turns forward about +Y."""
    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    tyre = _upright(radius, _TYRE_M).transformed(turn)
    mass = _solid_cylinder(0.3, radius, _TYRE_M)
    shape = Shape("tyre", triangles(tyre), _RUBBER)
    upright = MassProperties(mass.mass, mass.centre, turn @ mass.inertia @ turn.T)
    place = pose(np.eye(3), (0.0, y, radius))
    link = Link(name, "", place, upright, (shape,), (Visual("tyre", triangles(tyre), DARK),))
    return link, Joint(name, "hinge", "base", name, np.array([0.0, 1.0, 0.0]), (-inf, inf))


def _camera(parent: str, where: tuple[float, float, float], mass: float) -> tuple[Link, Joint]:
    """A link without a shape, fixed to another one."""
    link = Link(CAMERA, "", pose(np.eye(3), where), _solid_box(mass, (0.02, 0.02, 0.02)))
    return link, Joint("mount", "fixed", parent, CAMERA, np.array([1.0, 0.0, 0.0]), (0.0, 0.0))


def _upright(radius: float, height: float) -> Mesh:
    """A closed cylinder about Z, its middle in the origin."""
    angles = np.arange(_ROUND_SIDES) * (2.0 * pi / _ROUND_SIDES)
    ring = np.stack([radius * np.cos(angles), radius * np.sin(angles)], axis=1)
    low = np.column_stack([ring, np.full(_ROUND_SIDES, -0.5 * height)])
    high = np.column_stack([ring, np.full(_ROUND_SIDES, 0.5 * height)])
    here = np.arange(_ROUND_SIDES)
    there = np.roll(here, -1)
    sides = np.column_stack([here, there, there + _ROUND_SIDES, here + _ROUND_SIDES]).ravel()
    indices = np.concatenate([sides, here[::-1], here + _ROUND_SIDES]).astype(np.int32)
    counts = np.array([4] * _ROUND_SIDES + [_ROUND_SIDES] * 2, np.int32)
    return Mesh(np.concatenate([low, high]), counts, indices)


def _bead(radius: float) -> Mesh:
    """A ball of triangles about the origin: an icosahedron, each face cut into four, twice."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=2, radius=radius)
    faces = np.asarray(ball.faces, np.int32)
    counts = np.full(len(faces), 3, np.int32)
    return Mesh(np.asarray(ball.vertices, np.float64), counts, faces.ravel())


def _solid_box(mass: float, size: tuple[float, float, float]) -> MassProperties:
    x, y, z = np.square(size) * (mass / 12.0)
    return MassProperties(mass, np.zeros(3), np.diag([y + z, x + z, x + y]))


def _solid_cylinder(mass: float, radius: float, height: float) -> MassProperties:
    """About Z."""
    side = mass * (3.0 * radius**2 + height**2) / 12.0
    return MassProperties(mass, np.zeros(3), np.diag([side, side, 0.5 * mass * radius**2]))


def _at(mass: MassProperties, height: float, forward: float = 0.0) -> MassProperties:
    return replace(mass, centre=np.array([forward, 0.0, height]))
