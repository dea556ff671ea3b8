"""What an engine needs of a room: bodies, links, joints, shapes and contacts, as plain arrays.

Everything is in metres, kilograms, seconds and radians, in right-handed frames with Z up. Frames
are rigid: scales and mirrors are baked into the points. ``a_from_b`` takes points of b to a.
"""

from dataclasses import dataclass, field
from typing import Final, Literal

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.physics.mass import MassProperties

Motion = Literal["hinge", "rail", "fixed"]

STANDARD_GRAVITY: Final = 9.81


@dataclass(frozen=True)
class Contact:
    """What a surface brings into a contact.

    Attributes:
        static_friction: Coulomb coefficient at rest; `pair.friction` says what two give together.
        dynamic_friction: The same while sliding, at most the static one.
        restitution: Speed after a bounce by the speed before it.
        name: What it is of, for people and for files.
    """

    static_friction: float
    dynamic_friction: float
    restitution: float = 0.0
    name: str = ""


@dataclass(frozen=True, eq=False)
class Shape:
    """A convex shape that collides.

    Attributes:
        name: Its prim's name, unique within its link.
        mesh: Its closed, convex surface in the frame of its link, metres.
        contact: What it is made of.
    """

    name: str
    mesh: TriangleMesh
    contact: Contact


@dataclass(frozen=True, eq=False)
class Visual:
    """A surface that is seen.

    Attributes:
        name: Unique within its link, and safe as a file's name.
        mesh: Triangles in the frame of its link, metres; faces seen from outside.
        material: The path of its Material prim; empty without one.
    """

    name: str
    mesh: TriangleMesh
    material: str = ""


@dataclass(frozen=True, eq=False)
class Link:
    """One rigid piece of a body.

    Attributes:
        name: Unique within its body.
        path: Its prim.
        body_from_link: (4, 4) rigid, in the pose that the stage shows.
        mass: Its mass, centre and inertia in its own frame; None where it never moves.
        shapes: What collides.
        visuals: What is seen.
        between: Whether it is only there to part two joints of one child, whose frame it has.
    """

    name: str
    path: str
    body_from_link: Array
    mass: MassProperties | None
    shapes: tuple[Shape, ...] = ()
    visuals: tuple[Visual, ...] = ()
    between: bool = False


@dataclass(frozen=True)
class Drive:
    """A spring and a motor of a joint; what damps the joint is the motor's gain.

    Attributes:
        stiffness: N m/rad or N/m.
        target: Where the spring is at rest, from the pose of the stage, radians or metres.
        speed: What the damping draws the joint to, rad/s or m/s.
        force: The most that stiffness and damping give together, N m or N; may be infinite.
    """

    stiffness: float
    target: float = 0.0
    speed: float = 0.0
    force: float = np.inf


@dataclass(frozen=True, eq=False)
class Joint:
    """How a link moves against another; its frame is the child's, in the pose of the stage.

    Attributes:
        name: Unique within its body.
        kind: A ``hinge`` turns counter-clockwise about the axis, a ``rail`` slides along it.
        parent: The name of a link.
        child: The name of another link.
        axis: (3,) unit vector in the child's frame.
        limits: From the pose of the stage: radians or metres.
        damping: N m s/rad or N s/m.
        friction: N m or N that it takes to move it at all.
        drive: A spring or a motor; None without one.
        speed: At first, rad/s or m/s.
    """

    name: str
    kind: Motion
    parent: str
    child: str
    axis: Array
    limits: tuple[float, float]
    damping: float = 0.0
    friction: float = 0.0
    drive: Drive | None = None
    speed: float = 0.0


@dataclass(frozen=True, eq=False)
class Body:
    """A thing of the room: one link, or a tree of links.

    Attributes:
        name: Unique within the world: its root prim's name.
        path: Its root prim.
        world_from_body: (4, 4) rigid.
        links: The first one is the base, whose frame is that of the body.
        joints: A tree over the links.
        fixed: Whether its base never moves.
        category: What it is; empty if unknown.
        velocity: Of its base at first: (3,) of the centre of mass, m/s, and (3,) about the world's
            axes, rad/s.
    """

    name: str
    path: str
    world_from_body: Array
    links: tuple[Link, ...]
    joints: tuple[Joint, ...] = ()
    fixed: bool = False
    category: str = ""
    velocity: tuple[Array, Array] = field(default_factory=lambda: (np.zeros(3), np.zeros(3)))


LinkName = tuple[str, str]
"""The name of a body, and that of one of its links."""


@dataclass(frozen=True, eq=False)
class Loop:
    """A joint that closes a loop: points of two links that stay together.

    Attributes:
        path: Its prim.
        links: What it holds together, also of two bodies.
        points: (N, 3) in the world, in the pose of the stage: one of a ball, two of a hinge, three
            of what is held as a whole.
    """

    path: str
    links: tuple[LinkName, LinkName]
    points: Array


@dataclass(frozen=True, eq=False)
class World:
    """A whole room for an engine.

    Attributes:
        bodies: The room's shell is a fixed body like any other; in the order of the stage.
        gravity: (3,) m/s2.
        losses: (prim path, ``approximated`` or ``skipped``, reason).
        apart: Links of different bodies that pass through each other; those of one body always do.
        loops: Joints that close a loop.
    """

    bodies: tuple[Body, ...]
    gravity: Array = field(default_factory=lambda: np.array([0.0, 0.0, -STANDARD_GRAVITY]))
    losses: tuple[tuple[str, Literal["approximated", "skipped"], str], ...] = ()
    apart: tuple[tuple[LinkName, LinkName], ...] = ()
    loops: tuple[Loop, ...] = ()
