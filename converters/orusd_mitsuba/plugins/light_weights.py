"""How often each light is sampled: by the flux that it can bring, with a share for every light.

Mitsuba takes lights evenly by default. In a room by day that spends most samples on lamps that add
little. The mixture with an even share (a defensive mixture, Hesterberg 1995) bounds what a light
that is close by can lose.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.colorimetry import luminance
from openrooms_usd.rendering.scene.arrays import Environment, Patch, Scene
from openrooms_usd.rendering.scene.pictures import Picture

# The part of the samples that is spread evenly over all lights.
_SHARE_FOR_EVERY_LIGHT: Final = 0.25
# How far around the brightest pixel light counts as one beam, radians.
_BEAM_RADIANS: Final = np.radians(1.0)


@dataclass(frozen=True)
class LightWeights:
    """How often lights are sampled, relative to each other.

    Attributes:
        sky: The surroundings.
        patches: Each emitting patch, by its name.
        suns: Each parallel light, in turn.
    """

    sky: float
    patches: dict[str, float]
    suns: tuple[float, ...]


@dataclass(frozen=True)
class Beam:
    """The brightest place of the surroundings, such as the sun.

    Attributes:
        direction: (3,) unit vector to it, in the world.
        share: The part of all light around that comes from there.
    """

    direction: Array
    share: float


def brightest_beam(environment: Environment) -> Beam:
    """Find the brightest pixel and what comes from around it.

    Its rows go from pole to pole; directions are as in Mitsuba's ``envmap``, whose pole is Y and
    whose middle column looks along +Z.
    """
    light = luminance(environment.pixels)
    height, width = light.shape
    theta = np.linspace(0.0, np.pi, height)[:, None]
    phi = 2.0 * np.pi * (np.arange(width) + 0.5) / width
    row, column = np.unravel_index(int(light.argmax()), light.shape)
    y = np.cos(theta) * np.ones_like(phi)
    x, z = np.sin(theta) * np.sin(phi), -np.sin(theta) * np.cos(phi)
    way = np.stack([x, y, z], axis=-1)
    near = way @ way[row, column] > np.cos(_BEAM_RADIANS)
    flux = light * np.sin(theta)
    share = float(flux[near].sum() / flux.sum()) if flux.sum() > 0.0 else 0.0
    return Beam(environment.world_from_light @ way[row, column], share)


def light_weights(scene: Scene) -> LightWeights:
    """Weigh the lights of a translated stage.

    Without portals it is unknown how much of the surroundings comes in: they are then sampled as
    often as all other lights together.
    """
    lamps = {patch.name: flux_of(patch) for patch in scene.patches if patch.radiance is not None}
    inlet = sum(portal.width * portal.height for portal in scene.portals)
    suns = [inlet * float(luminance(sun.irradiance)) for sun in scene.suns]
    count = len(lamps) + len(suns)
    if scene.environment is None or not inlet:
        return LightWeights(float(max(1, count)), dict.fromkeys(lamps, 1.0), (1.0,) * len(suns))
    flux = np.array([inlet * _illuminance(scene.environment), *lamps.values(), *suns])
    total = float(flux.sum())
    share = flux / total if total > 0.0 else np.full(len(flux), 1.0 / len(flux))
    sky, *others = (
        (1.0 - _SHARE_FOR_EVERY_LIGHT) * share + _SHARE_FOR_EVERY_LIGHT / len(flux)
    ).tolist()
    by_name = dict(zip(lamps, others, strict=False))
    return LightWeights(sky, by_name, tuple(others[len(lamps) :]))


def flux_of(patch: Patch) -> float:
    """Lumen of a patch."""
    if patch.radiance is None:
        return 0.0
    radiance = patch.radiance
    a, b, c = np.moveaxis(patch.triangles.corners, 1, 0)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    held = radiance.pixels if isinstance(radiance, Picture) else np.array([[radiance]])
    pixels = held.astype(np.float64)
    return patch.flux_share() * float(np.pi * area * luminance(_three(pixels)).mean())


def _illuminance(environment: Environment) -> float:
    """Lux on a window that looks at the mean of the surroundings."""
    pixels = environment.pixels
    edges = np.cos(np.linspace(0.0, np.pi, len(pixels) + 1))
    rows = luminance(pixels).mean(axis=1) * (edges[:-1] - edges[1:]) / 2.0
    return float(np.pi * rows.sum())


def _three(pixels: Array) -> Array:
    return np.repeat(pixels, 3, axis=-1) if pixels.shape[-1] == 1 else pixels
