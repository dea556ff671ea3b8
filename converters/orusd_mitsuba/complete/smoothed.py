"""Pictures whose indirect light is averaged where it varies slowly.

Averaged is what arrives of a light indirectly; and what is reflected of it, by Lambert's law and by
lobes, each over what it is of even light. What that changes of a part changes all pictures that it
is a part of by the same, so that they go on adding up. Both halves of the samples are averaged by
the same weights, so they go on telling the noise. What they cannot find, because it is not noise,
is kept as means over blocks: see `pictures.Changes`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Floats
from openrooms_usd.channels import numbered
from orusd_mitsuba.complete.accumulator import GUIDES, OF_LIGHT, ONCE
from orusd_mitsuba.complete.smoothing import IrradianceGradient, smoothed
from orusd_mitsuba.pictures import BLOCK_PIXELS, Pick, Pictures
from orusd_mitsuba.transport.sampling import Halves

# More at once would take more memory.
_LIGHTS_AT_ONCE: Final = 8


@dataclass(frozen=True)
class _Part:
    """Something that is averaged.

    Attributes:
        name: Of what is summed.
        over: The guide that it is divided by; None: it is averaged as it is.
        slowness: How slowly that varies.
        of_light: The channel of every light that it is a part of.
        whole: The other channels.
    """

    name: str
    over: str | None
    slowness: Callable[[Floats], IrradianceGradient]
    of_light: str
    whole: tuple[str, ...]


_PARTS: Final = (
    _Part(
        "irradiance_indirect",
        None,
        IrradianceGradient.of_irradiance,
        "irradiance_i",
        ("irradiance", "irradiance_indirect"),
    ),
    _Part(
        "diffuse_indirect",
        "albedo",
        IrradianceGradient.of_irradiance,
        "radiance_i",
        ("radiance", "indirect", "diffuse"),
    ),
    _Part(
        "rest_indirect",
        "lobe_albedo",
        IrradianceGradient.of_lobes,
        "radiance_i",
        ("radiance", "indirect", "specular"),
    ),
)
SMOOTHED: Final = frozenset(name for part in _PARTS for name in (part.of_light, *part.whole))
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
        self._halves = {
            part.name: np.zeros(shape, np.uint16) for part in _PARTS if self._is_wanted(part)
        }

    def finish(self, rows: slice, halves: Halves) -> None:
        """See `Pictures`."""
        lit, guides = np.split(halves.sums, [-len(GUIDES)], axis=1)
        self._guides[:, rows] = guides.sum(axis=0, dtype=np.float64) / halves.total
        for half, sums in enumerate(lit):
            for name, kept in self._halves.items():
                means = self._by_light(name, sums) / max(1, halves.samples[half])
                kept[half, :, rows] = _shortened(means)
        super().finish(rows, Halves(lit, halves.samples, halves.judged))

    def smooth(self, samples: tuple[int, int]) -> None:
        """Smooth what there is.

        Args:
            samples: Of a pixel, in each half.
        """
        # What strips took is kept for reuse.
        dr.flush_malloc_cache()
        for part in filter(self._is_wanted, _PARTS):
            kept = self._halves.pop(part.name)[: 2 if min(samples) else 1]
            whole: Any = 0.0
            for first in range(0, kept.shape[1], _LIGHTS_AT_ONCE):
                changes = self._changes(part, kept[:, first : first + _LIGHTS_AT_ONCE])
                whole = whole + changes.sum(axis=1)
                for number in range(changes.shape[1] if self._lights else 0):
                    name = numbered(part.of_light, first + number)
                    self._add(name, changes[:, number], samples)
            for name in part.whole:
                self._add(name, whole, samples)

    def _is_wanted(self, part: _Part) -> bool:
        return not {*part.whole, numbered(part.of_light, 0)}.isdisjoint(self._picks)

    def _changes(self, part: _Part, kept: NDArray[np.uint16]) -> Floats:
        """(halves, lights, height, width, 3) what averaging changes."""
        raw = _lengthened(kept)
        even = np.float32(1.0) if part.over is None else self._guides[GUIDES.index(part.over)]
        np.divide(raw, even, out=raw, where=np.asarray(even) > 0.0)
        planes = raw.reshape(-1, *raw.shape[2:])
        means = np.stack(smoothed(planes, self._guides, part.slowness(self._guides)))
        means -= planes
        found = means.reshape(raw.shape)
        found *= even
        return found

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


def _shortened(values: NDArray[np.floating]) -> NDArray[np.uint16]:
    """Numbers in two bytes: all of single precision's range, to two digits.

    Many lights take much memory, and what is lost is lost of raw pictures and of their means alike.
    """
    bits = np.ascontiguousarray(values, dtype=np.float32).view(np.uint32)
    return np.asarray((bits + 0x8000) >> 16, dtype=np.uint16)


def _lengthened(values: NDArray[np.uint16]) -> Floats:
    """The same in four bytes again."""
    return (values.astype(np.uint32) << 16).view(np.float32)
