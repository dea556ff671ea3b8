"""Lamps that follow an IES profile: the inverse square law, the path tracer, the records."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdLux

from openrooms_usd.arrays import Array
from openrooms_usd.rendering.scene.models import without_shaping
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.usd.light.profiles import parse_profile
from openrooms_usd.usd.light.shaping import define_shaping
from orusd_mitsuba.plugins.light_weights import flux_of
from tests import small
from tests.mitsuba.rendering import passes, pictures, session_of
from tests.mitsuba.statistics import blocks, z_of
from tests.small import square

POLAR = (0, 10, 20, 40, 60, 90, 180)
AROUND = (0, 90, 180, 270, 360)
CANDELA = (
    "100 90 70 30 10 4 1",
    "100 80 40 20 10 4 1",
    "100 95 80 60 30 8 1",
    "100 85 50 40 20 4 1",
    "100 90 70 30 10 4 1",
)
HEAD = f"IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 {len(POLAR)} {len(AROUND)} 1 2 0 0 0\n1 1 10"
ANGLES = (" ".join(map(str, row)) for row in (POLAR, AROUND))
TEXT = "\n".join([HEAD, *ANGLES, *CANDELA, ""])
NITS, RADIUS = 5000.0, 0.02


@pytest.fixture
def file(tmp_path: Path) -> str:
    (tmp_path / "lamp.ies").write_text(TEXT)
    return str(tmp_path / "lamp.ies")


def ball(made: Any, file: str, center: tuple[float, float, float], radius: float) -> None:
    light = made.light("Sphere", "/Lamp", NITS, at=center, turn=(20.0, 0.0, 30.0), radius=radius)
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
def test_lux_below_follow_the_inverse_square(lit: Any, file: str, at: tuple[float, float]) -> None:
    x, y = at
    made = small.patch((x, y, 0))
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


def furnished(file: str) -> Any:
    """A closed room with a box on the floor, a profiled ball and a profiled panel."""
    made = small.room(4.0)
    made.box("/Table", 0.5, material="/Grey")
    made.camera((0.2, -0.3, 0.9), (1.0, 1.0, -0.6), fov=80, aspect=1.0)
    ball(made, file, (0.9, 1.4, 0.1), 0.2)
    panel = made.quad("/Panel", square((0.5, 0.5, 1.9), 0.3, "-Z"), material="/Grey", nits=400.0)
    define_shaping(panel.GetPrim(), file)
    return made


def test_the_records_have_the_flux(lit: Any, file: str) -> None:
    from openrooms_usd.rendering.scene.light_records import light_records

    scene = lit(furnished(file).stage)
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


def test_what_knows_no_profiles_keeps_the_flux_and_says_so(file: str) -> None:
    scene = translate(furnished(file).stage)
    even = without_shaping(scene)
    assert all(patch.shaping is None for patch in even.patches)
    assert [flux_of(p) for p in even.patches] == pytest.approx([flux_of(p) for p in scene.patches])
    told = {path for path, _, reason in even.report.losses() if "shines evenly" in reason}
    assert told == {"/Lamp", "/Panel"}


def test_points_on_lamps_and_hits_agree(lit: Any, file: str) -> None:
    """The lights one by one, and Mitsuba's own choice of points: the same irradiance."""
    scene = lit(furnished(file).stage)
    white = scene.paths(2, (16, 16), by_light=False, first=scene.first)
    theirs = np.pi * passes(white, 6, 64)[:, 1]
    lights = len(scene.sources)
    ours = np.stack([scene.direct(16, seed)[:lights].sum(axis=0) for seed in range(6)])
    a, b = ours.mean(axis=(1, 2, 3)), theirs.mean(axis=(1, 2, 3))
    assert abs(z_of(a, b)) < 4.0
    assert np.sqrt((a.var(ddof=1) + b.var(ddof=1)) / 6) < 0.02 * a.mean()


def test_all_backends_see_what_the_ball_sends(shoot: Any, file: str) -> None:
    made = small.Stage()
    ball(made, file, (0.0, 0.0, 0.0), 0.5)
    eye = np.array([0.7, -2.0, -3.0])
    made.camera(tuple(eye.tolist()), (0.0, 0.0, 0.0), fov=0.5, aspect=1.0)
    view = shoot(made.stage, "radiance", samples=4)
    way = eye / np.linalg.norm(eye)
    expected = candela(way, turned(), 0.5) / (np.pi * 0.5**2)
    assert view.images["radiance"].pixels.mean() == pytest.approx(expected, rel=0.01)


@pytest.mark.slow
def test_passes_and_methods_agree(vectorized: str, file: str) -> None:
    """All channels at once, the parts of radiance alone, the cache."""
    session = session_of(furnished(file).stage)
    paths = pictures(session, ["radiance"], range(8))["radiance"]
    whole = pictures(session, ["radiance", "irradiance", "direct_i"], range(8))
    cached = pictures(session, ["radiance", "indirect"], range(8), method="cache")
    for other in (whole["radiance"], cached["radiance"]):
        assert_alike(other, paths)


@pytest.mark.slow
def test_a_lamp_that_is_carried_takes_its_profile_along(lit: Any, file: str) -> None:
    session = session_of(furnished(file).stage)
    before = pictures(session, ["radiance"], [0])["radiance"]
    turn = np.diag([1.0, -1.0, -1.0, 1.0])
    place = np.eye(4)
    place[:3, 3] = 0.9, 1.4, 0.1
    motion = place @ turn @ np.linalg.inv(place)
    session.move({"/Lamp": motion})
    moved = pictures(session, ["radiance"], range(4))["radiance"]
    other = furnished(file)
    lamp = UsdGeom.Xformable(other.stage.GetPrimAtPath("/Lamp"))
    lamp.ClearXformOpOrder()
    M = motion @ place
    M[:3, :3] = motion[:3, :3] @ turned()
    lamp.AddTransformOp(opSuffix="set").Set(Gf.Matrix4d(M.T.tolist()))
    there = pictures(session_of(other.stage), ["radiance"], range(4))["radiance"]
    assert np.abs(before[0] - moved[0]).max() > 1.0
    assert_alike(moved, there)


def assert_alike(one: Array, other: Array) -> None:
    """Blocks of two sets of pictures have the same means, but for noise or 2 %."""
    z = z_of(blocks(one), blocks(other))
    far = np.abs(blocks(one).mean(axis=0) / blocks(other).mean(axis=0) - 1.0)
    assert ((np.abs(z) < 5.0) | (far < 0.02)).all()
