"""Light by direction, in cells of elevation and azimuth about a normal or about the vertical.

A cell holds the mean of radiance over its solid angle. Rows are polar angles, the first about the
frame's third axis; columns are azimuths, the middle one along its first axis, and grow towards its
second one. The frame of a surface is the one of OpenRooms' released maps: n the normal, y the
camera's up made orthogonal to it, x = n cross y. It is left-handed: where a surface faces the
camera, x points to the camera's left.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from openrooms_usd.arrays import Array, Floats

# Sine of the angle between normal and up below which the direction of view stands in for up.
_PARALLEL_SINE: Final = 1e-4


@dataclass(frozen=True)
class HemisphereGrid:
    """A division of directions into cells of equal angles.

    Attributes:
        rows: Of polar angle.
        columns: Of azimuth, all around.
        extent: The largest polar angle, radians: pi / 2 for a hemisphere, pi for a sphere.
    """

    rows: int
    columns: int
    extent: float

    @property
    def count(self) -> int:
        """How many there are."""
        return self.rows * self.columns

    @cached_property
    def edges(self) -> Array:
        """(rows + 1,) cosines of the polar angles between the rows, falling."""
        cosines = np.cos(np.linspace(0.0, self.extent, self.rows + 1))
        cosines[-1] = 0.0 if self.extent == 0.5 * math.pi else cosines[-1]
        return np.asarray(cosines)

    @cached_property
    def solid_angles(self) -> Array:
        """(rows,) of a cell in each row, steradian."""
        return np.asarray(-np.diff(self.edges) * (2.0 * math.pi / self.columns))

    @cached_property
    def directions(self) -> Array:
        """(rows, columns, 3) unit vectors through the cells' middle angles, in their frame."""
        theta = (np.arange(self.rows) + 0.5) / self.rows * self.extent
        phi = ((np.arange(self.columns) + 0.5) / self.columns - 0.5) * 2.0 * math.pi
        return spherical(*np.meshgrid(theta, phi, indexing="ij"))


HEMISPHERE: Final = HemisphereGrid(16, 32, 0.5 * math.pi)
"""What a point of a grid receives; polar angles about its shading normal."""


PANORAMA: Final = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""The frame of latitude-longitude pictures of the surroundings, rows in the world: the first row
around +Z, the middle column along -Y, a quarter from the left along +X, as in UsdLux."""


def panorama_cells(panorama: NDArray[Any]) -> HemisphereGrid:
    """The cells of a (height, width, ...) picture of all directions."""
    return HemisphereGrid(panorama.shape[0], panorama.shape[1], math.pi)


def spherical(theta: ArrayLike, phi: ArrayLike) -> Array:
    """(..., 3) unit vectors of polar angles and azimuths, radians."""
    t, p = np.asarray(theta, dtype=np.float64), np.asarray(phi, dtype=np.float64)
    return np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1)


def surface_frames(normals: ArrayLike, up: ArrayLike, forward: ArrayLike) -> Array:
    """Frames of surfaces as a camera sees them.

    Args:
        normals: (P, 3) unit.
        up: (3,) the camera's up.
        forward: (3,) its direction of view. It takes the place of up where the normal is parallel
            to up: as on a floor that a level camera sees, where it is the limit of cameras that
            look down.

    Returns:
        (P, 3, 3) rows x, y, n: unit vectors in the frame of the normals.
    """
    n = np.asarray(normals, dtype=np.float64)
    y = _across(np.asarray(up, dtype=np.float64), n)
    along = np.linalg.norm(y, axis=1) < _PARALLEL_SINE
    y[along] = _across(np.asarray(forward, dtype=np.float64), n[along])
    y /= np.linalg.norm(y, axis=1, keepdims=True)
    return np.stack([np.cross(n, y), y, n], axis=1)


def _across(direction: Array, normals: Array) -> Array:
    """The parts of a direction that are orthogonal to normals."""
    return np.asarray(direction - (normals @ direction)[:, None] * normals)


def cosine_weights(cells: HemisphereGrid, normal: ArrayLike) -> Array:
    """(rows, columns) what radiance in the cells is worth for the irradiance about any normal.

    The cosine is that of the cells' middles, about the mean where cells are small.

    Args:
        cells: How directions are divided.
        normal: (3,) unit, in the cells' frame.
    """
    cosines = np.maximum(0.0, cells.directions @ np.asarray(normal, dtype=np.float64))
    return np.asarray(cosines * cells.solid_angles[:, None])


def irradiance(radiance: NDArray[Any]) -> Array:
    """The cosine integral over hemispheres, lux.

    The integral of the cosine over each cell is exact, so that even light L gives pi L. Light that
    is uneven within a cell makes the error that `irradiance_bound` bounds.

    Args:
        radiance: (..., rows, columns, C) means over the cells of hemispheres.

    Returns:
        (..., C).
    """
    cells = _hemisphere(radiance)
    middle = 0.5 * (cells.edges[:-1] + cells.edges[1:])
    return _weighted(radiance, cells.solid_angles * middle)


def irradiance_bound(radiance: NDArray[Any]) -> Array:
    """How far `irradiance` may be from the irradiance that the true light gives.

    Light is not negative. Of all light with the same mean over a cell, a beam along the cell's edge
    towards the normal gives most, one along the edge towards the horizon least. The mean cosine
    over the solid angle of a cell lies half-way between. So the bound is the sum of radiance times
    solid angle times half the difference of the edges' cosines, and beams reach it. It is half a
    percent of a cell's share at the normal, and all of it at the horizon.

    Args:
        radiance: (..., rows, columns, C) means over the cells of hemispheres.

    Returns:
        (..., C), lux.
    """
    cells = _hemisphere(radiance)
    return _weighted(radiance, cells.solid_angles * -0.5 * np.diff(cells.edges))


def _hemisphere(radiance: NDArray[Any]) -> HemisphereGrid:
    rows, columns = radiance.shape[-3:-1]
    return (
        HEMISPHERE if (rows, columns) == (16, 32) else HemisphereGrid(rows, columns, 0.5 * math.pi)
    )


def _weighted(radiance: NDArray[Any], weights: Array) -> Array:
    sums = radiance.sum(axis=-2, dtype=np.float64)
    return np.asarray(np.einsum("...rc,r->...c", sums, weights))


def tiled(grid: Floats) -> Floats:
    """A grid of hemispheres as one picture.

    Args:
        grid: (rows, columns, elevations, azimuths, C).

    Returns:
        (rows elevations, columns azimuths, C).
    """
    rows, columns, elevations, azimuths, depth = grid.shape
    tiles = grid.transpose(0, 2, 1, 3, 4)
    return tiles.reshape(rows * elevations, columns * azimuths, depth)


def untiled(picture: Floats, cells: HemisphereGrid = HEMISPHERE) -> Floats:
    """The hemispheres of `tiled`.

    Args:
        picture: (rows elevations, columns azimuths, C).
        cells: What each tile is divided into.

    Returns:
        (rows, columns, elevations, azimuths, C).
    """
    height, width, depth = picture.shape
    tiles = picture.reshape(
        height // cells.rows, cells.rows, width // cells.columns, cells.columns, depth
    )
    return np.ascontiguousarray(tiles.transpose(0, 2, 1, 3, 4))
