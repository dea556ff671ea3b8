"""UsdPhysicsMaterialAPI on materials: what is authored is read, by us and by the standard."""

import math
from collections.abc import Iterator

import pytest
from pxr import Sdf, Usd, UsdPhysics, UsdShade

from openrooms_usd import names
from openrooms_usd.usd import physics
from openrooms_usd.usd.physics import MaterialPhysics

OAK = MaterialPhysics(0.5, 0.375, 0.625, 720.0, friction_spread=0.125)


@pytest.fixture
def prim() -> Iterator[Usd.Prim]:
    stage = Usd.Stage.CreateInMemory()
    yield UsdShade.Material.Define(stage, "/World/Materials/oak").GetPrim()


def test_round_trip(prim):
    assert physics.read(prim) is None
    physics.author(prim, OAK)
    assert physics.read(prim) == OAK
    standard = UsdPhysics.MaterialAPI(prim)
    assert standard.GetDynamicFrictionAttr().Get() == 0.375
    assert standard.GetDensityAttr().Get() == 720.0
    spread = prim.GetAttribute("openrooms:material:frictionSpread")
    assert spread.GetTypeName() == Sdf.ValueTypeNames.Float and not spread.IsCustom()
    # Without the plugin of our schemas USD lists only those that it knows.
    assert names.MATERIAL_API in prim.GetMetadata("apiSchemas").GetAppliedItems()


def test_without_spread_it_is_the_standard_alone(prim):
    physics.author(prim, MaterialPhysics(0.5, 0.25, 0.0, 0.0))
    assert prim.GetMetadata("apiSchemas").GetAppliedItems() == ["PhysicsMaterialAPI"]
    assert physics.read(prim) == MaterialPhysics(0.5, 0.25, 0.0, 0.0, None)


@pytest.mark.parametrize(
    "wrong",
    [
        {"dynamic_friction": 0.6},
        {"dynamic_friction": -0.1},
        {"static_friction": math.nan},
        {"static_friction": math.inf},
        {"restitution": 1.1},
        {"density": -1.0},
        {"density": math.nan},
        {"friction_spread": -0.1},
        {"friction_spread": math.nan},
    ],
    ids=str,
)
def test_what_no_surface_has(prim, wrong):
    with pytest.raises(ValueError, match="no "):
        physics.author(prim, MaterialPhysics(**{**OAK.__dict__, **wrong}))
    assert prim.GetAppliedSchemas() == []


def test_a_foreign_file_that_says_little_or_nonsense(prim):
    UsdPhysics.MaterialAPI.Apply(prim)
    assert physics.read(prim) == MaterialPhysics(0.0, 0.0, 0.0, 0.0, None)
    prim.CreateAttribute("physics:staticFriction", Sdf.ValueTypeNames.Float).Set(math.nan)
    prim.CreateAttribute("physics:density", Sdf.ValueTypeNames.Float).Set(-3.0)
    assert physics.read(prim) == MaterialPhysics(0.0, 0.0, 0.0, 0.0, None)


def test_category(prim):
    assert physics.read_category(prim) is None
    prim.CreateAttribute(names.MATERIAL_CATEGORY, Sdf.ValueTypeNames.Token).Set("wood")
    assert physics.read_category(prim) == "wood"
