"""Bodies of a gram, whose moments of inertia are near the rounding of floats."""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdPhysics

from openrooms_usd.physics.mass import MassProperties
from openrooms_usd.usd.rigid.reading import read_world

SIDE = 0.02
MOMENTS = np.array([6e-8, 7e-8, 8e-8])


@pytest.fixture
def stage() -> Usd.Stage:
    """A cube of a gram that says all of its mass itself."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, "Z")
    cube = UsdGeom.Cube.Define(stage, "/crumb")
    cube.CreateSizeAttr(1.0)
    cube.AddScaleOp().Set(Gf.Vec3f(SIDE))
    prim = cube.GetPrim()
    UsdPhysics.RigidBodyAPI.Apply(prim)
    UsdPhysics.CollisionAPI.Apply(prim)
    said = UsdPhysics.MassAPI.Apply(prim)
    said.CreateMassAttr(1e-3)
    said.CreateCenterOfMassAttr(Gf.Vec3f(1, 0, 0))
    said.CreateDiagonalInertiaAttr(Gf.Vec3f(*MOMENTS))
    return stage


def mass_of(stage: Usd.Stage) -> MassProperties:
    found = read_world(stage).bodies[0].links[0].mass
    assert found is not None
    return found


def test_its_inertia_is_what_it_says(stage: Usd.Stage) -> None:
    """USD's own computation takes such moments for unsaid."""
    found = mass_of(stage)
    assert found.mass == pytest.approx(1e-3)
    np.testing.assert_allclose(found.centre, [SIDE, 0, 0], rtol=1e-6)
    np.testing.assert_allclose(found.inertia, np.diag(MOMENTS), rtol=1e-6)


def test_its_axes_are_what_it_says(stage: Usd.Stage) -> None:
    """A quarter turn about Z changes X with Y."""
    quarter = Gf.Quatf(0.5**0.5, 0, 0, 0.5**0.5)
    UsdPhysics.MassAPI(stage.GetPrimAtPath("/crumb")).CreatePrincipalAxesAttr(quarter)
    np.testing.assert_allclose(mass_of(stage).inertia, np.diag(MOMENTS[[1, 0, 2]]), atol=1e-14)
