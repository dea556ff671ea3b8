"""Bias that a method has by its making is measured at sparse pixels, and none where it has none."""

from collections.abc import Callable
from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from openrooms_usd.channels import CHANNELS
from openrooms_usd.rendering import Image, RenderRequest
from orusd_mitsuba import MitsubaRenderer
from tests.mitsuba.conftest import Lit
from tests.mitsuba.rendering import session_of
from tests.mitsuba.rooms import half_hidden

SIZE = (48, 36)
CHANNELS_HERE = ("radiance", "emission", "indirect", "radiance_i")
REQUEST = RenderRequest("/Camera", CHANNELS_HERE, *SIZE, samples=16, halves=True)
# A path of so many segments is scattered once, or up to four times.
STRAIGHT, LONG = 2, 5


@pytest.fixture
def rendered(mi: Any) -> Callable[..., tuple[dict[str, Image], Any]]:
    """The pictures of a little room by paths of a length, and what renders them."""
    from orusd_mitsuba.render_passes import RADIANCE, run_pass
    from orusd_mitsuba.transport.path_integrator import PathIntegrator

    lit = Lit(half_hidden())
    camera = lit.camera(*SIZE)

    def render(depth: int, **how: Any) -> tuple[dict[str, Image], Any]:
        integrator = PathIntegrator(lit.built, lit.index, camera, *SIZE, lit.scene.origin, depth)
        request = replace(REQUEST, **how)
        images, _, _ = run_pass(
            RADIANCE, integrator, request, CHANNELS_HERE, lit.index.count, lambda done: None
        )
        return images, integrator

    return render


def measured(images: dict[str, Image], biased: Any, reference: Any, **how: Any) -> dict[str, Image]:
    from orusd_mitsuba.bias import with_bias
    from orusd_mitsuba.render_passes import RADIANCE

    request, lights = replace(REQUEST, **how), sum(name.startswith("radiance_") for name in images)
    return with_bias(images, {}, RADIANCE, biased, reference, request, CHANNELS_HERE, lights)


def test_a_method_that_stops_too_early_is_too_dark_by_what_it_leaves_out(rendered: Any) -> None:
    images, biased = rendered(STRAIGHT, samples=64)
    _, reference = rendered(LONG, samples=1)
    told = measured(images, biased, reference)
    # Of the whole pictures, by other random numbers.
    short, whole = (rendered(depth, samples=256, seed=9)[0] for depth in (STRAIGHT, LONG))
    for name, image in told.items():
        truth = whole[name].pixels.sum(dtype=np.float64)
        if truth == 0.0 or name == "emission":
            continue
        wanted = short[name].pixels.sum(dtype=np.float64) / truth - 1.0
        bias = image.bias
        assert bias and abs(bias.total - wanted) <= 4 * bias.total_error + 1e-3, name
        assert wanted < -0.1 and bias.total_error < 0.1, name
        assert bias.pixels > 500
    lost = told["radiance"].bias
    assert lost and (lost.worst_tenth or 0.0) > -lost.total > 5 * lost.total_error
    lost = told["indirect"].bias
    assert lost and lost.total == -1.0 and lost.worst_tenth == pytest.approx(1.0, abs=0.1)


def test_what_is_changed_after_the_samples_is_part_of_the_bias(rendered: Any) -> None:
    """Three tenths of the light of one block are taken away; no sparse pixel knows of it."""
    from orusd_mitsuba.bias import with_bias
    from orusd_mitsuba.render_passes import RADIANCE

    images, integrator = rendered(LONG, samples=64)
    change = np.zeros((3, 3, 3), dtype=np.float32)
    mean = images["radiance"].pixels.mean()
    change[1, 2] = -0.3 * mean
    lights = sum(name.startswith("radiance_") for name in images)
    told = with_bias(
        images,
        {"radiance": change},
        RADIANCE,
        integrator,
        integrator,
        REQUEST,
        CHANNELS_HERE,
        lights,
    )
    bias = told["radiance"].bias
    # Of 48 x 36 pixels the block has 16 x 16.
    assert bias and bias.total == pytest.approx(-0.3 * 256 / (48 * 36), rel=0.2)
    assert told["indirect"].bias and told["indirect"].bias.total == 0.0


def test_a_method_without_bias_is_told_to_have_none(rendered: Any) -> None:
    images, integrator = rendered(LONG, seed=3, samples=64)
    # With the same random numbers it is the same, to the last bit.
    same = measured(images, integrator, integrator)
    assert all(image.bias.total == 0.0 for image in same.values() if image.bias)
    deviations = []
    for seed in range(4):
        for image in measured(images, reseeded(integrator), integrator, seed=seed).values():
            if image.bias and image.bias.total_error > 0.0:
                deviations.append(image.bias.total / image.bias.total_error)
                worst, error = image.bias.worst_tenth, image.bias.worst_tenth_error
                assert worst is None or abs(worst) <= 4 * error
    assert len(deviations) >= 12 and max(map(abs, deviations)) < 4.0
    assert all(same[name].pixels is images[name].pixels for name in images)


def reseeded(integrator: Any) -> Any:
    """The same with random numbers of its own."""

    class Reseeded(type(integrator)):  # type: ignore[misc]
        def _band(self, band: Any) -> Any:
            band.seed ^= 0x2A
            return super()._band(band)

    found = copy(integrator)
    found.__class__ = Reseeded
    return found


@pytest.mark.slow
def test_every_light_channel_of_a_session_tells_its_bias(mi: Any) -> None:
    stage = half_hidden()
    opened = session_of(stage, variant="llvm")
    names = tuple(name for name, row in CHANNELS.items() if row.kind == "light")
    given = tuple(name for name in names if name in MitsubaRenderer.channels)
    request = RenderRequest("/Camera", given, *SIZE, samples=32, grid=(8, 6), method="cache")
    view = opened.render(request)
    without = [name for name, image in view.images.items() if image.bias is None]
    assert {name.rpartition("_")[0] for name in without} <= {
        "direct",
        "unoccluded",
        "visibility",
        "radiance",
        "irradiance",
        "",  # "traced"
    }
    for name in ("radiance", "irradiance", "indirect", "environment", "radiance_0"):
        image = view.images[name]
        assert image.halves is None and image.bias
        assert abs(image.bias.total) < 0.05 + 4 * image.bias.total_error, name
    for how in ({"method": "reference"}, {"measure_bias": False}):
        plain = opened.render(replace(request, channels=("radiance",), **how))
        assert plain.images["radiance"].bias is None
