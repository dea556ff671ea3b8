"""Light that is filed adds up to Mitsuba's own, and each part of it is what theory says."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from pxr import Gf, UsdLux

from openrooms_usd.render import RenderRequest
from openrooms_usd.usd.lights import Portal, connect_portals, define_portal

SIZE = (32, 24)
Passes = NDArray[np.float64]


def window_of(y: float = 1.0) -> Portal:
    """Half a metre about the middle of the wall at ``y``, outwards along +Y."""
    world = np.eye(4)
    world[:3, :3] = np.array([[-1, 0, 0], [0, 0, 1], [0, 1, 0]]).T
    world[:3, 3] = [0.0, y, 0.0]
    return Portal("/Window", world, 1.0, 1.0)


def little_room(build: Any, sky: str | None = None, *, lamp: float = 50.0, **looks: Any) -> Any:
    """A room of two metres with a window, a lamp, a glossy box and a cloth: everything at once."""
    made = build()
    wall = made.material("/Wall", base_color=(0.7, 0.6, 0.5), **looks)
    shiny = made.material("/Shiny", **({"base_color": (0.2, 0.3, 0.6), "roughness": 0.2,
                                        "ior": 1.5} | looks))  # fmt: skip
    corners = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    walls = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [0, 4, 6, 2], [1, 3, 7, 5]]
    made.mesh("/Walls", corners, np.array(walls)[:, ::-1], material=wall)
    outer = [(-1, 1, -1), (1, 1, -1), (1, 1, 1), (-1, 1, 1)]
    inner = [(x / 2, 1, z / 2) for x, _, z in outer]
    ring = [[i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i] for i in range(4)]
    made.mesh("/Front", [*outer, *inner], ring, material=wall)
    made.box("/Box", 0.5, material=shiny).AddTranslateOp().Set(Gf.Vec3d(0.4, 0.2, -0.75))
    light = UsdLux.RectLight.Define(made.stage, "/Lamp")
    light.CreateIntensityAttr(lamp)
    light.CreateWidthAttr(0.4)
    light.CreateHeightAttr(0.2)
    light.AddTranslateOp().Set(Gf.Vec3d(-0.3, 0, 0.9))
    dome = made.dome(radiance=20.0)
    if sky:
        dome.CreateTextureFileAttr(sky)
    connect_portals(dome.GetPrim(), [define_portal(made.stage, window_of()).GetPrim()])
    made.camera((-0.6, -0.9, 0.2), (0.3, 0.9, -0.4), fov=75)
    return made.stage


@pytest.fixture
def sun(save_picture: Any, tmp_path: Path) -> str:
    """A sky of one unit with a small sun, thirty degrees up, that shines in by the window."""
    pixels = np.ones((32, 64, 3), dtype=np.float32)
    pixels[10, :] = 2.0
    pixels[10, 48] = 3000.0
    return save_picture(tmp_path / "sky.exr", pixels)


def integrator_of(room: Any, depth: int = 8, size: tuple[int, int] = SIZE, **how: Any) -> Any:
    from orusd_mitsuba.transport.path_integrator import PathIntegrator

    return PathIntegrator(
        room.built, room.index, room.camera(*size), *size, room.scene.origin, depth, **how
    )


def passes(integrator: Any, count: int = 12, samples: int = 16, seed: int = 100) -> Passes:
    """(count, planes, height, width, 3)."""
    return np.stack([integrator(samples, seed + n) for n in range(count)]).astype(np.float64)


def blocks(pictures: Passes) -> Passes:
    """(..., 12) means of blocks of 8 by 8 pixels, of all colours."""
    *rest, height, width, _ = pictures.shape
    cut = pictures.mean(axis=-1).reshape(*rest, height // 8, 8, width // 8, 8)
    return cut.mean(axis=(-3, -1)).reshape(*rest, -1)


def distances(a: Passes, b: Passes) -> Passes:
    """How far the means of two sets of passes are apart, in standard errors, block by block."""
    error = np.sqrt(a.var(axis=0, ddof=1) / len(a) + b.var(axis=0, ddof=1) / len(b))
    return (a.mean(axis=0) - b.mean(axis=0)) / np.maximum(error, 1e-12)


def assert_alike(a: Passes, b: Passes) -> None:
    z = distances(blocks(a), blocks(b))
    assert np.abs(z).max() < 5.0
    assert np.mean(z**2) < 2.2


@pytest.mark.slow
def test_the_sum_is_what_mitsubas_own_integrator_gives(build: Any, lit: Any, sun: str) -> None:
    """The z of every block of pixels, by independent passes of both."""
    from orusd_mitsuba.transport.builtin_integrator import BuiltinIntegrator

    room = lit(little_room(build, sun))
    request = RenderRequest("/Camera", ("radiance",), *SIZE, samples=1, bounces=7)
    theirs = BuiltinIntegrator(room.built, room.camera(*SIZE), request, room.scene.origin)
    ours = passes(integrator_of(room, by_light=False)).sum(axis=1)
    assert_alike(ours, passes(theirs, seed=900)[:, 0])


def test_kinds_and_lights_are_two_ways_to_add_up_the_same(build: Any, lit: Any, sun: str) -> None:
    from orusd_mitsuba.transport.path_tracing import KINDS

    planes = integrator_of(lit(little_room(build, sun)))(16, 1).astype(np.float64)
    kinds, lights = planes[: len(KINDS)], planes[len(KINDS) :]
    assert len(lights) == 3 and (planes >= 0).all()
    np.testing.assert_allclose(kinds.sum(axis=0), lights.sum(axis=0), rtol=2e-5, atol=1e-6)
    # Nothing comes in but by the window.
    assert lights[2].max() == 0.0
    assert all(part.max() > 0.0 for part in (*kinds, *lights[:2]))


@pytest.mark.slow
def test_a_light_that_is_off_is_dark_and_changes_no_other(build: Any, lit: Any) -> None:
    both, one = (passes(integrator_of(lit(little_room(build, lamp=nits)))) for nits in (50.0, 0.0))
    # After the three kinds: the lamp, the window, the rest.
    assert_alike(both[:, 4], one[:, 4])
    assert one[:, 3].max() == 0.0 and both[:, 3].max() > 0.0


def test_equal_seeds_give_equal_bits_and_others_do_not(build: Any, lit: Any, sun: str) -> None:
    integrator = integrator_of(lit(little_room(build, sun)))
    first, again, other = (integrator(4, seed) for seed in (5, 5, 6))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


@pytest.mark.slow
def test_bands_and_passes_agree_within_their_noise(
    build: Any, lit: Any, sun: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    from orusd_mitsuba.transport import bands

    room = lit(little_room(build, sun))
    whole = passes(integrator_of(room))
    monkeypatch.setattr(bands, "_PATHS_IN_FLIGHT", 32 * 5)
    banded = integrator_of(room)
    assert banded.most == 1
    many = passes(banded, count=48, samples=1, seed=700)
    assert_alike(whole[:, 3:].sum(axis=1), many[:, :3].sum(axis=1))


@pytest.mark.slow
def test_a_white_first_surface_receives_what_lambert_sends(build: Any, lit: Any, sun: str) -> None:
    """irradiance x base_color / pi = direct + indirect where everything is exactly Lambertian."""
    from openrooms_usd.render.scene.first_hits import first_hits
    from openrooms_usd.render.scene.ground_truth import GroundTruth
    from orusd_mitsuba.tracer import MitsubaTracer

    room = lit(little_room(build, sun, roughness=1.0, ior=1.0))
    camera = room.camera(*SIZE)
    hits = first_hits(room.scene, MitsubaTracer(room.scene, room.built), camera, *SIZE)
    color = GroundTruth(room.scene, camera, hits).channel("base_color").astype(np.float64)
    received = passes(integrator_of(room, first=room.first))[:, 1:3].sum(axis=1)
    sent = passes(integrator_of(room), seed=400)[:, 1:3].sum(axis=1)
    # Blocks of one colour alone: at edges the centre's colour is not the pixel's.
    even = color.reshape(3, 8, 4, 8, 3)
    pure = (even.max(axis=(1, 3)) - even.min(axis=(1, 3))).max(axis=-1).ravel() < 1e-6
    assert pure.sum() >= 3
    z = distances(blocks(received * color), blocks(sent))[pure]
    assert np.abs(z).max() < 4.5


@pytest.mark.parametrize(("albedo", "bounces"), [(0.0, 7), (0.6, 7), (1.0, 7), (0.95, 50)])
def test_a_glowing_room_adds_one_power_of_the_albedo_for_each_bounce(
    build: Any, lit: Any, albedo: float, bounces: int
) -> None:
    """A furnace: emission 1, direct a, indirect a^2 + ... + a^bounces."""
    made = build()
    glowing = made.material("/Glow", base_color=(albedo,) * 3, emissive=(1.0, 1.0, 1.0))
    made.box("/Room", 4.0, inside=True, material=glowing)
    made.camera((0.3, -0.5, 0.2), (1, 1, 0.1))
    found = passes(integrator_of(lit(made.stage), bounces + 1, by_light=False), 4, 16)
    powers = albedo ** np.arange(bounces + 1)
    expected = [powers[0], powers[1], powers[2:].sum()]
    means = found.mean(axis=(0, 2, 3, 4))
    pixels = found.mean(axis=-1)
    error = pixels.std(axis=(0, 2, 3)) / np.sqrt(pixels[:, 0].size)
    assert (np.abs(means - expected) <= 4.5 * error + 2e-4 * np.array(expected)).all()
