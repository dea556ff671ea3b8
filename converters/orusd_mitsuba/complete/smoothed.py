"""Pictures whose indirect light, as far as first surfaces scatter it by Lambert's law, is smooth.

What smoothing changes of a light's indirect irradiance changes all pictures that it is part of by
the same, so that they go on adding up: what is received as it is, what is reflected by the albedo.
Both halves of the samples are smoothed by the same weights, so they go on telling the noise. What
they cannot tell, because it is no noise, is kept as means over blocks: see `pictures.Changes`.
"""

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.channels import numbered
from orusd_mitsuba.complete.accumulator import GUIDES, OF_LIGHT, ONCE
from orusd_mitsuba.complete.smoothing import smoothed
from orusd_mitsuba.pictures import BLOCK_PIXELS, Pick, Pictures
from orusd_mitsuba.transport.sampling import Halves

Floats = NDArray[np.float32]

SMOOTHED: Final = (
    "irradiance", "irradiance_indirect", "irradiance_i", "radiance", "indirect", "diffuse",
    "radiance_i",
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
        self._halves = np.zeros((2, lights or 1, *size, 3), dtype=np.float32)

    def finish(self, rows: slice, halves: Halves) -> None:
        """See `Pictures`."""
        lit, guides = np.split(halves.sums, [-len(GUIDES)], axis=1)
        self._guides[:, rows] = guides.sum(axis=0, dtype=np.float64) / halves.total
        for half, (sums, samples) in enumerate(zip(lit, halves.samples, strict=True)):
            self._halves[half, :, rows] = self._irradiance(sums) / max(1, samples)
        super().finish(rows, Halves(lit, halves.samples, halves.judged))

    def smooth(self, samples: tuple[int, int]) -> None:
        """Smooth what there is.

        Args:
            samples: Of a pixel, in each half.
        """
        both = min(samples) > 0
        raw = self._halves if both else self._halves[:1]
        planes = raw.reshape(-1, *raw.shape[2:])
        changes = np.stack(smoothed(planes, self._guides)).reshape(raw.shape) - raw
        for name in ("irradiance", "irradiance_indirect"):
            self._add(name, changes.sum(axis=1), samples)
        self._add_by_light("irradiance_i", changes, samples)
        reflected = changes * (self._guides[GUIDES.index("albedo")] / np.float32(np.pi))
        whole = reflected.sum(axis=1) + self._add_by_light("radiance_i", reflected, samples)
        for name in ("radiance", "indirect", "diffuse"):
            self._add(name, whole, samples)

    def _add_by_light(
        self, channel: str, halves: Floats, samples: tuple[int, int]
    ) -> Floats | float:
        """Add to a channel of every light, and give what this has added beyond that.

        Where a pixel sees several surfaces, its light may be less than what would be taken away.
        """
        beyond: Floats | float = 0.0
        for light in range(self._lights or 0):
            beyond = beyond + self._add(numbered(channel, light), halves[:, light], samples)
        return beyond

    def _add(self, name: str, halves: Floats, samples: tuple[int, int]) -> Floats | float:
        if name not in self._kept:
            return 0.0
        mean = np.average(halves, axis=0, weights=samples[: len(halves)]).astype(np.float32)
        before = self._kept[name].pixels.copy()
        self._kept[name].add(mean, *halves)
        change = self._kept[name].pixels - before
        self.changes[name] = _by_blocks(change)
        return change - mean

    def _irradiance(self, planes: NDArray[np.floating]) -> NDArray[np.floating]:
        """(lights, rows, width, 3) what arrives indirectly."""
        if self._lights is None:
            return planes[[ONCE.index("irradiance_indirect")]]
        start = len(ONCE) + [*OF_LIGHT].index("irradiance_indirect") * self._lights
        return planes[start : start + self._lights]


def _by_blocks(plane: Floats) -> Floats:
    """Means over blocks; those at the right and at the bottom may be smaller."""
    starts = [np.arange(0, side, BLOCK_PIXELS) for side in plane.shape[:2]]
    down, across = (np.diff(np.append(*cut)) for cut in zip(starts, plane.shape[:2], strict=True))
    sums = np.add.reduceat(np.add.reduceat(plane, starts[0], axis=0), starts[1], axis=1)
    return np.asarray(sums / np.outer(down, across)[..., None], dtype=np.float32)
