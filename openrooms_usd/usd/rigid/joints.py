"""The joints of a stage: what they join, and the trees that they make of links."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from pxr import Gf, Sdf, UsdPhysics

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.rotations import inverse
from openrooms_usd.physics.world import Joint, Motion
from openrooms_usd.usd.rigid.shapes import Frames, ShapeReader

Kind = UsdPhysics.ObjectType

KINDS: Final[dict[Any, Motion]] = {
    Kind.RevoluteJoint: "hinge",
    Kind.PrismaticJoint: "rail",
    Kind.FixedJoint: "fixed",
}
UNKNOWN_KINDS: Final = {
    Kind.SphericalJoint: "a spherical joint",
    Kind.DistanceJoint: "a distance joint",
    Kind.D6Joint: "a joint of several degrees of freedom",
    Kind.CustomJoint: "a joint of its own kind",
}
# Largest mismatch of the two frames of a joint, metres and radians.
_APART_M_RAD: Final = 1e-3
# Frames of joints are stored in single precision.
_FRAME_DIGITS: Final = 6


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid piece before it is put into a tree.

    Attributes:
        path: Its prim.
        moves: Whether it is a body of its own.
        frame: (4, 4) its rigid frame in the world.
    """

    path: Sdf.Path
    moves: bool
    frame: Array


@dataclass(frozen=True, eq=False)
class Edge:
    """A joint between two links.

    Attributes:
        path: Its prim.
        kind: How it moves.
        links: What body0 and body1 belong to.
        anchors: (4, 4) the joint's frame in the rigid frame of each.
        axis: (3,) of the joint, in the joint's frame.
        limits: Radians or metres; infinite where there are none.
        damping: N m s/rad or N s/m.
        friction: N m or N that it takes to move it at all.
    """

    path: Sdf.Path
    kind: Motion
    links: tuple[Sdf.Path, Sdf.Path]
    anchors: tuple[Array, Array]
    axis: Array
    limits: tuple[float, float]
    damping: float
    friction: float = 0.0


@dataclass(frozen=True, eq=False)
class Tree:
    """Links that joints hold together.

    Attributes:
        links: The base first, each after its parent.
        joints: (parent, child, joint, whether body1 is the parent).
    """

    links: tuple[Sdf.Path, ...]
    joints: tuple[tuple[Sdf.Path, Sdf.Path, Edge, bool], ...]


def joint_axis(desc: Any) -> Array:
    """(3,) the axis of a joint in its own frame."""
    number = "XYZ".index(str(desc.axis)[-1]) if hasattr(desc, "axis") else 0
    return np.asarray(np.eye(3)[number])


def limits_of(frames: Frames, kind: Motion, desc: Any) -> tuple[float, float]:
    """Radians or metres."""
    if kind == "fixed":
        return 0.0, 0.0
    lower, upper = float(desc.limit.lower), float(desc.limit.upper)
    unit = np.pi / 180.0 if kind == "hinge" else frames.metres
    return (lower * unit, upper * unit) if desc.limit.enabled else (-np.inf, np.inf)


def damping_of(frames: Frames, kind: Motion, desc: Any) -> float:
    """N m s/rad or N s/m; the standard counts angles in degrees."""
    if kind == "fixed" or not desc.drive.enabled:
        return 0.0
    unit = frames.kilograms * (frames.metres**2 * 180.0 / np.pi if kind == "hinge" else 1.0)
    return float(desc.drive.damping) * unit


def friction_of(frames: Frames, kind: Motion, path: Sdf.Path) -> float:
    """Joint friction, N m or N, from our own attribute: the standard has none."""
    attribute = frames.stage.GetPrimAtPath(path).GetAttribute(names.JOINT_FRICTION)
    value = attribute.Get() if attribute else None
    unit = frames.kilograms * frames.metres ** (2 if kind == "hinge" else 1)
    return value * unit if isinstance(value, float) and 0.0 < value < np.inf else 0.0


def pose(frames: Frames, position: Gf.Vec3f, orientation: Gf.Quatf) -> Array:
    """(4, 4) of a joint's frame in a body's, metres."""
    found = np.eye(4)
    found[:3, :3] = np.array(Gf.Matrix3d(Gf.Quatd(orientation).GetNormalized())).T
    found[:3, 3] = np.array(position, dtype=np.float64) * frames.metres
    return found


def trees(
    links: Mapping[Sdf.Path, Link], edges: Sequence[Edge], roots: Iterable[Sdf.Path]
) -> Iterator[Tree]:
    """Take links and joints apart into trees, each with its base.

    Args:
        links: In the order of the stage.
        edges: Joints between them.
        roots: What somebody calls the root of an articulation.

    Raises:
        InputError: Joints go round in a loop.
    """
    _refuse_loops(edges)
    beside: dict[Sdf.Path, list[Edge]] = {path: [] for path in links}
    for edge in edges:
        for end in edge.links:
            beside[end].append(edge)
    children = {edge.links[1] for edge in edges}
    called = set(roots)
    order = sorted(
        links, key=lambda path: (links[path].moves, path not in called, path in children)
    )
    found: dict[Sdf.Path, Tree] = {}
    taken: set[Sdf.Path] = set()
    for base in order:
        if base not in taken:
            tree = _grown(base, beside)
            taken.update(tree.links)
            found[base] = tree
    yield from (found[path] for path in links if path in found)


def _refuse_loops(edges: Sequence[Edge]) -> None:
    group: dict[Sdf.Path, Sdf.Path] = {}

    def top(path: Sdf.Path) -> Sdf.Path:
        while path in group:
            path = group[path]
        return path

    for edge in edges:
        first, second = (top(end) for end in edge.links)
        if first == second:
            raise InputError(
                "this joint closes a loop: robots' formats know trees alone",
                place=edge.path,
                remedy="remove one joint of the loop, or set physics:jointEnabled = false on it",
            )
        group[second] = first


def _grown(base: Sdf.Path, beside: Mapping[Sdf.Path, Sequence[Edge]]) -> Tree:
    order, joints, waiting = [base], [], [base]
    while waiting:
        parent = waiting.pop(0)
        for edge in beside[parent]:
            backward = edge.links[1] == parent
            child = edge.links[0] if backward else edge.links[1]
            if child not in order:
                order.append(child)
                waiting.append(child)
                joints.append((parent, child, edge, backward))
    return Tree(tuple(order), tuple(joints))


def joint_of(
    edge: Edge,
    backward: bool,
    links: tuple[Link, Link],
    called: tuple[str, str, str],
    reader: ShapeReader,
) -> tuple[Joint, Array]:
    """A joint in the frame of its child.

    Args:
        edge: The joint.
        backward: Whether its body1 is the parent.
        links: Its body0 and its body1.
        called: Of the joint, the parent and the child.
        reader: Receives what is approximated.

    Returns:
        The joint, and (4, 4) the frame of the child in its rigid frame: at the joint.
    """
    first, second = (link.frame @ anchor for link, anchor in zip(links, edge.anchors, strict=True))
    moved = inverse(first) @ second
    now, apart = _position(edge, moved)
    now = round(now, _FRAME_DIGITS)
    if apart > _APART_M_RAD:
        reader.lose(edge.path, "approximated", "its two frames do not meet: the child stays")
    anchor = edge.anchors[0 if backward else 1]
    axis = anchor[:3, :3] @ edge.axis * (-1.0 if backward else 1.0)
    lower, upper = (limit - now for limit in edge.limits)
    at = np.eye(4)
    at[:3, 3] = anchor[:3, 3]
    name, parent, child = called
    made = Joint(
        name, edge.kind, parent, child, axis + 0.0, (lower, upper), edge.damping, edge.friction
    )
    return made, at


def _position(edge: Edge, moved: Array) -> tuple[float, float]:
    """How far a joint is moved in the stage, and how far its frames are from where it can be."""
    R, t = moved[:3, :3], moved[:3, 3]
    if edge.kind == "rail":
        along = float(t @ edge.axis)
        aside = float(np.linalg.norm(t - along * edge.axis))
        return along, max(aside, float(np.abs(R - np.eye(3)).max()))
    twist = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2.0
    angle = float(np.arctan2(twist @ edge.axis, (np.trace(R) - 1.0) / 2.0))
    off = float(np.linalg.norm(R @ edge.axis - edge.axis))
    apart = max(off, float(np.linalg.norm(t)))
    return (angle, apart) if edge.kind == "hinge" else (0.0, max(apart, abs(angle)))
