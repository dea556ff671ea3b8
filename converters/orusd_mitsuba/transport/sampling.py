"""Batches of samples in two independent halves, until they are enough, and their error.

A picture is rendered in strips of rows, each to completion where the number of samples is known
beforehand: sums take the memory of one strip. Where an error or a time is asked for, all strips go
on in turns; their sums are then kept, in single precision. Where those would take too much memory,
only the picture that is judged is kept until the number of samples is known, and then the strips
are rendered with it.
"""

import hashlib
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.rendering import RenderRequest, estimates
from orusd_mitsuba.transport.integrator import Integrator

# When an error is asked for: samples a pixel to begin with, and where to give up.
_FIRST_SAMPLES: Final = 16
_MOST_SAMPLES: Final = 1 << 16
# Sums of all strips that may be kept at once, bytes.
_MOST_KEPT_BYTES: Final = 1 << 29
# The part of the time in which the pace is measured, where sums are not kept.
_PACE_SHARE: Final = 0.2

Pick = Callable[[Array], Array]
Finish = Callable[[slice, "Halves"], None]
"""Receives the rows of a strip, and all its samples."""


@dataclass(eq=False)
class Halves:
    """Sums of the even and of the odd batches.

    Attributes:
        sums: Two (..., height, width, 3) sums over samples; one where the other has none.
        samples: How many each has.
        judged: Picks from (..., height, width, 3) the picture whose error counts; linear.
    """

    sums: NDArray[Any]
    samples: list[int]
    judged: Pick = lambda pixels: pixels

    @property
    def total(self) -> int:
        """Samples a pixel."""
        return sum(self.samples)

    @property
    def mean(self) -> Floats:
        """(..., height, width, 3) of all samples."""
        total = self.sums[0] if self.samples[1] == 0 else self.sums[0] + self.sums[1]
        if self.total > 1:
            total = total / self.sums.dtype.type(self.total)
        return np.asarray(total, dtype=np.float32)

    @property
    def each(self) -> tuple[NDArray[Any], NDArray[Any]] | None:
        """(..., height, width, 3) of the samples of each half; None while one is empty."""
        if min(self.samples) == 0:
            return None
        a, b = (
            total / self.sums.dtype.type(count)
            for total, count in zip(self.sums, self.samples, strict=True)
        )
        return a, b

    @property
    def error(self) -> float | None:
        """The estimated robust error of what is judged; None where they do not tell."""
        return self.estimate.robust

    @property
    def estimate(self) -> estimates.ErrorEstimate:
        """The estimated errors of what is judged."""
        if min(self.samples) == 0:
            return estimates.ErrorEstimate(None, None)
        a, b = (
            np.asarray(self.judged(total), np.float64) / count
            for total, count in zip(self.sums, self.samples, strict=True)
        )
        return estimates.Halves(a, b, (self.samples[0], self.samples[1])).estimate

    def rows(self, which: slice) -> "Halves":
        """A strip of it."""
        return Halves(self.sums[..., which, :, :], self.samples, self.judged)


def batch_seed(*parts: object) -> int:
    """A seed of 32 bits from whatever makes a batch unlike every other."""
    text = "\0".join(map(str, parts))
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=4).digest(), "little")


class ProgressiveSampler:
    """Renders batches of one camera until the request is met.

    Args:
        integrator: Renders its batches.
        request: Says when it is enough, and the seed.
        progress: Called with the finished fraction.
        judged: See `Halves`.
        key: Sets its random numbers apart from those of other render passes of the same camera.

    Attributes:
        samples: How many each half has at the end.
        error: That of what is judged; None if not requested.
    """

    def __init__(
        self,
        integrator: Integrator,
        request: RenderRequest,
        progress: Callable[[float], None],
        judged: Pick = lambda pixels: pixels,
        key: str = "",
    ) -> None:
        self._integrator = integrator
        self._request = request
        self._progress = progress
        self._judged = judged
        self._key = key
        self._batches = 0
        self.samples = [0, 0]
        self.error: float | None = None

    def run(self, finish: Finish) -> None:
        """Render until there are enough samples, the error is small enough or time is up.

        Args:
            finish: Called with every strip of the picture.
        """
        request = self._request
        if request.error is None and request.seconds is None:
            self._complete(request.samples or 1, finish, self._progress)
            return
        height, width = self._integrator.size
        shape = 2, self._integrator.planes, height, width, 3
        if 4 * np.prod(shape, dtype=np.int64) <= _MOST_KEPT_BYTES:
            sums = Halves(np.zeros(shape, np.float32), self.samples, self._judged)
            self._rounds(sums, lambda planes: planes, request.seconds, self._progress)
            for rows in self._integrator.strips(min(sums.samples)):
                finish(rows, sums.rows(rows))
            return
        # Twice: to know how many samples it takes, and with so many.
        sums = Halves(np.zeros((2, height, width, 3), np.float32), [0, 0])
        start, limit = time.perf_counter(), request.seconds
        scouting = None if limit is None else _PACE_SHARE * limit
        self._rounds(sums, self._judged, scouting, lambda done: self._progress(0.5 * done))
        wanted = sums.total
        if limit is not None:
            passed = time.perf_counter() - start
            wanted = max(2, int(wanted * (limit - passed) / passed))
        self._complete(wanted, finish, lambda done: self._progress(0.5 + 0.5 * done))

    def whole(self) -> Halves:
        """Render what has one strip alone."""
        found: list[Halves] = []
        self.run(lambda rows, halves: found.append(halves))
        (halves,) = found
        return halves

    def _complete(self, wanted: int, finish: Finish, progress: Callable[[float], None]) -> None:
        """Render strip after strip, each with all samples."""
        height, width = self._integrator.size
        self.samples[:] = wanted - wanted // 2, wanted // 2
        for rows in self._integrator.strips(self.samples[0]):
            count = rows.stop - rows.start
            shape = 2, self._integrator.planes, count, width, 3
            shares = list(self._shares(wanted, rows))
            # What is one batch is as exact as that.
            precision = np.float32 if len(shares) <= 2 else np.float64
            halves = Halves(np.zeros(shape, precision), [0, 0], self._judged)
            self._batches = 0
            for half, samples in shares:
                pixels = self._render(rows, samples)
                if wanted == 1:
                    halves.sums = pixels[None]
                elif halves.samples[half]:
                    halves.sums[half] += precision(samples) * pixels
                else:
                    np.multiply(pixels, precision(samples), out=halves.sums[half])
                halves.samples[half] += samples
                self._batches += 1
                progress((rows.start + count * halves.total / wanted) / height)
            finish(rows, halves)

    def _rounds(
        self, sums: Halves, kept: Pick, limit: float | None, progress: Callable[[float], None]
    ) -> None:
        """Add samples to all strips until the error is small enough or time is up.

        Args:
            sums: Receives them.
            kept: What of a batch's planes.
            limit: Seconds; None goes by the error.
            progress: Called with the finished fraction.
        """
        add = self._adder(sums, kept)
        if limit is None:
            self._until_error(self._request.error or 0.0, sums, add, progress)
        else:
            self._until_time(limit, add, progress)

    def _adder(self, sums: Halves, kept: Pick) -> Callable[[int, int], None]:
        def add(half: int, samples: int) -> None:
            for rows in self._integrator.strips(samples):
                found: NDArray[Any] = np.float32(samples) * self._render(rows, samples)
                sums.sums[half][..., rows, :, :] += kept(found)
            sums.samples[half] += samples
            self._batches += 1

        return add

    def _until_error(
        self,
        wanted: float,
        sums: Halves,
        add: Callable[[int, int], None],
        progress: Callable[[float], None],
    ) -> None:
        goal, error = _FIRST_SAMPLES, np.inf
        while error > wanted and goal <= _MOST_SAMPLES:
            for half, samples in self._shares(goal - sums.total):
                add(half, samples)
                # The error falls as the inverse of the samples.
                known = np.isfinite(error) and wanted > 0
                expected = goal * max(1.0, error / wanted if known else 1.0)
                progress(min(0.99, sums.total / expected))
            self.error = error = sums.error or 0.0
            goal *= 2
        progress(1.0)

    def _until_time(
        self, limit: float, add: Callable[[int, int], None], progress: Callable[[float], None]
    ) -> None:
        start, samples = time.perf_counter(), 1
        while True:
            begun = time.perf_counter()
            add(0, samples)
            add(1, samples)
            now = time.perf_counter()
            left = limit - (now - start)
            progress(min(1.0, (now - start) / limit))
            pace = (now - begun) / samples
            # Twice as much while that surely fits; what remains is filled with what fits.
            samples = min(2 * samples, self._most(), int(left / pace)) if left > 0 else 0
            if samples < 1:
                return

    def _most(self, rows: slice | None = None) -> int:
        """Samples of each pixel that a batch may have, of a strip or of the narrowest there are."""
        rows = rows or self._integrator.strips(_MOST_SAMPLES)[0]
        return self._integrator.most_in(rows)

    def _shares(self, samples: int, rows: slice | None = None) -> Iterator[tuple[int, int]]:
        """(half, samples) of batches that bring both halves on alike."""
        shares = [samples - samples // 2, samples // 2]
        most = self._most(rows)
        while any(shares):
            for half, left in enumerate(shares):
                if left:
                    now = min(left, most)
                    shares[half] -= now
                    yield half, now

    def _render(self, rows: slice, samples: int) -> Floats:
        request = self._request
        key = [self._key] if self._key else []
        below = [f"row {rows.start}"] if rows.start else []
        seed = batch_seed(request.seed, request.camera, *key, self._batches, *below)
        return self._integrator.strip(rows, samples, seed)
