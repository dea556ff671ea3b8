"""What a render says about its channels of light: errors, what was replaced, what cannot be had."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from openrooms_usd.channels import definition
from openrooms_usd.rendering.estimates import robust_error
from orusd_mitsuba.complete import integrator as complete_integrator
from orusd_mitsuba.transport import incident
from tests.mitsuba.passes import LIT, PASSES
from tests.mitsuba.rendering import session_of, shown
from tests.mitsuba.rooms import half_hidden


@pytest.fixture(scope="module")
def session(lit: Any) -> Any:
    return session_of(half_hidden())


def images(session: Any, *names: str, **how: Any) -> Any:
    return shown(session, *names, grid=(6, 4), **({"samples": 32} | how)).images


def distance(a: NDArray[Any], b: NDArray[Any], scale: NDArray[Any]) -> float:
    """The mean squared difference by the conventions, relative to ``scale``."""
    m, whole = scale.astype(np.float64), scale.mean(axis=(0, 1), dtype=np.float64)
    wide = m**2 + 0.01 * whole**2
    part = (a.astype(np.float64) - b) ** 2
    return float(np.mean(np.divide(part, wide, out=np.zeros_like(part), where=wide > 0)))


def lights_of(name: str, found: Any) -> list[str]:
    return [single for single in found if definition(single).name == name]


@pytest.fixture(scope="module")
def renders(session: Any) -> list[Any]:
    names = tuple(name for name in LIT if name not in PASSES["environment"])
    few = [images(session, *names, samples=64, seed=seed) for seed in range(6)]
    cells = [images(session, *PASSES["environment"], samples=256, seed=seed) for seed in range(6)]
    return [a | b for a, b in zip(few, cells, strict=True)]


@pytest.fixture(scope="module")
def truth(session: Any) -> Any:
    names = tuple(name for name in LIT if name not in PASSES["environment"])
    many = images(session, *names, samples=640, seed=77)
    return many | images(session, *PASSES["environment"], samples=2560, seed=77)


def test_each_channel_tells_the_error_that_it_has(session: Any) -> None:
    """Against many more samples, with another seed."""
    names = ("radiance", "direct", "indirect", "irradiance", "radiance_i")
    few, many = (images(session, *names, samples=n, seed=n) for n in (32, 1024))
    for name, image in few.items():
        truth = many[name].pixels
        if name.endswith("_2"):  # Nothing comes in from elsewhere.
            assert not truth.any() and not image.pixels.any() and image.error is None
            continue
        assert 0.5 * distance(image.pixels, truth, truth) <= image.error, name
        robust = robust_error(image.pixels, truth.astype(np.float64))
        assert 0.5 * robust <= image.robust_error <= 3.0 * robust, name


# Of emission the edges of lamps are all there is: what hardly ever meets one has no estimate.
@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in LIT if name != "emission"])
def test_the_estimated_error_is_the_error_that_was_made(
    renders: list[Any], truth: Any, name: str
) -> None:
    """On the mean over some renders, for every light."""
    for single in lights_of(name, truth):
        exact = truth[single].pixels
        # The reference has ten times the samples, and its own tenth of the error.
        made = np.mean([distance(found[single].pixels, exact, exact) for found in renders])
        if not exact.any():  # Nothing comes in from elsewhere, and nothing is glossy.
            assert made == 0.0
            assert {found[single].error for found in renders} == {None}
        else:
            said = np.mean([found[single].error for found in renders]) + truth[single].error
            # Where few pixels decide, at edges of lamps, rather too much than too little is told;
            # a ratio may be told as wrong as one pixel, where the reference has a single ray in it.
            one = 1.0 / exact[..., 0].size if name == "visibility_i" else 1e-9
            assert 0.56 * made - 1e-9 <= said <= 10.0 * made + one, (single, said, made)


@pytest.mark.slow
def test_cutting_a_render_into_passes_and_bands_is_no_more_than_another_noise(
    session: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = images(session, *LIT, samples=32)
    # Ten rows of sums for three lights.
    rows = 10 * 24 * 3 * complete_integrator.rows_of(3)
    monkeypatch.setattr(complete_integrator, "_MOST_SUMS", rows)
    monkeypatch.setattr(incident, "_PATHS_IN_FLIGHT", 512 * 16)
    cut = images(session, *LIT, samples=32, seed=5)
    for name, image in whole.items():
        other = cut[name]
        assert other.samples == image.samples
        if image.error is None:  # Nothing is glossy here, and nothing comes in from elsewhere.
            assert other.error is None and not image.pixels.any() and not other.pixels.any()
            continue
        mean = 0.5 * (image.pixels + other.pixels)
        made, said = distance(image.pixels, other.pixels, mean), image.error + other.error
        # What a few pixels at edges decide is known to a factor.
        assert made <= 10.0 * said + 1e-3, (name, said, made)
        apart = (image.pixels - other.pixels).astype(np.float64).mean(axis=-1)
        assert abs(apart.mean()) <= 5.0 * apart.std() / np.sqrt(apart.size), name


@pytest.fixture
def one_thread() -> Iterator[None]:
    import drjit as dr

    before = dr.thread_count()
    dr.set_thread_count(1)
    yield
    dr.set_thread_count(before)


def test_equal_seeds_give_equal_bits_of_every_channel_on_any_number_of_threads(
    session: Any, request: pytest.FixtureRequest
) -> None:
    first = images(session, *LIT)
    request.getfixturevalue("one_thread")
    again = session_of(half_hidden())
    for names in PASSES.values():
        for name, image in images(again, *names).items():
            assert image.pixels.tobytes() == first[name].pixels.tobytes(), name
    other = images(session, *LIT, seed=1)
    assert all(
        (other[name].pixels != image.pixels).any()
        for name, image in first.items()
        if image.pixels.any()
    )


@pytest.mark.parametrize(
    ("some", "more"),
    [
        (["radiance"], ["radiance", "emission", "direct", "indirect", "depth"]),
        (["irradiance", "radiance"], ["irradiance", "diffuse", "specular", "radiance", "direct"]),
    ],
)
def test_a_channel_has_equal_bits_whatever_else_is_asked_for(
    session: Any, some: list[str], more: list[str]
) -> None:
    """Of what comes from the same pass."""
    few, many = images(session, *some), images(session, *more)
    assert np.array_equal(few[some[0]].pixels, many[some[0]].pixels)
