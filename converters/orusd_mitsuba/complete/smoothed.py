"""Pictures whose indirect light is averaged where it varies slowly.

Averaged is what arrives of a light indirectly; and what is reflected of it, by Lambert's law and by
lobes, each over what it is of even light. What that changes of a part changes all pictures that it
is a part of by the same, so that they go on adding up. Both halves of the samples are averaged by
the same weights, so they go on telling the noise. What they cannot tell, because it is no noise, is
kept as means over blocks: see `pictures.Changes`.
"""

from collections.abc import Callable, Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.channels import numbered
from orusd_mitsuba.complete.accumulator import GUIDES, OF_LIGHT, ONCE
from orusd_mitsuba.complete.smoothing import Slowness, smoothed
from orusd_mitsuba.pictures import BLOCK_PIXELS, Pick, Pictures
from orusd_mitsuba.transport.sampling import Halves

Floats = NDArray[np.float32]

# The channel of a part of what is reflected, its sum, the same of even light, and how slowly the
# one over the other varies.
_REFLECTED: Final = (
    ("diffuse", "diffuse_indirect", "albedo", Slowness.of_irradiance),
    ("specular", "rest_indirect", "lobe_albedo", Slowness.of_lobes),
)
_AVERAGED: Final = ("irradiance_indirect", *(row[1] for row in _REFLECTED))

SMOOTHED: Final = (
    "irradiance", "irradiance_indirect", "irradiance_i", "radiance", "indirect", "diffuse",
    "radiance_i", "specular",
)  # fmt: skip
"""Channels that are changed."""


class SmoothedPictures(Pictures):
    """See `Pictures`.

    Args:
        picks: By image, what makes it of an integrator's planes, without the guides.
        size: Height and width.
        lights: How many lights are told apart; None where they are not.
    """

    def __init__(
        self, picks: Mapping[str, Pick], size: tuple[int, int], lights: int | None
    ) -> None:
        super().__init__(picks, size)
        self._lights = lights
        self._guides = np.zeros((len(GUIDES), *size, 3), dtype=np.float32)
        shape = 2, lights or 1, *size, 3
        self._halves = {name: np.zeros(shape, np.float32) for name in _AVERAGED}

    def finish(self, rows: slice, halves: Halves) -> None:
        """See `Pictures`."""
        lit, guides = np.split(halves.sums, [-len(GUIDES)], axis=1)
        self._guides[:, rows] = guides.sum(axis=0, dtype=np.float64) / halves.total
        for half, (sums, samples) in enumerate(zip(lit, halves.samples, strict=True)):
            for name, kept in self._halves.items():
                kept[half, :, rows] = self._by_light(name, sums) / max(1, samples)
        super().finish(rows, Halves(lit, halves.samples, halves.judged))

    def smooth(self, samples: tuple[int, int]) -> None:
        """Smooth what there is.

        Args:
            samples: Of a pixel, in each half.
        """
        received = self._changes("irradiance_indirect", samples, 1.0, Slowness.of_irradiance)
        for name in ("irradiance", "irradiance_indirect"):
            self._add(name, received.sum(axis=1), samples)
        self._add_by_light("irradiance_i", received, samples)
        del received
        for channel, name, factor, slowness in _REFLECTED:
            over = self._guides[GUIDES.index(factor)]
            halves = self._changes(name, samples, over, slowness)
            self._add_by_light("radiance_i", halves, samples)
            for image in ("radiance", "indirect", channel):
                self._add(image, halves.sum(axis=1), samples)

    def _changes(
        self, name: str, samples: tuple[int, int], factor: Floats | float,
        slowness: Callable[[Floats], Slowness],
    ) -> Floats:  # fmt: skip
        """(halves, lights, height, width, 3) what averaging changes of something over a factor."""
        raw = self._halves.pop(name)[: 2 if min(samples) else 1]
        np.divide(raw, factor, out=raw, where=np.asarray(factor) > 0.0)
        planes = raw.reshape(-1, *raw.shape[2:])
        means = np.stack(smoothed(planes, self._guides, slowness(self._guides)))
        means -= planes
        found = means.reshape(raw.shape)
        found *= factor
        return found

    def _add_by_light(self, channel: str, halves: Floats, samples: tuple[int, int]) -> None:
        for light in range(self._lights or 0):
            self._add(numbered(channel, light), halves[:, light], samples)

    def _add(self, name: str, halves: Floats, samples: tuple[int, int]) -> None:
        if name not in self._kept:
            return
        mean = np.average(halves, axis=0, weights=samples[: len(halves)])
        self._kept[name].add(mean, *halves)
        self.changes[name] = self.changes.get(name, np.float32(0.0)) + _by_blocks(mean)

    def _by_light(self, name: str, planes: NDArray[np.floating]) -> NDArray[np.floating]:
        """(lights, rows, width, 3) of the planes of some rows."""
        if self._lights is None:
            return planes[[ONCE.index(name)]]
        start = len(ONCE) + [*OF_LIGHT].index(name) * self._lights
        return planes[start : start + self._lights]


def _by_blocks(plane: NDArray[np.floating]) -> Floats:
    """Means over blocks; those at the right and at the bottom may be smaller."""
    starts = [np.arange(0, side, BLOCK_PIXELS) for side in plane.shape[:2]]
    down, across = (np.diff(np.append(*cut)) for cut in zip(starts, plane.shape[:2], strict=True))
    sums = np.add.reduceat(np.add.reduceat(plane, starts[0], axis=0), starts[1], axis=1)
    return np.asarray(sums / np.outer(down, across)[..., None], dtype=np.float32)
