"""Which joints ask for an articulation, and which bodies lie in others."""

import pytest
from pxr import Sdf, Usd, UsdGeom, UsdPhysics

from openrooms_usd.validation.model import Subject
from openrooms_usd.validation.stage_rules import articulations, nested_bodies

BODIES = ("/World/case", "/World/door", "/World/knob")


@pytest.fixture
def stage() -> Usd.Stage:
    """A knob on a door on a case: three bodies, two joints."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.Xform.Define(stage, "/World")
    for path in BODIES:
        UsdPhysics.RigidBodyAPI.Apply(UsdGeom.Cube.Define(stage, path).GetPrim())
    for name, ends in (("hinge", BODIES[:2]), ("screw", BODIES[1:])):
        joint = UsdPhysics.RevoluteJoint.Define(stage, f"/World/{name}")
        joint.CreateBody0Rel().SetTargets([ends[0]])
        joint.CreateBody1Rel().SetTargets([ends[1]])
    return stage


def complaints(stage: Usd.Stage) -> list[str]:
    return [place for place, _ in articulations(Subject(stage))]


def test_all_joints_of_a_chain_ask_for_one_root(stage: Usd.Stage) -> None:
    assert complaints(stage) == ["/World/hinge", "/World/screw"]


@pytest.mark.parametrize("place", [*BODIES, "/World", "/World/hinge"])
def test_one_root_anywhere_is_enough(stage: Usd.Stage, place: str) -> None:
    UsdPhysics.ArticulationRootAPI.Apply(stage.GetPrimAtPath(place))
    assert complaints(stage) == []


def test_a_root_elsewhere_is_none(stage: Usd.Stage) -> None:
    UsdPhysics.ArticulationRootAPI.Apply(UsdGeom.Xform.Define(stage, "/World/robot").GetPrim())
    assert complaints(stage) == ["/World/hinge", "/World/screw"]


def test_what_hangs_on_the_world_needs_none(stage: Usd.Stage) -> None:
    """A body that does not move, is disabled or is animated is the world to a joint."""
    stage.GetPrimAtPath("/World/case").RemoveAPI(UsdPhysics.RigidBodyAPI)
    UsdPhysics.RigidBodyAPI(stage.GetPrimAtPath("/World/knob")).CreateKinematicEnabledAttr(True)
    assert complaints(stage) == []


@pytest.mark.parametrize(
    ("key", "value"), [("jointEnabled", False), ("excludeFromArticulation", True)]
)
def test_joints_that_say_so_need_none(stage: Usd.Stage, key: str, value: bool) -> None:
    stage.GetPrimAtPath("/World/hinge").GetAttribute(f"physics:{key}").Set(value)
    assert complaints(stage) == ["/World/screw"]


def test_a_body_in_a_body_is_named_unless_it_leaves_its_parents_transform() -> None:
    stage = Usd.Stage.CreateInMemory()
    paths = [Sdf.Path("/a"), Sdf.Path("/a/b/c")]
    for path in paths:
        UsdPhysics.RigidBodyAPI.Apply(UsdGeom.Xform.Define(stage, path).GetPrim())
    assert [place for place, _ in nested_bodies(Subject(stage))] == ["/a/b/c"]
    UsdGeom.Xformable(stage.GetPrimAtPath("/a/b/c")).SetResetXformStack(True)
    assert not list(nested_bodies(Subject(stage)))
