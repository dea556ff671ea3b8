"""Lights of any stage against closed forms: what falls on a small white patch below them."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdLux

from openrooms_usd.rendering.scene.surroundings import surroundings
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.usd.shading.surfaces import Texture
from tests import small
from tests.mitsuba.rendering import radiance, session_of
from tests.pictures import save_picture

HEIGHT = 2.0
NITS = 1000.0


def light(made: small.Stage, kind: str, **inputs: Any) -> Any:
    """A light at the height over the origin that looks down."""
    return made.light(kind, "/L", **({"nits": NITS, "at": (0, 0, HEIGHT)} | inputs))


def lux(made: small.Stage, samples: int = 64) -> np.ndarray:
    """(3,) what the patch receives: of a white surface pi times its radiance."""
    session = session_of(made.stage, variant="scalar")
    pixels = radiance(session, width=4, height=4, samples=samples, bounces=1)
    return np.pi * pixels.reshape(-1, 3).mean(axis=0, dtype=np.float64)


@pytest.mark.parametrize(
    ("angle", "softness", "focus", "off"),
    [
        (20.0, 0.0, 0.0, 0.0),
        (20.0, 0.0, 0.0, 19.0),
        (20.0, 0.0, 0.0, 21.0),
        (30.0, 0.5, 0.0, 20.0),
        (60.0, 0.5, 3.0, 40.0),
    ],
)
def test_a_spot_is_as_bright_as_its_disk_and_dark_beside_it(
    angle: float, softness: float, focus: float, off: float
) -> None:
    a = math.radians(off)
    made = small.patch((HEIGHT * math.tan(a), 0, 0))
    light(
        made,
        "Disk",
        radius=0.01,
        shaping__cone__angle=angle,
        shaping__cone__softness=softness,
        shaping__focus=focus,
    )
    start = angle * (1.0 - softness)
    t = np.clip((off - start) / (angle - start), 0, 1) if softness else float(off > angle)
    factor = math.cos(a) ** focus * (1.0 - t * t * (3.0 - 2.0 * t))
    even = NITS * math.pi * 0.01**2 * math.cos(a) ** 4 / HEIGHT**2
    assert lux(made)[1] == pytest.approx(factor * even, rel=0.01, abs=1e-6)


def test_points_have_the_flux_of_their_intensity() -> None:
    """A ball of radius r sends pi^2 4 r^2 L lumen: without any, by its intensity alone."""
    made = small.patch()
    light(made, "Sphere", radius=0.0).CreateTreatAsPointAttr(True)
    assert lux(made, 1024)[1] == pytest.approx(NITS / 4.0 / HEIGHT**2, rel=0.02)


@pytest.mark.parametrize("kind", ["Sphere", "Disk", "Cylinder"])
def test_lights_of_no_size_are_left_out(kind: str) -> None:
    made = small.patch()
    light(made, kind, radius=0.0)
    scene = translate(made.stage)
    assert all(patch.radiance is None for patch in scene.patches)
    assert ("/L", "skipped", "it has no size") in scene.report.losses()
    assert lux(made).max() == 0.0


@pytest.mark.parametrize("kind", ["Rect", "Disk", "Sphere", "Cylinder"])
def test_lights_alone_are_seen_and_all_else_is_black(kind: str) -> None:
    made = small.Stage()
    made.camera((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), up=(0, 1, 0), fov=40.0, aspect=1.0)
    light(made, kind)
    session = session_of(made.stage, variant="scalar")
    pixels = radiance(session, width=16, height=16, samples=1)
    assert np.unique(pixels.round(2)).tolist() == [0.0, NITS]


@pytest.mark.parametrize("kind", ["Distant", "Dome"])
def test_light_from_afar_alone_is_no_error(kind: str) -> None:
    made = small.Stage()
    getattr(UsdLux, f"{kind}Light").Define(made.stage, "/L").CreateIntensityAttr(NITS)
    session = session_of(made.stage, variant="scalar")
    pixels = radiance(session, camera=None, width=4, height=4, samples=1)
    assert (pixels == (NITS if kind == "Dome" else 0.0)).all()


@pytest.mark.parametrize("scale", [(2.0, 1.0, 1.0), (-2.0, 1.0, 1.0), (2.0, 1.0, -1.0)])
def test_scaled_and_mirrored_lights_keep_their_side(scale: tuple[float, float, float]) -> None:
    """An elongated rectangle, seen from afar; -Z of a light whose Z is mirrored looks up."""
    made = small.patch()
    light(made, "Rect", width=0.02, height=0.02).AddScaleOp().Set(Gf.Vec3f(*scale))
    expected = 2.0 * NITS * 0.02**2 / HEIGHT**2 if scale[2] > 0 else 0.0
    assert lux(made)[1] == pytest.approx(expected, rel=1e-3)


def test_all_domes_shine() -> None:
    made = small.patch()
    made.dome(radiance=NITS)
    made.dome("/Second", 2.0 * NITS)
    assert lux(made, 256)[1] == pytest.approx(3.0 * math.pi * NITS, rel=0.02)


def test_domes_of_any_turn_are_summed_by_direction(tmp_path: Path) -> None:
    """Two smooth pictures, 1 + a d for a direction d: their sum has the sum of both."""
    rows, columns = 32, 64
    polar = np.pi * (np.arange(rows) + 0.5)[:, None] / rows
    around = np.pi - 2.0 * np.pi * (np.arange(columns) + 0.5) / columns
    x, y = np.sin(polar) * np.sin(around), np.cos(polar) * np.ones(columns)
    z = np.sin(polar) * np.cos(around)
    made, expected = small.Stage(), []
    ways = np.random.default_rng(0).normal(size=(400, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    for name, tilt in (("One", (0.9, 0.0, 0.0)), ("Other", (0.0, 0.5, 0.4))):
        values = 1.0 + tilt[0] * x + tilt[1] * y + tilt[2] * z
        file = save_picture(tmp_path / f"{name}.exr", np.stack([values] * 3, -1).astype(np.float32))
        dome = UsdLux.DomeLight.Define(made.stage, f"/{name}")
        dome.CreateTextureFileAttr(file)
        dome.AddRotateXYZOp().Set(Gf.Vec3f(20.0, 30.0 if name == "One" else -50.0, 70.0))
        turn = np.array(dome.GetLocalTransformation())[:3, :3]
        expected.append(1.0 + ways @ (np.array(tilt) @ turn))
    sky = surroundings(translate(made.stage))
    flat = sky.radiance[..., 1].ravel()
    nearest = flat[(ways @ sky.directions.reshape(-1, 3).T).argmax(axis=1)]
    np.testing.assert_allclose(nearest, sum(expected), atol=0.12)
    assert abs((nearest - sum(expected)).mean()) < 0.01


def test_shapes_that_are_lights_emit() -> None:
    """A sphere of `UsdGeom` with LightAPI."""
    made = small.patch()
    ball = UsdGeom.Sphere.Define(made.stage, "/Ball")
    ball.CreateRadiusAttr(0.1)
    ball.AddTranslateOp().Set(Gf.Vec3d(0.0, 0.0, HEIGHT))
    UsdLux.LightAPI.Apply(ball.GetPrim()).CreateIntensityAttr(NITS)
    assert lux(made, 1024)[1] == pytest.approx(NITS * math.pi * 0.1**2 / HEIGHT**2, rel=0.03)


def test_the_picture_of_a_glow_is_tinted_by_the_light(tmp_path: Path) -> None:
    glow = save_picture(tmp_path / "glow.exr", np.full((4, 4, 3), (2.0, 1.0, 0.5), np.float32))
    made = small.Stage()
    material = made.material("/Glow", emissive=Texture(glow, color_space="raw"))
    prim = made.quad("/Sheet", small.square((0, 0, 0), 1, "-Y"), material=material).GetPrim()
    UsdLux.MeshLightAPI.Apply(prim)
    UsdLux.LightAPI(prim).CreateIntensityAttr(10.0)
    UsdLux.LightAPI(prim).CreateColorAttr(Gf.Vec3f(1.0, 0.5, 0.25))
    made.camera((0.0, -2.0, 0.0), (0.0, 0.0, 0.0), fov=20.0, aspect=1.0)
    session = session_of(made.stage, variant="scalar")
    pixels = radiance(session, width=2, height=2, samples=4)
    np.testing.assert_allclose(pixels.reshape(-1, 3), [[20.0, 5.0, 1.25]] * 4, rtol=1e-3)


@pytest.mark.parametrize("size", [(1, 1), (1, 8), (2, 4), (4, 8), (32, 64)])
def test_a_bright_pixel_of_a_small_dome_brings_what_lies_between_pixels(
    tmp_path: Path, size: tuple[int, int]
) -> None:
    """By the integral of the rows' means, linear between their centres."""
    pixels = np.ones((*size, 3), dtype=np.float32)
    pixels[size[0] // 4, size[1] // 2] = 1e4
    polar = (np.arange(4000) + 0.5) / 4000 * np.pi / 2.0
    rows = np.pi * (np.arange(size[0]) + 0.5) / size[0]
    even = np.interp(polar, rows, pixels[..., 1].mean(axis=1, dtype=np.float64))
    expected = 2.0 * np.pi * (even * np.sin(polar) * np.cos(polar)).sum() * np.pi / 8000
    made = small.patch()
    dome = UsdLux.DomeLight.Define(made.stage, "/Dome")
    dome.CreateTextureFileAttr(save_picture(tmp_path / "sky.exr", pixels))
    dome.OrientToStageUpAxis()
    assert lux(made, 1024)[1] == pytest.approx(expected, rel=0.015)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("intensity", math.inf),
        ("intensity", 1e38),
        ("exposure", 1e4),
        ("radius", -1.0),
        ("radius", math.nan),
        ("colorTemperature", -5.0),
        ("color", Gf.Vec3f(math.nan)),
    ],
)
def test_broken_values_give_a_picture(name: str, value: Any) -> None:
    made = small.patch()
    light(made, "Sphere", enableColorTemperature=True, **{name: value})
    assert np.isfinite(lux(made, 4)).all()


THIN: dict[str, dict[str, Any]] = {
    "Sphere": {"radius": 0.0, "normalize": True},
    "Disk": {"radius": 0.0, "normalize": True},
    "Rect": {"width": 0.0, "height": 0.0, "normalize": True},
    "Cylinder": {"radius": 0.0, "length": 0.002, "normalize": True},
}


@pytest.mark.parametrize("kind", THIN)
def test_a_light_of_no_size_lights_without_being_seen(shoot: Any, kind: str) -> None:
    """Its flux is that of its intensity: a sphere, and a line from the side, give I / 4 d^2."""
    nits, height = 1000.0, 2.0
    made = small.Stage()
    grey = made.material("/Grey", base_color=(0.5,) * 3)
    made.quad("/Floor", small.square((0, 0, 0), 4), material=grey)
    made.light(kind, "/Thin", nits, at=(0, 0, height), **THIN[kind])
    # From above, through the light.
    made.camera((0, 0, 4), (0, 0, 0), up=(0, 1, 0), fov=5, aspect=1.0)
    images = shoot(made.stage, "radiance", "depth", width=9, height=9, samples=64, bounces=1).images
    shares = {"Sphere": 0.25, "Disk": 1.0, "Rect": 1.0, "Cylinder": 1.0 / math.pi}
    expected = 0.5 / math.pi * shares[kind] * nits / height**2
    assert images["radiance"].pixels.mean() == pytest.approx(expected, rel=0.06)
    assert images["radiance"].pixels.max() < 2.0 * expected
    assert images["depth"].pixels == pytest.approx(4.0, abs=1e-5)


def test_a_point_is_as_its_hint_says() -> None:
    """Without normalize, too; and a sphere of no radius without either sends nothing."""
    made = small.Stage()
    made.light("Sphere", "/Point", 10.0, at=(0, 0, 1), radius=0.0)
    assert ("/Point", "skipped", "it has no size") in translate(made.stage).report.losses()
    made.stage.GetPrimAtPath("/Point").GetAttribute("treatAsPoint").Set(True)
    (patch,) = [patch for patch in translate(made.stage).patches if patch.lamp]
    assert patch.unseen and patch.radiance == pytest.approx((10.0 / (4e-6 * np.pi),) * 3, rel=1e-3)
