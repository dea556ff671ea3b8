"""Indirect irradiance is averaged over what is near and flat, and over nothing else."""

from itertools import product
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.mitsuba.rooms import half_hidden

Array = NDArray[Any]
HEIGHT, WIDTH, SPACING_M = 36, 160, 0.02


def flat(nearness: float = 0.5) -> Array:
    """The guides of a plane that is seen square on, everything ``1 / nearness`` metres away."""
    guides = np.zeros((6, HEIGHT, WIDTH, 3), dtype=np.float32)
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    guides[0] = 0.5
    guides[1, ..., 2] = 1.0
    guides[2] = np.stack([columns, rows, 0 * rows], axis=-1) * SPACING_M
    guides[3, ..., 0], guides[3, ..., 1] = nearness, 1.0
    return guides


def smooth(plane: Array, guides: Array, light: str = "irradiance") -> Array:
    from orusd_mitsuba.complete.smoothing import IrradianceGradient, smoothed

    how = {"irradiance": IrradianceGradient.of_irradiance, "lobes": IrradianceGradient.of_lobes}[
        light
    ](guides)
    return smoothed([np.asarray(plane, np.float32)], guides, how)[0]


def noise(seed: int = 0) -> Array:
    return np.random.default_rng(seed).exponential(size=(HEIGHT, WIDTH, 3)).astype(np.float32)


@pytest.mark.parametrize("light", ["irradiance", "lobes"])
def test_the_average_is_that_of_plain_loops(mi: Any, light: str) -> None:
    """The same once more, pixel by pixel, of a scene with an edge, a step and sky."""
    from orusd_mitsuba.complete import smoothing

    cut = np.s_[:, :12, :20]
    guides = flat()[cut].copy()
    rng = np.random.default_rng(5)
    guides[1, :, 10:] = (0.6, 0.0, 0.8)
    guides[2, 6:, :, 2] += 0.05
    guides[3, ..., 0] = rng.uniform(0.3, 4.0, size=guides.shape[1:3])
    guides[5] = rng.uniform(0.4, 0.9, size=guides.shape[1:])
    guides[5, ..., 2] = 1.0
    guides[:, 2:4, 3:5] = 0.0
    planes = noise()[:12, :20]
    given = planes.astype(np.float64), guides.astype(np.float64)
    found = smooth(planes, guides, light)
    np.testing.assert_allclose(found, _by_loops(*given, smoothing, light), rtol=5e-4, atol=1e-5)
    assert np.abs(found - planes).mean() > 0.2


def _by_loops(plane: Array, guides: Array, how: Any, light: str) -> Array:
    height, width = plane.shape[:2]
    normal, point = guides[1], guides[2]
    if light == "irradiance":
        near, turns = (
            guides[3, ..., 0] / how._RADIUS_PER_DISTANCE,
            0 * guides[3, ..., 0] + how._TURN,
        )
        least = 2.0
    else:
        sigma = np.maximum(guides[5, ..., 0], 1e-4)
        near, turns = guides[5, ..., 1] / (how._RADIUS_PER_FOOTPRINT * sigma), sigma**2
        turns, least = how._TURN_OF_LOBE * turns, 1e-9
    inverse = np.zeros((height, width))
    for y, x in np.ndindex(height, width):
        total, spacing = [near[y, x]], np.inf
        for v, u, _ in _neighbours(guides, y, x, 1):
            offset = point[v, u] - point[y, x]
            distance = np.linalg.norm(offset)
            level = abs(offset @ normal[y, x]) <= 0.1 * distance
            if level and normal[v, u] @ normal[y, x] > 0.9:
                total.append(near[v, u])
            if abs(v - y) + abs(u - x) == 1:
                spacing = min(spacing, distance)
        inverse[y, x] = min(np.mean(total), 1 / (least * spacing))
    for level in range(int(np.clip(np.log2(width / how._PIXELS_A_LEVEL), 1, 8))):
        before, plane = plane, plane.copy()
        for y, x in np.ndindex(height, width):
            value, weight = before[y, x] * 36 / 256, 36 / 256
            for v, u, w in _neighbours(guides, y, x, 1 << level):
                offset = point[v, u] - point[y, x]
                radius = 2 / (inverse[y, x] + inverse[v, u])
                off = offset @ normal[y, x] / (how._HEIGHT_PER_RADIUS * radius)
                turn = 1 - normal[v, u] @ normal[y, x]
                apart = (offset @ offset) / radius**2 + off**2
                w *= np.exp(-0.5 * apart - turn / min(turns[y, x], turns[v, u]))
                value, weight = value + w * before[v, u], weight + w
            plane[y, x] = value / weight
    return plane


def _neighbours(guides: Array, y: int, x: int, step: int) -> list[tuple[int, int, float]]:
    kernel, seen = np.array([1, 4, 6, 4, 1]) / 16, guides[3, ..., 1] > 0.5
    found = []
    for dy, dx in product(range(-2, 3), repeat=2):
        v, u = y + dy * step, x + dx * step
        inside = 0 <= v < seen.shape[0] and 0 <= u < seen.shape[1] and (dy, dx) != (0, 0)
        if inside and seen[y, x] and seen[v, u]:
            found.append((v, u, kernel[dy + 2] * kernel[dx + 2]))
    return found


def test_even_light_stays_and_a_slope_stays(mi: Any) -> None:
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    np.testing.assert_allclose(smooth(np.full((HEIGHT, WIDTH, 3), 3.0), flat()), 3.0, rtol=1e-5)
    slope = np.repeat((columns + 2.0 * rows)[..., None], 3, axis=-1)
    inside = np.s_[14:-14, 40:-40]
    found = smooth(slope, flat(4.0))
    np.testing.assert_allclose(found[inside], slope[inside], rtol=1e-3)


def test_noise_falls_where_all_is_far_and_stays_where_something_is_near(mi: Any) -> None:
    raw = noise()
    far, near = (smooth(raw, flat(nearness)).var() / raw.var() for nearness in (0.2, 1000.0))
    # Of a Gaussian, 1 over 4 pi times the square of its deviation: two pixels at least.
    assert far < 0.004 and near == pytest.approx(1 / (4 * np.pi * 2.0**2), rel=0.5)
    assert smooth(raw, flat(0.2)).mean() == pytest.approx(raw.mean(), rel=0.02)


@pytest.mark.parametrize("apart", ["turned", "lower", "sky"])
def test_nothing_passes_from_one_surface_to_another(mi: Any, apart: str) -> None:
    guides, plane = flat(), noise()
    other = np.s_[:, WIDTH // 2 :]
    if apart == "turned":
        guides[1][other] = (1.0, 0.0, 0.0)
    elif apart == "lower":
        guides[2, :, WIDTH // 2 :, 2] = -0.6
    else:
        guides[:, :, WIDTH // 2 :] = 0.0
    plane[other] += 1000.0
    found = smooth(plane, guides)
    assert found[:, : WIDTH // 2].max() < 5.0
    assert found[other].min() > 990.0
    if apart == "sky":
        np.testing.assert_array_equal(found[other], plane[other])


def test_what_a_mirror_shows_stays_sharp_and_a_wide_lobe_is_smooth(mi: Any) -> None:
    raw, guides = noise(), flat()
    guides[4], guides[5, ..., 1], guides[5, ..., 2] = 0.04, 1.0, 1.0
    guides[5, ..., 0] = 0.001
    np.testing.assert_allclose(smooth(raw, guides, "lobes"), raw, rtol=1e-5)
    guides[5, ..., 0] = 0.5
    assert smooth(raw, guides, "lobes").var() < 0.05 * raw.var()
    # Turned by a tenth of a radian each column, it shows something else.
    angle = 0.1 * np.arange(WIDTH)
    guides[1] = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=-1)
    guides[5, ..., 0] = 0.1
    raw[:] = raw[0]
    np.testing.assert_allclose(smooth(raw, guides, "lobes"), raw, rtol=0.01, atol=1e-3)


@pytest.mark.slow
def test_pictures_of_a_room_are_smoother_and_add_up(few_surfels: None) -> None:
    from openrooms_usd.rendering import RenderRequest
    from openrooms_usd.rendering.estimates import robust_error
    from tests.mitsuba.rendering import session_of

    channels = tuple(
        (
            "radiance direct indirect emission diffuse specular radiance_i irradiance "
            "irradiance_direct irradiance_indirect irradiance_i"
        ).split()
    )
    stage = half_hidden()
    session = session_of(stage, bsdf="openrooms")

    def render(samples: int, method: str = "cache") -> Any:
        request = RenderRequest(
            session.cameras[0], channels, 48, 36, samples=samples, method=method, measure_bias=False
        )
        return session.render(request).images

    truth, found, exact = render(1024, "reference"), render(16), render(16, "reference")
    single = render(1)["irradiance_indirect"]
    assert single.robust_error is None and single.pixels.mean() == pytest.approx(
        truth["irradiance_indirect"].pixels.mean(), rel=0.05
    )
    pixels = {name: image.pixels.astype(np.float64) for name, image in found.items()}
    lights = [name for name in pixels if name.startswith("radiance_")]
    for parts, whole in (
        (("emission", "direct", "indirect"), "radiance"),
        (("emission", "diffuse", "specular"), "radiance"),
        (lights, "radiance"),
        ([f"ir{name}" for name in lights], "irradiance"),
        (("irradiance_direct", "irradiance_indirect"), "irradiance"),
    ):
        total = sum(pixels[part] for part in parts)
        off = np.abs(total - pixels[whole]) > 1e-4 * pixels[whole].mean() + 1e-4 * pixels[whole]
        assert off.mean() < 0.002, (whole, parts)
    for name in ("irradiance_indirect", "indirect", "diffuse"):
        before, after = (robust_error(i[name].pixels, truth[name].pixels) for i in (exact, found))
        assert after < 0.3 * before
        # The halves are smoothed as well: they know how little noise is left.
        assert found[name].robust_error < 0.3 * exact[name].robust_error
