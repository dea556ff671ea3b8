"""Cone, softness and focus of lights, by the formulas of UsdLux's schema and their integrals."""

import math

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdLux

from openrooms_usd.usd.lights import read_lights
from openrooms_usd.usd.profiles import Shaping, parse_profile, shaping
from openrooms_usd.usd.shaping import EVEN, Cone

DOWN = np.array([[0.0, 0.0, -1.0]])
CASES = [
    (20.0, 0.0, 0.0),
    (30.0, 0.5, 0.0),
    (130.0, 1.0, 0.0),
    (180.0, 0.0, 8.0),
    (60.0, 0.5, 3.0),
    (0.8, 0.25, 0.0),
    (180.0, 0.0, 2000.0),
]


def ways(polar: float, around: float = 20.0) -> list[float]:
    a, b = math.radians(polar), math.radians(around)
    return [math.sin(a) * math.cos(b), math.sin(a) * math.sin(b), -math.cos(a)]


def written(angle: float, softness: float, focus: float, polar: float) -> float:
    """The schema's text, line by line."""
    if polar > angle:
        return 0.0
    start = (1 - softness) * angle
    t = min(1.0, max(0.0, (polar - start) / (angle - start))) if angle > start else 0.0
    return abs(math.cos(math.radians(polar))) ** focus * (1.0 - (3.0 - 2.0 * t) * t**2)


def shaped(kind: str, **inputs: float | Gf.Vec3f) -> Usd.Stage:
    """A stage with one light that has a cone."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    prim = getattr(UsdLux, f"{kind}Light").Define(stage, "/L").GetPrim()
    UsdLux.ShapingAPI.Apply(prim)
    for name, value in inputs.items():
        prim.GetAttribute(f"inputs:shaping:{name.replace('_', ':')}").Set(value)
    return stage


def found(stage: Usd.Stage) -> Shaping | None:
    [light] = read_lights(stage)
    assert light.losses == ()
    return light.shaping


@pytest.mark.parametrize(("angle", "softness", "focus"), CASES)
def test_radiance_goes_as_the_schema_says(angle: float, softness: float, focus: float) -> None:
    made = found(shaped("Sphere", cone_angle=angle, cone_softness=softness, focus=focus))
    assert made is not None
    for polar in (*np.linspace(0.0, 180.0, 97), *np.linspace(0.0, min(180.0, 1.1 * angle), 18)):
        if abs(polar - angle) > 1e-5:
            expected = written(angle, softness, focus, float(polar))
            assert made.factor(ways(float(polar))) == pytest.approx(expected, abs=2e-3)


@pytest.mark.parametrize("angle", [0.3, 12.0, 25.0, 90.0])
def test_a_hard_cone_lets_a_disk_send_the_square_of_its_sine(angle: float) -> None:
    made = shaping(EVEN, np.eye(4), normalize=False, cut=Cone(angle=angle).of)
    share = math.sin(math.radians(angle)) ** 2
    assert made.mean_over(DOWN, np.ones(1)) == pytest.approx(share, rel=1e-3)


@pytest.mark.parametrize("focus", [0.5, 4.0, 300.0])
def test_a_focus_lets_a_disk_send_its_integral(focus: float) -> None:
    made = shaping(EVEN, np.eye(4), normalize=False, cut=Cone(focus=focus).of)
    assert made.mean_over(DOWN, np.ones(1)) == pytest.approx(2.0 / (focus + 2.0), rel=0.01)


def test_an_angle_that_nobody_wrote_cuts_nothing() -> None:
    assert found(shaped("Sphere")) is None
    assert found(shaped("Sphere", cone_angle=180.0)) is None
    assert found(shaped("Disk", cone_angle=90.0)) is None
    half = found(shaped("Sphere", cone_angle=90.0))
    soft = found(shaped("Sphere", cone_softness=0.5))
    assert half is not None and soft is not None
    assert half.factor([ways(89.0), ways(91.0)]).tolist() == [1.0, 0.0]
    assert soft.factor(ways(67.5)) == pytest.approx(0.5, abs=1e-3)


def test_a_focus_of_tinted_light_keeps_the_tint() -> None:
    made = found(shaped("Sphere", focus=2.0, focusTint=Gf.Vec3f(0.25)))
    assert made is not None
    assert made.factor(ways(60.0)) == pytest.approx(0.25 + 0.75 * 0.25, abs=1e-3)
    [light] = read_lights(shaped("Sphere", focus=2.0, focusTint=Gf.Vec3f(1, 0, 0)))
    assert "focusTint" in light.losses[0]


@pytest.mark.parametrize("scale", [(1.0, 1.0, 1.0), (1.0, 1.0, -1.0), (3.0, 3.0, 3.0)])
def test_the_axis_goes_along_with_the_light(scale: tuple[float, float, float]) -> None:
    stage = shaped("Disk", cone_angle=20.0)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    xform = UsdGeom.Xformable(stage.GetPrimAtPath("/L"))
    xform.AddRotateYOp().Set(-90.0)
    xform.AddScaleOp().Set(Gf.Vec3f(*scale))
    made = found(stage)
    assert made is not None
    # -Z, turned by a quarter about +Y, is +X; the mirror turns it back.
    axis = math.copysign(1.0, scale[2])
    inside, outside = (
        [axis * math.cos(a), 0.0, math.sin(a)] for a in (math.radians(19), math.radians(21))
    )
    np.testing.assert_allclose(made.factor([inside, outside]), [1.0, 0.0], atol=1e-6)


def test_a_profile_is_cut_by_the_cone() -> None:
    text = "IESNA:LM-63-2002\nTILT=NONE\n1 1 1 3 1 1 2 0 0 0\n1 1 1\n0 40 90\n0\n8 6 1\n"
    profile = parse_profile(text, "")
    made = shaping(profile, np.eye(4), normalize=False, cut=Cone(angle=60.0, softness=0.5).of)
    for polar in (0.0, 20.0, 35.0, 50.0, 59.0, 61.0, 80.0):
        expected = profile.intensity(ways(polar)) * written(60.0, 0.5, 0.0, polar)
        assert made.factor(ways(polar)) == pytest.approx(expected, abs=2e-3)


def test_lights_from_afar_say_that_they_have_no_cone() -> None:
    [light] = read_lights(shaped("Distant", cone_angle=20.0))
    assert light.shaping is None and "cone" in light.losses[0]
    [light] = read_lights(shaped("Sphere", cone_angle=math.nan))
    assert light.shaping is None and "not finite" in light.losses[0]
