"""Rules about bodies and joints that engines refuse rooms for, beside those of USD's validators."""

from collections.abc import Iterator

from pxr import Sdf, Usd, UsdGeom, UsdPhysics

from openrooms_usd.validation.model import Complaint, Subject


def nested_bodies(subject: Subject) -> Iterator[Complaint]:
    """No body that moves lies below another one, unless it leaves its parent's transform."""
    for prim in subject.prims:
        if moves(prim) and (outer := _outer(prim)):
            yield str(prim.GetPath()), f"a rigid body below the rigid body {outer.GetPath()}"


def _outer(body: Usd.Prim) -> Usd.Prim | None:
    prim = body
    while prim and not UsdGeom.Xformable(prim).GetResetXformStack():
        prim = prim.GetParent()
        if prim and moves(prim):
            return prim
    return None


def articulations(subject: Subject) -> Iterator[Complaint]:
    """Bodies that joints hold to each other are in an articulation; joints to the world need none.

    Its root stands on one of the bodies or joints, or above one.
    """
    group: dict[Sdf.Path, Sdf.Path] = {}
    joints: dict[Sdf.Path, Sdf.Path] = {}
    for prim in subject.prims:
        ends = _joined(prim)
        if len(ends) == 2:
            joints[prim.GetPath()] = ends[0]
            group[_top(group, ends[0])] = _top(group, ends[1])
    rooted = {
        _top(group, body)
        for joint, body in joints.items()
        if any(_has_root(subject.stage.GetPrimAtPath(path)) for path in (joint, body))
    }
    rooted |= {_top(group, body) for body in group if _has_root(subject.stage.GetPrimAtPath(body))}
    for joint, body in joints.items():
        if _top(group, body) not in rooted:
            yield str(joint), "joins two bodies that belong to no articulation"


def _joined(prim: Usd.Prim) -> list[Sdf.Path]:
    """The distinct bodies that move which a joint holds together, first what holds."""
    joint = UsdPhysics.Joint(prim)
    if not joint or not joint.GetJointEnabledAttr().Get():
        return []
    if joint.GetExcludeFromArticulationAttr().Get():
        return []
    found: dict[Sdf.Path, None] = {}
    for relation in (joint.GetBody0Rel(), joint.GetBody1Rel()):
        for target in relation.GetTargets()[:1]:
            body = prim.GetStage().GetPrimAtPath(target)
            while body and not moves(body):
                body = body.GetParent()
            if body:
                found[body.GetPath()] = None
    return list(found)


def moves(prim: Usd.Prim) -> bool:
    """Whether a prim is a body that forces move: enabled and not kinematic."""
    body = UsdPhysics.RigidBodyAPI(prim) if prim.HasAPI(UsdPhysics.RigidBodyAPI) else None
    if body is None or not body.GetRigidBodyEnabledAttr().Get():
        return False
    return not body.GetKinematicEnabledAttr().Get()


def _has_root(prim: Usd.Prim) -> bool:
    while prim and not prim.IsPseudoRoot():
        if prim.HasAPI(UsdPhysics.ArticulationRootAPI):
            return True
        prim = prim.GetParent()
    return False


def _top(group: dict[Sdf.Path, Sdf.Path], body: Sdf.Path) -> Sdf.Path:
    while (above := group.setdefault(body, body)) != body:
        body = above
    return body
