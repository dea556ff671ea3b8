"""Hemispheres of light at the points of a grid, as one tiled picture.

A hemisphere has 16 rows of elevation, the first around the normal n, and 32 columns of azimuth; its
frame is (n x y, y, n) with y the camera's up made orthogonal to n: left-handed, so that on a
surface that faces the camera the first axis points to the camera's left.
"""

from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

Grid = NDArray[np.float32]

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
