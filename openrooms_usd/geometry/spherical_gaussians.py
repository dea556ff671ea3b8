"""Hemispheres of light as sums of spherical Gaussians: color exp(sharpness (axis . d - 1)).

Lobes are chosen from a fixed set (`lobe_pursuit`) and brought to their best places
(`lobe_refinement`).

What is made small is the squared difference, weighed by solid angle over luminance plus the mean
luminance: between relative and absolute, so that neither the sun nor dim walls are all that counts.
In the end colours change by as little as gives exactly the irradiance of the cells.

Points come in blocks of one size, and no matrix product is large enough for BLAS to share it among
threads, which costs more than the product. So the result at a point does not depend, to the bit, on
its neighbours or the number of threads.
"""

import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.colorimetry import LUMINANCE
from openrooms_usd.geometry.hemisphere import HEMISPHERE, irradiance, spherical
from openrooms_usd.geometry.lobe_pursuit import CELLS, pursue, raised
from openrooms_usd.geometry.lobe_refinement import Lobes, refined

LOBES: Final = 12
_POINTS_AT_A_TIME: Final = 64
_LUMINANCE: Final = LUMINANCE.astype(np.float32)

_SIZES: Final = np.repeat(HEMISPHERE.solid_angles, HEMISPHERE.columns).astype(np.float32)
# (cells,) what a cell's light is worth for the irradiance.
_COSINES: Final = irradiance(np.eye(len(CELLS)).reshape(-1, 16, 32, 1))[:, 0].astype(np.float32)
# Of the mean square of lobes, so that those alike can be told apart.
_RIDGE: Final = np.float32(1e-3)


def fit(radiance: NDArray[Any], lobes: int = LOBES) -> Floats:
    """Fit lobes to hemispheres.

    Args:
        radiance: (..., 16, 32, 3) means over the cells, not negative.
        lobes: How many.

    Returns:
        (..., lobes, 6): theta and phi of the axis in the hemisphere's frame, radians, its polar
        angle at most pi / 2; sharpness; red, green and blue, not negative.
    """
    flat = radiance.reshape(-1, HEMISPHERE.count, 3)
    found = np.zeros((len(flat), lobes, 6), dtype=np.float32)
    blocks = range(0, len(flat), _POINTS_AT_A_TIME)
    threads = min(os.cpu_count() or 1, len(blocks)) or 1

    def work(some: Iterable[int]) -> None:
        room = np.empty((_POINTS_AT_A_TIME, 4 * lobes, HEMISPHERE.count), np.float32)
        for start in some:
            part = flat[start : start + _POINTS_AT_A_TIME]
            block = np.zeros((_POINTS_AT_A_TIME, *flat.shape[1:]), np.float32)
            block[: len(part)] = part
            found[start : start + _POINTS_AT_A_TIME] = _fit(block, lobes, room)[: len(part)]

    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(work, (blocks[first::threads] for first in range(threads))))
    return found.reshape(*radiance.shape[:-3], lobes, 6)


def evaluate(lobes: NDArray[Any]) -> Floats:
    """(..., 16, 32, 3) the light of lobes in the middles of the cells.

    Args:
        lobes: (..., K, 6) as of `fit`.
    """
    flat = lobes.reshape(-1, *lobes.shape[-2:]).astype(np.float32)
    light = np.empty((len(flat), HEMISPHERE.count, 3), np.float32)
    for start in range(0, len(flat), _POINTS_AT_A_TIME):
        some = flat[start : start + _POINTS_AT_A_TIME]
        axes = spherical(some[..., 0], some[..., 1]).astype(np.float32)
        shapes = raised(some[..., 2:3] * (axes @ CELLS.T - 1.0))
        light[start : start + _POINTS_AT_A_TIME] = np.swapaxes(shapes, 1, 2) @ some[..., 3:]
    return light.reshape(*lobes.shape[:-2], HEMISPHERE.rows, HEMISPHERE.columns, 3)


def error(radiance: NDArray[Any], lobes: NDArray[Any]) -> Array:
    """(...) the root of the mean squared difference over that of the mean square."""
    light = radiance.reshape(-1, *radiance.shape[-3:])
    flat = lobes.reshape(-1, *lobes.shape[-2:])
    found = np.empty(len(flat))
    for start in range(0, len(flat), _POINTS_AT_A_TIME):
        some = slice(start, start + _POINTS_AT_A_TIME)
        off, whole = (
            np.einsum("prac,prac,r->p", part, part, HEMISPHERE.solid_angles, optimize=False)
            for part in (evaluate(flat[some]) - light[some], light[some])
        )
        found[some] = np.sqrt(off / np.maximum(whole, 1e-30))
    return found.reshape(lobes.shape[:-2])


def _fit(light: Floats, count: int, room: Floats) -> Floats:
    """(P, count, 6) for (P, cells, 3), whose brightness is brought near 1 meanwhile."""
    means = np.einsum("pnc,c,n->p", light, _LUMINANCE, _SIZES / _SIZES.sum())
    scale = np.maximum(means, np.float32(1e-20))[:, None, None]
    light = light / scale
    grey = light @ _LUMINANCE
    weights = _SIZES / (grey + 1.0)
    lobes = refined(*pursue(grey, weights, count), light, weights, room)
    x, y, z = np.moveaxis(lobes.axes, -1, 0)
    theta, phi = np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)
    shapes = np.stack([theta, phi, lobes.sharpness], axis=-1)
    colors = scale * _carrying(lobes, np.einsum("pnc,n->pc", light, _COSINES))
    return np.concatenate([shapes, colors], axis=-1).astype(np.float32)


def _carrying(lobes: Lobes, wanted: Floats) -> Floats:
    """(P, K, 3) the colours that give an irradiance with the least squares of what is left.

    What would be negative is 0; a factor then makes up for it.

    Args:
        lobes: With the best colours, whatever irradiance they give.
        wanted: (P, 3).
    """
    count = lobes.sharpness.shape[1]
    shapes = raised(lobes.sharpness[..., None] * (lobes.axes @ CELLS.T - 1.0))
    each = shapes @ _COSINES
    gram = lobes.products[:, :count, :count]
    ridge = _RIDGE * np.einsum("pkk->p", gram)[:, None, None] / np.float32(count)
    way = np.linalg.solve(gram + ridge * np.eye(count, dtype=np.float32), each[..., None])
    lacking = wanted - (each[:, None] @ lobes.colors)[:, 0]
    colors = lobes.colors + way * (lacking / (each[:, None] @ way)[:, 0])[:, None]
    colors = np.maximum(colors, 0.0)
    given = (each[:, None] @ colors)[:, 0]
    return np.asarray(colors * (wanted / np.maximum(given, 1e-20))[:, None])
