"""What lies under things does not lift them."""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.steps.physics.layers import pass_layers
from openrooms_usd.usd.bodies import author_body
from openrooms_usd.usd.rigid.reading import read_world
from openrooms_usd.usd.semantics import label

Box = tuple[float, float, float, float, float, float]

# Category, least and greatest corner.
THINGS: dict[str, tuple[str, Box]] = {
    "rug": ("rug", (0, 0, 0, 2, 2, 0.02)),
    "bed": ("bed", (1, 1, 0, 3, 3, 0.5)),
    "beside": ("bed", (2.1, 0, 0, 3, 0.9, 0.5)),
    "lamp": ("floor_lamp", (0, 0, 0.02, 0.5, 0.5, 1.5)),
    "table": ("coffee_table", (0.5, 0.5, 0.0190, 0.9, 0.9, 0.4)),
    "throw": ("throw", (1, 1, 0.5, 2, 2, 0.53)),
    "tray": ("tray", (1.5, 1.5, 0.5, 1.8, 1.8, 0.53)),
}


@pytest.fixture
def stage() -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, "Z")
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    for name, (category, box) in THINGS.items():
        low, high = np.array(box, dtype=np.float64).reshape(2, 3)
        cube = UsdGeom.Cube.Define(stage, f"{names.FURNITURE}/{name}")
        cube.CreateSizeAttr(1.0)
        cube.AddTranslateOp().Set(Gf.Vec3d(*(0.5 * (low + high)).tolist()))
        cube.AddScaleOp().Set(Gf.Vec3f(*(high - low).tolist()))
        prim = cube.GetPrim()
        author_body(prim)
        label(prim, category)
    return stage


def test_layers_pass_what_the_same_support_holds(stage: Usd.Stage) -> None:
    """A bed half on a rug, and a tray in a throw; not the table that the rug carries."""
    pass_layers(stage, stage.GetPrimAtPath(names.FURNITURE).GetChildren())
    apart = {frozenset(body for body, _ in pair) for pair in read_world(stage).apart}
    assert apart == {frozenset({"rug", "bed"}), frozenset({"throw", "tray"})}
