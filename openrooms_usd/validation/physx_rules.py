"""What Isaac Sim's engine, PhysX, takes bodies and joints for, beside what USD's validators ask.

Each rule names its source: a requirement of NVIDIA's SimReady Foundation
(https://nvidia.github.io/simready-foundation/, chapters "Physics Bodies" and "Units"), or what
PhysX documents of reading USD (ovphysx 0.7, docs/population).
"""

import math
from collections.abc import Iterator
from typing import Final

from pxr import Gf, Usd, UsdGeom, UsdPhysics

from openrooms_usd.usd.places.frames import stated_metres
from openrooms_usd.validation.model import Complaint, Rule, Subject
from openrooms_usd.validation.stage_rules import moves

_UNITS: Final = ("metersPerUnit", "kilogramsPerUnit", "upAxis")
# What PhysX turns into a hull on a body that moves.
_TRIANGLES: Final = ("none", "meshSimplification")
_HINGE_DEG: Final = {"on the world": 180.0, "in an articulation": 360.0}
# What engines leave behind where a room has settled is less.
_APART_M: Final = 1e-3
_APART_DEG: Final = 0.5
_AXES: Final = {"X": Gf.Vec3d.XAxis(), "Y": Gf.Vec3d.YAxis(), "Z": Gf.Vec3d.ZAxis()}


def units(subject: Subject) -> Iterator[Complaint]:
    """The root layer of a stage with bodies says its units (UN.001, UN.002, UN.003)."""
    if any(prim.HasAPI(UsdPhysics.RigidBodyAPI) for prim in subject.prims):
        for key in _UNITS:
            if not subject.root.pseudoRoot.HasInfo(key):
                yield subject.name(subject.root), f"it has bodies and does not author {key}"


def scenes(subject: Subject) -> Iterator[Complaint]:
    """Bodies have one scene, whose gravity is theirs (PhysicsScene)."""
    found = [prim for prim in subject.prims if prim.IsA(UsdPhysics.Scene)]
    bodies = [prim for prim in subject.prims if moves(prim)]
    if bodies and not found:
        yield str(bodies[0].GetPath()), "a body moves, and the stage has no PhysicsScene"
    for prim in found[1:]:
        yield str(prim.GetPath()), f"a second PhysicsScene beside {found[0].GetPath()}"


def shapes_of_bodies(subject: Subject) -> Iterator[Complaint]:
    """What moves has a shape that collides (RB.013)."""
    for prim in filter(moves, subject.prims):
        if not any(own.HasAPI(UsdPhysics.CollisionAPI) for own in _own(prim)):
            yield str(prim.GetPath()), "it moves and has no collider: it falls through everything"


def masses(subject: Subject) -> Iterator[Complaint]:
    """What moves says its mass, or its shapes do; never a negative one (RB.007, RB.011)."""
    for prim in filter(moves, subject.prims):
        said = [mass for own in _own(prim) if (mass := _mass(own)) is not None]
        if not any(mass > 0.0 for mass in said):
            yield str(prim.GetPath()), "neither it nor its shapes author a mass"
        if any(mass < 0.0 for mass in said):
            yield str(prim.GetPath()), "a mass is negative"


def _mass(prim: Usd.Prim) -> float | None:
    if not prim.HasAPI(UsdPhysics.MassAPI):
        return None
    value = UsdPhysics.MassAPI(prim).GetMassAttr().Get()
    return None if value is None else float(value)


def kinds_of_shapes(subject: Subject) -> Iterator[Complaint]:
    """Colliders are geometry, and mesh colliders meshes (RB.COL.001, RB.COL.003)."""
    for prim in subject.prims:
        if prim.HasAPI(UsdPhysics.CollisionAPI) and not prim.IsA(UsdGeom.Gprim):
            yield str(prim.GetPath()), f"{_word(prim)} cannot collide: only geometry does"
        if prim.HasAPI(UsdPhysics.MeshCollisionAPI) and not prim.IsA(UsdGeom.Mesh):
            yield str(prim.GetPath()), f"{_word(prim)} has the collision of a mesh"


def moving_triangles(subject: Subject) -> Iterator[Complaint]:
    """Meshes of what moves are approximated (PhysicsMeshCollisionAPI: else by one hull)."""
    for body in filter(moves, subject.prims):
        for prim in _own(body):
            if prim.IsA(UsdGeom.Mesh) and prim.HasAPI(UsdPhysics.CollisionAPI):
                api = UsdPhysics.MeshCollisionAPI(prim)
                how = api.GetApproximationAttr().Get() if api else "none"
                if how in _TRIANGLES:
                    text = f"its body moves, so that {how} becomes the hull of the whole"
                    yield str(prim.GetPath()), text


def articulation_roots(subject: Subject) -> Iterator[Complaint]:
    """A root stands on a body that moves, on a joint to the world, or above (JT.ART.003, .004)."""
    for prim in subject.prims:
        if prim.HasAPI(UsdPhysics.ArticulationRootAPI):
            if prim.HasAPI(UsdPhysics.RigidBodyAPI) and not moves(prim):
                yield str(prim.GetPath()), "an articulation's root on a body that does not move"
            elif not any(moves(own) or own.IsA(UsdPhysics.Joint) for own in _below(prim)):
                yield str(prim.GetPath()), "an articulation's root with no body and no joint"


def joint_frames(subject: Subject) -> Iterator[Complaint]:
    """Both frames of a hinge or rail are one, but for its own motion within limits (DJ.003)."""
    metres = stated_metres(subject.stage)
    for prim in subject.prims:
        if (hinge := UsdPhysics.RevoluteJoint(prim)) or (rail := UsdPhysics.PrismaticJoint(prim)):
            joint = hinge or rail
            between = _between(UsdPhysics.Joint(prim))
            if between is not None:
                yield from _misfits(joint, between, metres, turns=bool(hinge))


def _misfits(
    joint: UsdPhysics.RevoluteJoint | UsdPhysics.PrismaticJoint,
    between: Gf.Matrix4d,
    metres: float,
    *,
    turns: bool,
) -> Iterator[Complaint]:
    axis = _AXES[joint.GetAxisAttr().Get()]
    shift = between.ExtractTranslation()
    along = Gf.Dot(shift, axis)
    across = (shift if turns else shift - along * axis).GetLength() * metres
    turn = between.ExtractRotation()
    angle = turn.GetAngle() * (1.0 if Gf.Dot(turn.GetAxis(), axis) >= 0.0 else -1.0)
    tilt = Gf.Rotation(axis, turn.TransformDir(axis)).GetAngle() if turns else abs(angle)
    place = str(joint.GetPath())
    if across > _APART_M:
        yield place, f"its two frames lie {1e3 * across:.2g} mm apart"
    if tilt > _APART_DEG:
        yield place, f"its two frames differ by {tilt:.2g} degrees"
    value, near = (angle, _APART_DEG) if turns else (along, _APART_M / metres)
    # A rotation says no whole turns.
    values = [value + whole for whole in ((-360.0, 0.0, 360.0) if turns else (0.0,))]
    low, high = joint.GetLowerLimitAttr().Get(), joint.GetUpperLimitAttr().Get()
    if low <= high and not any(low - near <= each <= high + near for each in values):
        yield place, f"its position {value:.3g} is outside its limits {low:g} to {high:g}"


def _between(joint: UsdPhysics.Joint) -> Gf.Matrix4d | None:
    """The frame on body1 as that on body0 sees it, without scales; None where a body is missing."""
    frames = []
    for targets, shift, turn in (
        (joint.GetBody0Rel(), joint.GetLocalPos0Attr(), joint.GetLocalRot0Attr()),
        (joint.GetBody1Rel(), joint.GetLocalPos1Attr(), joint.GetLocalRot1Attr()),
    ):
        world, paths = Gf.Matrix4d(1.0), targets.GetTargets()
        if paths:
            body = joint.GetPrim().GetStage().GetPrimAtPath(paths[0])
            if not body:
                return None
            world = UsdGeom.Xformable(body).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
        rotation = Gf.Rotation(Gf.Quatd(turn.Get().GetNormalized()))
        local = Gf.Matrix4d(rotation, Gf.Vec3d(0.0))
        rigid = local * world.RemoveScaleShear()
        rigid.SetTranslateOnly(world.Transform(Gf.Vec3d(shift.Get())))
        frames.append(rigid)
    return frames[1] * frames[0].GetInverse()


def joint_limits(subject: Subject) -> Iterator[Complaint]:
    """Limits are in order; hinges stay within what PhysX turns (PhysicsRevoluteJoint)."""
    for prim in subject.prims:
        hinge, rail = UsdPhysics.RevoluteJoint(prim), UsdPhysics.PrismaticJoint(prim)
        if not hinge and not rail:
            continue
        joint = hinge or rail
        low, high = joint.GetLowerLimitAttr().Get(), joint.GetUpperLimitAttr().Get()
        if low > high:
            yield str(prim.GetPath()), f"its limits {low:g} to {high:g} leave no range"
        finite = [abs(limit) for limit in (low, high) if math.isfinite(limit)]
        where = _where(UsdPhysics.Joint(prim))
        if hinge and finite and max(finite) > _HINGE_DEG[where]:
            text = f"a hinge {where} stops at {_HINGE_DEG[where]:g} degrees, not at {max(finite):g}"
            yield str(prim.GetPath()), text


def _where(joint: UsdPhysics.Joint) -> str:
    stage = joint.GetPrim().GetStage()
    for relation in (joint.GetBody0Rel(), joint.GetBody1Rel()):
        prims = [stage.GetPrimAtPath(path) for path in relation.GetTargets()[:1]]
        if not any(prim and moves(prim) for prim in prims):
            return "on the world"
    return "in an articulation"


def drives(subject: Subject) -> Iterator[Complaint]:
    """Drives are finite and pull to where their joint can go, in degrees (DJ.001, DJ.006)."""
    for prim in subject.prims:
        for kind, joint in (
            ("angular", UsdPhysics.RevoluteJoint(prim)),
            ("linear", UsdPhysics.PrismaticJoint(prim)),
        ):
            if joint and prim.HasAPI(UsdPhysics.DriveAPI, kind):
                yield from _drive(UsdPhysics.DriveAPI(prim, kind), joint)
            elif prim.HasAPI(UsdPhysics.DriveAPI, kind) and _other(prim, kind):
                yield (
                    str(prim.GetPath()),
                    f"a drive of the kind {kind} has no effect on {_word(prim)}",
                )


def _other(prim: Usd.Prim, kind: str) -> bool:
    other = UsdPhysics.PrismaticJoint if kind == "angular" else UsdPhysics.RevoluteJoint
    return bool(prim.IsA(other))


def _drive(
    drive: UsdPhysics.DriveAPI, joint: UsdPhysics.RevoluteJoint | UsdPhysics.PrismaticJoint
) -> Iterator[Complaint]:
    place = str(joint.GetPath())
    stiffness, damping = drive.GetStiffnessAttr().Get(), drive.GetDampingAttr().Get()
    if not (0.0 <= stiffness < math.inf and 0.0 <= damping < math.inf):
        yield place, f"its drive has a stiffness of {stiffness:g} and a damping of {damping:g}"
    if not drive.GetMaxForceAttr().Get() > 0.0:
        yield place, "its drive has no force"
    low, high = joint.GetLowerLimitAttr().Get(), joint.GetUpperLimitAttr().Get()
    target = drive.GetTargetPositionAttr().Get()
    if stiffness > 0.0 and not low <= target <= high:
        yield place, f"its drive targets {target:g}, outside its limits {low:g} to {high:g}"


def _below(prim: Usd.Prim) -> Iterator[Usd.Prim]:
    yield from Usd.PrimRange(prim, Usd.TraverseInstanceProxies())


def _own(body: Usd.Prim) -> Iterator[Usd.Prim]:
    """A body and all below it that is not of another body."""
    walk = iter(Usd.PrimRange(body, Usd.TraverseInstanceProxies()))
    for prim in walk:
        if prim != body and moves(prim):
            walk.PruneChildren()
        else:
            yield prim


def _word(prim: Usd.Prim) -> str:
    return f"a {prim.GetTypeName() or 'prim without a type'}"


PHYSX_RULES: Final = (
    Rule("physics-units", units, "write it into the root layer: USD's fallback is centimetres"),
    Rule("physics-scene", scenes, "define one PhysicsScene with the gravity"),
    Rule("body-shape", shapes_of_bodies, "apply PhysicsCollisionAPI to a shape of it"),
    Rule("body-mass", masses, "apply PhysicsMassAPI with mass, centre and inertia"),
    Rule("shape-type", kinds_of_shapes, "apply it to the geometry below"),
    Rule("moving-mesh", moving_triangles, "use convex pieces: convexHull, or a box"),
    Rule("articulation-root", articulation_roots, "apply it to the body that carries the others"),
    Rule("joint-frames", joint_frames, "recompute localPos and localRot from the bodies' poses"),
    Rule("joint-limits", joint_limits, "put the joint's zero in the middle of its range"),
    Rule("joint-drive", drives, "units are N m/degree and degrees, or N/m and metres"),
)
"""In the order of docs/reference/physics.md."""
