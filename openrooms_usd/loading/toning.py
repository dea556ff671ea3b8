"""Light as networks like it: of a sensible size, centred."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from openrooms_usd.channels import Channel
from openrooms_usd.errors import InputError
from openrooms_usd.loading.sample import Array, Sample, is_scaled


@dataclass(frozen=True)
class Exposure:
    """All nits and lux times one number, which `Sample.light_scale` keeps.

    It brings a percentile of the radiance to a level, as published loaders of OpenRooms do. Ratios
    and reflectances stay, so the identities between channels hold.

    Attributes:
        percentile: Of all components of the radiance, from 0 to 100.
        level: What it becomes.
        stops: Then up to so many stops brighter or darker, evenly drawn.
    """

    percentile: float = 95.0
    level: float = 0.9
    stops: float = 0.0

    def __call__(self, sample: Sample, rng: np.random.Generator, /) -> Sample:
        """The exposed sample; a black one stays black.

        Raises:
            InputError: It has no radiance.
        """
        if "radiance" not in sample.images:
            raise InputError(
                "there is no radiance to expose by",
                place=sample.name,
                remedy="load the channel radiance too",
            )
        found = float(np.percentile(sample.images["radiance"], self.percentile))
        drawn = 2.0 ** rng.uniform(-self.stops, self.stops)
        return scaled(sample, drawn * (self.level / found if found > 0.0 else 1.0))


def scaled(sample: Sample, factor: float) -> Sample:
    """The sample with all light times a factor."""
    by = np.float32(factor)

    def change(channel: Channel, pixels: Array) -> Array:
        return pixels * by if is_scaled(channel) else pixels

    changed = sample.each(change).each_grid(lambda grid: grid * by)
    return replace(changed, light_scale=sample.light_scale * factor)


@dataclass(frozen=True)
class Normalise:
    """Numbers centred and scaled for a network: the last step, since they mean nothing after it.

    Attributes:
        statistics: By channel, the means and the standard deviations of its components.
    """

    statistics: Mapping[str, tuple[Sequence[float], Sequence[float]]]

    def __call__(self, sample: Sample, rng: np.random.Generator, /) -> Sample:
        """The sample with ``(value - mean) / deviation`` in these channels.

        Raises:
            InputError: It lacks one of them.
        """
        if missing := sorted({*self.statistics} - {*sample.images, *sample.lights}):
            raise InputError(
                f"there is no {missing[0]!r} to normalise",
                place=sample.name,
                remedy="load that channel too, or leave its statistics out; hemispheres have none",
            )

        def change(channel: Channel, pixels: Array) -> Array:
            if channel.name not in self.statistics:
                return pixels
            mean, deviation = (np.asarray(row, np.float32) for row in self.statistics[channel.name])
            return np.asarray((pixels - mean) / deviation, np.float32)

        return sample.each(change)
