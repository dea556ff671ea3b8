"""Light by direction as real spherical harmonics.

The basis is orthonormal over the sphere, without the Condon-Shortley phase, and ordered by l, then
m from -l to l: 0.282095, 0.488603 y, 0.488603 z, 0.488603 x, 1.092548 x y, ... (R. Ramamoorthi, P.
Hanrahan, An Efficient Representation for Irradiance Environment Maps, 2001, equation 3).
"""

import math
from functools import cache
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.hemisphere import HemisphereGrid

# Nodes of a quadrature across one row of cells: exact to rounding for all orders in use.
_QUADRATURE_NODES: Final = 12


def basis(directions: ArrayLike, order: int) -> Array:
    """(..., (order + 1)^2) the functions in directions.

    Args:
        directions: (..., 3) unit vectors.
        order: The highest degree l.
    """
    d = np.asarray(directions, dtype=np.float64)
    polar = _polar(d[..., 2], order)
    phi = np.arctan2(d[..., 1], d[..., 0])
    return np.stack(
        [polar[degree, abs(m)] * _turning(m, phi) for degree, m in _indices(order)], axis=-1
    )


def project(radiance: NDArray[Any], cells: HemisphereGrid, order: int) -> Array:
    """The harmonics nearest to means over cells, by least squares over solid angle.

    Light of no higher degree is found exactly. A hemisphere has no light below its horizon.

    Args:
        radiance: (..., rows, columns, C).
        cells: What the means are over: a sphere, or a hemisphere.
        order: The highest degree.

    Returns:
        (..., (order + 1)^2, C) coefficients.
    """
    whole = cells
    if cells.extent < math.pi:
        whole = HemisphereGrid(round(cells.rows * math.pi / cells.extent), cells.columns, math.pi)
    integrals = cell_integrals(whole, order)
    sizes = np.repeat(whole.solid_angles, whole.columns)
    gram = integrals.T @ (integrals / sizes[:, None])
    weights = np.linalg.solve(gram, integrals[: cells.count].T)
    flat = radiance.reshape(*radiance.shape[:-3], cells.count, radiance.shape[-1])
    return np.asarray(np.matmul(weights, flat))


def turned(coefficients: ArrayLike, frame: ArrayLike) -> Array:
    """The same light in other axes.

    Args:
        coefficients: (..., (order + 1)^2, C) in a frame.
        frame: (3, 3) rows: the frame's axes in the world, orthonormal, of either handedness.

    Returns:
        The coefficients in the world.
    """
    values = np.asarray(coefficients, dtype=np.float64)
    order = math.isqrt(values.shape[-2]) - 1
    spread = HemisphereGrid(order + 2, 2 * order + 3, math.pi).directions.reshape(-1, 3)
    local = basis(spread @ np.asarray(frame, dtype=np.float64).T, order)
    matrix = np.linalg.lstsq(basis(spread, order), local, rcond=None)[0]
    return np.asarray(np.matmul(matrix, values))


def irradiance(coefficients: ArrayLike) -> Array:
    """From radiance to irradiance by the direction of the normal.

    Irradiance is radiance convolved with the clamped cosine (Ramamoorthi and Hanrahan 2001,
    equations 7 to 9): a factor for each degree.

    Args:
        coefficients: (..., (order + 1)^2, C) of radiance.
    """
    values = np.asarray(coefficients, dtype=np.float64)
    order = math.isqrt(values.shape[-2]) - 1
    factors = np.array([_cosine(degree) for degree, _ in _indices(order)])
    return np.asarray(values * factors[:, None])


@cache
def cell_integrals(cells: HemisphereGrid, order: int) -> Array:
    """(cells, (order + 1)^2) the functions' integrals over cells.

    They are exact by azimuth, and by Gauss's rule across rows.
    """
    nodes, weights = np.polynomial.legendre.leggauss(_QUADRATURE_NODES)
    step = cells.extent / cells.rows
    theta = (np.arange(cells.rows)[:, None] + 0.5 * (nodes + 1.0)) * step
    polar = _polar(np.cos(theta), order) * np.sin(theta)
    rows = np.einsum("lmrn,n->lmr", polar, 0.5 * step * weights)
    edges = (np.arange(cells.columns + 1) / cells.columns - 0.5) * 2.0 * math.pi
    found = [
        np.multiply.outer(rows[degree, abs(m)], np.diff(_turned(m, edges)))
        for degree, m in _indices(order)
    ]
    return np.stack(found, axis=-1).reshape(cells.count, -1)


def _indices(order: int) -> list[tuple[int, int]]:
    return [(degree, m) for degree in range(order + 1) for m in range(-degree, degree + 1)]


def _polar(z: Array, order: int) -> Array:
    """(order + 1, order + 1, ...) by degree and |m|: normalized Legendre functions of a cosine."""
    found = np.zeros((order + 1, order + 1, *z.shape))
    sine = np.sqrt(np.maximum(0.0, 1.0 - z * z))
    found[0, 0] = math.sqrt(0.25 / math.pi)
    for m in range(order + 1):
        if m:
            found[m, m] = math.sqrt((2 * m + 1) / (2 * m)) * sine * found[m - 1, m - 1]
        for n in range(m + 1, order + 1):
            a = math.sqrt((4 * n * n - 1) / (n * n - m * m))
            b = math.sqrt(((n - 1) ** 2 - m * m) / (4 * (n - 1) ** 2 - 1))
            found[n, m] = a * (z * found[n - 1, m] - (b * found[n - 2, m] if n > m + 1 else 0.0))
    return found


def _turning(m: int, phi: Array) -> Array:
    if m == 0:
        return np.ones_like(phi)
    return math.sqrt(2.0) * (np.cos(m * phi) if m > 0 else np.sin(-m * phi))


def _turned(m: int, phi: Array) -> Array:
    """The integral of `_turning`."""
    if m == 0:
        return phi
    return math.sqrt(2.0) * (np.sin(m * phi) / m if m > 0 else np.cos(-m * phi) / m)


def _cosine(degree: int) -> float:
    """The factor of a degree: pi, 2 pi / 3, pi / 4, 0, -pi / 24, 0 ..."""
    if degree == 1:
        return 2.0 * math.pi / 3.0
    if degree % 2:
        return 0.0
    half = degree // 2
    sign = -1.0 if half % 2 == 0 else 1.0
    size = math.comb(degree, half) / 2.0**degree
    return 2.0 * math.pi * sign * size / ((degree + 2) * (degree - 1))
