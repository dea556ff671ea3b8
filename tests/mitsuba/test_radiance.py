"""Radiance against closed forms, within the error that the renders estimate of themselves."""

import math

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdLux

from openrooms_usd.usd.light.lights import define_mesh_light
from orusd_mitsuba.transport import sampling
from orusd_mitsuba.transport.bands import Band
from tests import small
from tests.mitsuba.rendering import session_of, shown
from tests.mitsuba.statistics import lambert
from tests.pictures import save_picture
from tests.small import square

ALBEDO = 0.6
PATCH = square((0, 0, 0), 1)


@pytest.mark.parametrize("bounces", [0, 1, 7])
def test_a_glowing_room_adds_one_power_of_the_albedo_for_each_bounce(shoot, bounces):
    emission = (3.0, 2.0, 1.0)
    made = small.Stage()
    glowing = made.material("/Glow", base_color=(ALBEDO,) * 3, emissive=emission)
    made.box("/Room", 4.0, inside=True, material=glowing)
    made.camera((0.3, -0.5, 0.2), (1, 1, 0.1))
    image = shoot(made.stage, "radiance", samples=64, bounces=bounces).images["radiance"]
    expected = np.array(emission) * (1 - ALBEDO ** (bounces + 1)) / (1 - ALBEDO)
    means = image.pixels.mean(axis=(0, 1), dtype=np.float64)
    deviation = image.pixels.std(axis=(0, 1)) / math.sqrt(image.pixels[..., 0].size)
    assert (np.abs(means - expected) <= 4 * deviation + 1e-5 * expected).all()


def test_light_comes_from_where_a_camera_off_its_axis_sees_the_surface(shoot):
    made = small.Stage()
    glowing = made.material("/Glow", base_color=(0, 0, 0), emissive=(1, 1, 1))
    corners = square((0.05, -0.05, 0), (0.45, 0.25))
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


def over_patch() -> small.Stage:
    """A Lambertian patch, and a camera that sees only the patch."""
    made = small.Stage()
    made.quad("/Patch", PATCH, material=made.material("/Grey", base_color=(ALBEDO,) * 3))
    made.camera((0, -1.2, 1.0), (0, 0, 0), fov=35)
    return made


UP, LAMP = np.array([0.0, 0.0, 1.0]), square((0, 0, 1.5), (0.4, 0.25), "-Z")
ROUND = np.exp(2j * np.pi * np.arange(2000) / 2000)
DISK = np.column_stack([0.3 * ROUND.real, 0.3 * ROUND.imag, np.full(2000, 1.5)])


def lit_patch():
    made = over_patch()
    made.light("Rect", "/Light", 100.0, at=(0, 0, 1.5), width=0.8, height=0.5)
    return made.stage


def to_lamp(points):
    """Distance and cosine to what hangs at 1.4 m, of points (..., 3)."""
    way = np.array([0, 0, 1.4]) - points
    d = np.linalg.norm(way, axis=-1)
    return d, way[..., 2] / d


def sphere(points):
    """Exact for a sphere that is wholly above the horizon."""
    d, cosine = to_lamp(points)
    return np.pi * (0.1 / d) ** 2 * cosine


def cylinder(points):
    """Below an endless cylinder: each ring of a line source integrated."""
    d, cosine = to_lamp(points * [0, 1, 1])
    return np.pi * 0.02 / d * cosine


# What lights the patch, and lux for each unit of its radiance.
LIGHTS = {
    "rectangle": (
        lambda made: made.light("Rect", "/L", 100.0, at=(0, 0, 1.5), width=0.8, height=0.5),
        lambda p: lambert(p, UP, LAMP),
        100.0,
    ),
    "mesh": (lambda made: made.quad("/L", LAMP, nits=100.0), lambda p: lambert(p, UP, LAMP), 100.0),
    "disk": (
        lambda made: made.light("Disk", "/L", 500.0, at=(0, 0, 1.5), radius=0.3),
        lambda p: lambert(p, UP, DISK),
        500.0,
    ),
    "sphere": (
        lambda made: made.light("Sphere", "/L", 1000.0, at=(0, 0, 1.4), radius=0.1),
        sphere,
        1000.0,
    ),
    "cylinder": (
        lambda made: made.light("Cylinder", "/L", 300.0, at=(0, 0, 1.4), radius=0.02, length=60.0),
        cylinder,
        300.0,
    ),
    "sun": (
        lambda made: made.light("Distant", "/L", 50.0, turn=(30, 0, 0), angle=0.0),
        lambda p: np.full(p.shape[:-1], math.cos(math.radians(30))),
        50.0,
    ),
}


@pytest.mark.parametrize("name", LIGHTS)
def test_lights_give_the_irradiance_of_their_closed_form(shoot, name):
    define, irradiance, nits = LIGHTS[name]
    made = over_patch()
    define(made)
    flat = name in ("rectangle", "mesh")
    samples = 64 if flat else 256
    view = shoot(made.stage, "radiance", "position", "valid", samples=samples, bounces=1)
    assert (view.images["valid"].pixels == 1).all()
    points = view.images["position"].pixels.astype(np.float64)
    image = view.images["radiance"]
    ratio = image.pixels.mean(axis=2) / (nits * irradiance(points) * ALBEDO / np.pi)
    # The estimated error is nearly the relative variance of a pixel; pixels are independent.
    facets = 0.0 if flat else 2e-3
    assert abs(ratio.mean() - 1) < 4 * math.sqrt(image.error / ratio.size) + facets
    assert image.error < 1e-3 or not flat


def test_the_estimated_error_is_the_error_that_was_made(shoot):
    stage = lit_patch()
    size = {"width": 96, "height": 72}
    points = shoot(stage, "position", **size).images["position"].pixels.astype(np.float64)
    truth = (100.0 * lambert(points, UP, LAMP) * ALBEDO / np.pi)[..., None]
    for samples in (2, 5, 16):
        image = shoot(stage, "radiance", samples=samples, bounces=1, **size).images["radiance"]
        scale = truth**2 + 0.01 * truth.mean() ** 2
        made = float(((image.pixels - truth) ** 2 / scale).mean())
        assert image.samples == samples
        # Some 7000 pixels, whose errors are skewed: the ratio is known to a few percent.
        assert image.error == pytest.approx(made, rel=0.2)


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
def test_the_sky_stands_where_usd_says(shoot, tmp_path, kind):
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
    made = small.Stage(up="Y" if kind == "y up" else "Z")
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


def test_a_constant_sky_and_a_sky_with_wrong_pixels(open_stage, shoot, tmp_path):
    made = small.Stage()
    made.dome(radiance=7.0)
    made.camera((0, 0, 0), (1, 0, 0))
    view = shoot(made.stage, "radiance")
    assert (view.images["radiance"].pixels == 7.0).all()
    pixels = np.full((32, 64, 3), 2.0, dtype=np.float32)
    pixels[0, 0], pixels[0, 1] = np.inf, -5.0
    wrong = small.Stage()
    wrong.dome().CreateTextureFileAttr(save_picture(tmp_path / "wrong.exr", pixels))
    wrong.camera((0, 0, 0), (1, 0, 0))
    assert np.allclose(shoot(wrong.stage, "radiance").images["radiance"].pixels, 2.0)
    losses = {path: reason for path, _, reason in open_stage(wrong.stage).report.losses()}
    assert "2 negative or infinite pixels" in losses["/Dome"]


def test_equal_seeds_give_equal_bits_and_others_do_not(shoot):
    stage = lit_patch()
    first, again, other = (
        shoot(stage, "radiance", samples=5, seed=seed).images["radiance"].pixels
        for seed in (7, 7, 8)
    )
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_one_sample_estimates_no_error_and_centre_rays_have_none(shoot):
    images = shoot(lit_patch(), "radiance", "depth", samples=1).images
    assert images["radiance"].error is None
    assert images["depth"].error == 0.0
    assert (images["radiance"].samples, images["depth"].samples) == (1, 1)


def test_an_error_is_reached(shoot):
    image = shoot(lit_patch(), "radiance", error=1e-3, bounces=1).images["radiance"]
    assert image.robust_error <= 1e-3


def test_pixels_that_are_no_numbers_are_counted_and_reported(open_stage, monkeypatch):
    session = open_stage(lit_patch())

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
    image = shown(session, "radiance", width=32, height=24, samples=4).images["radiance"]
    assert np.isfinite(image.pixels).all()
    assert image.replaced == 2
    rows = [reason for path, _, reason in session.report.losses() if path == "/Camera"]
    assert rows == ["radiance was not finite in 2 pixels; 0 is used"]


def test_an_error_that_is_not_reached_is_reported(open_stage, monkeypatch):
    monkeypatch.setattr(sampling, "_MOST_SAMPLES", 16)
    session = open_stage(lit_patch())
    image = shown(session, "radiance", width=32, height=24, error=1e-9, bounces=1).images[
        "radiance"
    ]
    (row,) = [reason for path, _, reason in session.report.losses() if path == "/Camera"]
    said = f"estimated error {image.robust_error:.2g} after 16 samples a pixel"
    assert row == f"radiance: {said}, not 1e-09"


@pytest.mark.parametrize("ior", [1.5, 2.0])
def test_a_black_dielectric_reflects_what_fresnel_says(shoot, ior):
    made = small.Stage()
    black = made.material("/Black", base_color=(0.0, 0.0, 0.0), ior=ior, roughness=0.1)
    made.quad("/Patch", PATCH, material=black)
    made.dome(radiance=10.0)
    made.camera((0, 0, 5), (0, 0, 0), up=(0, 1, 0), fov=2)
    image = shoot(made.stage, "radiance", samples=256, bounces=1).images["radiance"]
    expected = 10.0 * ((ior - 1) / (ior + 1)) ** 2
    assert image.pixels.mean() == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize(("roughness", "seen"), [(0.02, 0.95), (1.0, 0.1)])
def test_a_metal_is_as_sharp_a_mirror_as_it_is_smooth(shoot, roughness, seen):
    made = small.Stage()
    how = {"base_color": (0.8, 0.8, 0.8), "metallic": 1.0, "roughness": roughness}
    made.quad("/Patch", PATCH, material=made.material("/Metal", **how))
    made.light("Rect", "/Light", 100.0, at=(0, 1, 1), width=0.4, height=0.4)
    made.camera((0, -1, 1), (0, 0, 0), fov=1)
    image = shoot(made.stage, "radiance", samples=256, bounces=1).images["radiance"]
    ratio = image.pixels.mean() / 80.0
    assert ratio > seen if roughness < 0.5 else ratio < seen


def test_the_glow_of_a_lamps_material_is_counted_once(shoot):
    """What lights is the mesh light: no pixel of any channel hangs on ``emissiveColor``."""
    views = []
    for glow in ((0.0, 0.0, 0.0), (50.0, 40.0, 30.0), (9e4, 9e4, 9e4)):
        made = small.Stage()
        made.box("/Room", 4.0, inside=True, material=made.material("/Grey", base_color=(0.5,) * 3))
        for name, nits in (("Lamp", 50.0), ("Off", 0.0)):
            worn = made.material(f"/{name}Glow", base_color=(0.8,) * 3, ior=1.5, emissive=glow)
            lamp = made.box(f"/{name}", 0.3, material=worn, at=(0.8, 0.9 if nits else 0.3, 0.3))
            define_mesh_light(lamp.GetPrim(), nits=nits)
        made.camera((-0.5, -0.5, 0.2), (1, 1, 0.1))
        channels = ("radiance", "emission_mask", "base_color", "instance", "material")
        views.append(shoot(made.stage, *channels, samples=4))
    assert views[0].images["emission_mask"].pixels.mean() > 0.01
    for view in views[1:]:
        for name, image in views[0].images.items():
            np.testing.assert_array_equal(view.images[name].pixels, image.pixels, name)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_tilted_normal_sees_the_sky_but_what_the_surface_hides(vectorized, sign):
    """pi (1 + cos) / 2 of a normal beside the plate's, also where it was written with -1."""
    made = small.patch()
    made.dome()
    mesh = UsdGeom.Mesh(made.stage.GetPrimAtPath("/Patch"))
    mesh.CreateNormalsAttr([Gf.Vec3f(0.6 * sign, 0.0, 0.8 * sign)])
    mesh.SetNormalsInterpolation("constant")
    found = session_of(made.stage, variant="llvm")
    images = shown(found, "irradiance", "normal", samples=64).images
    assert np.allclose(images["normal"].pixels, (0.6, 0.0, 0.8), atol=1e-6)
    assert images["irradiance"].pixels.mean() == pytest.approx(np.pi * 1.8 / 2, rel=0.02)
