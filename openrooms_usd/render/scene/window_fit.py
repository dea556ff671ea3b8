"""Three spherical Gaussians for the surroundings that an opening sees: sun, sky and ground.

The sun is taken by its moments: its direction and flux are kept, and its spread about the
direction. Sky and ground are fitted to what is left by least squares (Levenberg 1944, Marquardt
1963) in axis and sharpness, with amplitudes that are linear and solved for on the way (variable
projection, Golub and Pereyra 1973).
"""

from typing import Final

import numpy as np

from openrooms_usd.colorimetry import luminance
from openrooms_usd.render.scene.arrays import Sun
from openrooms_usd.render.scene.lights import Gaussian
from openrooms_usd.render.scene.pictures import Array
from openrooms_usd.render.scene.surroundings import Surroundings, cells_of, sums_by
from openrooms_usd.usd.portals import Portal

# The fit looks at pictures with this many rows.
_FITTED_ROWS: Final = 32
# Around the brightest pixel light counts as the sun's within this angle, radians, where it is this
# much brighter than the median of what the opening sees.
_SUN_RADIANS: Final = np.radians(6.0)
_SUN_PER_MEDIAN: Final = 8.0
# No lobe is sharper: half of it within 0.1 degrees.
_MOST_SHARPNESS: Final = 5e5
_FIT_STEPS: Final = 30


def fit(sky: Surroundings, portal: Portal) -> tuple[tuple[Gaussian, ...], float]:
    """Sun, sky and ground as an opening sees them.

    Returns:
        The Gaussians, and the root of the mean squared error of their sum over the outward
        hemisphere, relative to that of the surroundings, both without the sun: a lobe that is as
        small as the sun is right by its flux, not pixel by pixel.
    """
    outside = sky.directions @ portal.world_from_portal[:3, 2] > 0.0
    ways, weights = sky.directions[outside], sky.weights[outside]
    light = np.maximum(sky.radiance[outside], 0.0)
    beams, rest = _sun(ways, weights, light, sky.suns, portal.world_from_portal[:3, 2])
    if not rest.any():
        return beams, 0.0
    lobes = _Lobes(*_binned(ways, weights, rest), portal.world_from_portal[:3, 2])
    return (*beams, *lobes.gaussians()), lobes.error()


def _binned(ways: Array, weights: Array, light: Array) -> tuple[Array, Array, Array]:
    """The same light in fewer pixels: means over cells of a coarse panorama."""
    cells = cells_of(ways, _FITTED_ROWS)
    solid = np.bincount(cells, weights).astype(np.float64)
    used = solid > 0.0
    middles: Array = sums_by(cells, weights, ways)[used]
    lengths = np.linalg.norm(middles, axis=1, keepdims=True)
    return middles / lengths, solid[used], sums_by(cells, weights, light)[used] / solid[used, None]


def _sun(
    ways: Array, weights: Array, light: Array, suns: tuple[Sun, ...], outwards: Array
) -> tuple[tuple[Gaussian, ...], Array]:
    """The brightest place as a lobe, if it stands out, and the light without it."""
    shining = [sun for sun in suns if -sun.direction @ outwards > 0.0]
    if shining:
        strongest = max(shining, key=lambda sun: float(luminance(sun.irradiance)))
        return (_lobe("sun", -strongest.direction, strongest.irradiance, _MOST_SHARPNESS),), light
    bright = luminance(light)
    if not bright.any():
        return (), light
    near = ways @ ways[int(bright.argmax())] > np.cos(_SUN_RADIANS)
    around = np.median(light[~near], axis=0) if (~near).any() else np.zeros(3)
    ring = near & (bright > _SUN_PER_MEDIAN * max(float(luminance(around)), 1e-12))
    if not ring.any():
        return (), light
    excess = np.maximum(light[ring] - around, 0.0) * weights[ring, None]
    flux, share = excess.sum(axis=0), luminance(excess)
    mean = share @ ways[ring] / share.sum()
    length = float(np.linalg.norm(mean))
    # For a sharp lobe the mean of the cosine about its axis is 1 - 1 / sharpness.
    sharpness = min(_MOST_SHARPNESS, 1.0 / max(1.0 - length, 1e-12))
    rest = light.copy()
    rest[ring] = np.minimum(light[ring], around)
    return (_lobe("sun", mean / length, flux, sharpness),), rest


def _lobe(name: str, axis: Array, flux: Array, sharpness: float) -> Gaussian:
    """A lobe that brings a flux, lux on a surface that faces it if it is sharp."""
    solid = 2.0 * np.pi * -np.expm1(-2.0 * sharpness) / sharpness
    return Gaussian(name, np.asarray(flux / solid), np.asarray(axis), sharpness)


class _Lobes:
    """The lobes of sky and ground, fitted to what an opening sees without the sun."""

    def __init__(self, ways: Array, weights: Array, light: Array, outwards: Array) -> None:
        self._ways, self._roots, self._light = ways, np.sqrt(weights)[:, None], light
        self._axes = np.stack(
            [_unit(outwards + np.array([0.0, 0.0, lift])) for lift in (1.0, -1.0)]
        )
        self._logs = np.zeros(2)
        self._fit()

    def gaussians(self) -> tuple[Gaussian, ...]:
        """Both lobes."""
        rows = zip(("sky", "ground"), self._amplitudes(), self._axes, self._logs, strict=True)
        return tuple(Gaussian(name, a, axis, float(np.exp(log))) for name, a, axis, log in rows)

    def error(self) -> float:
        """Root of the squared error relative to that of the light."""
        return float(np.linalg.norm(self._residual()) / np.linalg.norm(self._roots * self._light))

    def _shapes(self) -> Array:
        """(N, 2) the lobes at the directions, with the roots of their weights."""
        shapes = np.exp(np.exp(self._logs) * (self._ways @ self._axes.T - 1.0))
        return np.asarray(self._roots * shapes)

    def _amplitudes(self) -> Array:
        """(2, 3) the best that are not negative: of two lobes one or both."""
        shapes, light = self._shapes(), self._roots * self._light
        both = np.linalg.lstsq(shapes, light, rcond=None)[0]
        alone = np.maximum((shapes.T @ light) / (shapes**2).sum(axis=0)[:, None], 0.0)
        gains = alone * (shapes.T @ light)
        best = np.where(gains == gains.max(axis=0), alone, 0.0)
        return np.where((both >= 0.0).all(axis=0), both, best)

    def _residual(self) -> Array:
        return (self._shapes() @ self._amplitudes() - self._roots * self._light).ravel()

    def _fit(self) -> None:
        damping, cost = 1e-2, float(np.square(self._residual()).sum())
        for _ in range(_FIT_STEPS):
            before = self._axes, self._logs
            base, slopes = self._residual(), self._slopes()
            normal = slopes.T @ slopes
            ridge = damping * np.diag(np.diag(normal) + 1e-12 * (np.trace(normal) + 1e-30))
            self._move(np.clip(np.linalg.solve(normal + ridge, -slopes.T @ base), -0.5, 0.5))
            now = float(np.square(self._residual()).sum())
            if now < cost:
                damping, cost = damping / 4.0, now
            else:
                damping, (self._axes, self._logs) = damping * 4.0, before

    def _slopes(self) -> Array:
        """(3 N, 6) by differences: two turns of each axis, then both sharpnesses."""
        before, columns, step = (self._axes, self._logs), [], 1e-4
        for number in range(6):
            change = step * np.eye(6)[number]
            ends = []
            for sign in (1.0, -1.0):
                self._move(sign * change)
                ends.append(self._residual())
                self._axes, self._logs = before
            columns.append((ends[0] - ends[1]) / (2.0 * step))
        return np.column_stack(columns)

    def _move(self, change: Array) -> None:
        turned = []
        for axis, (a, b) in zip(self._axes, change[:4].reshape(2, 2), strict=True):
            across = _unit(np.cross(axis, [1.0, 0, 0] if abs(axis[0]) < 0.7 else [0, 1.0, 0]))
            turned.append(_unit(axis + a * across + b * np.cross(axis, across)))
        # The sky is not below the horizon, the ground is not above it.
        kept = [turned[0] * [1, 1, turned[0][2] > 0.0], turned[1] * [1, 1, turned[1][2] < 0.0]]
        self._axes = np.stack([_unit(axis) for axis in kept])
        self._logs = np.clip(self._logs + change[4:], -6.0, 6.0)


def _unit(vector: Array) -> Array:
    return np.asarray(vector / np.linalg.norm(vector))
