"""Radiance against closed forms, within the error that the renders estimate of themselves."""

import math

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdLux

from openrooms_usd.render import RenderRequest
from openrooms_usd.usd.lights import define_mesh_light
from orusd_mitsuba.transport import sampling
from orusd_mitsuba.transport.bands import Band

ALBEDO = 0.6
PATCH = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]


@pytest.mark.parametrize("bounces", [0, 1, 7])
def test_a_glowing_room_adds_one_power_of_the_albedo_for_each_bounce(build, shoot, bounces):
    emission = (3.0, 2.0, 1.0)
    made = build()
    glowing = made.material("/Glow", base_color=(ALBEDO,) * 3, emissive=emission)
    made.box("/Room", 4.0, inside=True, material=glowing)
    made.camera((0.3, -0.5, 0.2), (1, 1, 0.1))
    image = shoot(made.stage, "radiance", samples=64, bounces=bounces).images["radiance"]
    expected = np.array(emission) * (1 - ALBEDO ** (bounces + 1)) / (1 - ALBEDO)
    means = image.pixels.mean(axis=(0, 1), dtype=np.float64)
    deviation = image.pixels.std(axis=(0, 1)) / math.sqrt(image.pixels[..., 0].size)
    assert (np.abs(means - expected) <= 4 * deviation + 1e-5 * expected).all()


def test_light_comes_from_where_a_camera_off_its_axis_sees_the_surface(build, shoot):
    made = build()
    glowing = made.material("/Glow", base_color=(0, 0, 0), emissive=(1, 1, 1))
    corners = [(-0.4, -0.3, 0), (0.5, -0.3, 0), (0.5, 0.2, 0), (-0.4, 0.2, 0)]
    made.quad("/Patch", corners, material=glowing)
    made.camera((0, -1.2, 1.0), (0, 0, 0), fov=60)
    camera = UsdGeom.Camera(made.stage.GetPrimAtPath("/Camera"))
    aperture = camera.GetHorizontalApertureAttr().Get()
    camera.CreateHorizontalApertureOffsetAttr(0.15 * aperture)
    camera.CreateVerticalApertureOffsetAttr(-0.1 * aperture)
    images = shoot(made.stage, "radiance", "valid", samples=64, bounces=0).images
    seen = images["valid"].pixels[..., 0] == 1
    assert 0.05 < seen.mean() < 0.6
    # Pixels on the edges are lit in part.
    assert ((images["radiance"].pixels[..., 0] > 0.5) == seen).mean() > 0.98


def corner_factor(a, b, h):
    """Form factor from a point to a parallel rectangle a by b whose corner is h above it.

    J. R. Howell, A Catalog of Radiation Heat Transfer Configuration Factors, B-3.
    """
    A, B = a / h, b / h
    return (A / np.sqrt(1 + A**2) * np.arctan(B / np.sqrt(1 + A**2))
            + B / np.sqrt(1 + B**2) * np.arctan(A / np.sqrt(1 + B**2))) / (2 * np.pi)  # fmt: skip


def irradiance_of_rectangle(points, half_width, half_depth, height, radiance):
    """Lux at points (..., 3) from a rectangle around the vertical axis that shines down."""
    h = height - points[..., 2]
    total = sum(
        corner_factor(half_width + sx * points[..., 0], half_depth + sy * points[..., 1], h)
        for sx in (-1, 1)
        for sy in (-1, 1)
    )
    return np.pi * radiance * total


def lit_patch(build):
    """A Lambertian patch below a rectangle light, and a camera that sees only the patch."""
    made = build()
    made.quad("/Patch", PATCH, material=made.material("/Grey", base_color=(ALBEDO,) * 3))
    light = UsdLux.RectLight.Define(made.stage, "/Light")
    light.CreateWidthAttr(0.8)
    light.CreateHeightAttr(0.5)
    light.CreateIntensityAttr(100.0)
    light.AddTranslateOp().Set(Gf.Vec3d(0, 0, 1.5))
    made.camera((0, -1.2, 1.0), (0, 0, 0), fov=35)
    return made.stage


def test_a_rectangle_light_gives_the_irradiance_of_its_form_factor(build, shoot):
    view = shoot(lit_patch(build), "radiance", "position", "valid", samples=64, bounces=1)
    assert (view.images["valid"].pixels == 1).all()
    image, points = view.images["radiance"], view.images["position"].pixels.astype(np.float64)
    expected = irradiance_of_rectangle(points, 0.4, 0.25, 1.5, 100.0) * ALBEDO / np.pi
    ratio = image.pixels.mean(axis=2) / expected
    # The estimated error is nearly the relative variance of a pixel; pixels are independent.
    z = (ratio.mean() - 1) / math.sqrt(image.error / ratio.size)
    assert abs(z) < 4
    assert image.error < 1e-3


def test_the_estimated_error_is_the_error_that_was_made(build, shoot):
    stage = lit_patch(build)
    view = shoot(stage, "position", width=96, height=72)
    points = view.images["position"].pixels.astype(np.float64)
    expected = irradiance_of_rectangle(points, 0.4, 0.25, 1.5, 100.0) * ALBEDO / np.pi
    for samples in (2, 5, 16):
        image = shoot(stage, "radiance", samples=samples, bounces=1, width=96, height=72).images[
            "radiance"
        ]
        truth = expected[..., None]
        scale = truth**2 + 0.01 * truth.mean() ** 2
        made = float(((image.pixels - truth) ** 2 / scale).mean())
        assert image.samples == samples
        # Some 7000 pixels, whose errors are skewed: the ratio is known to a few percent.
        assert image.error == pytest.approx(made, rel=0.2)


def test_a_mesh_light_is_as_bright_as_the_rectangle_of_its_shape(build, shoot):
    made = build()
    made.quad("/Patch", PATCH, material=made.material("/Grey", base_color=(ALBEDO,) * 3))
    # Counter-clockwise seen from below: its front looks down.
    lamp = made.quad("/Lamp", [(-0.4, -0.25, 1.5), (-0.4, 0.25, 1.5), (0.4, 0.25, 1.5),
                               (0.4, -0.25, 1.5)])  # fmt: skip
    define_mesh_light(lamp.GetPrim(), nits=100.0)
    made.camera((0, -1.2, 1.0), (0, 0, 0), fov=35)
    view = shoot(made.stage, "radiance", "position", samples=64, bounces=1)
    points = view.images["position"].pixels.astype(np.float64)
    expected = irradiance_of_rectangle(points, 0.4, 0.25, 1.5, 100.0) * ALBEDO / np.pi
    image = view.images["radiance"]
    z = (np.mean(image.pixels.mean(axis=2) / expected) - 1) / math.sqrt(
        image.error / points[..., 0].size
    )
    assert abs(z) < 4


def lamp_over_patch(build, define):
    made = build()
    made.quad("/Patch", PATCH, material=made.material("/Grey", base_color=(ALBEDO,) * 3))
    define(made.stage)
    made.camera((0, -1.2, 1.0), (0, 0, 0), fov=35)
    return made.stage


def sphere(stage):
    light = UsdLux.SphereLight.Define(stage, "/Light")
    light.CreateRadiusAttr(0.1)
    light.CreateIntensityAttr(1000.0)
    light.AddTranslateOp().Set(Gf.Vec3d(0, 0, 1.4))


def sphere_irradiance(points):
    """Lux: pi L (r / d)^2 cos, exact for a sphere that is wholly above the horizon."""
    to_light = np.array([0, 0, 1.4]) - points
    d = np.linalg.norm(to_light, axis=-1)
    return np.pi * 1000.0 * (0.1 / d) ** 2 * to_light[..., 2] / d


def sun(stage):
    light = UsdLux.DistantLight.Define(stage, "/Light")
    light.CreateAngleAttr(0.0)
    light.CreateIntensityAttr(50.0)
    light.AddRotateXOp().Set(30.0)


def sun_irradiance(points):
    return np.full(points.shape[:-1], 50.0 * math.cos(math.radians(30)))


def cylinder(stage):
    light = UsdLux.CylinderLight.Define(stage, "/Light")
    light.CreateRadiusAttr(0.02)
    light.CreateLengthAttr(60.0)
    light.CreateIntensityAttr(300.0)
    light.AddTranslateOp().Set(Gf.Vec3d(0, 0, 1.4))


def cylinder_irradiance(points):
    """Lux below an endless cylinder: pi L r / d cos (each ring of a line source integrated)."""
    d = np.hypot(points[..., 1], 1.4 - points[..., 2])
    return np.pi * 300.0 * 0.02 / d * (1.4 - points[..., 2]) / d


@pytest.mark.parametrize(
    ("define", "irradiance"),
    [(sphere, sphere_irradiance), (sun, sun_irradiance), (cylinder, cylinder_irradiance)],
)
def test_lights_give_the_irradiance_of_their_closed_form(build, shoot, define, irradiance):
    view = shoot(lamp_over_patch(build, define), "radiance", "position", samples=256, bounces=1)
    points = view.images["position"].pixels.astype(np.float64)
    expected = irradiance(points) * ALBEDO / np.pi
    image = view.images["radiance"]
    ratio = image.pixels.mean(axis=2) / expected
    # Facets of the round lights may cost a thousandth.
    assert abs(ratio.mean() - 1) < 4 * math.sqrt(image.error / ratio.size) + 2e-3


def test_a_disk_light_gives_the_irradiance_on_its_axis(build, shoot):
    def disk(stage):
        light = UsdLux.DiskLight.Define(stage, "/Light")
        light.CreateRadiusAttr(0.3)
        light.CreateIntensityAttr(500.0)
        light.AddTranslateOp().Set(Gf.Vec3d(0, 0, 1.5))

    stage = lamp_over_patch(build, disk)
    UsdGeom.Camera(stage.GetPrimAtPath("/Camera")).CreateFocalLengthAttr(30.0)
    image = shoot(stage, "radiance", samples=64, bounces=1).images["radiance"]
    expected = np.pi * 500.0 * 0.3**2 / (0.3**2 + 1.5**2) * ALBEDO / np.pi
    ratio = image.pixels.mean() / expected
    assert abs(ratio - 1) < 4 * math.sqrt(image.error / image.pixels[..., 0].size) + 2e-3


SKY = (8, 16)


def directions_of_sky():
    """(8, 16, 3) directions of an upright latitude-longitude picture, as USD defines them.

    Seen in a Y-up dome's own frame: the middle column looks along +Z, a quarter from the left
    along +X, and the first row is near +Y.
    """
    theta = (np.arange(SKY[0]) + 0.5) / SKY[0] * np.pi
    phi = (np.arange(SKY[1]) + 0.5) / SKY[1] * 2 * np.pi
    x = np.sin(theta)[:, None] * np.sin(phi)
    y = np.cos(theta)[:, None] * np.ones_like(phi)
    z = -np.sin(theta)[:, None] * np.cos(phi)
    return np.stack([x, y, z], axis=2)


@pytest.mark.parametrize("kind", ["z pole", "y pole", "legacy", "rotated", "y up"])
def test_the_sky_stands_where_usd_says(build, shoot, save_picture, tmp_path, kind):
    own = directions_of_sky()
    # What a pixel stores is its direction in our world, Z up, worked out without the translator.
    to_world = {
        "z pole": lambda v: np.stack([v[..., 0], -v[..., 2], v[..., 1]], axis=-1),
        "y pole": lambda v: v,
        "legacy": lambda v: v,
        "rotated": lambda v: np.stack([v[..., 2], v[..., 0], v[..., 1]], axis=-1),
        "y up": lambda v: np.stack([v[..., 0], -v[..., 2], v[..., 1]], axis=-1),
    }[kind]
    stored = ((to_world(own) + 1) / 2).astype(np.float32)
    picture = save_picture(tmp_path / "sky.exr", stored)
    made = build(up="Y" if kind == "y up" else "Z")
    if kind in ("legacy", "y up"):
        dome = UsdLux.DomeLight.Define(made.stage, "/Dome")
        dome.CreateIntensityAttr(1.0)
    else:
        dome = made.dome()
        dome.CreatePoleAxisAttr("Y" if kind == "y pole" else "Z")
    dome.CreateTextureFileAttr(picture)
    if kind == "rotated":
        dome.AddRotateZOp().Set(90.0)
    turned = (lambda x, y, z: (x, z, -y)) if kind == "y up" else (lambda x, y, z: (x, y, z))
    targets = [(1, 0.2, 0.1), (-0.3, 1, -0.4), (-1, -0.3, 0.2), (0.2, -1, 0.5), (0.5, 0.2, 0.9)]
    for number, target in enumerate(targets):
        path = f"/Camera{number}"
        made.camera(turned(0, 0, 0), turned(*target), up=turned(0, 0, 1), path=path, fov=2)
        view = shoot(made.stage, "radiance", camera=path, width=2, height=2, samples=16)
        seen = view.images["radiance"].pixels.mean(axis=(0, 1)) * 2 - 1
        direction = np.array(target) / np.linalg.norm(target)
        # Pixels of the sky are 22 degrees wide and interpolated.
        assert np.degrees(np.arccos(seen @ direction / np.linalg.norm(seen))) < 2.5


def test_a_constant_sky_and_a_sky_with_wrong_pixels(
    build, open_stage, shoot, save_picture, tmp_path
):
    made = build()
    made.dome(radiance=7.0)
    made.camera((0, 0, 0), (1, 0, 0))
    view = shoot(made.stage, "radiance")
    assert (view.images["radiance"].pixels == 7.0).all()
    pixels = np.full((32, 64, 3), 2.0, dtype=np.float32)
    pixels[0, 0], pixels[0, 1] = np.inf, -5.0
    wrong = build()
    wrong.dome().CreateTextureFileAttr(save_picture(tmp_path / "wrong.exr", pixels))
    wrong.camera((0, 0, 0), (1, 0, 0))
    assert np.allclose(shoot(wrong.stage, "radiance").images["radiance"].pixels, 2.0)
    losses = {path: reason for path, _, reason in open_stage(wrong.stage).report.losses()}
    assert "2 negative or infinite pixels" in losses["/Dome"]


def test_equal_seeds_give_equal_bits_and_others_do_not(build, shoot):
    stage = lit_patch(build)
    first, again, other = (
        shoot(stage, "radiance", samples=5, seed=seed).images["radiance"].pixels
        for seed in (7, 7, 8)
    )
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_one_sample_estimates_no_error_and_centre_rays_have_none(build, shoot):
    images = shoot(lit_patch(build), "radiance", "depth", samples=1).images
    assert images["radiance"].error is None
    assert images["depth"].error == 0.0
    assert (images["radiance"].samples, images["depth"].samples) == (1, 1)


def test_an_error_is_reached(build, shoot):
    image = shoot(lit_patch(build), "radiance", error=1e-3, bounces=1).images["radiance"]
    assert image.robust_error <= 1e-3


def test_pixels_that_are_no_numbers_are_counted_and_reported(build, open_stage, monkeypatch):
    session = open_stage(lit_patch(build))

    import mitsuba as mi

    real = mi.render

    class Spoiled:
        def __init__(self, tensor):
            self.tensor = tensor

        def numpy(self):
            pixels = self.tensor.numpy()
            pixels[1, 2, 0], pixels[1, 2, 1], pixels[3, 4, 2] = np.nan, np.inf, -np.inf
            return pixels

    def spoiled(*args):
        planes = gather(*args)
        planes[:, 0, 1, 2], planes[:, 1, 1, 2], planes[:, 2, 3, 4] = np.nan, np.inf, -np.inf
        return planes

    gather = Band.means
    monkeypatch.setattr(mi, "render", lambda *args, **how: Spoiled(real(*args, **how)))
    monkeypatch.setattr(Band, "means", spoiled)
    request = RenderRequest("/Camera", ("radiance",), 32, 24, samples=4)
    image = session.render(request).images["radiance"]
    assert np.isfinite(image.pixels).all()
    assert image.replaced == 2
    rows = [reason for path, _, reason in session.report.losses() if path == "/Camera"]
    assert rows == ["radiance was no number in 2 pixels, taken as 0"]


def test_an_error_that_is_not_reached_is_reported(build, open_stage, monkeypatch):
    monkeypatch.setattr(sampling, "_MOST_SAMPLES", 16)
    session = open_stage(lit_patch(build))
    request = RenderRequest("/Camera", ("radiance",), 32, 24, error=1e-9, bounces=1)
    image = session.render(request).images["radiance"]
    (row,) = [reason for path, _, reason in session.report.losses() if path == "/Camera"]
    said = f"estimated error {image.robust_error:.2g} after 16 samples a pixel"
    assert row == f"radiance: {said}, not 1e-09"


@pytest.mark.parametrize("ior", [1.5, 2.0])
def test_a_black_dielectric_reflects_what_fresnel_says(build, shoot, ior):
    made = build()
    black = made.material("/Black", base_color=(0.0, 0.0, 0.0), ior=ior, roughness=0.1)
    made.quad("/Patch", PATCH, material=black)
    made.dome(radiance=10.0)
    made.camera((0, 0, 5), (0, 0, 0), up=(0, 1, 0), fov=2)
    image = shoot(made.stage, "radiance", samples=256, bounces=1).images["radiance"]
    expected = 10.0 * ((ior - 1) / (ior + 1)) ** 2
    assert image.pixels.mean() == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize(("roughness", "seen"), [(0.02, 0.95), (1.0, 0.1)])
def test_a_metal_is_as_sharp_a_mirror_as_it_is_smooth(build, shoot, roughness, seen):
    made = build()
    how = {"base_color": (0.8, 0.8, 0.8), "metallic": 1.0, "roughness": roughness}
    made.quad("/Patch", PATCH, material=made.material("/Metal", **how))
    light = UsdLux.RectLight.Define(made.stage, "/Light")
    light.CreateIntensityAttr(100.0)
    light.CreateWidthAttr(0.4)
    light.CreateHeightAttr(0.4)
    light.AddTranslateOp().Set(Gf.Vec3d(0, 1, 1))
    made.camera((0, -1, 1), (0, 0, 0), fov=1)
    image = shoot(made.stage, "radiance", samples=256, bounces=1).images["radiance"]
    ratio = image.pixels.mean() / 80.0
    assert ratio > seen if roughness < 0.5 else ratio < seen


def test_the_glow_of_a_lamps_material_is_counted_once(build, shoot):
    """What lights is the mesh light: no pixel of any channel hangs on ``emissiveColor``."""
    views = []
    for glow in ((0.0, 0.0, 0.0), (50.0, 40.0, 30.0), (9e4, 9e4, 9e4)):
        made = build()
        made.box("/Room", 4.0, inside=True, material=made.material("/Grey", base_color=(0.5,) * 3))
        for name, nits in (("Lamp", 50.0), ("Off", 0.0)):
            worn = made.material(f"/{name}Glow", base_color=(0.8,) * 3, ior=1.5, emissive=glow)
            lamp = made.box(f"/{name}", 0.3, material=worn)
            lamp.AddTranslateOp().Set((0.8, 0.9 if nits else 0.3, 0.3))
            define_mesh_light(lamp.GetPrim(), nits=nits)
        made.camera((-0.5, -0.5, 0.2), (1, 1, 0.1))
        channels = ("radiance", "emission_mask", "base_color", "instance", "material")
        views.append(shoot(made.stage, *channels, samples=4))
    assert views[0].images["emission_mask"].pixels.mean() > 0.01
    for view in views[1:]:
        for name, image in views[0].images.items():
            np.testing.assert_array_equal(view.images[name].pixels, image.pixels, name)
