"""Each rule about what PhysX takes finds what breaks it, and nothing in a cabinet with a door."""

from collections.abc import Callable

import pytest
from pxr import Gf, Usd, UsdGeom, UsdPhysics

from openrooms_usd.validation.model import Subject
from openrooms_usd.validation.physx_rules import PHYSX_RULES

CASE, DOOR, HINGE = "/World/case", "/World/door", "/World/hinge"


@pytest.fixture
def stage() -> Usd.Stage:
    """A case of 40 cm with a door on its left edge that stands 30 degrees open, on the floor."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    UsdGeom.Xform.Define(stage, "/World")
    UsdPhysics.Scene.Define(stage, "/World/Scene")
    for path in (CASE, DOOR):
        body = UsdGeom.Xform.Define(stage, path)
        UsdPhysics.RigidBodyAPI.Apply(body.GetPrim())
        UsdPhysics.MassAPI.Apply(body.GetPrim()).CreateMassAttr(5.0)
        shape = UsdGeom.Mesh.Define(stage, f"{path}/shape").GetPrim()
        UsdPhysics.CollisionAPI.Apply(shape)
        UsdPhysics.MeshCollisionAPI.Apply(shape).CreateApproximationAttr("convexHull")
    UsdPhysics.ArticulationRootAPI.Apply(stage.GetPrimAtPath(CASE))
    UsdGeom.Xformable(stage.GetPrimAtPath(CASE)).AddTranslateOp().Set((1.0, 2.0, 0.2))
    door = UsdGeom.Xformable(stage.GetPrimAtPath(DOOR))
    door.AddTranslateOp().Set((0.8, 1.8, 0.2))
    door.AddRotateZOp().Set(30.0)
    joint = UsdPhysics.RevoluteJoint.Define(stage, HINGE)
    joint.CreateBody0Rel().SetTargets([CASE])
    joint.CreateBody1Rel().SetTargets([DOOR])
    joint.CreateAxisAttr("Z")
    joint.CreateLocalPos0Attr((-0.2, -0.2, 0.0))
    joint.CreateLocalPos1Attr((0.0, 0.0, 0.0))
    joint.CreateLocalRot0Attr(Gf.Quatf(1.0))
    joint.CreateLocalRot1Attr(Gf.Quatf(1.0))
    joint.CreateLowerLimitAttr(0.0)
    joint.CreateUpperLimitAttr(110.0)
    drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), "angular")
    drive.CreateDampingAttr(0.1)
    return stage


def found(stage: Usd.Stage) -> dict[str, list[str]]:
    checked = {
        rule.code: [place for place, _ in rule.check(Subject(stage))] for rule in PHYSX_RULES
    }
    return {code: places for code, places in checked.items() if places}


def test_a_cabinet_breaks_no_rule(stage: Usd.Stage) -> None:
    assert found(stage) == {}


def test_what_does_not_move_needs_no_body(stage: Usd.Stage) -> None:
    for path in (CASE, DOOR):
        stage.GetPrimAtPath(path).RemoveAPI(UsdPhysics.RigidBodyAPI)
        stage.GetPrimAtPath(path).RemoveAPI(UsdPhysics.ArticulationRootAPI)
        stage.GetPrimAtPath(f"{path}/shape").RemoveAPI(UsdPhysics.MeshCollisionAPI)
    stage.RemovePrim("/World/Scene")
    stage.ClearMetadata("metersPerUnit")
    assert found(stage) == {}


def joint(stage: Usd.Stage) -> UsdPhysics.RevoluteJoint:
    return UsdPhysics.RevoluteJoint(stage.GetPrimAtPath(HINGE))


def drive(stage: Usd.Stage) -> UsdPhysics.DriveAPI:
    return UsdPhysics.DriveAPI(stage.GetPrimAtPath(HINGE), "angular")


def body(stage: Usd.Stage, path: str) -> UsdPhysics.RigidBodyAPI:
    return UsdPhysics.RigidBodyAPI(stage.GetPrimAtPath(path))


def hang_on_the_world(stage: Usd.Stage) -> None:
    stage.GetPrimAtPath(CASE).RemoveAPI(UsdPhysics.RigidBodyAPI)
    stage.GetPrimAtPath(CASE).RemoveAPI(UsdPhysics.ArticulationRootAPI)
    joint(stage).GetUpperLimitAttr().Set(270.0)


def turn_the_door(stage: Usd.Stage, degrees: float) -> None:
    stage.GetPrimAtPath(DOOR).GetAttribute("xformOp:rotateZ").Set(degrees)


# What is broken: the rule, where it says so, and how.
Break = Callable[[Usd.Stage], object]
BREAKS: tuple[tuple[str, str, Break], ...] = (
    ("physics-units", "", lambda s: s.ClearMetadata("kilogramsPerUnit")),
    ("physics-units", "", lambda s: s.ClearMetadata("metersPerUnit")),
    ("physics-scene", CASE, lambda s: s.RemovePrim("/World/Scene")),
    ("physics-scene", "/World/Second", lambda s: UsdPhysics.Scene.Define(s, "/World/Second")),
    ("body-shape", DOOR, lambda s: s.RemovePrim(f"{DOOR}/shape")),
    ("body-mass", DOOR, lambda s: s.GetPrimAtPath(DOOR).RemoveAPI(UsdPhysics.MassAPI)),
    (
        "body-mass",
        DOOR,
        lambda s: UsdPhysics.MassAPI(s.GetPrimAtPath(DOOR)).GetMassAttr().Set(-1.0),
    ),
    ("shape-type", CASE, lambda s: UsdPhysics.CollisionAPI.Apply(s.GetPrimAtPath(CASE))),
    ("shape-type", f"{DOOR}/shape", lambda s: UsdGeom.Cube.Define(s, f"{DOOR}/shape")),
    (
        "moving-mesh",
        f"{DOOR}/shape",
        lambda s: s.GetPrimAtPath(f"{DOOR}/shape").RemoveAPI(UsdPhysics.MeshCollisionAPI),
    ),
    ("articulation-root", CASE, lambda s: body(s, CASE).CreateKinematicEnabledAttr(True)),
    (
        "articulation-root",
        "/World/Scene",
        lambda s: UsdPhysics.ArticulationRootAPI.Apply(s.GetPrimAtPath("/World/Scene")),
    ),
    ("joint-frames", HINGE, lambda s: joint(s).GetLocalPos1Attr().Set((0.0, 0.0, 0.01))),
    (
        "joint-frames",
        HINGE,
        lambda s: joint(s).GetLocalRot1Attr().Set(Gf.Quatf(0.7071068, 0.7071068, 0.0, 0.0)),
    ),
    ("joint-frames", HINGE, lambda s: turn_the_door(s, -5.0)),
    ("joint-limits", HINGE, lambda s: joint(s).GetLowerLimitAttr().Set(120.0)),
    ("joint-limits", HINGE, hang_on_the_world),
    ("joint-drive", HINGE, lambda s: drive(s).CreateMaxForceAttr(0.0)),
    ("joint-drive", HINGE, lambda s: drive(s).CreateDampingAttr(float("nan"))),
    # Radians where degrees are meant would be inside; degrees beyond the limit are not.
    (
        "joint-drive",
        HINGE,
        lambda s: (drive(s).CreateStiffnessAttr(1.0), drive(s).CreateTargetPositionAttr(115.0)),
    ),
    ("joint-drive", HINGE, lambda s: UsdPhysics.DriveAPI.Apply(s.GetPrimAtPath(HINGE), "linear")),
)


@pytest.mark.parametrize(
    ("code", "place", "breaks"), BREAKS, ids=[f"{n}-{b[0]}" for n, b in enumerate(BREAKS)]
)
def test_a_rule_finds_what_breaks_it(
    code: str, place: str, breaks: Break, stage: Usd.Stage
) -> None:
    breaks(stage)
    hits = found(stage)
    assert code in hits
    assert not place or place in hits[code]


def test_every_rule_has_a_stage_that_breaks_it() -> None:
    assert {code for code, _, _ in BREAKS} == {rule.code for rule in PHYSX_RULES}


@pytest.mark.parametrize("shift", [0.0, 0.05, 0.3])
def test_a_drawer_may_stand_open_within_its_limits(shift: float, stage: Usd.Stage) -> None:
    stage.RemovePrim(HINGE)
    rail = UsdPhysics.PrismaticJoint.Define(stage, "/World/rail")
    rail.CreateBody0Rel().SetTargets([CASE])
    rail.CreateBody1Rel().SetTargets([DOOR])
    rail.CreateAxisAttr("Y")
    rail.CreateLowerLimitAttr(0.0)
    rail.CreateUpperLimitAttr(0.2)
    stage.GetPrimAtPath(DOOR).GetAttribute("xformOp:translate").Set((1.0, 2.0 + shift, 0.2))
    turn_the_door(stage, 0.0)
    assert found(stage) == ({} if shift <= 0.2 else {"joint-frames": ["/World/rail"]})
