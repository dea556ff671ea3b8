"""Batches, strips, halves and stopping rules, with random numbers instead of pictures."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from openrooms_usd.rendering import RenderRequest
from orusd_mitsuba.transport import sampling, strips
from orusd_mitsuba.transport.sampling import Halves, ProgressiveSampler, batch_seed

SIZE = 16, 16


def noise(rows, samples, seed):
    """A batch of a constant picture of 1 with variance 0.01 / samples."""
    random = np.random.default_rng(seed)
    shape = rows.stop - rows.start, SIZE[1], 3
    return (1 + 0.1 * random.standard_normal(shape) / np.sqrt(samples)).astype(np.float32)


class Noise:
    """An integrator of random numbers: one picture, in strips of so many samples."""

    planes, size = 1, SIZE

    def __init__(self, render, most):
        self.render, self.capacity = render, most * SIZE[0] * SIZE[1]
        self.broken = np.zeros(SIZE, bool)

    def strips(self, samples):
        return strips.strips(SIZE, 1, samples, self.capacity)

    def most_in(self, rows):
        return strips.most_samples(rows, SIZE[1], self.capacity)

    def strip(self, rows, samples, seed):
        return self.render(rows, samples, seed)[None]


def rendered(request, render=noise, most=64, progress=lambda fraction: None) -> Halves:
    """All strips of a render, put together."""
    sampler = ProgressiveSampler(Noise(render, most), request, progress, lambda planes: planes[0])
    found: list[Any] = []
    sampler.run(lambda rows, halves: found.append((rows, halves)))
    tops = [rows.start for rows, _ in found]
    assert tops == sorted(tops) and sum(rows.stop - rows.start for rows, _ in found) == SIZE[0]
    assert all(halves.samples == sampler.samples for _, halves in found)
    sums = np.concatenate([halves.sums for _, halves in found], axis=2)
    return Halves(sums, sampler.samples, lambda planes: planes[0])


def request(**how):
    return RenderRequest("/Camera", ("radiance",), 16, 16, **how)


@pytest.mark.parametrize("samples", [1, 2, 3, 7, 16, 33, 100])
def test_exactly_as_many_samples_as_asked_in_halves_that_are_alike(samples):
    passes = []

    def count(rows, samples, seed):
        passes.append((samples, seed))
        return noise(rows, samples, seed)

    halves = rendered(request(samples=samples), count, most=8)
    assert halves.total == samples
    assert abs(halves.samples[0] - halves.samples[1]) <= 1
    assert max(taken for taken, _ in passes) <= min(64, samples)
    assert len({seed for _, seed in passes}) == len(passes)
    assert (halves.error is None) == (samples == 1)


def test_the_mean_weighs_passes_by_their_samples():
    halves = rendered(request(samples=9), lambda rows, n, seed: 0 * noise(rows, n, seed) + n)
    # Passes of 5 and of 4 samples that give 5 and 4.
    assert np.allclose(halves.mean, (5 * 5 + 4 * 4) / 9)


@pytest.mark.parametrize("samples", [2, 3, 10, 64])
def test_the_estimate_is_the_variance_of_the_mean(samples):
    errors = [
        rendered(request(samples=samples, seed=seed)).error for seed in range(40)
    ]  # 30,000 values
    # With its own standard error: a part of its 256 pixels.
    assert 1.0 < np.mean(errors) / (0.01 / samples / 1.01) < 1.2


def test_until_the_error_is_small_enough_with_as_few_doublings_as_needed():
    halves = rendered(request(error=5e-5), most=1 << 20)
    assert halves.error <= 5e-5
    assert halves.total == 256


def test_an_error_that_cannot_be_reached_ends():
    halves = rendered(request(error=0.0), most=1 << 20)
    assert halves.total == 1 << 16
    assert halves.error > 0


@pytest.fixture
def clock(monkeypatch):
    """Time that passes by rendering alone: a microsecond a ray; the list holds what has passed."""
    passed = [0.0]
    monkeypatch.setattr(sampling, "time", SimpleNamespace(perf_counter=lambda: passed[0]))
    return passed


def timed(clock):
    def render(rows, samples, seed):
        clock[0] += 1e-6 * samples * (rows.stop - rows.start) * SIZE[1]
        return noise(rows, samples, seed)

    return render


@pytest.mark.parametrize("seconds", [0.05, 0.4])
def test_until_time_is_up_and_hardly_longer(clock, seconds):
    halves = rendered(request(seconds=seconds), timed(clock))
    assert halves.samples[0] == halves.samples[1] >= 1
    assert 0.9 * seconds < clock[0] <= 1.01 * seconds


def test_there_is_at_least_one_pass_for_each_half(clock):
    assert rendered(request(seconds=1e-9), timed(clock)).samples == [1, 1]


@pytest.mark.parametrize("how", [{"samples": 40}, {"error": 1e-4}, {"seconds": 0.02}])
def test_progress_grows_to_one(how, clock):
    seen = []
    rendered(request(**how), timed(clock), progress=seen.append)
    assert 0 < min(seen) <= max(seen) <= 1.0
    assert seen[-1] == pytest.approx(1.0, abs=0.1 if "seconds" in how else 0)


def test_seeds_differ_by_camera_pass_and_seed():
    seeds = {batch_seed(s, c, p) for s in range(5) for c in ("/a", "/b") for p in range(100)}
    assert len(seeds) == 1000
    assert all(0 <= seed < 1 << 32 for seed in seeds)


def test_strips_hold_what_memory_allows_and_go_by_the_request_alone():
    assert strips.strips((480, 640), 54, 8, 1 << 20) == strips.strips((480, 640), 54, 8, 1 << 20)
    for planes in (3, 54, 1000):
        for samples in (1, 8, 512):
            cut = strips.strips((480, 640), planes, samples, 1 << 20)
            assert [rows.start for rows in cut[1:]] == [rows.stop for rows in cut[:-1]]
            assert (cut[0].start, cut[-1].stop) == (0, 480)
            assert 640 * cut[0].stop * min(samples, 64) <= 1 << 20
            assert 2 * planes * cut[0].stop * 640 * 3 * 8 <= 1 << 28
    assert {rows.start % 16 for rows in strips.strips((480, 640), 3, 64, 1 << 18, step=16)} == {0}


@pytest.mark.parametrize("how", [{"samples": 40}, {"error": 5e-5}, {"seconds": 0.02}])
def test_no_two_batches_draw_the_same_random_numbers(how, clock):
    seeds = []

    def count(rows, samples, seed):
        seeds.append(seed)
        return timed(clock)(rows, samples, seed)

    rendered(request(**how), count, most=2)
    assert len({*seeds}) == len(seeds) > 16


@pytest.mark.parametrize("how", [{"error": 5e-5}, {"seconds": 0.05}])
def test_where_sums_take_too_much_memory_the_number_of_samples_is_found_first(
    how, clock, monkeypatch
):
    kept = rendered(request(**how), timed(clock))
    clock[0] = 0.0
    monkeypatch.setattr(sampling, "_MOST_KEPT_BYTES", 0)
    halves = rendered(request(**how), timed(clock))
    assert halves.error is not None and halves.error < 1e-3
    if "seconds" in how:
        assert clock[0] == pytest.approx(how["seconds"], rel=0.1)
    if "error" in how:
        assert halves.total == kept.total == 256
        assert np.allclose(halves.mean, 1.0, atol=0.05)
