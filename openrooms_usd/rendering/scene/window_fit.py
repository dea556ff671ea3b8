"""Three spherical Gaussians for the surroundings that an opening sees: sun, sky and ground.

A sun is taken by its moments: its direction and flux are kept, and its spread about the direction.
Sky and ground are fitted to what is left (`window_lobes`). Where no sun shines in, all three lobes
are fitted, and the sharper of the upper two has the sun's name.

Errors count by how much of each direction comes in: by the cosine to the opening.
"""

from typing import Final

import numpy as np

from openrooms_usd.colorimetry import luminance
from openrooms_usd.rendering.scene.arrays import Sun
from openrooms_usd.rendering.scene.lights import Gaussian
from openrooms_usd.rendering.scene.pictures import Array
from openrooms_usd.rendering.scene.surroundings import Surroundings, cells_of, sums_by
from openrooms_usd.rendering.scene.window_lobes import Lit, fitted
from openrooms_usd.usd.light.lights import Portal

# The fit looks at pictures with this many rows.
_FITTED_ROWS: Final = 32
# Around the brightest pixel light counts as the sun's within this angle, radians, where it is this
# much brighter than the median of what the opening sees.
_SUN_RADIANS: Final = np.radians(6.0)
_SUN_PER_MEDIAN: Final = 8.0
# A sun that brings less than this of the light that comes in has no lobe by itself.
_SUN_SHARE: Final = 0.05
# No lobe is sharper: half of it within 0.1 degrees.
_MOST_SHARPNESS: Final = 5e5


def fit(sky: Surroundings, portal: Portal) -> tuple[tuple[Gaussian, ...], float]:
    """Sun, sky and ground as an opening sees them.

    Returns:
        The Gaussians, and the root of the mean squared error of their sum over the directions that
        come in, weighted by their cosine, relative to that of the surroundings; both in cells of
        5.6 degrees, and without a sun that has a lobe by itself: one that is as small as the sun is
        right by its flux, not pixel by pixel.
    """
    outwards = portal.world_from_portal[:3, 2]
    outside = sky.directions @ outwards > 0.0
    ways = sky.directions[outside]
    weights = sky.weights[outside] * (ways @ outwards)
    light = np.maximum(sky.radiance[outside], 0.0)
    beams, rest = _sun(ways, sky.weights[outside], light, sky.suns, outwards)
    if not rest.any():
        return beams, 0.0
    found = fitted(_binned(ways, weights, rest), 2 if beams else 3)
    lobes = zip(found.colors, found.axes, np.exp(found.logs).tolist(), strict=True)
    return (*beams, *_named([*lobes])), found.error


def _named(lobes: list[tuple[Array, Array, float]]) -> tuple[Gaussian, ...]:
    """The lowest is the ground; of two others the sharper is the sun."""
    ground, *upper = sorted(lobes, key=lambda lobe: lobe[1][2])
    upper.sort(key=lambda lobe: -lobe[2])
    names = ("sun", "sky", "ground")[-len(lobes) :]
    return tuple(Gaussian(name, *lobe) for name, lobe in zip(names, [*upper, ground], strict=True))


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
    cosine = ways @ outwards
    if share @ cosine[ring] < _SUN_SHARE * (weights * cosine @ bright):
        return (), light
    mean = share @ ways[ring] / share.sum()
    length = float(np.linalg.norm(mean))
    # For a sharp lobe the mean of the cosine about its axis is 1 - 1 / sharpness.
    sharpness = min(_MOST_SHARPNESS, 1.0 / max(1.0 - length, 1e-12))
    rest = light.copy()
    rest[ring] = np.minimum(light[ring], around)
    return (_lobe("sun", mean / length, flux, sharpness),), rest


def _lobe(name: str, axis: Array, flux: Array, sharpness: float) -> Gaussian:
    """A lobe that brings a flux, lux on a surface that faces it if it is sharp."""
    return Gaussian(name, np.asarray(flux / _solid(sharpness)), np.asarray(axis), sharpness)


def _solid(sharpness: float) -> float:
    return float(2.0 * np.pi * -np.expm1(-2.0 * sharpness) / sharpness)
