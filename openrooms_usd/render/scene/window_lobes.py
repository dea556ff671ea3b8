"""Two spherical Gaussians for what an opening sees but for the sun: of the sky, and of the ground.

Axes and sharpnesses are found by least squares (Levenberg 1944, Marquardt 1963), with colours that
are solved for on the way (variable projection, Golub and Pereyra 1973; slopes as by Kaufman 1975).
It begins at the best of many coarse pairs, far apart, and the best end counts.

Broad lobes overlap so much that squares are least where one is all red and the other all blue. So a
lobe has the colour of the light that it lies on, to within a factor.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.colorimetry import LUMINANCE
from openrooms_usd.render.scene.pictures import Array

# Coarse lobes: elevations of sky and ground, degrees, so many around; and sharpnesses.
_ELEVATIONS_DEG: Final = (5.0, 20.0, 45.0, 90.0), (0.0, -30.0, -90.0)
_AROUND: Final = 8
_SHARPNESS: Final = (0.1, 0.4, 1.5, 5.0, 15.0)
_STARTS: Final = 3
_MAX_STEPS: Final = 30
# The end is reached after so many steps in a row that take less than this share of what is left.
_POOR_STEPS: Final = 3
_MIN_GAIN_SHARE: Final = 1e-4
# The largest turn, radians, and change of a sharpness's logarithm in one step.
_MAX_CHANGE: Final = 0.5
_MAX_LOGARITHM: Final = 6.0
# How many times as much, or as little, of a colour a lobe may have as the light that it lies on.
_COLOR_FACTOR: Final = 2.0


# Where turns upwards are among what a pair changes by; and the sides of the horizon.
_LIFTS: Final = [1, 3]
_SIDES: Final = np.array([1.0, -1.0])


@dataclass(frozen=True, eq=False)
class Lit:
    """Light by direction.

    Attributes:
        ways: (N, 3) unit vectors.
        weights: (N,) solid angles, sr.
        light: (N, 3) nits.
    """

    ways: Array
    weights: Array
    light: Array


@dataclass(frozen=True, eq=False)
class Pair:
    """The lobes of sky and ground.

    Attributes:
        axes: (2, 3) unit.
        logs: (2,) logarithms of their sharpnesses.
        colors: (2, 3) nits along the axes.
        error: Root of the squared error relative to that of the light.
    """

    axes: Array
    logs: Array
    colors: Array
    error: float


def fitted(lit: Lit) -> Pair:
    """The lobes of sky and ground that leave least; the light is not black."""
    return min((_improved(lit, *start) for start in _starts(lit)), key=lambda pair: pair.error)


def _starts(lit: Lit) -> list[tuple[Array, Array]]:
    """Axes and logarithms of coarse pairs that leave least luminance; each has another sky axis."""
    (high, low), root = (_directions(each) for each in _ELEVATIONS_DEG), np.sqrt(lit.weights)
    axes, logs = np.concatenate([high, low]), np.log(_SHARPNESS)
    shapes = np.exp(np.exp(logs)[:, None, None] * (axes @ lit.ways.T - 1.0)) * root
    gray = root * (lit.light @ LUMINANCE)
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


def _directions(elevations_deg: tuple[float, ...]) -> Array:
    """(A, 3) unit vectors around the vertical; one for each pole."""
    found = []
    for elevation in np.radians(elevations_deg):
        count = 1 if np.cos(elevation) < 1e-6 else _AROUND
        turns = 2.0 * np.pi * np.arange(count) / count
        flat = np.cos(elevation) * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        found.append(np.column_stack([flat, np.full(count, np.sin(elevation))]))
    return np.concatenate(found)


def _improved(lit: Lit, axes: Array, logs: Array) -> Pair:
    """The end of damped steps from a start."""
    root = np.sqrt(lit.weights)[:, None]
    light = root * lit.light
    whole = float(np.linalg.norm(light))

    def placed(axes: Array, logs: Array) -> tuple[Pair, Array]:
        shapes = root * np.exp(np.exp(logs) * (lit.ways @ axes.T - 1.0))
        colors = _colors(shapes, light)
        error = float(np.linalg.norm(shapes @ colors - light)) / whole
        return Pair(axes, logs, colors, error), shapes

    pair, shapes = placed(axes, logs)
    damping, poor = 1e-2, 0
    for _ in range(_MAX_STEPS):
        change = _step(lit.ways, pair, shapes, light, damping)
        tried, its_shapes = placed(*_moved(pair, change))
        well = tried.error**2 < (1.0 - _MIN_GAIN_SHARE) * pair.error**2
        poor = 0 if well else poor + 1
        if tried.error < pair.error:
            pair, shapes, damping = tried, its_shapes, damping / 4.0
        else:
            damping *= 4.0
        if poor == _POOR_STEPS:
            break
    return pair


def _step(ways: Array, pair: Pair, shapes: Array, light: Array, damping: float) -> Array:
    """(6,) the change that the squares of what is left ask for."""
    left = (light - shapes @ pair.colors).reshape(-1, 1)
    beside = np.concatenate([_slopes(ways, pair, shapes), left], axis=1)
    products = beside.T @ beside
    normal, wanted = products[:6, :6], products[:6, 6]
    normal += damping * np.diag(np.diag(normal) + 1e-12 * (np.trace(normal) + 1e-30))
    # What would leave its side of the horizon stays on it while the rest moves.
    held = np.zeros(6, dtype=bool)
    held[_LIFTS] = (pair.axes[:, 2] == 0.0) & (wanted[_LIFTS] * _SIDES < 0.0)
    normal[held], normal[:, held], wanted[held] = 0.0, 0.0, 0.0
    normal[held, held] = 1.0
    return np.asarray(np.clip(np.linalg.solve(normal, wanted), -_MAX_CHANGE, _MAX_CHANGE))


def _colors(shapes: Array, light: Array) -> Array:
    """(2, 3) the best within a factor of those that the light has where the lobes lie.

    Args:
        shapes: (N, 2) of the colour 1.
        light: (N, 3).
    """
    gram, target = shapes.T @ shapes, shapes.T @ light
    tints = target / np.maximum(np.linalg.norm(target, axis=1, keepdims=True), 1e-300)
    alike, wanted = _steady(gram * (tints @ tints.T)), (tints * target).sum(axis=1, keepdims=True)
    # With another beside it a lobe is not brighter than alone.
    amounts = _within(alike, wanted, np.zeros((2, 1)), wanted / np.diag(alike)[:, None])
    middle = amounts * tints
    return _within(gram, target, middle / _COLOR_FACTOR, middle * _COLOR_FACTOR)


def _within(gram: Array, target: Array, low: Array, high: Array) -> Array:
    """(2, C) that makes x . gram x - 2 x . target least within bounds, column by column.

    Where that lies outside of the bounds, the best is on an edge.
    """
    gram = _steady(gram)
    tried = [np.clip(np.linalg.solve(gram, target), low, high)]
    for held, free in ((0, 1), (1, 0)):
        for bound in (low, high):
            edge = bound.copy()
            best = (target[free] - gram[0, 1] * bound[held]) / gram[free, free]
            edge[free] = np.clip(best, low[free], high[free])
            tried.append(edge)
    costs = [(each * (gram @ each - 2.0 * target)).sum(axis=0) for each in tried]
    chosen = np.argmin(costs, axis=0)
    return np.asarray(np.stack(tried)[chosen, :, np.arange(target.shape[1])].T)


def _steady(gram: Array) -> Array:
    """Of two lobes; solvable even if they are the same, or one is nowhere."""
    return np.asarray(gram + (1e-9 * np.trace(gram) + 1e-300) * np.eye(2))


def _slopes(ways: Array, pair: Pair, shapes: Array) -> Array:
    """(3 N, 6) of the sum: around and up of each axis, then both sharpnesses; colours follow."""
    turns = np.stack([_turns(axis) for axis in pair.axes])
    logarithms = np.concatenate([ways @ turns.reshape(4, 3).T, ways @ pair.axes.T - 1.0], axis=1)
    of = np.array([0, 0, 1, 1, 0, 1])
    each = logarithms * (np.exp(pair.logs) * shapes)[:, of]
    flat = (each[:, None] * pair.colors.T[:, of]).reshape(len(ways), -1)
    flat = flat - shapes @ np.linalg.solve(_steady(shapes.T @ shapes), shapes.T @ flat)
    return np.asarray(flat.reshape(-1, 6))


def _moved(pair: Pair, change: Array) -> tuple[Array, Array]:
    """Axes and logarithms after a step; the sky stays above the horizon, the ground below."""
    turns = change[:4].reshape(2, 2, 1) * np.stack([_turns(axis) for axis in pair.axes])
    axes = pair.axes + turns.sum(axis=1)
    axes[:, 2] = _SIDES * np.maximum(_SIDES * axes[:, 2], 0.0)
    logs = np.clip(pair.logs + change[4:], -_MAX_LOGARITHM, _MAX_LOGARITHM)
    return axes / np.linalg.norm(axes, axis=1, keepdims=True), logs


def _turns(axis: Array) -> Array:
    """(2, 3) unit vectors around the vertical, and upwards."""
    around = np.array([-axis[1], axis[0], 0.0])
    length = np.linalg.norm(around)
    around = around / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    return np.stack([around, np.cross(axis, around)])
