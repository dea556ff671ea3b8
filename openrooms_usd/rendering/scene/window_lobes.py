"""Two or three spherical Gaussians for what an opening sees of the surroundings.

Axes and sharpnesses are found by least squares (Levenberg 1944, Marquardt 1963), with colours that
are solved for on the way (variable projection, Golub and Pereyra 1973; slopes as by Kaufman 1975).
It begins at the best of many coarse ones, far apart, and the best end counts.

Broad lobes overlap so much that squares are least where one is all red and the other all blue. So a
lobe has the colour of the light that it lies on, to within a factor.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.colorimetry import LUMINANCE

# Coarse lobes: elevations of sky and ground, degrees, so many around; and sharpnesses.
_ELEVATIONS_DEG: Final = (5.0, 20.0, 45.0, 90.0), (0.0, -30.0, -90.0)
_AROUND: Final = 8
_SHARPNESS: Final = (0.1, 0.4, 1.5, 5.0, 15.0, 60.0)
_STARTS: Final = 3
_STARTS_OF_THIRD: Final = 6
# A pair that leaves no more than this needs no third.
_ENOUGH: Final = 0.05
_MAX_STEPS: Final = 30
# The end is reached after so many steps in a row that take less than this share of what is left.
_POOR_STEPS: Final = 3
_MIN_GAIN_SHARE: Final = 1e-4
# The largest turn, radians, and change of a sharpness's logarithm in one step.
_MAX_CHANGE: Final = 0.5
_MAX_LOGARITHM: Final = 7.0
# How many times as much, or as little, of a colour a lobe may have as the light that it lies on.
_COLOR_FACTOR: Final = 2.0


@dataclass(frozen=True, eq=False)
class Lit:
    """Light by direction.

    Attributes:
        ways: (N, 3) unit vectors.
        weights: (N,) what a squared error counts there, such as solid angles, sr.
        light: (N, 3) nits.
    """

    ways: Array
    weights: Array
    light: Array


@dataclass(frozen=True, eq=False)
class Lobes:
    """K lobes.

    Attributes:
        axes: (K, 3) unit.
        logs: (K,) logarithms of their sharpnesses.
        colors: (K, 3) nits along the axes.
        error: Root of the squared error relative to that of the light.
    """

    axes: Array
    logs: Array
    colors: Array
    error: float


def fitted(lit: Lit, count: int) -> Lobes:
    """Two lobes that fit best, three if asked for and needed; the light is not black."""
    best = _best(_improved(lit, *start) for start in _pairs(lit))
    if count > len(best.logs) and best.error > _ENOUGH:
        best = _best(_improved(lit, *start) for start in _with_another(lit, best))
    return best


def _best(ends: Iterable[Lobes]) -> Lobes:
    return min(ends, key=lambda end: end.error)


def _pairs(lit: Lit) -> list[tuple[Array, Array]]:
    """Axes and logarithms of coarse pairs that leave least luminance; each has another sky axis."""
    (high, low), root = (_directions(each) for each in _ELEVATIONS_DEG), np.sqrt(lit.weights)
    axes, logs = np.concatenate([high, low]), np.log(_SHARPNESS)
    shapes, gray = _coarse(lit, axes), root * (lit.light @ LUMINANCE)
    # (widths, axes) of the sky, then of the ground.
    sky, ground = (part.reshape(-1, len(root)) for part in np.split(shapes, [len(high)], axis=1))
    a, b = (sky**2).sum(axis=1)[:, None], (ground**2).sum(axis=1)
    # Sums that do not depend on the number of threads, as those of BLAS may.
    s, t = (np.einsum("in,n->i", part, gray) for part in (sky, ground))
    s, both = s[:, None], np.einsum("in,jn->ij", sky, ground)
    rest = np.maximum(a * b - both**2, 1e-12 * a * b)
    x, y = (b * s - both * t) / rest, (a * t - both * s) / rest
    alone = np.maximum(s**2 / a, t**2 / b)
    gains = np.where((x > 0.0) & (y > 0.0), x * s + y * t, alone)
    gains = gains.reshape(len(logs), len(high), len(logs), len(low)).swapaxes(0, 1)
    gains = gains.reshape(len(high), -1)
    found = []
    for number in np.argsort(-gains.max(axis=1))[:_STARTS]:
        width, other, place = np.unravel_index(
            int(gains[number].argmax()), (len(logs), len(logs), len(low))
        )
        found.append((np.stack([high[number], low[place]]), logs[[width, other]]))
    return found


def _with_another(lit: Lit, lobes: Lobes) -> list[tuple[Array, Array]]:
    """Axes and logarithms of lobes and a coarse one that takes most of what they leave."""
    axes, logs = np.concatenate([*map(_directions, _ELEVATIONS_DEG)]), np.log(_SHARPNESS)
    left = lit.light - np.exp(np.exp(lobes.logs) * (lit.ways @ lobes.axes.T - 1.0)) @ lobes.colors
    shapes, gray = _coarse(lit, axes), np.sqrt(lit.weights) * (left @ LUMINANCE)
    gains = np.maximum(np.einsum("wan,n->wa", shapes, gray), 0.0) ** 2 / (shapes**2).sum(axis=2)
    return [
        (np.vstack([lobes.axes, axes[row]]), np.append(lobes.logs, logs[gains[:, row].argmax()]))
        for row in np.argsort(-gains.max(axis=0))[:_STARTS_OF_THIRD]
    ]


def _coarse(lit: Lit, axes: Array) -> Array:
    """(widths, axes, N) lobes of luminance 1, by the roots of the weights."""
    widths = np.array(_SHARPNESS)[:, None, None]
    return np.asarray(np.exp(widths * (axes @ lit.ways.T - 1.0)) * np.sqrt(lit.weights))


def _directions(elevations_deg: tuple[float, ...]) -> Array:
    """(A, 3) unit vectors around the vertical; one for each pole."""
    found = []
    for elevation in np.radians(elevations_deg):
        count = 1 if np.cos(elevation) < 1e-6 else _AROUND
        turns = 2.0 * np.pi * np.arange(count) / count
        flat = np.cos(elevation) * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        found.append(np.column_stack([flat, np.full(count, np.sin(elevation))]))
    return np.concatenate(found)


def _improved(lit: Lit, axes: Array, logs: Array) -> Lobes:
    """The end of damped steps from a start."""
    root = np.sqrt(lit.weights)[:, None]
    light = root * lit.light
    whole = float(np.linalg.norm(light))

    def placed(axes: Array, logs: Array) -> tuple[Lobes, Array]:
        shapes = root * np.exp(np.exp(logs) * (lit.ways @ axes.T - 1.0))
        colors = _colors(shapes, light)
        error = float(np.linalg.norm(shapes @ colors - light)) / whole
        return Lobes(axes, logs, colors, error), shapes

    lobes, shapes = placed(axes, logs)
    damping, poor = 1e-2, 0
    for _ in range(_MAX_STEPS):
        change = _step(lit.ways, lobes, shapes, light, damping)
        tried, its_shapes = placed(*_moved(lobes, change))
        well = tried.error**2 < (1.0 - _MIN_GAIN_SHARE) * lobes.error**2
        poor = 0 if well else poor + 1
        if tried.error < lobes.error:
            lobes, shapes, damping = tried, its_shapes, damping / 4.0
        else:
            damping *= 4.0
        if poor == _POOR_STEPS:
            break
    return lobes


def _step(ways: Array, lobes: Lobes, shapes: Array, light: Array, damping: float) -> Array:
    """(3 K,) the change that the squares of what is left ask for."""
    left = (light - shapes @ lobes.colors).reshape(-1, 1)
    beside = np.concatenate([_slopes(ways, lobes, shapes), left], axis=1)
    products = beside.T @ beside
    normal, wanted = products[:-1, :-1], products[:-1, -1]
    normal += damping * np.diag(np.diag(normal) + 1e-12 * (np.trace(normal) + 1e-30))
    return np.asarray(np.clip(np.linalg.solve(normal, wanted), -_MAX_CHANGE, _MAX_CHANGE))


def _colors(shapes: Array, light: Array) -> Array:
    """(K, 3) the best within a factor of those that the light has where the lobes lie.

    Args:
        shapes: (N, K) of the colour 1.
        light: (N, 3).
    """
    gram, target = shapes.T @ shapes, shapes.T @ light
    tints = target / np.maximum(np.linalg.norm(target, axis=1, keepdims=True), 1e-300)
    alike, wanted = _steady(gram * (tints @ tints.T)), (tints * target).sum(axis=1, keepdims=True)
    # With others beside it a lobe is not brighter than alone.
    amounts = _within(alike, wanted, 0.0, wanted / np.diag(alike)[:, None])
    middle = amounts * tints
    return _within(gram, target, middle / _COLOR_FACTOR, middle * _COLOR_FACTOR)


def _within(gram: Array, target: Array, low: Array | float, high: Array | float) -> Array:
    """(K, C) that makes x . gram x - 2 x . target least within bounds, column by column.

    The best has each of its numbers at a bound, or is the best of those that are not: all ways to
    choose are tried.
    """
    gram, count = _steady(gram), len(gram)
    low, high = (np.broadcast_to(bound, target.shape) for bound in (low, high))
    tried = []
    for held in product((None, low, high), repeat=count):
        free = np.array([bound is None for bound in held])
        found = np.stack(
            [
                np.zeros(target.shape[1]) if bound is None else bound[row]
                for row, bound in enumerate(held)
            ]
        )
        if not np.isfinite(found).all():
            continue
        if free.any():
            rest = target[free] - gram[np.ix_(free, ~free)] @ found[~free]
            found[free] = np.linalg.solve(gram[np.ix_(free, free)], rest)
        tried.append(np.clip(found, low, high))
    costs = [(each * (gram @ each - 2.0 * target)).sum(axis=0) for each in tried]
    chosen = np.argmin(costs, axis=0)
    return np.asarray(np.stack(tried)[chosen, :, np.arange(target.shape[1])].T)


def _steady(gram: Array) -> Array:
    """Solvable even if lobes are the same, or one is nowhere."""
    return np.asarray(gram + (1e-9 * np.trace(gram) + 1e-300) * np.eye(len(gram)))


def _slopes(ways: Array, lobes: Lobes, shapes: Array) -> Array:
    """(3 N, 3 K) of the sum: both turns of each axis, then the sharpnesses; colours follow."""
    count = len(lobes.axes)
    turns = np.concatenate([_turns(axis) for axis in lobes.axes])
    logarithms = np.concatenate([ways @ turns.T, ways @ lobes.axes.T - 1.0], axis=1)
    of = np.concatenate([np.repeat(np.arange(count), 2), np.arange(count)])
    each = logarithms * (np.exp(lobes.logs) * shapes)[:, of]
    flat = (each[:, None] * lobes.colors.T[:, of]).reshape(len(ways), -1)
    flat = flat - shapes @ np.linalg.solve(_steady(shapes.T @ shapes), shapes.T @ flat)
    return np.asarray(flat.reshape(-1, 3 * count))


def _moved(lobes: Lobes, change: Array) -> tuple[Array, Array]:
    """Axes and logarithms after a step."""
    count = len(lobes.axes)
    turns = np.stack([_turns(axis) for axis in lobes.axes])
    axes = lobes.axes + (change[: 2 * count].reshape(count, 2, 1) * turns).sum(axis=1)
    logs = np.clip(lobes.logs + change[2 * count :], -_MAX_LOGARITHM, _MAX_LOGARITHM)
    return axes / np.linalg.norm(axes, axis=1, keepdims=True), logs


def _turns(axis: Array) -> Array:
    """(2, 3) unit vectors around the vertical, and upwards."""
    around = np.array([-axis[1], axis[0], 0.0])
    length = np.linalg.norm(around)
    around = around / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    return np.stack([around, np.cross(axis, around)])
