"""Daylight as a panorama in nits: sky, sun and ground at a place and a moment."""

import math
from dataclasses import dataclass
from functools import cache
from math import comb
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.colorimetry import luminance
from openrooms_usd.library.surroundings.environments import directions, horizontal_illuminance
from openrooms_usd.library.surroundings.sunlight import (
    SUN_RADIUS,
    SunPosition,
    clear_illuminance,
    direct_normal,
    overcast_illuminance,
)

_COEFFICIENTS: Final = Path(__file__).with_name("hosek_wilkie.npy")
_LUMENS_PER_WATT: Final = 683.0
# Below this the model is brighter than measured skies, three times at the horizon: from here down
# its brightness goes over to that of the published curve.
_LOW_SUN_DEG: Final = 10.0
# The glow of dusk gives way to a dark sky between these elevations.
_DUSK_LIMITS_DEG: Final = (-6.0, -18.0)
# The blue of dusk, when ozone takes the orange out of light that has come through much of it (E. O.
# Hulburt, Explanation of the Brightness and Color of the Sky, 1953): its hue, about 20,000 K and of
# luminance 1; the sun's elevation at which it is full; how far up the glow of the sunset reaches,
# as a sine.
_DUSK_HUE: Final = np.array([0.62, 0.98, 2.31])
_BLUE_HOUR_DEG: Final = -4.0
_GLOW_HEIGHT: Final = 0.12


def clear_sky(way: Array, sun: Array, elevation: float, turbidity: float, albedo: Array) -> Array:
    """(H, W, 3) nits of a cloudless sky; 0 below the horizon.

    Args:
        way: (H, W, 3) unit vectors of `directions`.
        sun: (3,) unit vector to the sun as it is seen, perhaps below the horizon.
        elevation: Degrees of the sun, without refraction.
        turbidity: 1 to 10.
        albedo: (3,) reflectance of the ground, which lights the air from below.
    """
    bearing = np.array([sun[0], sun[1], max(float(sun[2]), 0.0)])
    sky = hosek_wilkie(way, bearing / np.linalg.norm(bearing), turbidity, albedo)
    if elevation >= _LOW_SUN_DEG:
        return sky
    given = horizontal_illuminance(sky)
    wanted = clear_illuminance(elevation)
    nearness = min(1.0, (_LOW_SUN_DEG - elevation) / _LOW_SUN_DEG)
    sky *= (wanted / given) ** nearness
    night = float(
        np.clip(
            (_DUSK_LIMITS_DEG[0] - elevation) / (_DUSK_LIMITS_DEG[0] - _DUSK_LIMITS_DEG[1]),
            0.0,
            1.0,
        )
    )
    return (1.0 - night) * _at_dusk(sky, way, bearing, elevation) + night * _even(way, wanted)


def _at_dusk(sky: Array, way: Array, sun: Array, elevation: float) -> Array:
    """The sky in the blue of dusk but for the glow above the sun; its luminance stays."""
    share = float(np.clip(elevation / _BLUE_HOUR_DEG, 0.0, 1.0))
    if share == 0.0:
        return sky
    flat = np.maximum(np.linalg.norm(way[..., :2], axis=-1), 1e-9)
    facing = 0.5 * (1.0 + way[..., :2] @ (sun[:2] / max(float(np.hypot(*sun[:2])), 1e-9)) / flat)
    glow = facing * np.exp(-np.clip(way[..., 2], 0.0, None) / _GLOW_HEIGHT)
    blue = (share * (1.0 - glow))[..., None]
    return np.asarray((1.0 - blue) * sky + blue * luminance(sky)[..., None] * _DUSK_HUE)


def overcast_sky(way: Array, elevation: float) -> Array:
    """(H, W, 3) nits of the CIE overcast sky, grey; 0 below the horizon.

    Its zenith is three times as bright as its horizon (Moon and Spencer 1942; ISO 15469).

    Args:
        way: (H, W, 3) unit vectors of `directions`.
        elevation: Degrees of the sun, without refraction.
    """
    up = way[..., 2]
    shape = np.where(up > 0.0, 1.0 + 2.0 * up, 0.0)[..., None] * np.ones(3)
    return np.asarray(shape * (overcast_illuminance(elevation) / horizontal_illuminance(shape)))


def hosek_wilkie(way: Array, sun: Array, turbidity: float, albedo: Array) -> Array:
    """(H, W, 3) nits of the model itself; 0 below the horizon.

    Args:
        way: (H, W, 3) unit vectors.
        sun: (3,) unit vector, not below the horizon.
        turbidity: 1 to 10.
        albedo: (3,) reflectance of the ground, 0 to 1.
    """
    A, B, C, D, E, F, G, H, I, mean = _parameters(sun, turbidity, albedo)  # noqa: E741
    above = way[..., 2] > 0.0
    up = way[above][:, 2:]
    cosine = np.clip(way[above] @ sun, -1.0, 1.0)[:, None]
    halo = (1.0 + cosine**2) / (1.0 + I**2 - 2.0 * I * cosine) ** 1.5
    around = C + D * np.exp(E * np.arccos(cosine)) + F * cosine**2 + G * halo + H * np.sqrt(up)
    sky = np.zeros(way.shape)
    sky[above] = (
        np.maximum((1.0 + A * np.exp(B / (up + 0.01))) * around * mean, 0.0) * _LUMENS_PER_WATT
    )
    return sky


def _parameters(sun: Array, turbidity: float, albedo: Array) -> Array:
    """(10, 3) A to I and the mean radiance: quintic in the sun's height, linear in the others."""
    height = np.arcsin(np.clip(sun[2], 0.0, 1.0)) / (0.5 * np.pi)
    x = float(np.cbrt(height))
    bernstein = np.array([comb(5, i) * (1.0 - x) ** (5 - i) * x**i for i in range(6)])
    by_turbidity = np.einsum("tackp,c->takp", _coefficients(), bernstein)
    index = min(int(turbidity), 9)
    share = turbidity - index
    by_albedo = (1.0 - share) * by_turbidity[index - 1] + share * by_turbidity[index]
    weight = albedo[:, None]
    return np.asarray(((1.0 - weight) * by_albedo[0] + weight * by_albedo[1]).T)


@cache
def _coefficients() -> Array:
    """(10, 2, 6, 3, 10): turbidity, albedo, control point, primary, parameter."""
    return np.asarray(np.load(_COEFFICIENTS, allow_pickle=False), dtype=np.float64)


def _even(way: Array, illuminance: float) -> Array:
    """(H, W, 3) nits of the same grey from everywhere above."""
    shape = np.where(way[..., 2:] > 0.0, np.ones(3), 0.0)
    return np.asarray(shape * (illuminance / horizontal_illuminance(shape)))


Color = tuple[float, float, float]

# Rows: a quarter of a degree each, so that the sun is two pixels wide.
HEIGHT: Final = 720
# Significant bits that are kept: files become small, and machines whose last bits differ agree.
_SKY_BITS: Final = 10
_SUN_BITS: Final = 18


@dataclass(frozen=True)
class Air:
    """What lies between the sun and the room.

    Attributes:
        turbidity: Haze: 1 clean air, 2 very clear, 3 clear, 6 hazy, 10 thick haze.
        ground: Reflectance of the land outside, scene-linear Rec.709.
        overcast: Whether clouds cover the whole sky.
    """

    turbidity: float = 3.0
    ground: Color = (0.2, 0.2, 0.2)
    overcast: bool = False


def daylight(
    position: SunPosition, air: Air, *, north: float = 0.0, height: int = HEIGHT
) -> Floats:
    """Make the panorama of a moment.

    Args:
        position: Where the sun stands.
        air: The weather and the ground.
        north: Degrees from +Y to north, counter-clockwise seen from above.
        height: Rows, an even number; there are twice as many columns.

    Returns:
        (H, 2 H, 3) nits, scene-linear Rec.709, laid out as `directions`.
    """
    way = directions(height)
    sun = sun_direction(position, north)
    albedo = np.array(air.ground)
    if air.overcast:
        sky, disk = overcast_sky(way, position.elevation), np.zeros_like(way)
    else:
        sky = clear_sky(way, sun, position.elevation, air.turbidity, albedo)
        beam = direct_normal(position.apparent, air.turbidity, position.distance)
        disk = sun_disk(height, sun, SUN_RADIUS / position.distance)[..., None] * beam
    sky, disk = rounded(sky, _SKY_BITS), rounded(disk, _SUN_BITS)
    lit = np.array([_irradiance(sky + disk, primary) for primary in range(3)])
    below = way[..., 2] < 0.0
    ground = rounded(albedo * lit / math.pi, _SKY_BITS)
    return np.asarray(np.where(below[..., None], ground, sky + disk), dtype=np.float32)


def sun_direction(position: SunPosition, north: float) -> Array:
    """(3,) unit vector in the room's frame to the sun as it is seen.

    Args:
        position: Where the sun stands.
        north: Degrees from +Y to north, counter-clockwise seen from above.
    """
    elevation = math.radians(position.apparent)
    # Azimuths run clockwise from north, angles of the room counter-clockwise from +X.
    angle = math.radians(90.0 + north - position.azimuth)
    flat = math.cos(elevation)
    return np.array([flat * math.cos(angle), flat * math.sin(angle), math.sin(elevation)])


def sun_disk(height: int, sun: Array, radius: float) -> Array:
    """(H, 2 H) radiance of a disk that gives an illuminance of 1 to what faces it.

    Pixels at its edge have a part of it. The sum over pixels of radiance times solid angle is 1
    whatever the resolution and wherever it stands; what lies below the horizon is then cut off.

    Args:
        height: Rows, an even number.
        sun: (3,) unit vector to its middle.
        radius: Degrees; a disk that is smaller than a pixel becomes as wide as one.
    """
    texel = math.pi / height
    reach = max(math.radians(radius), texel / 2.0)
    middle = (0.5 - math.asin(float(sun[2])) / math.pi) * height
    half = reach / texel + 2.0
    rows = slice(max(0, math.floor(middle - half)), min(height, math.ceil(middle + half)))
    away = 2.0 * np.arcsin(np.linalg.norm(directions(height, rows) - sun, axis=-1) / 2.0)
    disk = np.zeros((height, 2 * height))
    disk[rows] = np.clip((reach - away) / texel + 0.5, 0.0, 1.0)
    disk /= float(solid_angles(height) @ disk.sum(axis=1))
    disk[height // 2 :] = 0.0
    return np.asarray(disk)


def solid_angles(height: int) -> Array:
    """(H,) steradians of a pixel in each row."""
    edges = np.sin(math.pi * (0.5 - np.arange(height + 1) / height))
    return np.asarray((edges[:-1] - edges[1:]) * math.pi / height)


def rounded(values: Array, bits: int) -> Array:
    """Values to so many significant bits."""
    mantissa, exponent = np.frexp(values)
    return np.asarray(np.ldexp(np.rint(np.ldexp(mantissa, bits)), exponent - bits))


def _irradiance(pixels: Array, primary: int) -> float:
    """Horizontal irradiance of one primary."""
    grey = np.repeat(pixels[..., primary : primary + 1], 3, axis=-1)
    return horizontal_illuminance(grey)
