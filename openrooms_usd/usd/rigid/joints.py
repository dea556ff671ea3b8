"""The joints of a stage: in which directions they let two links move, and what drives them.

A joint of UsdPhysics is a list of free directions: none is a weld, one a hinge or a rail, and
several, as a D6 or spherical joint has, are joints one after the other with light links between.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from pxr import Gf, Sdf, UsdPhysics

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.geometry.rotations import about_axis, inverse
from openrooms_usd.physics.world import Drive, Joint
from openrooms_usd.usd.rigid.shapes import Frames, ShapeReader

Kind = UsdPhysics.ObjectType

KINDS: Final = (
    Kind.RevoluteJoint,
    Kind.PrismaticJoint,
    Kind.SphericalJoint,
    Kind.FixedJoint,
    Kind.D6Joint,
)
UNKNOWN_KINDS: Final = {
    Kind.DistanceJoint: "a distance joint",
    Kind.CustomJoint: "an unknown kind of joint",
}
_DIRECTIONS: Final = ("transX", "transY", "transZ", "rotX", "rotY", "rotZ")
# What may drive a joint of each kind.
_DRIVES: Final = {
    Kind.RevoluteJoint: ("angular",),
    Kind.PrismaticJoint: ("linear",),
    Kind.D6Joint: _DIRECTIONS,
}
# Largest mismatch of the two frames of a joint, metres and radians.
_APART_M_RAD: Final = 1e-3
# Frames of joints are stored in single precision.
_FRAME_DIGITS: Final = 6


@dataclass(frozen=True, eq=False)
class Freedom:
    """A direction that a joint leaves free.

    Attributes:
        axis: 0 to 2: X, Y or Z of the joint's frame.
        turns: Whether it is about the axis, and not along it.
        limits: Radians or metres; infinite where there are none.
        damping: N m s/rad or N s/m.
        drive: A spring or a motor; None without one.
    """

    axis: int
    turns: bool
    limits: tuple[float, float]
    damping: float
    drive: Drive | None


@dataclass(frozen=True, eq=False)
class Edge:
    """A joint between two links.

    Attributes:
        path: Its prim.
        links: What body0 and body1 belong to.
        anchors: (4, 4) the joint's frame in the rigid frame of each.
        freedoms: From body0 to body1: along axes first, then about axes that follow each other.
        friction: N m or N that it takes to move it at all.
        excluded: Whether the stage wants it outside of the tree of its articulation.
    """

    path: Sdf.Path
    links: tuple[Sdf.Path, Sdf.Path]
    anchors: tuple[Array, Array]
    freedoms: tuple[Freedom, ...]
    friction: float = 0.0
    excluded: bool = False


def is_loose(freedoms: Sequence[Freedom]) -> bool:
    """Whether directions are all that there are, and nothing holds or drives them."""
    acts = (np.isfinite(f.limits).any() or f.damping or f.drive for f in freedoms)
    return len(freedoms) == len(_DIRECTIONS) and not any(acts)


def friction_of(frames: Frames, path: Sdf.Path, freedoms: Sequence[Freedom]) -> float:
    """Joint friction, N m or N, from our own attribute: the standard has none."""
    attribute = frames.stage.GetPrimAtPath(path).GetAttribute(names.JOINT_FRICTION)
    value = attribute.Get() if attribute else None
    turns = any(freedom.turns for freedom in freedoms)
    unit = frames.kilograms * frames.metres ** (2 if turns else 1)
    return value * unit if isinstance(value, float) and 0.0 < value < np.inf else 0.0


def pose(frames: Frames, position: Gf.Vec3f, orientation: Gf.Quatf) -> Array:
    """(4, 4) of a joint's frame in a body's, metres."""
    found = np.eye(4)
    found[:3, :3] = np.array(Gf.Matrix3d(Gf.Quatd(orientation).GetNormalized())).T
    found[:3, 3] = np.array(position, dtype=np.float64) * frames.metres
    return found


def freedoms_of(frames: Frames, kind: Any, desc: Any, reader: ShapeReader) -> tuple[Freedom, ...]:
    """The directions that a joint leaves free, those about axes in cyclic order.

    Args:
        frames: Of the stage.
        kind: One of `KINDS`.
        desc: As USD's parser has it.
        reader: Receives what is approximated.
    """
    _tell_idle_drives(frames, kind, desc, reader)
    if kind == Kind.FixedJoint:
        return ()
    if kind == Kind.D6Joint:
        return tuple(_several(frames, desc, reader))
    axis = "XYZ".index(str(desc.axis)[-1])
    if kind == Kind.SphericalJoint:
        return tuple(_ball(frames, axis, desc, reader))
    turns = kind == Kind.RevoluteJoint
    limit = (desc.limit.lower, desc.limit.upper) if desc.limit.enabled else (-np.inf, np.inf)
    if limit[0] == limit[1]:
        return ()
    return (_freedom(frames, axis, turns, limit, desc.drive, reader, desc.primPath),)


def _tell_idle_drives(frames: Frames, kind: Any, desc: Any, reader: ShapeReader) -> None:
    """Say which drives are for joints of another kind: nothing asks for them."""
    applied = frames.stage.GetPrimAtPath(desc.primPath).GetAppliedSchemas()
    drives = {name.partition(":")[2] for name in applied if name.startswith("PhysicsDriveAPI:")}
    for name in sorted(drives - set(_DRIVES.get(kind, ()))):
        reader.lose(
            desc.primPath, "approximated", f"a joint of its kind cannot have the drive {name!r}"
        )


def _several(frames: Frames, desc: Any, reader: ShapeReader) -> Iterator[Freedom]:
    """Of a joint with limits by direction, of which the lower may lie above: then it is locked."""
    limits = {str(one.first).rpartition(".")[2]: one.second for one in desc.jointLimits}
    drives = {str(one.first).rpartition(".")[2]: one.second for one in desc.jointDrives}
    for number, name in enumerate(_DIRECTIONS):
        word = name[0].upper() + name[1:]
        limit = limits.get(word)
        bounds = (limit.lower, limit.upper) if limit and limit.enabled else (-np.inf, np.inf)
        if bounds[0] < bounds[1]:
            turns, axis = number > 2, number % 3
            yield _freedom(frames, axis, turns, bounds, drives.get(word), reader, desc.primPath)


def _ball(frames: Frames, axis: int, desc: Any, reader: ShapeReader) -> Iterator[Freedom]:
    """About the axes of a ball: its own last, and by that of a cone only the others.

    The cone's first angle is towards the next axis, which is a turn about the one after it.
    """
    cone = [np.inf, np.inf]
    if desc.limit.enabled:
        given = (desc.limit.upper, desc.limit.lower)
        cone = [value if value >= 0.0 else np.inf for value in given]
    if np.isfinite(cone).any():
        reader.lose(desc.primPath, "approximated", "the cone of its limits is a pyramid")
    for step, angle in enumerate((*cone, np.inf), 1):
        if angle > 0.0:
            about = (axis + step) % 3
            yield _freedom(frames, about, True, (-angle, angle), None, reader, desc.primPath)


def _freedom(
    frames: Frames,
    axis: int,
    turns: bool,
    limits: tuple[float, float],
    drive: Any,
    reader: ShapeReader,
    path: Sdf.Path,
) -> Freedom:
    """In radians, metres and newtons; the standard counts angles in degrees."""
    unit = np.pi / 180.0 if turns else frames.metres
    force = frames.kilograms * frames.metres ** (2 if turns else 1)
    low, high = (float(value) * unit for value in limits)
    if drive is None or not drive.enabled:
        return Freedom(axis, turns, (low, high), 0.0, None)
    if drive.acceleration:
        reader.lose(path, "approximated", "its drive is of the type acceleration: it gives force")
    damping, stiffness = (float(v) * force / unit for v in (drive.damping, drive.stiffness))
    speed = float(drive.targetVelocity) * unit if damping > 0.0 else 0.0
    most = float(drive.forceLimit) * force
    made = Drive(stiffness, float(drive.targetPosition) * unit, speed, most)
    drives = stiffness > 0.0 or speed != 0.0 or (damping > 0.0 and np.isfinite(most))
    return Freedom(axis, turns, (low, high), damping, made if drives else None)


def joints_of(
    edge: Edge,
    backward: bool,
    frames: tuple[Array, Array],
    called: tuple[str, str, str],
    fresh: Callable[[str], str],
    reader: ShapeReader,
) -> tuple[list[Joint], Array]:
    """A joint, or several one after the other, in the frame of its child.

    Args:
        edge: The joint.
        backward: Whether its body1 is the parent.
        frames: (4, 4) of its body0 and its body1 in the world.
        called: Of the joint, the parent and the child.
        fresh: Makes a name of which no link and no joint of the body has it.
        reader: Receives what is approximated.

    Returns:
        The joints from the parent on, where links between have the name of the joint above them,
        and (4, 4) the frame of the child in its rigid frame: at the joint.
    """
    label, parent, child = called
    moved, now = positions(edge, frames, reader)
    anchor = edge.anchors[0 if backward else 1]
    at = np.eye(4)
    # Several turn about the point that body1 has.
    turned = backward and len(edge.freedoms) > 1
    at[:3, 3] = (anchor @ moved if turned else anchor)[:3, 3]
    if not edge.freedoms:
        return [Joint(label, "fixed", parent, child, np.eye(3)[0], (0.0, 0.0))], at
    axes = _axes(edge, backward, anchor[:3, :3], moved[:3, :3], now)
    rows = list(zip(edge.freedoms, axes, now, strict=True))
    made: list[Joint] = []
    for freedom, axis, value in rows[::-1] if backward else rows:
        several = f"{label}_{_DIRECTIONS[freedom.axis + 3 * freedom.turns]}"
        own = fresh(several) if len(rows) > 1 else label
        last = len(made) == len(rows) - 1
        made.append(
            Joint(
                own,
                "hinge" if freedom.turns else "rail",
                parent,
                child if last else own,
                axis + 0.0,
                (freedom.limits[0] - value, freedom.limits[1] - value),
                freedom.damping,
                edge.friction,
                freedom.drive and replace(freedom.drive, target=freedom.drive.target - value),
            )
        )
        parent = own
    return made, at


def _axes(edge: Edge, backward: bool, M: Array, R: Array, now: Sequence[float]) -> list[Array]:
    """The axis of each freedom in the frame of the child, in the pose of the stage.

    Args:
        edge: The joint.
        backward: Whether body1 is the parent.
        M: (3, 3) the joint's frame in that of the child.
        R: (3, 3) from the joint's frame in body1 to that in body0.
        now: How far each freedom is moved.
    """
    # Along the axes of body0, then about them, each turned by those before it.
    first = M if backward else M @ R.T
    found = [first[:, freedom.axis] for freedom in edge.freedoms if not freedom.turns]
    turning = [(f.axis, value) for f, value in zip(edge.freedoms, now, strict=True) if f.turns]
    W, axes = M, list[Array]()
    for axis, value in turning if backward else reversed(turning):
        axes.append(W[:, axis])
        W = W @ about_axis(axis, value if backward else -value)
    found += axes if backward else axes[::-1]
    return [-axis for axis in found] if backward else found


def positions(
    edge: Edge, frames: tuple[Array, Array], reader: ShapeReader
) -> tuple[Array, list[float]]:
    """(4, 4) from the joint's frame in body1 to that in body0, and how far each freedom moved it.

    What no freedom explains is reported.
    """
    first, second = (frame @ anchor for frame, anchor in zip(frames, edge.anchors, strict=True))
    moved = inverse(first) @ second
    along = [f.axis for f in edge.freedoms if not f.turns]
    about = [f.axis for f in edge.freedoms if f.turns]
    angles, off = _angles(moved[:3, :3], about)
    aside = float(np.linalg.norm(np.delete(moved[:3, 3], along)))
    if max(off, aside) > _APART_M_RAD:
        reader.lose(
            edge.path, "approximated", "its two frames do not coincide: the child keeps its place"
        )
    ways = [*(float(moved[axis, 3]) for axis in along), *angles]
    return moved, [round(value, _FRAME_DIGITS) for value in ways]


def _angles(R: Array, about: Sequence[int]) -> tuple[list[float], float]:
    """Angles about axes in cyclic order that make a rotation, and what is left, radians."""
    if len(about) < 2:
        twist = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2.0
        if not about:
            return [], float(np.arctan2(np.linalg.norm(twist), (np.trace(R) - 1.0) / 2.0))
        (axis,) = about
        angle = float(np.arctan2(twist[axis], (np.trace(R) - 1.0) / 2.0))
        return [angle], float(np.linalg.norm(R[:, axis] - np.eye(3)[axis]))
    # As a turn about each axis from the first on, one of which may be locked.
    a, b, c = ((about[0] + step) % 3 for step in range(3))
    all_angles = {
        a: float(np.arctan2(-R[b, c], R[c, c])),
        b: float(np.arcsin(np.clip(R[a, c], -1.0, 1.0))),
        c: float(np.arctan2(-R[a, b], R[a, a])),
    }
    left = max((abs(angle) for axis, angle in all_angles.items() if axis not in about), default=0.0)
    return [all_angles[axis] for axis in about], left
