"""What an opening sees of the surroundings: flux, panorama and the three lobes."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from openrooms_usd.arrays import Array
from openrooms_usd.library.surroundings.sky import Air, daylight, sun_direction
from openrooms_usd.library.surroundings.sunlight import SunPosition
from openrooms_usd.rendering.scene.lights import Gaussian
from openrooms_usd.usd.light.lights import Portal

# The picture's upper edge is the world's up, its middle looks along -Y.
DOME = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], dtype=np.float64)
SUN = SunPosition(azimuth=150.0, elevation=35.0, apparent=35.0, distance=1.0)


def portal(outwards: tuple[float, float, float] = (0.0, -1.0, 0.0)) -> Portal:
    z = np.array(outwards)
    x = np.cross([0.0, 0.0, 1.0], z)
    world = np.eye(4)
    world[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    return Portal("/Portal", world, 1.0, 1.0)


def around(pixels: Any, suns: tuple[Any, ...] = ()) -> Any:
    from openrooms_usd.rendering.scene.arrays import Environment
    from openrooms_usd.rendering.scene.lamps import _pole_to_pole
    from openrooms_usd.rendering.scene.surroundings import surroundings

    whole = _pole_to_pole(pixels.astype(np.float32)) if len(pixels) > 1 else pixels
    return surroundings(SimpleNamespace(environment=Environment(whole, DOME), suns=suns))  # type: ignore[arg-type]


def lux(lobes: tuple[Gaussian, ...], outwards: Array) -> Array:
    """What lobes send through a plane, by plain integration; sharp ones by their flux."""
    from openrooms_usd.rendering.scene.surroundings import latlong

    ways, weights = latlong(128)
    total = np.zeros(3)
    for lobe in lobes:
        if lobe.sharpness > 1e4:
            flux = 2.0 * np.pi / lobe.sharpness * lobe.amplitude
            total += flux * max(0.0, float(lobe.axis @ outwards))
        else:
            shape = np.exp(lobe.sharpness * (ways @ lobe.axis - 1.0))
            total += lobe.amplitude * float(
                (shape * np.maximum(ways @ outwards, 0.0) * weights).sum()
            )
    return total


def test_an_even_sky_sends_pi_l_through_every_window() -> None:
    from openrooms_usd.rendering.scene.surroundings import passing

    sky = around(np.full((1, 1, 3), 7.0))
    for outwards in np.eye(3):
        np.testing.assert_allclose(passing(sky, outwards), 7.0 * np.pi, rtol=5e-3)


def test_a_panorama_has_the_flux_of_the_sky_and_the_sun_in_its_place() -> None:
    from openrooms_usd.rendering.scene.surroundings import latlong, panorama, passing

    sky = around(daylight(SUN, Air(), height=360))
    window = portal()
    outwards = window.world_from_portal[:3, 2]
    for height in (64, 256):
        found = panorama(sky, window, height).astype(np.float64)
        ways, weights = latlong(height)
        assert found.shape == (height, 2 * height, 3)
        assert not found[ways @ outwards <= 0.0].any()
        cosine = np.maximum(ways @ outwards, 0.0) * weights
        np.testing.assert_allclose(
            np.einsum("hw,hwc->c", cosine, found), passing(sky, outwards), rtol=0.02
        )
        brightest = np.unravel_index(int(found.sum(axis=2).argmax()), found.shape[:2])
        assert ways[brightest] @ sun_direction(SUN, 0.0) > np.cos(np.pi / height)


def test_parallel_light_comes_in_whole_and_only_from_its_side() -> None:
    from openrooms_usd.rendering.scene.arrays import Sun
    from openrooms_usd.rendering.scene.light_records import fit
    from openrooms_usd.rendering.scene.surroundings import latlong, panorama, passing

    way = np.array([0.0, -0.8, 0.6])
    sky = around(np.ones((1, 1, 3)), (Sun(-way, np.array([100.0, 90.0, 80.0])),))
    front, back = portal(), portal((0.0, 1.0, 0.0))
    extra = passing(sky, np.array([0.0, -1.0, 0.0])) - passing(sky, np.array([0.0, 1.0, 0.0]))
    np.testing.assert_allclose(extra, 0.8 * np.array([100.0, 90.0, 80.0]), rtol=1e-3)
    _, weights = latlong(64)
    excess = (panorama(sky, front, 64) - 1.0) * weights[..., None]
    np.testing.assert_allclose(excess.max(axis=(0, 1)), [100.0, 90.0, 80.0], rtol=1e-3)
    assert panorama(sky, back, 64).max() < 1.01
    assert [lobe.name for lobe in fit(sky, front)[0]] == ["sun", "sky", "ground"]
    assert [lobe.name for lobe in fit(sky, back)[0]] == ["sky", "ground"]


def test_three_lobes_keep_the_sun_and_what_comes_in() -> None:
    from openrooms_usd.rendering.scene.light_records import fit
    from openrooms_usd.rendering.scene.surroundings import passing

    sky = around(daylight(SUN, Air(), height=360))
    outwards = portal().world_from_portal[:3, 2]
    lobes, error = fit(sky, portal())
    assert [lobe.name for lobe in lobes] == ["sun", "sky", "ground"]
    assert lobes[0].axis @ sun_direction(SUN, 0.0) > np.cos(np.radians(0.2))
    np.testing.assert_allclose(lux(lobes, outwards), passing(sky, outwards), rtol=0.03)
    assert error < 0.45
    assert all((lobe.amplitude >= 0.0).all() for lobe in lobes)
    assert lobes[1].axis[2] > lobes[2].axis[2]


def landscape(overcast: bool) -> Array:
    """A sky over ground, with a dark house and a bright wall; with or without a sun."""
    from openrooms_usd.rendering.scene.surroundings import latlong

    ways, _ = latlong(128)
    even = [2.0, 2.5, 4.0] * (1.0 + 2.0 * np.maximum(ways[..., 2:], 0.0))
    sky = even if overcast else daylight(SUN, Air(), height=128).astype(np.float64) / 2000.0
    light = np.where(ways[..., 2:] > 0.0, sky, [1.0, 0.9, 0.5])
    low = (ways[..., 2] > -0.2) & (ways[..., 2] < 0.4)
    light[low & (ways[..., 0] > 0.3)] = [0.4, 0.3, 0.25]
    light[low & (ways[..., 0] < -0.5)] = [5.0, 4.5, 4.0]
    return np.asarray(light)


@pytest.mark.slow
@pytest.mark.parametrize("overcast", [True, False])
def test_no_other_lobes_leave_much_less(overcast: bool) -> None:
    """Against the best of many starts of another method that may use any colour above zero."""
    from scipy.optimize import least_squares, nnls

    from openrooms_usd.rendering.scene.light_records import fit
    from openrooms_usd.rendering.scene.surroundings import latlong

    lobes, error = fit(around(landscape(overcast)), portal())
    assert [lobe.name for lobe in lobes] == ["sun", "sky", "ground"]
    assert all((lobe.amplitude > 0.0).all() for lobe in lobes)
    free = lobes if overcast else lobes[1:]
    ways, weights = latlong(16)
    light = landscape(overcast).reshape(16, 8, 32, 8, 3).mean(axis=(1, 3))
    inside = ways @ [0.0, -1.0, 0.0] > 0.0
    # The sun has a lobe by itself; what is left of its place is like what is around it.
    inside &= overcast | (ways @ sun_direction(SUN, 0.0) < np.cos(np.radians(12.0)))
    ways, light = ways[inside], light[inside]
    root = np.sqrt(weights[inside] * -ways[:, 1])[:, None]

    def left(numbers: Array) -> Array:
        axes = numbers[: 3 * len(free)].reshape(-1, 3)
        axes = axes / np.linalg.norm(axes, axis=1, keepdims=True)
        sharp = np.exp(np.clip(numbers[3 * len(free) :], -6.0, 7.0))
        shapes = root * np.exp(sharp * (ways @ axes.T - 1.0))
        colors = np.stack([nnls(shapes, (root * light)[:, c])[0] for c in range(3)], axis=1)
        return np.asarray((shapes @ colors - root * light).ravel())

    whole = np.linalg.norm(root * light)
    found = np.concatenate([lobe.axis for lobe in free])
    ours = left(np.append(found, np.log([lobe.sharpness for lobe in free])))
    rng, best = np.random.default_rng(5), np.inf
    for _ in range(3):
        begin = np.append(rng.normal(size=3 * len(free)), rng.uniform(-2.0, 3.0, len(free)))
        best = min(best, np.linalg.norm(least_squares(left, begin, max_nfev=15).fun) / whole)
    assert error == pytest.approx(np.linalg.norm(ours) / whole, rel=0.1)
    assert np.linalg.norm(ours) / whole < 1.03 * best + 0.01


def test_two_lobes_are_found_again() -> None:
    from openrooms_usd.rendering.scene.light_records import fit
    from openrooms_usd.rendering.scene.surroundings import latlong

    ways, _ = latlong(128)
    true = (
        Gaussian("sky", np.array([3.0, 4.0, 5.0]), np.array([0.6, -0.64, 0.48]), 3.0),
        Gaussian("ground", np.array([2.0, 1.5, 1.0]), np.array([-0.48, -0.64, -0.6]), 1.5),
    )
    pixels = sum(
        lobe.amplitude * np.exp(lobe.sharpness * (ways @ lobe.axis - 1.0))[..., None]
        for lobe in true
    )
    lobes, error = fit(around(np.asarray(pixels)), portal())
    assert error < 0.01
    for found, wanted in zip(lobes, true, strict=True):
        assert found.axis @ wanted.axis > np.cos(np.radians(1.0))
        assert found.sharpness == pytest.approx(wanted.sharpness, rel=0.03)
        np.testing.assert_allclose(found.amplitude, wanted.amplitude, rtol=0.03)


@pytest.mark.parametrize("outwards", [(0.0, -1.0, 0.0), (1.0, 0.0, 0.0)])
@pytest.mark.parametrize("row", [3, 20, 28])
def test_light_from_one_place_is_fitted_without_a_number_that_is_none(
    row: int, outwards: tuple[float, float, float]
) -> None:
    from openrooms_usd.rendering.scene.light_records import fit

    pixels = np.zeros((32, 64, 3))
    pixels[row, 24:44, 1] = 5.0
    lobes, error = fit(around(pixels), portal(outwards))
    assert np.isfinite([error, *np.concatenate([lobe.amplitude for lobe in lobes])]).all()
    assert error <= 1.0


def test_a_black_sky_has_no_lobes() -> None:
    from openrooms_usd.rendering.scene.light_records import fit

    assert fit(around(np.zeros((1, 1, 3))), portal()) == ((), 0.0)


def test_no_lobe_is_much_more_colourful_than_the_light_that_it_lies_on() -> None:
    """Least squares alone makes the sky blue without red, the ground red without blue."""
    from openrooms_usd.rendering.scene.window_lobes import _colors

    heights = np.linspace(-1.0, 1.0, 50)
    shapes = np.exp(0.5 * (np.stack([heights, -heights], axis=1) - 1.0))
    light = np.where(heights[:, None] > 0.0, [1.0, 2.0, 8.0], [4.0, 2.0, 1.0])
    free = np.linalg.lstsq(shapes, light, rcond=None)[0]
    assert free[0, 0] < 0.0
    assert free[1, 2] < 0.0
    found, lying = _colors(shapes, light), shapes.T @ light
    share = (found / lying) / (found / lying).max(axis=1, keepdims=True)
    # By two in the one direction for one colour, in the other for another.
    assert share.min() > 0.25 - 1e-6


def test_colours_within_bounds_are_the_best_there() -> None:
    from scipy.optimize import lsq_linear

    from openrooms_usd.rendering.scene.window_lobes import _within

    rng = np.random.default_rng(4)
    for _ in range(20):
        shapes, light = rng.random((9, 2)), rng.normal(size=(9, 3))
        low = rng.uniform(-1.0, 0.0, (2, 3))
        high = low + rng.uniform(0.1, 1.0, (2, 3))
        found = _within(shapes.T @ shapes, shapes.T @ light, low, high)
        wanted = [
            lsq_linear(shapes, light[:, c], (low[:, c], high[:, c]), tol=1e-12).x for c in range(3)
        ]
        np.testing.assert_allclose(found, np.stack(wanted, axis=1), atol=1e-6)


def test_slopes_are_those_of_the_error_with_the_colours_that_follow() -> None:
    from openrooms_usd.rendering.scene import window_lobes

    rng = np.random.default_rng(9)
    ways = rng.normal(size=(200, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    axes = np.array([[0.6, 0.0, 0.8], [0.0, -0.8, -0.6]])
    logs, colors = np.array([0.4, 1.1]), np.zeros((2, 3))
    light = np.exp(2.0 * (ways @ [[0.0], [0.6], [0.8]] - 1.0)) * [1.0, 2.0, 3.0] + 0.1

    def best(change: Array) -> tuple[Any, Array]:
        pair = window_lobes.Lobes(axes, logs, colors, 0.0)
        moved = window_lobes._moved(pair, change)
        shapes = np.exp(np.exp(moved[1]) * (ways @ moved[0].T - 1.0))
        found = np.linalg.lstsq(shapes, light, rcond=None)[0]
        return window_lobes.Lobes(*moved, found, 0.0), shapes

    def cost(change: Array) -> float:
        pair, shapes = best(change)
        return float(0.5 * np.square(light - shapes @ pair.colors).sum())

    pair, shapes = best(np.zeros(6))
    slopes = window_lobes._slopes(ways, pair, shapes)
    found = -slopes.T @ (light - shapes @ pair.colors).ravel()
    np.testing.assert_allclose(shapes.T @ slopes.reshape(200, -1), 0.0, atol=1e-6)
    steps = 1e-5 * np.eye(6)
    wanted = [(cost(step) - cost(-step)) / 2e-5 for step in steps]
    np.testing.assert_allclose(found, wanted, rtol=1e-5, atol=1e-7)
