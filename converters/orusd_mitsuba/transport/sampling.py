"""Batches of samples in two independent halves, until they are enough, and their error."""

import hashlib
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.render import RenderRequest, estimates
from openrooms_usd.render.scene.pictures import Array

# When an error is asked for: samples a pixel to begin with, and where to give up.
_FIRST_SAMPLES: Final = 16
_MOST_SAMPLES: Final = 1 << 16


Pick = Callable[[Array], Array]


class Batch(Protocol):
    """Renders (..., height, width, 3) pictures with some samples a pixel from a seed."""

    def __call__(self, samples: int, seed: int) -> NDArray[np.float32]:
        """Render one batch."""
        ...


@dataclass(eq=False)
class Halves:
    """Sums of the even and of the odd batches.

    Attributes:
        sums: Two (..., height, width, 3) sums over samples.
        samples: How many each has.
        judged: Picks from (..., height, width, 3) the picture whose error counts.
    """

    sums: Array
    samples: list[int]
    judged: Pick = lambda pixels: pixels

    def add(self, half: int, pixels: NDArray[np.float32], samples: int) -> None:
        """Add a batch."""
        self.sums[half] += samples * pixels.astype(np.float64)
        self.samples[half] += samples

    @property
    def total(self) -> int:
        """Samples a pixel."""
        return sum(self.samples)

    @property
    def mean(self) -> NDArray[np.float32]:
        """(..., height, width, 3) all samples."""
        return np.asarray(self.sums.sum(axis=0) / self.total, dtype=np.float32)

    @property
    def error(self) -> float | None:
        """The estimated error of what is judged; None while one half is empty."""
        return self.error_of(self.judged)

    def error_of(self, pick: Pick) -> float | None:
        """The estimated error of one picture; None while one half is empty.

        Args:
            pick: Picks it from (..., height, width, 3).
        """
        found = self.of(pick)
        return found.error if found else None

    def of(self, pick: Pick) -> estimates.Halves | None:
        """The halves of one picture; None while one is empty."""
        if min(self.samples) == 0:
            return None
        a, b = (pick(total / count) for total, count in zip(self.sums, self.samples, strict=True))
        return estimates.Halves(a, b, (self.samples[0], self.samples[1]))


def batch_seed(*parts: object) -> int:
    """A seed of 32 bits from whatever makes a batch unlike every other."""
    text = "\0".join(map(str, parts))
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=4).digest(), "little")


class ProgressiveSampler:
    """Renders batches of one camera until the request is met.

    Args:
        render: Renders one batch.
        request: Says when it is enough, and the seed.
        shape: Height and width, and before them how many pictures a batch gives, if many.
        most: Samples a pixel that one batch may have at most.
        progress: Called with the finished fraction.
        judged: See `Halves`.
        key: Sets its random numbers apart from those of other render passes of the same camera.
    """

    def __init__(
        self,
        render: Batch,
        request: RenderRequest,
        shape: tuple[int, ...],
        most: int,
        progress: Callable[[float], None],
        judged: Pick = lambda pixels: pixels,
        key: str = "",
    ) -> None:
        self._render = render
        self._request = request
        self._most = most
        self._progress = progress
        self._batches = 0
        self._key = key
        self.halves = Halves(np.zeros((2, *shape, 3)), [0, 0], judged)

    def run(self) -> Halves:
        """Render until there are enough samples, the error is small enough or time is up."""
        request = self._request
        if request.error is not None:
            self._until_error(request.error)
        elif request.seconds is not None:
            self._until_time(request.seconds)
        else:
            self._until_samples(request.samples or 1)
        return self.halves

    def _until_samples(self, wanted: int) -> None:
        for half, samples in self._shares(wanted):
            self._add(half, samples)
            self._progress(self.halves.total / wanted)

    def _until_error(self, wanted: float) -> None:
        goal, error = _FIRST_SAMPLES, np.inf
        while error > wanted and goal <= _MOST_SAMPLES:
            for half, samples in self._shares(goal - self.halves.total):
                self._add(half, samples)
                # The error falls as the inverse of the samples.
                known = np.isfinite(error) and wanted > 0
                expected = goal * max(1.0, error / wanted if known else 1.0)
                self._progress(min(0.99, self.halves.total / expected))
            error = self.halves.error or 0.0
            goal *= 2
        self._progress(1.0)

    def _until_time(self, limit: float) -> None:
        start, samples = time.perf_counter(), 1
        while True:
            begun = time.perf_counter()
            self._add(0, samples)
            self._add(1, samples)
            now = time.perf_counter()
            left = limit - (now - start)
            self._progress(min(1.0, (now - start) / limit))
            pace = (now - begun) / samples
            # Twice as much while that surely fits; what remains is filled with what fits.
            samples = min(2 * samples, self._most, int(left / pace)) if left > 0 else 0
            if samples < 1:
                return

    def _shares(self, samples: int) -> Iterator[tuple[int, int]]:
        """(half, samples) of batches that bring both halves on alike."""
        shares = [samples - samples // 2, samples // 2]
        while any(shares):
            for half, left in enumerate(shares):
                if left:
                    now = min(left, self._most)
                    shares[half] -= now
                    yield half, now

    def _add(self, half: int, samples: int) -> None:
        request = self._request
        seed = batch_seed(request.seed, request.camera, *filter(None, [self._key]), self._batches)
        self._batches += 1
        self.halves.add(half, self._render(samples, seed), samples)
