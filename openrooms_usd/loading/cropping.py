"""Parts of pictures: the principal point moves along, and hemispheres stay on their pixels."""

import math
from dataclasses import dataclass, replace

import numpy as np

from openrooms_usd.errors import InputError
from openrooms_usd.loading.sample import Array, Sample


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
                remedy=f"take columns by {across} and rows by {down}, or leave such channels out",
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
