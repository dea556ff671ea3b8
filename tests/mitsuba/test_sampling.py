"""Passes, halves and stopping rules, with passes of random numbers instead of pictures."""

import time

import numpy as np
import pytest

from openrooms_usd.render import RenderRequest
from orusd_mitsuba.transport.sampling import ProgressiveSampler, batch_seed


def noise(samples, seed):
    """A pass over a constant picture of 1 with variance 0.01 / samples."""
    random = np.random.default_rng(seed)
    return (1 + 0.1 * random.standard_normal((16, 16, 3)) / np.sqrt(samples)).astype(np.float32)


def sampler(request, render=noise, most=8, progress=lambda fraction: None):
    return ProgressiveSampler(render, request, (16, 16), most, progress)


def request(**how):
    return RenderRequest("/Camera", ("radiance",), 16, 16, **how)


@pytest.mark.parametrize("samples", [1, 2, 3, 7, 16, 33, 100])
def test_exactly_as_many_samples_as_asked_in_halves_that_are_alike(samples):
    passes = []

    def count(samples, seed):
        passes.append((samples, seed))
        return noise(samples, seed)

    halves = sampler(request(samples=samples), count).run()
    assert halves.total == samples
    assert abs(halves.samples[0] - halves.samples[1]) <= 1
    assert max(taken for taken, _ in passes) <= 8
    assert len({seed for _, seed in passes}) == len(passes)
    assert (halves.error is None) == (samples == 1)


def test_the_mean_weighs_passes_by_their_samples():
    halves = sampler(request(samples=9), lambda n, seed: np.full((16, 16, 3), n, np.float32)).run()
    # Passes of 5 and of 4 samples that give 5 and 4.
    assert np.allclose(halves.mean, (5 * 5 + 4 * 4) / 9)


@pytest.mark.parametrize("samples", [2, 3, 10, 64])
def test_the_estimate_is_the_variance_of_the_mean(samples):
    errors = [
        sampler(request(samples=samples, seed=seed)).run().error for seed in range(40)
    ]  # 30,000 values
    assert np.mean(errors) == pytest.approx(0.01 / samples / 1.01, rel=0.05)


def test_until_the_error_is_small_enough_with_as_few_doublings_as_needed():
    halves = sampler(request(error=5e-5), most=1 << 20).run()
    assert halves.error <= 5e-5
    assert halves.total == 256


def test_an_error_that_cannot_be_reached_ends():
    halves = sampler(request(error=0.0), most=1 << 20).run()
    assert halves.total == 1 << 16
    assert halves.error > 0


def test_until_time_is_up_at_least_one_pass_for_each_half():
    start = time.perf_counter()
    halves = sampler(request(seconds=0.05)).run()
    assert time.perf_counter() - start < 5
    assert halves.samples[0] == halves.samples[1] >= 1
    assert sampler(request(seconds=1e-9)).run().samples == [1, 1]


@pytest.mark.parametrize("how", [{"samples": 40}, {"error": 1e-4}, {"seconds": 0.02}])
def test_progress_grows_to_one(how):
    seen = []
    sampler(request(**how), progress=seen.append).run()
    assert 0 < min(seen) <= max(seen) <= 1.0
    assert seen[-1] == pytest.approx(1.0, abs=0.5 if "seconds" in how else 0)


def test_seeds_differ_by_camera_pass_and_seed():
    seeds = {batch_seed(s, c, p) for s in range(5) for c in ("/a", "/b") for p in range(100)}
    assert len(seeds) == 1000
    assert all(0 <= seed < 1 << 32 for seed in seeds)
