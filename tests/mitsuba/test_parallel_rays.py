"""Orthographic cameras and clipping planes: what is seen where, in exact channels and in light."""

from typing import Any

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

from orusd_mitsuba.export.exporter import export_scene
from tests import small
from tests.small import square

WIDTH, HEIGHT = 32, 24
WINDOW_M = 4.0
EYE_M = 5.0
UPPER_M = 2.0


@pytest.fixture
def tiles() -> Usd.Stage:
    """Seen from above: one glows red on the ground from 0 to 1, one green over it from -1 to 0.5.

    The camera's axis is a quarter of the picture off its middle.
    """
    made = small.Stage()
    red = made.material("/Red", base_color=(0, 0, 0), emissive=(1, 0, 0))
    green = made.material("/Green", base_color=(0, 0, 0), emissive=(0, 1, 0))
    made.quad("/Low", square((0.5, 0, 0), (0.5, 3)), material=red)
    high = [(x, y, UPPER_M) for x, y in ((-1, -3), (0.5, -3), (0.5, 3), (-1, 3))]
    made.quad("/High", high, material=green)
    made.dome(radiance=0.0)
    path = made.camera((0, 0, EYE_M), (0, 0, 0), up=(0, 1, 0), aspect=WIDTH / HEIGHT)
    camera = UsdGeom.Camera(made.stage.GetPrimAtPath(path))
    camera.CreateProjectionAttr("orthographic")
    # Apertures are in tenths of a unit, here of a metre.
    camera.GetHorizontalApertureAttr().Set(10 * WINDOW_M)
    camera.GetVerticalApertureAttr().Set(10 * WINDOW_M * HEIGHT / WIDTH)
    camera.CreateHorizontalApertureOffsetAttr(10 * WINDOW_M / 4)
    return made.stage


def clip(stage: Usd.Stage, near: float, far: float) -> None:
    UsdGeom.Camera(stage.GetPrimAtPath("/Camera")).CreateClippingRangeAttr(Gf.Vec2f(near, far))


# x of the pixels' centres in the plane that the window lies in.
ACROSS = (np.arange(WIDTH) + 0.5) / WIDTH * WINDOW_M - WINDOW_M / 2 + WINDOW_M / 4
LOW = (ACROSS > 0) & (ACROSS < 1)
HIGH = (ACROSS > -1) & (ACROSS < 0.5)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("clipping", "high", "low"),
    [
        (None, HIGH, LOW & ~HIGH),
        ((4.0, 100.0), HIGH & False, LOW),
        ((0.5, 4.0), HIGH, LOW & False),
        ((-2.0, 4.5), HIGH, LOW & False),
    ],
)
def test_things_are_as_wide_however_far_they_are(
    tiles: Usd.Stage, shoot: Any, clipping: tuple[float, float] | None, high: Any, low: Any
) -> None:
    if clipping:
        clip(tiles, *clipping)
    names = ("radiance", "depth", "distance", "position", "valid")
    view = shoot(tiles, *names, width=WIDTH, height=HEIGHT, samples=4, bounces=1)
    images = {name: view.images[name].pixels for name in names}
    expected = np.where(high, EYE_M - UPPER_M, np.where(low, EYE_M, 0.0))
    seen = high | low
    for row in (0, HEIGHT - 1):
        np.testing.assert_allclose(images["depth"][row, :, 0], expected, rtol=1e-5)
        np.testing.assert_allclose(images["distance"][row, :, 0], expected, rtol=1e-5)
        np.testing.assert_allclose(images["position"][row, seen, 0], ACROSS[seen], atol=1e-5)
        np.testing.assert_array_equal(images["valid"][row, :, 0], seen)
        light = np.stack([low, high, np.zeros(WIDTH)], axis=1)
        np.testing.assert_allclose(images["radiance"][row], light, atol=1e-4)
    assert view.projection == "orthographic"


@pytest.mark.one_in(2)
@pytest.mark.parametrize("f_stop", [0.0, 2.0])
@pytest.mark.parametrize(("near", "far"), [(4.0, 100.0), (0.5, 4.0)])
def test_planes_cut_what_a_pinhole_and_a_lens_see(
    tiles: Usd.Stage, shoot: Any, variant: str, f_stop: float, near: float, far: float
) -> None:
    """The same picture as of a stage without what they cut away."""
    camera = UsdGeom.Camera(tiles.GetPrimAtPath("/Camera"))
    camera.GetProjectionAttr().Set("perspective")
    camera.GetFocalLengthAttr().Set(40.0)
    camera.GetHorizontalApertureOffsetAttr().Set(0.0)
    camera.CreateFStopAttr(f_stop)
    camera.CreateFocusDistanceAttr(EYE_M)
    how = {"width": WIDTH, "height": HEIGHT, "samples": 256 if f_stop else 4, "bounces": 1}
    clip(tiles, near, far)
    cut = shoot(tiles, "radiance", "depth", **how)
    camera.GetClippingRangeAttr().Clear()
    tiles.GetPrimAtPath("/High" if near > 3 else "/Low").SetActive(False)
    clean = shoot(tiles, "radiance", "depth", **how)
    pixels = [
        (view.images["radiance"].pixels, view.images["depth"].pixels) for view in (cut, clean)
    ]
    np.testing.assert_allclose(pixels[0][0], pixels[1][0], atol=0.06 if f_stop else 1e-4)
    np.testing.assert_allclose(pixels[0][1], pixels[1][1], rtol=1e-5)
    assert pixels[0][0].max() == pytest.approx(1.0, abs=1e-3)


def test_the_exported_sensor_sees_the_same(tiles: Usd.Stage, tmp_path: Any, variant: str) -> None:
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    export_scene(tiles, tmp_path, {})
    (sensor,) = mi.load_file(str(tmp_path / "scene.xml")).sensors()
    width, height = sensor.film().size()
    for across, down in ((0.1, 0.2), (0.75, 0.5)):
        ray = sensor.sample_ray(0.0, 0.5, (across, down), (0.5, 0.5))[0]
        x = (across - 0.5 + 0.25) * WINDOW_M
        y = (0.5 - down) * WINDOW_M * height / width
        np.testing.assert_allclose(np.array(ray.o), (x, y, EYE_M), atol=2e-3)
        np.testing.assert_allclose(np.array(ray.d), (0, 0, -1), atol=1e-6)


def test_planes_of_its_own_are_reported(tiles: Usd.Stage, open_stage: Any) -> None:
    camera = UsdGeom.Camera(tiles.GetPrimAtPath("/Camera"))
    camera.CreateClippingPlanesAttr([Gf.Vec4f(0, 0, 1, 3)])
    rows = [row for row in open_stage(tiles).report.losses() if row[0] == "/Camera"]
    assert [row[2] for row in rows] == [
        "clippingPlanes are left out: what they cut away is seen too"
    ]


def test_no_ray_slips_between_the_triangles_of_a_ball(shoot: Any, variant: str) -> None:
    """Its edges lie where the pixels' centres are: along the diagonals, through the middle."""
    made = small.Stage()
    UsdGeom.Sphere.Define(made.stage, "/Ball").CreateRadiusAttr(1.0)
    path = made.camera((0, 0, EYE_M), (0, 0, 0), up=(0, 1, 0), aspect=1.0)
    camera = UsdGeom.Camera(made.stage.GetPrimAtPath(path))
    camera.CreateProjectionAttr("orthographic")
    camera.GetHorizontalApertureAttr().Set(20.0)
    camera.GetVerticalApertureAttr().Set(20.0)
    depth = shoot(made.stage, "depth", width=64, height=64).images["depth"].pixels[..., 0]
    x, y = np.meshgrid(*2 * [(np.arange(64) + 0.5) / 32 - 1])
    inside = np.hypot(x, y) < 0.95
    expected = EYE_M - np.sqrt(1.0 - np.minimum(x**2 + y**2, 1.0))
    np.testing.assert_allclose(depth[inside], expected[inside], atol=0.02)
