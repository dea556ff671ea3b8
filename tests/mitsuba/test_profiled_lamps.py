"""Lamps that follow an IES profile: the inverse square law, the path tracer, the records."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from pxr import Gf, UsdGeom, UsdLux

from openrooms_usd.render import RenderRequest
from openrooms_usd.render.scene.models import without_shaping
from openrooms_usd.render.scene.translate import translate
from openrooms_usd.usd.lights import define_mesh_light
from openrooms_usd.usd.profiles import parse_profile
from openrooms_usd.usd.shaping import define_shaping
from orusd_mitsuba import MitsubaRenderer
from orusd_mitsuba.plugins.light_weights import flux_of
from tests.mitsuba.lamps import SIZE, blocks, view_of, z_of
from tests.opening import open_with

Array = NDArray[np.float64]
WHITE = (1.0, 1.0, 1.0)
POLAR = (0, 10, 20, 40, 60, 90, 180)
AROUND = (0, 90, 180, 270, 360)
CANDELA = ((100, 90, 70, 30, 10, 4, 1), (100, 80, 40, 20, 10, 4, 1), (100, 95, 80, 60, 30, 8, 1),
           (100, 85, 50, 40, 20, 4, 1), (100, 90, 70, 30, 10, 4, 1))  # fmt: skip
TEXT = "\n".join([
    "IESNA:LM-63-2002", "TILT=NONE", f"1 1000 1 {len(POLAR)} {len(AROUND)} 1 2 0 0 0", "1 1 10",
    *(" ".join(map(str, row)) for row in (POLAR, AROUND, *CANDELA)), ""])  # fmt: skip
NITS, RADIUS = 5000.0, 0.02


@pytest.fixture
def file(tmp_path: Path) -> str:
    (tmp_path / "lamp.ies").write_text(TEXT)
    return str(tmp_path / "lamp.ies")


def ball(made: Any, file: str, center: tuple[float, float, float], radius: float) -> None:
    light = UsdLux.SphereLight.Define(made.stage, "/Lamp")
    light.CreateRadiusAttr(radius)
    light.CreateIntensityAttr(NITS)
    light.AddTranslateOp().Set(center)
    light.AddRotateXYZOp().Set((20.0, 0.0, 30.0))
    define_shaping(light.GetPrim(), file)


def candela(ways: Array, turn: Array, radius: float) -> Array:
    """What a ball sends along directions of the world."""
    profile = parse_profile(TEXT, "")
    return NITS * np.pi * radius**2 * profile.intensity(ways @ turn) / profile.mean


def turned() -> Array:
    """(3, 3) of the ball in the world."""
    a, b = np.radians([20.0, 30.0])
    x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    z = np.array([[np.cos(b), -np.sin(b), 0], [np.sin(b), np.cos(b), 0], [0, 0, 1]])
    return np.asarray(z @ x)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("at", [(0.5, -0.4), (0.9, 0.3), (-1.1, 0.8), (0.4, -2.0)])
def test_lux_below_follow_the_inverse_square(
    build: Any, lit: Any, file: str, at: tuple[float, float]
) -> None:
    made = build()
    x, y = at
    made.quad("/Patch", [(x - 0.01, y - 0.01, 0), (x + 0.01, y - 0.01, 0), (x + 0.01, y + 0.01, 0),
                         (x - 0.01, y + 0.01, 0)],
              material=made.material("/White", base_color=WHITE))  # fmt: skip
    made.camera((x, y - 0.5, 0.5), (x, y, 0), fov=0.5, aspect=1.0)
    ball(made, file, (0.0, 0.0, 2.0), RADIUS)
    found = lit(made.stage).lights(16)
    UsdLux.ShapingAPI(made.stage.GetPrimAtPath("/Lamp")).GetShapingIesFileAttr().Clear()
    even = lit(made.stage).lights(16)["unoccluded_i"][0].mean()
    way = np.array([x, y, -2.0])
    distance = np.linalg.norm(way)
    expected = candela(way / distance, turned(), RADIUS) * 2.0 / distance**3
    assert found["unoccluded_i"][0].mean() == pytest.approx(expected, rel=0.01)
    # Of the same samples: the noise is that of the ball's facets.
    share = expected * distance**3 / 2.0 / (NITS * np.pi * RADIUS**2)
    assert found["unoccluded_i"][0].mean() / even == pytest.approx(share, rel=2e-3)
    np.testing.assert_array_equal(found["visibility_i"][0], 1.0)


def furnished(build: Any, file: str) -> Any:
    """A closed room with a box on the floor, a profiled ball and a profiled panel."""
    made = build()
    made.box("/Room", 4.0, inside=True, material=made.material("/Grey", base_color=(0.5, 0.5, 0.5)))
    made.box("/Table", 0.5, material="/Grey")
    made.camera((0.2, -0.3, 0.9), (1.0, 1.0, -0.6), fov=80, aspect=1.0)
    ball(made, file, (0.9, 1.4, 0.1), 0.2)
    corners = [(0.2, 0.2, 1.9), (0.2, 0.8, 1.9), (0.8, 0.8, 1.9), (0.8, 0.2, 1.9)]
    panel = made.quad("/Panel", corners, material="/Grey").GetPrim()
    define_mesh_light(panel, nits=400.0)
    define_shaping(panel, file)
    return made


def test_the_records_have_the_flux(build: Any, lit: Any, file: str) -> None:
    from openrooms_usd.render.scene.light_records import light_records

    scene = lit(furnished(build, file).stage)
    records = {one.name: one for one in light_records(scene.stage, scene.scene, scene.sources)}
    # By the mean over even directions of what the ball sends.
    rng = np.random.default_rng(0)
    ways = rng.normal(size=(200_000, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    ball = 4.0 * np.pi * candela(ways, turned(), 0.2).mean()
    assert records["Lamp"].lumen == pytest.approx(ball, rel=0.01)
    profile = parse_profile(TEXT, "")
    sent = np.maximum(-ways[:, 2], 0.0) * profile.intensity(ways) / profile.mean
    panel = 4.0 * np.pi * 400.0 * 0.36 * sent.mean()
    assert records["Panel"].lumen == pytest.approx(panel, rel=0.01)


def test_what_knows_no_profiles_keeps_the_flux_and_says_so(build: Any, file: str) -> None:
    scene = translate(furnished(build, file).stage)
    even = without_shaping(scene)
    assert all(patch.shaping is None for patch in even.patches)
    assert [flux_of(p) for p in even.patches] == pytest.approx([flux_of(p) for p in scene.patches])
    told = {path for path, _, reason in even.report.losses() if "shines evenly" in reason}
    assert told == {"/Lamp", "/Panel"}


def test_points_on_lamps_and_hits_agree(build: Any, lit: Any, file: str) -> None:
    """The lights one by one, and Mitsuba's own choice of points: the same irradiance."""
    from orusd_mitsuba.transport.path_integrator import PathIntegrator

    scene = lit(furnished(build, file).stage)
    integrator = PathIntegrator(scene.built, scene.index, scene.camera(16, 16), 16, 16,
                                scene.scene.origin, 2, by_light=False,
                                first=scene.first)  # fmt: skip
    theirs = np.stack([integrator(64, 100 + seed)[1] for seed in range(6)]) * np.pi
    lights = len(scene.sources)
    ours = np.stack([scene.direct(16, seed)[:lights].sum(axis=0) for seed in range(6)])
    a, b = ours.mean(axis=(1, 2, 3)), theirs.mean(axis=(1, 2, 3))
    spread = np.sqrt((a.var(ddof=1) + b.var(ddof=1)) / 6)
    assert abs(a.mean() - b.mean()) < 4.0 * spread
    assert spread < 0.02 * a.mean()


def test_all_backends_see_what_the_ball_sends(build: Any, shoot: Any, file: str) -> None:
    made = build()
    ball(made, file, (0.0, 0.0, 0.0), 0.5)
    eye = np.array([0.7, -2.0, -3.0])
    made.camera(tuple(eye.tolist()), (0.0, 0.0, 0.0), fov=0.5, aspect=1.0)
    view = shoot(made.stage, "radiance", samples=4)
    way = eye / np.linalg.norm(eye)
    expected = candela(way, turned(), 0.5) / (np.pi * 0.5**2)
    assert view.images["radiance"].pixels.mean() == pytest.approx(expected, rel=0.01)


@pytest.mark.slow
def test_passes_and_methods_agree(build: Any, lit: Any, file: str) -> None:
    """All channels at once, the parts of radiance alone, the cache."""
    del lit
    stage = furnished(build, file).stage
    whole = view_of(stage, "radiance", "radiance_i", "irradiance", "irradiance_i",
                    "irradiance_direct", "direct_i")  # fmt: skip
    for stem, one in (("radiance_", "radiance"), ("irradiance_", "irradiance"),
                      ("direct_", "irradiance_direct")):  # fmt: skip
        lights = [whole[f"{stem}{number}"] for number in range(3)]
        np.testing.assert_allclose(sum(lights), whole[one], rtol=1e-3, atol=1e-3)
    paths = view_of(stage, "radiance")["radiance"]
    cached = view_of(stage, "radiance", "indirect", method="cache")["radiance"]
    for other in (whole["radiance"], cached):
        assert_alike(other, paths)


@pytest.mark.slow
def test_a_lamp_that_is_carried_takes_its_profile_along(build: Any, lit: Any, file: str) -> None:
    del lit
    session = open_with(MitsubaRenderer(), furnished(build, file).stage)
    request = [RenderRequest("/Camera", ("radiance",), *SIZE, samples=16, seed=n) for n in range(4)]
    before = session.render(request[0]).images["radiance"].pixels
    turn = np.diag([1.0, -1.0, -1.0, 1.0])
    place = np.eye(4)
    place[:3, 3] = 0.9, 1.4, 0.1
    motion = place @ turn @ np.linalg.inv(place)
    session.move({"/Lamp": motion})
    moved = [session.render(one).images["radiance"].pixels for one in request]
    other = furnished(build, file)
    lamp = UsdGeom.Xformable(other.stage.GetPrimAtPath("/Lamp"))
    lamp.ClearXformOpOrder()
    M = motion @ place
    M[:3, :3] = motion[:3, :3] @ turned()
    lamp.AddTransformOp(opSuffix="set").Set(Gf.Matrix4d(M.T.tolist()))
    fresh = open_with(MitsubaRenderer(), other.stage)
    there = [fresh.render(one).images["radiance"].pixels for one in request]
    assert np.abs(before - moved[0]).max() > 1.0
    assert_alike(np.stack(moved), np.stack(there))


def assert_alike(one: Array, other: Array) -> None:
    """Blocks of two sets of pictures have the same means, but for noise or 2 %."""
    z = z_of(blocks(one), blocks(other))
    far = np.abs(blocks(one).mean(axis=0) / blocks(other).mean(axis=0) - 1.0)
    assert ((np.abs(z) < 5.0) | (far < 0.02)).all()
