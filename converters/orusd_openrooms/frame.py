"""A view on its way into the dataset: what it can give, and at which resolutions."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.errors import InputError
from openrooms_usd.rendering.folder import LIGHTS_FILE
from openrooms_usd.rendering.reading import RenderedView
from orusd_openrooms.lights import Light

# Hemispheres of light at the points of a grid, as one tiled picture.
#
# A hemisphere has 16 rows of elevation, the first around the normal n, and 32 columns of azimuth.
# Its frame is (n x y, y, n) with y the camera's up made orthogonal to n. It is left-handed, so that
# on a surface that faces the camera the first axis points to the camera's left.

Grid = Floats

HEMISPHERE: Final = (16, 32)

Order = Literal["legacy", "rgb"]
"""How the channels of a tiled picture are stored: as the released loaders take them, which read
blue, green, red and use that as red, green, blue; or in the file format's own order."""


def tiled(grid: Grid) -> Grid:
    """A grid of hemispheres as one picture.

    Args:
        grid: (rows, columns, elevations, azimuths, 3).

    Returns:
        (rows elevations, columns azimuths, 3).
    """
    rows, columns, elevations, azimuths, _ = grid.shape
    return grid.transpose(0, 2, 1, 3, 4).reshape(rows * elevations, columns * azimuths, 3)


def stored(picture: Grid, order: Order) -> Grid:
    """A picture with its channels in the order in which they are stored."""
    return picture[..., ::-1] if order == "legacy" else picture


def coarser(grid: Grid, factor: int) -> Grid:
    """A grid of 1/factor the rows and columns: means over blocks, each point in its own frame.

    That is what the released grids hold: the mean over a pixel's many samples.

    Args:
        grid: (rows, columns, elevations, azimuths, 3), rows and columns multiples of ``factor``.
        factor: Points of the finer grid along a side of a block.
    """
    rows, columns, *cell = grid.shape
    blocks = grid.reshape(rows // factor, factor, columns // factor, factor, *cell)
    result: Grid = blocks.mean(axis=(1, 3), dtype=np.float64).astype(np.float32)
    return result


def irradiance(grid: Grid) -> Grid:
    """The cosine integral of every hemisphere, whose cells hold means over their solid angles.

    The integral of the cosine over a cell is exact; that the light inside a cell is even is not.

    Args:
        grid: (rows, columns, elevations, azimuths, 3).

    Returns:
        (rows, columns, 3).
    """
    elevations, azimuths = grid.shape[2:4]
    edges = np.linspace(0.0, 0.5 * np.pi, elevations + 1)
    belts = np.diff(0.5 * np.sin(edges) ** 2) * (2.0 * np.pi / azimuths)
    lux: Grid = np.einsum("rceak,e->rck", grid, belts, optimize=True).astype(np.float32)
    return lux


Pixels = Floats
# Light is stored at a quarter of the picture's resolution, what is direct alone at a sixteenth.
COARSER: Final = 4


@dataclass(eq=False)
class Frame:
    """A view on its way into the dataset.

    Attributes:
        view: What was rendered.
        lights: Those of the scene that have a place.
        order: How the channels of environment maps are stored.
        instances: The largest number of an object in the scene.
        missing: By kind of file, why it cannot be made.
        approximations: By number of a light, what its lobes give at the points of the grid, lux.
    """

    view: RenderedView
    lights: Sequence[Light]
    order: Order
    instances: int
    missing: dict[str, str] = field(default_factory=dict)
    approximations: dict[int, Pixels] = field(default_factory=dict)

    @cached_property
    def environment(self) -> Pixels | None:
        """The grid of hemispheres, if it was rendered."""
        return self.view.grid("environment")

    @property
    def grid(self) -> tuple[int, int]:
        """Rows and columns of what is stored coarser."""
        if self.environment is not None:
            return self.environment.shape[0], self.environment.shape[1]
        return max(1, self.view.height // COARSER), max(1, self.view.width // COARSER)

    def has(self, need: str) -> bool:
        """Whether the render gives one of the channels ``a|b``; those of lights end in ``_i``."""
        return any(map(self._gives, need.split("|")))

    def _gives(self, name: str) -> bool:
        if name.endswith("_i"):
            return name.removesuffix("_i") in self.view.lights
        files = (self.view.folder / f"{name}{suffix}" for suffix in (".exr", ".npy"))
        return name in self.view.pixels or any(os.path.lexists(file) for file in files)

    def light(self, channel: str, light: Light) -> Pixels:
        """(height, width, components) a channel of one light.

        Raises:
            InputError: Other lights have it, and this one has not.
        """
        try:
            return self.view.lights[channel][light.number]
        except KeyError as error:
            raise InputError(
                f"light {light.number} has no channel {channel}_{light.number}",
                place=self.view.folder / LIGHTS_FILE,
                remedy="render again",
            ) from error

    def lacks(self, needs: Sequence[str]) -> str:
        """Why a file cannot be made; empty when it can."""
        absent = [need.replace("|", " nor ") for need in needs if not self.has(need)]
        return f"the render has no {', no '.join(absent)}" if absent else ""

    def coarse(self, pixels: Pixels) -> Pixels:
        """A channel at the resolution of the grid."""
        return area_mean(pixels, *self.grid)

    def misses(self, name: str, needs: Sequence[str]) -> bool:
        """Whether a file cannot be made; ``missing`` then says why."""
        reason = self.lacks(needs)
        if reason:
            self.missing[name] = reason
        return bool(reason)


def area_mean(pixels: NDArray[Any], rows: int, columns: int) -> Floats:
    """Average a picture over the pixels of a coarser (or finer) grid that covers it.

    Args:
        pixels: (height, width, components).
        rows: Of the result.
        columns: Of the result.

    Returns:
        (rows, columns, components).
    """
    down = _overlaps(pixels.shape[0], rows)
    across = _overlaps(pixels.shape[1], columns)
    reduced = np.einsum("rh,hwc->rwc", down, pixels.astype(np.float64), optimize=True)
    result: Floats = np.einsum("cw,rwk->rck", across, reduced, optimize=True).astype(np.float32)
    return result


def _overlaps(size: int, parts: int) -> Array:
    """(parts, size) which share of every part a cell covers; rows sum to 1."""
    edges = np.linspace(0.0, size, parts + 1)
    low, high = edges[:-1, None], edges[1:, None]
    cell = np.arange(size)
    covered = np.minimum(high, cell + 1) - np.maximum(low, cell)
    shares: Array = np.clip(covered, 0.0, None) / (high - low)
    return shares
