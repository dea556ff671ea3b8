"""What is hardly meant is told with its numbers, and what is usual is not."""

import pytest
from pxr import Gf, Usd, UsdGeom, UsdRender

from openrooms_usd.rendering.scene.cameras import camera_losses
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.rendering.scene.unseen import is_alarming
from openrooms_usd.rules import check
from openrooms_usd.usd.cameras import read_camera
from openrooms_usd.usd.doubts import DOUBT, camera_doubts
from tests import small

# Of Omniverse's camera: millimetres.
MILLIMETRES = {"focalLength": 24.0, "horizontalAperture": 20.955, "verticalAperture": 15.2908}


def camera(metres: float = 1.0, **said: float) -> UsdGeom.Camera:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, metres)
    made = UsdGeom.Camera.Define(stage, "/Camera")
    for name, value in said.items():
        made.GetPrim().GetAttribute(name).Set(value)
    KEPT.append(stage)
    return made


KEPT: list[Usd.Stage] = []


def doubts(made: UsdGeom.Camera) -> list[str]:
    return list(camera_doubts(made.GetPrim()))


def test_a_lens_in_millimetres_where_tenths_of_a_metre_count() -> None:
    made = camera(**MILLIMETRES, fStop=1.8)
    (told,) = doubts(made)
    assert "0.667 m" in told and "write 0.24" in told and is_alarming(told) and ";" not in told
    # The remedies that it names help.
    made.GetFStopAttr().Set(0.0)
    assert doubts(made) == []
    right = {name: 0.01 * value for name, value in MILLIMETRES.items()}
    assert doubts(camera(**right, fStop=1.8)) == []
    assert doubts(camera(0.01, **MILLIMETRES, fStop=1.8)) == []
    assert read_camera(camera(**right, fStop=1.8).GetPrim(), 8, 8).lens_radius == pytest.approx(
        0.024 / 3.6
    )


@pytest.mark.parametrize(
    ("said", "number"),
    [
        ({"focalLength": 24000.0}, "0.05 degrees"),
        ({"focalLength": 0.05}, "179 degrees"),
        ({"exposure": 15.0}, "3.28e+04"),
        ({"exposure": -40.0}, "9.09e-13"),
    ],
)
def test_extremes_are_told(said: dict[str, float], number: str) -> None:
    (told,) = doubts(camera(**({"horizontalAperture": 20.955} | said)))
    assert number in told and DOUBT in told


@pytest.mark.parametrize("said", [{}, {"exposure": -7.0}, {"focalLength": 600.0}, {"fStop": 22.0}])
def test_what_is_usual_is_not(said: dict[str, float]) -> None:
    assert doubts(camera(0.01, **said)) == []


def test_the_field_is_that_of_the_picture() -> None:
    """As the stage's render settings conform apertures."""
    made = camera(focalLength=0.24, horizontalAperture=20.955, verticalAperture=0.2)
    assert "degrees" in doubts(made)[0]
    settings = UsdRender.Settings.Define(made.GetPrim().GetStage(), "/Render")
    settings.CreateAspectRatioConformPolicyAttr("adjustApertureWidth")
    made.GetPrim().GetStage().SetMetadata("renderSettingsPrimPath", "/Render")
    assert doubts(made) == []


@pytest.mark.parametrize(
    ("near", "far", "is_told"),
    [(0.01, 100, False), (5, 100, True), (0.01, 0.5, True), (2.5, 9, False)],
)
def test_clipping_that_hides_all(near: float, far: float, is_told: bool) -> None:
    made = small.Stage()
    made.box("/Near", 0.5)
    made.box("/Far", 0.5, at=(0, 1, 0))
    made.camera((0, -3, 0), (0, 0, 0), path="/Camera")
    prim = made.stage.GetPrimAtPath("/Camera")
    UsdGeom.Camera(prim).CreateClippingRangeAttr(Gf.Vec2f(near, far))
    told = [why for why in camera_losses(prim, translate(made.stage)) if DOUBT in why]
    assert len(told) == is_told
    if told:
        assert "100 %" in told[0]


def test_lights_that_are_suns_or_all_off() -> None:
    made = small.Stage()
    bulb = made.light("Sphere", "/Bulb", 2e9)
    reasons = {path: why for path, _, why in translate(made.stage).report.losses()}
    assert "2e+09 nit" in reasons["/Bulb"]
    assert {f.place for f in check(made.stage) if f.code == "plausible"} == {"/Bulb"}
    bulb.GetIntensityAttr().Set(0.0)
    reasons = {path: why for path, _, why in translate(made.stage).report.losses()}
    assert "lights all have 0 nit" in reasons["/"]
    made.light("Rect", "/Panel", 10.0)
    rows = translate(made.stage).report.losses()
    assert not [why for _, _, why in rows if DOUBT in why]
