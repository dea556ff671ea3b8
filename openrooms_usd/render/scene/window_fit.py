"""Three spherical Gaussians for the surroundings that an opening sees: sun, sky and ground.

The sun is taken by its moments: its direction and flux are kept, and its spread about the
direction. Sky and ground are fitted to what is left (`window_lobes`).
"""

from typing import Final

import numpy as np

from openrooms_usd.colorimetry import luminance
from openrooms_usd.render.scene.arrays import Sun
from openrooms_usd.render.scene.lights import Gaussian
from openrooms_usd.render.scene.pictures import Array
from openrooms_usd.render.scene.surroundings import Surroundings, cells_of, sums_by
from openrooms_usd.render.scene.window_lobes import Lit, fitted
from openrooms_usd.usd.portals import Portal

# The fit looks at pictures with this many rows.
_FITTED_ROWS: Final = 32
# Around the brightest pixel light counts as the sun's within this angle, radians, where it is this
# much brighter than the median of what the opening sees.
_SUN_RADIANS: Final = np.radians(6.0)
_SUN_PER_MEDIAN: Final = 8.0
# No lobe is sharper: half of it within 0.1 degrees.
_MOST_SHARPNESS: Final = 5e5


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
    pair = fitted(_binned(ways, weights, rest))
    rows = zip(("sky", "ground"), pair.colors, pair.axes, pair.logs, strict=True)
    lobes = (Gaussian(name, color, axis, float(np.exp(log))) for name, color, axis, log in rows)
    return (*beams, *lobes), pair.error


def _binned(ways: Array, weights: Array, light: Array) -> Lit:
    """The same light in fewer pixels: means over cells of a coarse panorama."""
    cells = cells_of(ways, _FITTED_ROWS)
    solid = np.bincount(cells, weights).astype(np.float64)
    used = solid > 0.0
    middles: Array = sums_by(cells, weights, ways)[used]
    lengths = np.linalg.norm(middles, axis=1, keepdims=True)
    means = sums_by(cells, weights, light)[used] / solid[used, None]
    return Lit(middles / lengths, solid[used], means)


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
