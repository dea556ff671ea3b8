"""What may be done to a view on its way: a contract, and chains.

A transform changes all that a sample has, together: pixels by what their channel is, ``K``, the
pose, hemispheres, boxes of lights. So what holds of a render holds of what comes out: depth along
the rays of ``K`` gives the positions, normals in the camera's and in the world's axes agree, lights
sum to the whole.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Protocol

import numpy as np

from openrooms_usd.channels import Channel
from openrooms_usd.errors import InputError
from openrooms_usd.loading.sample import (
    Array,
    Sample,
    has_x,
    is_camera_vector,
    is_in_picture,
    is_scaled,
)

# Parts of pictures: the principal point moves along, and hemispheres stay on their pixels.


@dataclass(frozen=True)
class Crop:
    """A part of the picture.

    Attributes:
        left: The first column, from 0.
        top: The first row.
        width: Pixels.
        height: Pixels.
    """

    left: int
    top: int
    width: int
    height: int

    def __call__(self, sample: Sample, rng: np.random.Generator, /) -> Sample:
        """The part.

        Raises:
            InputError: It is not in the picture, or cuts through cells of a grid of hemispheres.
        """
        wide, high = sample.size
        right, bottom = self.left + self.width, self.top + self.height
        if not (0 <= self.left < right <= wide and 0 <= self.top < bottom <= high):
            raise InputError(
                f"a part of {self.width}x{self.height} pixels at ({self.left}, {self.top}) is not "
                f"in a picture of {wide}x{high}",
                place=sample.name,
                remedy="make it smaller, or resize the picture before",
            )
        across, down = steps(sample)
        if any(at % across for at in (self.left, right)) or any(
            at % down for at in (self.top, bottom)
        ):
            raise InputError(
                "the part cuts through cells of a grid of hemispheres",
                place=sample.name,
                remedy=f"choose multiples of {across} columns and {down} rows, or leave such "
                "channels out",
            )
        shift = np.array([[0.0, 0.0, self.left], [0.0, 0.0, self.top], [0.0, 0.0, 0.0]])
        part = sample.each(lambda _, pixels: pixels[..., self.top : bottom, self.left : right, :])

        def cells(grid: Array) -> Array:
            rows, columns = grid.shape[:2]
            return grid[
                self.top * rows // high : bottom * rows // high,
                self.left * columns // wide : right * columns // wide,
            ]

        return replace(part.each_grid(cells), size=(self.width, self.height), K=sample.K - shift)


@dataclass(frozen=True)
class CentreCrop:
    """The middle of the picture, as near as grids of hemispheres allow.

    Attributes:
        width: Pixels.
        height: Pixels.
    """

    width: int
    height: int

    def __call__(self, sample: Sample, rng: np.random.Generator, /) -> Sample:
        """The part; raises as `Crop` does."""
        left, top = (room // 2 for room in _rooms(sample, self.width, self.height))
        across, down = steps(sample)
        at = (left // across * across, top // down * down)
        return Crop(*at, self.width, self.height)(sample, rng)


@dataclass(frozen=True)
class RandomCrop:
    """A part anywhere in the picture, where grids of hemispheres allow.

    Attributes:
        width: Pixels.
        height: Pixels.
    """

    width: int
    height: int

    def __call__(self, sample: Sample, rng: np.random.Generator, /) -> Sample:
        """The part; raises as `Crop` does."""
        rooms = _rooms(sample, self.width, self.height)
        left, top = (
            int(rng.integers(max(room, 0) // step + 1)) * step
            for room, step in zip(rooms, steps(sample), strict=True)
        )
        return Crop(left, top, self.width, self.height)(sample, rng)


def steps(sample: Sample) -> tuple[int, int]:
    """Columns and rows by which parts may begin and end, so that no grid's cell is cut."""
    wide, high = sample.size
    across = [wide // math.gcd(wide, grid.shape[1]) for grid in sample.grids.values()]
    down = [high // math.gcd(high, grid.shape[0]) for grid in sample.grids.values()]
    return math.lcm(*across), math.lcm(*down)


def _rooms(sample: Sample, width: int, height: int) -> tuple[int, int]:
    return sample.size[0] - width, sample.size[1] - height


class Transform(Protocol):
    """Makes a sample of another one; it can be pickled, and draws from the numbers it is given."""

    def __call__(self, sample: Sample, rng: np.random.Generator, /) -> Sample:
        """The new sample; the old one stays as it is.

        Raises:
            InputError: The sample cannot be changed so.
        """
        ...


@dataclass(frozen=True)
class Compose:
    """Transforms, one after the other.

    Attributes:
        steps: The transforms.
    """

    steps: Sequence[Transform]

    def __call__(self, sample: Sample, rng: np.random.Generator, /) -> Sample:
        """The sample after all of them."""
        for step in self.steps:
            sample = step(sample, rng)
        return sample


# Mirrored and turned pictures.
#
# A mirrored picture is the picture of a mirrored room. The mirror is the world's plane x = 0.
# Positions, normals and boxes of lights change the sign of their x
# alone, so that nothing is rounded and up stays up. All mirrored views of a room are in the
# same mirrored room. With S = diag(-1, 1, 1, 1) the pose becomes S world_from_camera S, which is a
# rotation again, and the principal point goes to the other side.
#
# Hemispheres are given in the frame (n x y, y, n), y the camera's up made orthogonal to the normal
# n. Its first axis is a cross product and turns against the mirror: azimuth phi becomes pi - phi.

_MIRROR: Final = np.diag([-1.0, 1.0, 1.0, 1.0])
_X: Final = np.array([-1.0, 1.0, 1.0], np.float32)
# The camera's axes after a quarter turn of the picture to the left, in those before it: OpenCV.
_TURN: Final = np.array(
    [[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
)


@dataclass(frozen=True)
class HorizontalFlip:
    """Left and right exchanged; twice, it gives the same bits again.

    Attributes:
        probability: How often; 1 always.
    """

    probability: float = 0.5

    def __call__(self, sample: Sample, rng: np.random.Generator, /) -> Sample:
        """The mirrored sample, or the same."""
        # Drawn in any case, so that what comes after draws the same.
        return flipped(sample) if rng.random() < self.probability else sample


def flipped(sample: Sample) -> Sample:
    """The sample with left and right exchanged."""

    def change(channel: Channel, pixels: Array) -> Array:
        mirrored = pixels[..., ::-1, :]
        return mirrored * _X[: mirrored.shape[-1]] if has_x(channel) else mirrored

    K = sample.K.copy()
    K[0, 2] = sample.size[0] - K[0, 2]
    return replace(
        sample.each(change).each_grid(_flipped_grid),
        K=K,
        world_from_camera=_MIRROR @ sample.world_from_camera @ _MIRROR,
        # With its own x mirrored too, the frame of a box stays as right-handed as it was.
        world_from_box=_MIRROR @ sample.world_from_box @ _MIRROR,
        mirrored=not sample.mirrored,
    )


def _flipped_grid(grid: Array) -> Array:
    azimuths = grid.shape[3]
    return grid[:, ::-1, :, (azimuths // 2 - 1 - np.arange(azimuths)) % azimuths]


@dataclass(frozen=True)
class QuarterTurn:
    """The picture turned to the left; the camera rolls, the world stays.

    Attributes:
        times: How many quarters.
    """

    times: int = 1

    def __call__(self, sample: Sample, rng: np.random.Generator, /) -> Sample:
        """The turned sample.

        Raises:
            InputError: It has hemispheres: their frame hangs on the camera's up.
        """
        if self.times % 4 and sample.grids:
            raise InputError(
                f"{' and '.join(sample.grids)} cannot be turned: the frame of hemispheres hangs "
                "on the camera's up",
                place=sample.name,
                remedy="leave these channels out, or the turn",
            )
        for _ in range(self.times % 4):
            sample = _turned(sample)
        return sample


def _turned(sample: Sample) -> Sample:
    def change(channel: Channel, pixels: Array) -> Array:
        turned = np.rot90(pixels, axes=(-3, -2))
        if is_camera_vector(channel):
            right, up, backward = np.moveaxis(turned, -1, 0)
            return np.stack([-up, right, backward], axis=-1)
        if is_in_picture(channel):
            across, down = np.moveaxis(turned, -1, 0)
            return np.stack([down, -across], axis=-1)
        return turned

    width, height = sample.size
    K = sample.K
    turned = [[K[1, 1], 0.0, K[1, 2]], [0.0, K[0, 0], width - K[0, 2]], [0.0, 0.0, 1.0]]
    return replace(
        sample.each(change),
        size=(height, width),
        K=np.array(turned),
        world_from_camera=sample.world_from_camera @ _TURN,
    )


# Light as networks like it: of a sensible size, centred.


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
