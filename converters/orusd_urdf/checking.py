"""Worlds that no engine can hold are refused before a file is written."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.errors import StageError
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.physics.hulls import volume
from openrooms_usd.physics.mass import MassProperties
from openrooms_usd.physics.world import Body, Joint, Link, World

# Relative: moments are read in single precision.
_MOMENT_TOLERANCE: Final = 1e-5
# Of a shape's volume to that of a ball around it: a sheet of 1 m by 1 m and 1 micrometre.
_MIN_VOLUME_SHARE: Final = 1e-7


def check_world(world: World) -> None:
    """Refuse a world that is impossible.

    Raises:
        StageError: Names clash, a mass or an inertia is not valid, a shape has no volume, or joints
            do not form a tree. The place is the prim.
    """
    if not np.isfinite(world.gravity).all():
        _refuse("the gravity is not finite", "/", "set it in the physics scene")
    _check_unique([body.name for body in world.bodies], "bodies", "/")
    for body in world.bodies:
        _check_joints(body)
        moving = moving_links(body)
        for link in body.links:
            _check_link(link, body, link.name in moving)


def moving_links(body: Body) -> frozenset[str]:
    """The names of the links that can move."""
    parents = {joint.child: joint for joint in body.joints}

    def moves(name: str) -> bool:
        joint = parents.get(name)
        if joint is None:
            return not body.fixed
        return joint.kind != "fixed" or moves(joint.parent)

    return frozenset(link.name for link in body.links if moves(link.name))


def started(world: World) -> Iterator[str]:
    """The prims of bodies that move at first, or of which a joint does."""
    for body in world.bodies:
        if (not body.fixed and np.any(body.velocity)) or any(j.speed for j in body.joints):
            yield body.path


def sturdy_inertia(mass: MassProperties) -> Array:
    """(3, 3) the inertia, with a little more in every direction where it is that of a sheet.

    For a flat thing the greatest principal moment is the sum of the others, and rounding may push
    it beyond; Bullet and MuJoCo then refuse the tensor.
    """
    moments = np.linalg.eigvalsh(mass.inertia)
    slack = moments[0] + moments[1] - moments[2]
    lacking = max(0.0, 1e-6 * moments[2] - slack)
    return np.asarray(mass.inertia + lacking * np.eye(3))


def _check_link(link: Link, body: Body, moves: bool) -> None:
    if link.mass is None:
        if moves:
            _refuse("it can move, but has no mass", link.path, "give it a mass or a density")
    else:
        for problem in _impossible(link.mass):
            _refuse(problem, link.path, "give it a physically possible mass and inertia")
    _check_rigid(link.body_from_link, link.path)
    _check_rigid(body.world_from_body, body.path)
    _check_unique([shape.name for shape in link.shapes], "shapes", link.path)
    for shape in link.shapes:
        where = f"{link.path}/{shape.name}"
        if not np.isfinite(shape.mesh.points).all():
            _refuse("a point of its collider is not finite", where, "correct the mesh")
        if len(shape.mesh.triangles) < 4 or not _has_volume(shape.mesh):
            _refuse("the collider has no volume", where, "give it a thickness, or remove it")
        contact = shape.contact
        values = (contact.static_friction, contact.dynamic_friction, contact.restitution)
        if not all(np.isfinite(value) and value >= 0.0 for value in values):
            _refuse("friction or restitution is negative", where, "correct its physics material")


def _impossible(mass: MassProperties) -> Iterator[str]:
    if not (np.isfinite(mass.mass) and np.isfinite(mass.centre).all()):
        yield "the mass or the centre of mass is not finite"
        return
    if mass.mass <= 0.0:
        yield f"a mass of {mass.mass:g} kg"
    if not np.isfinite(mass.inertia).all():
        yield "the inertia is not finite"
        return
    small, middle, large = np.linalg.eigvalsh((mass.inertia + mass.inertia.T) / 2.0)
    if small <= 0.0:
        yield f"a principal moment of inertia of {small:g} kg m2"
    if large - small - middle > _MOMENT_TOLERANCE * large:
        yield f"a principal moment of {large:g} kg m2 above the sum of the others"


def _has_volume(mesh: TriangleMesh) -> bool:
    radius = float(np.linalg.norm(mesh.points - mesh.points.mean(axis=0), axis=1).max())
    return volume(mesh) > _MIN_VOLUME_SHARE * radius**3


def _check_rigid(M: Array, path: str) -> None:
    turn = M[:3, :3]
    rigid = np.isfinite(M).all() and np.allclose(turn @ turn.T, np.eye(3), atol=1e-6)
    if not rigid or np.linalg.det(turn) < 0.0:
        _refuse("its frame is not rigid", path, "apply scales and mirrors to its points")


def _check_joints(body: Body) -> None:
    _check_unique([link.name for link in body.links], "links", body.path)
    _check_unique([joint.name for joint in body.joints], "joints", body.path)
    if not body.links:
        _refuse("a body without links", body.path, "give it a prim that moves")
    known = {link.name for link in body.links}
    parents: dict[str, str] = {}
    for joint in body.joints:
        _check_joint(joint, known, body.path)
        if joint.child in parents or joint.child == body.links[0].name:
            message = f"joints form a loop: {joint.child!r} has more than one parent"
            _refuse(message, body.path, "remove the joint that closes the loop")
        parents[joint.child] = joint.parent
    for link in body.links[1:]:
        _check_hangs(link.name, parents, body)


def _check_hangs(name: str, parents: dict[str, str], body: Body) -> None:
    seen: list[str] = []
    at = name
    while at != body.links[0].name:
        if at in seen:
            _refuse(f"joints form a loop: {', '.join(seen)}", body.path, "remove one of them")
        if at not in parents:
            _refuse(f"no joint holds {at!r}", body.path, "join it, or make it a separate body")
        seen.append(at)
        at = parents[at]


def _check_joint(joint: Joint, known: set[str], path: str) -> None:
    for end in (joint.parent, joint.child):
        if end not in known:
            _refuse(f"joint {joint.name!r}: no link is named {end!r}", path, "correct its bodies")
    if joint.kind == "fixed":
        return
    low, high = joint.limits
    if not abs(float(np.linalg.norm(joint.axis)) - 1.0) < _MOMENT_TOLERANCE:
        _refuse(f"joint {joint.name!r}: its axis is not a unit vector", path, "correct its axis")
    if not low <= high:
        _refuse(f"joint {joint.name!r}: limits {low:g} to {high:g}", path, "swap its limits")
    if not (joint.damping >= 0.0 and joint.friction >= 0.0):
        _refuse(f"joint {joint.name!r}: negative damping or friction", path, "give 0 or more")


def _check_unique(names: list[str], kind: str, path: str) -> None:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        _refuse(f"{kind} of the same name: {', '.join(twice)}", path, "rename one of them")


def _refuse(message: str, place: str, remedy: str) -> None:
    raise StageError(message, place=place, remedy=remedy)
