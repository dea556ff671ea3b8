"""Daylight as a panorama in nits: sky, sun and ground at a place and a moment."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.library.environments import directions, horizontal_illuminance
from openrooms_usd.library.skylight import clear_sky, overcast_sky
from openrooms_usd.library.solar import SunPosition
from openrooms_usd.library.sunlight import SUN_RADIUS, direct_normal

Array = NDArray[np.float64]
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
) -> NDArray[np.float32]:
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
