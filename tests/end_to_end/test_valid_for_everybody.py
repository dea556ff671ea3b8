"""Whole rooms with physics, as the validators of USD and of NVIDIA see them."""

from collections.abc import Callable
from pathlib import Path

import pytest
from pxr import Usd, UsdGeom, UsdPhysics, Vt

from tests.validators import LEFT_OUT, nvidia_issues


@pytest.mark.slow
def test_a_small_room_with_bodies(
    composed_bodies: Path, assert_valid: Callable[[Path], None]
) -> None:
    assert_valid(composed_bodies)


@pytest.mark.slow
def test_the_whole_example(demo: Path, assert_valid: Callable[[Path], None]) -> None:
    assert_valid(demo)


@pytest.mark.slow
def test_rules_that_are_left_out_do_no_more_than_warn(composed_bodies: Path) -> None:
    found = {tuple(issue.split()[:2]) for issue in nvidia_issues(composed_bodies, without={})}
    assert found == {("WARNING", rule) for rule in LEFT_OUT}


@pytest.mark.slow
def test_collision_shapes_and_joints_are_looked_at(composed_bodies: Path) -> None:
    stage = Usd.Stage.Open(str(composed_bodies))
    stage.SetEditTarget(stage.GetSessionLayer())
    below = Usd.PrimRange(stage.GetPrimAtPath("/World/Room/Physics"))
    shape, other = [p for p in below if p.HasAPI(UsdPhysics.CollisionAPI)][:2]
    UsdGeom.Mesh(shape).GetNormalsAttr().Block()
    points = UsdGeom.Mesh(other).GetPointsAttr()
    points.Set(Vt.Vec3fArray([points.Get()[0]] * len(points.Get())))
    for path in ("/World", "/World/Room"):
        UsdPhysics.ArticulationRootAPI.Apply(stage.GetPrimAtPath(path))
    found = {issue.split()[1] for issue in nvidia_issues(stage)}
    assert found >= {"NormalsExistChecker", "ZeroAreaFaceChecker", "ArticulationChecker"}
