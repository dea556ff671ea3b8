"""Hemispheres of light as sums of spherical Gaussians: color exp(sharpness (axis . d - 1)).

Lobes are chosen from a fixed set (`lobe_pursuit`). Then all of a point's axes and sharpnesses move
together by damped Gauss-Newton steps, with the best colours that are not negative after each, as
long as it pays.

What is made small is the squared difference, weighed by solid angle over luminance plus the mean
luminance: between relative and absolute, so that neither the sun nor dim walls are all that counts.
In the end the colours are scaled so that the irradiance is exactly that of the cells.

All that a step needs of the cells are the products of the lobes and their slopes with one another
and with the light. Points come in blocks of one size, and no matrix product is so large that BLAS
would share it among threads, which costs more than these products do: so what is found at a point
depends to the bit neither on its neighbours nor on the number of threads.
"""

import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.colorimetry import LUMINANCE
from openrooms_usd.geometry.hemisphere import HEMISPHERE, irradiance, spherical
from openrooms_usd.geometry.lobe_pursuit import CELLS, MAX_SHARPNESS, Floats, pursue, raised

LOBES: Final = 12
_MIN_SHARPNESS: Final = 0.1
# Steps at most; after one that takes less than this share of what was left a point is done.
_MAX_STEPS: Final = 20
_MIN_GAIN_SHARE: Final = 0.03
# Sweeps over the colours of all lobes, after which they hardly change: at first, and after a step.
_SWEEPS: Final = (6, 3)
# The largest turn of an axis and change of a sharpness's logarithm in one step.
_MAX_TURN: Final = 0.3
# What the damping is multiplied by after a step that helps, and one that does not.
_BOLDER: Final = np.float32(0.3)
_SHYER: Final = np.float32(4.0)
_POINTS_AT_A_TIME: Final = 64
_LUMINANCE: Final = LUMINANCE.astype(np.float32)

_SIZES: Final = np.repeat(HEMISPHERE.solid_angles, HEMISPHERE.columns).astype(np.float32)
# (4, cells): sharpness (axis . d - 1) and its slopes are sums of these.
_FORMS: Final = np.concatenate([np.ones_like(CELLS[:, :1]), CELLS], axis=1).T.copy()


@dataclass(eq=False)
class _Lobes:
    """Of P points with K lobes each, and what they and their slopes have in common with the light.

    The slopes are those by the sharpness's logarithm and by two turns of the axis, of the colour 1.

    Attributes:
        axes: (P, K, 3) unit.
        sharpness: (P, K).
        colors: (P, K, 3).
        products: (P, 4 K, 4 K) of the lobes, then the slopes of each kind, with one another.
        target: (P, 4 K, 3) of the same with the light.
        loss: (P,) weighed sum of squares of what is left.
    """

    axes: Floats
    sharpness: Floats
    colors: Floats
    products: Floats
    target: Floats
    loss: Floats

    def of(self, points: NDArray[np.int64]) -> "_Lobes":
        """Those of some points."""
        return _Lobes(*(getattr(self, field.name)[points] for field in fields(self)))

    def put(self, points: NDArray[np.int64], lobes: "_Lobes") -> None:
        """Set those of some points."""
        for field in fields(self):
            getattr(self, field.name)[points] = getattr(lobes, field.name)


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


def error(radiance: NDArray[Any], lobes: NDArray[Any]) -> Floats:
    """(...) the root of the mean squared difference over that of the mean square."""
    off = ((evaluate(lobes) - radiance) ** 2).sum(axis=-1) * HEMISPHERE.solid_angles[:, None]
    all_of_it = (radiance**2).sum(axis=-1) * HEMISPHERE.solid_angles[:, None]
    whole = np.maximum(all_of_it.sum(axis=(-1, -2)), 1e-30)
    return np.asarray(np.sqrt(off.sum(axis=(-1, -2)) / whole))


def _fit(light: Floats, count: int, room: Floats) -> Floats:
    """(P, count, 6) for (P, cells, 3), whose brightness is brought near 1 meanwhile."""
    means = np.einsum("pnc,c,n->p", light, _LUMINANCE, _SIZES / _SIZES.sum())
    scale = np.maximum(means, np.float32(1e-20))[:, None, None]
    light = light / scale
    grey = light @ _LUMINANCE
    weights = _SIZES / (grey + 1.0)
    lobes = _refined(*pursue(grey, weights, count), light, weights, room)
    x, y, z = np.moveaxis(lobes.axes, -1, 0)
    theta, phi = np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)
    shapes = np.stack([theta, phi, lobes.sharpness], axis=-1)
    found = np.concatenate([shapes, lobes.colors], axis=-1).astype(np.float32)
    shape = len(light), HEMISPHERE.rows, HEMISPHERE.columns, 3
    wanted, given = irradiance(light.reshape(shape)), irradiance(evaluate(found))
    found[..., 3:] *= (scale[..., 0] * wanted / np.maximum(given, 1e-20))[:, None]
    return found


def _refined(
    axes: Floats, sharpness: Floats, light: Floats, weights: Floats, room: Floats
) -> _Lobes:
    """Axes and sharpnesses by Levenberg's and Marquardt's steps; no step makes a point worse."""
    root = np.sqrt(weights)
    light = light * root[..., None]
    lobes = _colored(axes, sharpness, np.zeros_like(axes), light, root, room, _SWEEPS[0])
    damping, going = np.ones(len(light), np.float32), np.arange(len(light))
    for _ in range(_MAX_STEPS):
        if not len(going):
            break
        now = lobes.of(going)
        axes, sharpness = _stepped(now, damping[going])
        tried = _colored(
            axes, sharpness, now.colors, light[going], root[going], room[: len(going)], _SWEEPS[1]
        )
        better = np.flatnonzero(tried.loss < now.loss)
        lobes.put(going[better], tried.of(better))
        damping[going] *= np.where(tried.loss < now.loss, _BOLDER, _SHYER)
        going = going[tried.loss < (1.0 - _MIN_GAIN_SHARE) * now.loss]
    return lobes


def _colored(
    axes: Floats, sharpness: Floats, colors: Floats, light: Floats, root: Floats, room: Floats,
    sweeps: int,
) -> _Lobes:  # fmt: skip
    """Lobes with the best colours that are not negative, by coordinate descent.

    Args:
        axes: (P, K, 3).
        sharpness: (P, K).
        colors: (P, K, 3) to begin with.
        light: (P, cells, 3) times ``root``.
        root: (P, cells) of the weights.
        room: (P, 4 K, cells) to work in.
        sweeps: How many.
    """
    count = sharpness.shape[1]
    np.matmul(_slopes(axes, sharpness), _FORMS, out=room[:, count:])
    raised(room[:, count : 2 * count], out=room[:, :count])
    room[:, :count] *= root[:, None]
    kinds = room.reshape(len(room), 4, count, -1)
    kinds[:, 1:] *= kinds[:, :1]
    products, target = room @ room.swapaxes(1, 2), room @ light
    gram, aims, colors = products[:, :count, :count], target[:, :count], colors.copy()
    lengths = np.maximum(np.einsum("pkk->pk", gram), 1e-20)[..., None]
    for _ in range(sweeps):
        for k in range(count):
            step = (aims[:, k] - (gram[:, k, None] @ colors)[:, 0]) / lengths[:, k]
            colors[:, k] = np.maximum(colors[:, k] + step, 0.0)
    loss = np.einsum("pnc,pnc->p", light, light)
    loss += np.einsum("pkc,pkc->p", colors, gram @ colors - 2.0 * aims)
    return _Lobes(axes, sharpness, colors, products, target, loss)


def _slopes(axes: Floats, sharpness: Floats) -> Floats:
    """(P, 3 K, 4) of a lobe's logarithm, in `_FORMS`: by sharpness's logarithm and by turns.

    The first of them is the logarithm itself.
    """
    ways = np.stack([axes, *_tangents(axes)], axis=1)
    first = np.zeros_like(ways[..., :1])
    first[:, 0] = -1.0
    slopes = np.concatenate([first, ways], axis=-1) * sharpness[:, None, :, None]
    return np.asarray(slopes.reshape(len(axes), -1, 4))


def _stepped(lobes: _Lobes, damping: Floats) -> tuple[Floats, Floats]:
    """Axes and sharpness after one step of all of them, the colours held.

    How a lobe changes does not depend on its colour but for a factor. So the normal matrix is that
    of the slopes, times the products of the colours.
    """
    points, count = lobes.sharpness.shape
    colors = np.tile(lobes.colors, (1, 3, 1))
    normal = lobes.products[:, count:, count:] * (colors @ colors.swapaxes(1, 2))
    left = lobes.target[:, count:] - lobes.products[:, count:, :count] @ lobes.colors
    diagonal = np.einsum("pkk->pk", normal)
    diagonal *= 1.0 + damping[:, None]
    diagonal += 1e-6 * diagonal.mean(axis=1, keepdims=True) + 1e-20
    step = np.linalg.solve(normal, (left * colors).sum(axis=2, keepdims=True))
    wider, *turns = np.clip(step.reshape(points, 3, count, 1), -_MAX_TURN, _MAX_TURN).swapaxes(0, 1)
    axes = lobes.axes + sum(
        turn * way for turn, way in zip(turns, _tangents(lobes.axes), strict=True)
    )
    axes[..., 2] = np.maximum(axes[..., 2], 0.0)
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    return axes, np.clip(lobes.sharpness * np.exp(wider[..., 0]), _MIN_SHARPNESS, MAX_SHARPNESS)


def _tangents(axes: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors across each axis of the upper hemisphere (J. Frisvad 2012)."""
    x, y, z = np.moveaxis(axes, -1, 0)
    share = -1.0 / (1.0 + z)
    both = x * y * share
    return (np.stack([1.0 + x * x * share, both, -x], axis=-1),
            np.stack([both, 1.0 + y * y * share, -y], axis=-1))  # fmt: skip
