"""IES profiles: what is read, refused and summed; closed forms of their flux."""

import math
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdLux

from openrooms_usd.errors import InputError
from openrooms_usd.library.styles.beams import BEAMS, beam_profile, profile_text
from openrooms_usd.usd.light.lights import read_lights
from openrooms_usd.usd.light.profiles import Shaping, parse_profile, read_profile, shaping
from openrooms_usd.usd.light.shaping import EVEN, Cone, define_shaping


def text(
    polar: object,
    around: object,
    candela: object,
    head: str = "IESNA:LM-63-2002",
    factor: str = "1",
) -> str:
    p, a, c = np.atleast_1d(polar), np.atleast_1d(around), np.atleast_2d(candela)
    rows = "\n".join(" ".join(f"{value:.12g}" for value in row) for row in (p, a, *c))
    return (
        f"{head}\n[TEST] 1\nTILT=NONE\n1 1000 {factor} {len(p)} {len(a)} 1 2 0 0 0\n1 1 9\n{rows}\n"
    )


def ways(polar: float, around: float) -> list[float]:
    t, p = np.radians([polar, around])
    return [np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), -np.cos(t)]


def test_flux_of_what_has_a_closed_form() -> None:
    assert parse_profile(text([0, 180], 0, [50, 50]), "").flux == pytest.approx(200 * np.pi)
    t = np.linspace(0, 90, 181)
    lambert = parse_profile(text(t, 0, 50 * np.cos(np.radians(t))), "")
    assert lambert.flux == pytest.approx(50 * np.pi, rel=1e-4)
    # A linear fall to the horizon: 2 pi (1 - 2 / pi).
    linear = parse_profile(text([0, 90], 0, [1, 0], factor="50"), "")
    assert linear.flux == pytest.approx(50 * 2 * np.pi * (1 - 2 / np.pi), rel=1e-12)


@pytest.mark.parametrize("head", ["IESNA91", "IESNA:LM-63-1995", "IESNA:LM-63-2002"])
def test_planes_that_are_left_out_are_mirrored(head: str) -> None:
    rows = np.array([[9, 3], [8, 2], [5, 1]])
    quarter = parse_profile(text([0, 90], [0, 45, 90], rows, head), "")
    half = parse_profile(text([0, 90], [0, 90, 180], rows, head), "")
    other = parse_profile(text([0, 90], [90, 180, 270], rows, head), "")
    at = [ways(90, angle) for angle in (0, 45, 90, 135, 180, 225, 270, 315, 359.9999999)]
    np.testing.assert_allclose(quarter.intensity(at), [3, 2, 1, 2, 3, 2, 1, 2, 3], rtol=1e-6)
    np.testing.assert_allclose(half.intensity(at), [3, 2.5, 2, 1.5, 1, 1.5, 2, 2.5, 3], rtol=1e-6)
    np.testing.assert_allclose(other.intensity(at), [2, 2.5, 3, 2.5, 2, 1.5, 1, 1.5, 2], rtol=1e-6)
    assert quarter.intensity([0, 0, 1.0]) == 0.0


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ("hello", "first line"),
        (
            text([0, 90], 0, [1, 0]).replace("TILT=NONE", "TILT=INCLUDE"),
            "TILT=INCLUDE is not supported",
        ),
        (text([0, 90], 0, [1, 0]).replace("TILT=NONE", ""), "no line TILT"),
        (text([0, 90], 0, [1, 0]).replace("1 1 2 0", "1 2 2 0"), "type 2"),
        (text([0, 90], 0, [1, 0]) + "7", "numbers"),
        (text([0, 90], 0, [1, 0]) + "x", "text among"),
        (text([0, 90], 0, [1, 0]) + "nan", "not finite"),
        (text([0, 90], 0, [1, -1]), "below 0"),
        (text([90, 0], 0, [1, 0]), "vertical angles"),
        (text([0, 90], [0, 70], [[1, 0], [1, 0]]), "not of type C"),
        (text([0, 90], 0, [1, 0]).replace("2 1 1 2", "1e9 1e9 1 2"), "not plausible"),
    ],
)
def test_what_is_no_such_file_is_refused(wrong: str, told: str) -> None:
    with pytest.raises(InputError, match=told):
        parse_profile(wrong, "lamp.ies")


def test_a_table_is_the_profile() -> None:
    rng = np.random.default_rng(1)
    polar, around = [0, 2.5, 20, 60, 90], [0, 45, 90, 180]
    profile = parse_profile(text(polar, around, rng.uniform(1, 9, (4, 5))), "")
    found = rng.normal(size=(500, 3))
    world = np.array([[0, 0, 1.0], [1, 0, 0], [0, 1, 0]])
    made = shaping(profile, 3.0 * world, normalize=False)
    np.testing.assert_allclose(made.factor(found @ world.T), profile.intensity(found), rtol=1e-5)
    half = profile.scaled(0.5)
    for angle in (0, 10, 30, 44):
        expected = profile.intensity(ways(2 * angle, 20))
        assert half.intensity(ways(angle, 20)) == pytest.approx(expected)
    wide = profile.scaled(-3.0)
    assert wide.intensity(ways(60, 20)) == pytest.approx(profile.intensity(ways(140, 20)))


@pytest.mark.parametrize("name", BEAMS)
def test_what_is_written_is_read_again(name: str, tmp_path: Path) -> None:
    made = beam_profile(name)  # type: ignore[arg-type]
    (tmp_path / "a.ies").write_text(profile_text(made, name))
    again = read_profile(tmp_path / "a.ies")
    np.testing.assert_array_equal(again.candela[0], made.candela[0])
    assert again.flux == pytest.approx(1000.0, rel=1e-5)
    if name in ("downlight", "spot"):
        beam = beam_profile(name, 30)  # type: ignore[arg-type]
        assert beam.intensity(ways(15, 0)) == pytest.approx(beam.candela[0, 0] / 2, rel=1e-5)


def test_lights_of_a_stage_follow_their_file(tmp_path: Path) -> None:
    (tmp_path / "a.ies").write_text(profile_text(beam_profile("spot"), "spot"))
    stage = Usd.Stage.CreateNew(str(tmp_path / "a.usda"))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    for kind, file in (
        (UsdLux.DiskLight, "a.ies"),
        (UsdLux.SphereLight, "none.ies"),
        (UsdLux.DistantLight, "a.ies"),
    ):
        define_shaping(kind.Define(stage, f"/{kind.__name__}").GetPrim(), f"./{file}")
    disk, sphere, sun = read_lights(stage)
    assert disk.losses == () and disk.shaping is not None
    narrow = disk.shaping.factor([ways(0, 0), ways(18, 0), ways(100, 0)])
    np.testing.assert_allclose(narrow / narrow[0], [1, 0.5, 0], rtol=1e-5)
    assert sphere.shaping is None and "missing" in sphere.losses[0]
    assert sun.shaping is None and "does not follow" in sun.losses[0]


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


def ways_of_cone(polar: float, around: float = 20.0) -> list[float]:
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
            assert made.factor(ways_of_cone(float(polar))) == pytest.approx(expected, abs=2e-3)


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
    assert half.factor([ways_of_cone(89.0), ways_of_cone(91.0)]).tolist() == [1.0, 0.0]
    assert soft.factor(ways_of_cone(67.5)) == pytest.approx(0.5, abs=1e-3)


def test_a_focus_of_tinted_light_keeps_the_tint() -> None:
    made = found(shaped("Sphere", focus=2.0, focusTint=Gf.Vec3f(0.25)))
    assert made is not None
    assert made.factor(ways_of_cone(60.0)) == pytest.approx(0.25 + 0.75 * 0.25, abs=1e-3)
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
        expected = profile.intensity(ways_of_cone(polar)) * written(60.0, 0.5, 0.0, polar)
        assert made.factor(ways_of_cone(polar)) == pytest.approx(expected, abs=2e-3)


def test_lights_from_afar_say_that_they_have_no_cone() -> None:
    [light] = read_lights(shaped("Distant", cone_angle=20.0))
    assert light.shaping is None and "cone" in light.losses[0]
    [light] = read_lights(shaped("Sphere", cone_angle=math.nan))
    assert light.shaping is None and "not finite" in light.losses[0]
