"""The sun among the portals: found where it is, sampled where it comes in, counted once."""

from types import ModuleType
from typing import Any

import numpy as np
import pytest

from openrooms_usd.rendering.scene.arrays import Environment
from openrooms_usd.usd.light.lights import Portal
from orusd_mitsuba.plugins.light_weights import Beam, brightest_beam

# A window in the plane y = 1, half a metre about the axis, that looks along +Y.
WINDOW = np.array([[-1.0, 0, 0, 0], [0, 0, 1, 1], [0, 1, 0, 0], [0, 0, 0, 1]])
# Y up and -Z to the front, as Mitsuba has it, in the world.
TURN = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])


def sky(sun: float, row: int = 20, column: int = 0) -> np.ndarray:
    pixels = np.ones((65, 128, 3), dtype=np.float32)
    pixels[row, column] = sun
    return pixels


def emitter(mi: ModuleType, pixels: np.ndarray, beam: Beam | None) -> tuple[Any, Any]:
    from orusd_mitsuba.plugins.portal_environment import through_portals

    turn = np.eye(4)
    turn[:3, :3] = TURN
    inner = mi.load_dict(
        {
            "type": "envmap",
            "bitmap": mi.Bitmap(pixels),
            "to_world": mi.ScalarTransform4f(turn.tolist()),
        }
    )
    portal = Portal("/Window", WINDOW, 1.0, 1.0)
    made = through_portals(inner, (portal,), np.zeros(3), 2.0, 1.0, beam)
    scene = mi.load_dict({"type": "scene", "ball": {"type": "sphere"}, "sky": inner})
    return made, scene


@pytest.mark.parametrize(("row", "column"), [(20, 0), (1, 64), (40, 100), (32, 127)])
def test_the_beam_points_to_the_brightest_pixel(mi: ModuleType, row: int, column: int) -> None:
    """Mitsuba itself is asked how bright it is there."""
    import drjit as dr

    pixels = sky(1e6, row, column)
    found = brightest_beam(Environment(pixels, TURN))
    inner, _ = emitter(mi, pixels, None)
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi = -mi.Vector3f(found.direction.tolist())
    assert float(np.array(inner.eval(si)).max()) > 0.4e6
    assert 0.5 < found.share < 1.0


def test_an_even_sky_has_no_beam() -> None:
    assert brightest_beam(Environment(sky(1.0), TURN)).share < 0.01
    black = Environment(np.zeros((5, 8, 3), np.float32), TURN)
    assert brightest_beam(black).share == 0.0


# In the sun, in its shadow, and beyond the window, which no portal faces.
PLACES = [(0.0, 0.5, -0.6), (0.0, -3.0, 0.0), (0.0, 3.0, 0.0)]


@pytest.mark.one_in(9)
@pytest.mark.parametrize("share", [None, 0.3, 0.99])
@pytest.mark.parametrize("at", PLACES, ids=["sun", "shadow", "outside"])
def test_samples_add_up_to_all_the_light(
    mi: ModuleType, share: float | None, at: tuple[float, float, float]
) -> None:
    """The mean of radiance over density is the integral of the radiance, whatever the mixture."""
    import drjit as dr

    # The middle of the left edge looks along -Z of the light, the world's +Y, 34 degrees up.
    pixels = sky(500.0)
    direction = brightest_beam(Environment(pixels, TURN)).direction
    assert direction[1] > 0.5 and direction[2] > 0.3
    made, _scene = emitter(mi, pixels, None if share is None else Beam(direction, share))
    count = 1 << 18
    it = dr.zeros(mi.SurfaceInteraction3f, count)
    it.p = mi.Point3f(*at)
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(3, count)
    ds, weight = made.sample_direction(it, sampler.next_2d())
    values = np.array(weight)[0]
    density = np.array(made.pdf_direction(it, ds))
    np.testing.assert_allclose(density, np.array(ds.pdf), rtol=1e-5)
    theta, phi = np.meshgrid(
        np.pi * (np.arange(1024) + 0.5) / 1024, 2 * np.pi * np.arange(2048) / 2048, indexing="ij"
    )
    way = np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1
    ).reshape(-1, 3)
    si = dr.zeros(mi.SurfaceInteraction3f, len(way))
    si.wi = mi.Vector3f(*(-way.T).astype(np.float32))
    light = np.array(made.eval(si))[0]
    expected = float((light * np.sin(theta).ravel()).sum() * np.pi / 1024 * 2 * np.pi / 2048)
    spread = values.std() / np.sqrt(count)
    assert abs(values.mean() - expected) < 4 * spread + 2e-3 * expected


def test_the_sun_is_sampled_where_it_comes_in(mi: ModuleType) -> None:
    import drjit as dr

    pixels = sky(5e4)
    beam = brightest_beam(Environment(pixels, TURN))
    made, _scene = emitter(mi, pixels, beam)
    parts = []
    for at in PLACES[:2]:
        it = dr.zeros(mi.SurfaceInteraction3f, 1 << 14)
        it.p = mi.Point3f(*at)
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(5, 1 << 14)
        ds, _ = made.sample_direction(it, sampler.next_2d())
        to_sun = np.array(ds.d).T @ beam.direction
        parts.append(float((to_sun > np.cos(np.radians(5))).mean()))
    assert parts[0] > 0.7 and parts[1] < 0.2
