"""The channels of one render pass, which fill up strip by strip."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.channels import CHANNELS, definition, numbered
from openrooms_usd.rendering import Image
from openrooms_usd.rendering.estimates import ErrorEstimate
from openrooms_usd.rendering.halves import HalvedPicture
from orusd_mitsuba.transport.sampling import Halves

Images = dict[str, Image]
Pick = Callable[[Array], Array]
PickOfLight = Callable[[Array, int], Array]

BLOCK_PIXELS: Final = 16
"""Side of the blocks in which changes are measured."""
Changes = dict[str, Floats]
"""By image, (blocks down, blocks across, 3): by how much its mean over blocks was changed after its
samples were taken."""


def of_lights(picks: Mapping[str, PickOfLight], lights: int) -> dict[str, Pick]:
    """By image, what makes it of an integrator's planes.

    Args:
        picks: The same by channel; of a channel of every light, given the light's number.
        lights: How many there are.
    """
    found: dict[str, Pick] = {}
    for name, pick in picks.items():
        of_light = CHANNELS[name].scope == "light"
        for light in range(lights) if of_light else (0,):
            single = numbered(name, light) if of_light else name
            found[single] = partial(_picked, pick, light)
    return found


def _picked(pick: PickOfLight, light: int, planes: Array) -> Array:
    return pick(planes, light)


class Pictures:
    """Images and their halves.

    Args:
        picks: By image, what makes it of an integrator's planes.
        size: Height and width.

    Attributes:
        changes: What was done to the images after the samples were taken.
    """

    def __init__(self, picks: Mapping[str, Pick], size: tuple[int, int]) -> None:
        self._picks = picks
        self._kept = {
            name: HalvedPicture.blank(np.zeros((*size, len(definition(name).components)), "f4"))
            for name in picks
        }
        self.changes: Changes = {}

    def finish(self, rows: slice, halves: Halves) -> None:
        """Fill in a strip."""
        mean, each = halves.mean.astype(halves.sums.dtype, copy=False), halves.each
        for name, pick in self._picks.items():
            self._kept[name].pixels[rows] = pick(mean)
            if each:
                self._kept[name].fill(rows, pick(each[0]), pick(each[1]))

    def images(
        self, samples: tuple[int, int], seconds: float, replaced: int, *, keep: bool
    ) -> Images:
        """The finished ones.

        Args:
            samples: Of a pixel, in each half.
            seconds: What they took.
            replaced: Pixels in which there was no number.
            keep: Whether images shall have their halves.
        """
        images: Images = {}
        for name in self._picks:
            kept = self._kept.pop(name)
            halves = kept.of(samples) if min(samples) else None
            is_ratio = definition(name).unit == "1"
            told = ErrorEstimate(None, None)
            if halves:
                told = halves.estimate_of_ratio if is_ratio else halves.estimate
            images[name] = Image(
                kept.pixels,
                sum(samples),
                seconds,
                told.relative_mse,
                replaced,
                halves if keep else None,
                robust_error=told.robust,
            )
        return images
