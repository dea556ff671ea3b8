"""The world outside as one panorama in nits: sky and sun, hills, land, houses and plants."""

import math
from typing import Final

import numpy as np

from openrooms_usd.colorimetry import luminance
from openrooms_usd.draws import generator
from openrooms_usd.library.surroundings.outside.canvas import Canvas
from openrooms_usd.library.surroundings.outside.daylight import Daylight, daylight_of
from openrooms_usd.library.surroundings.outside.faces import World
from openrooms_usd.library.surroundings.outside.houses import House
from openrooms_usd.library.surroundings.outside.land import OWN_HALF_M, ground, hills
from openrooms_usd.library.surroundings.outside.noise import Floats
from openrooms_usd.library.surroundings.outside.scenes import Scene
from openrooms_usd.library.surroundings.outside.shadows import Shadows
from openrooms_usd.library.surroundings.outside.site import Site
from openrooms_usd.library.surroundings.sky import Air
from openrooms_usd.library.surroundings.sunlight import SunPosition

# Rows: an eighth of a degree each, for windows that are looked at from some metres.
HEIGHT: Final = 1440
# Elevations between which things stand, degrees.
_BAND_DEG: Final = (-62.0, 62.0)
# Significant bits that are kept: of the land and the sky, and of the sun.
_BITS, _SUN_BITS = 8, 18
_MANTISSA_BITS: Final = 24


def outside_panorama(
    position: SunPosition,
    air: Air,
    site: Site,
    *,
    clouds: float = 0.0,
    north: float = 0.0,
    illuminance: float | None = None,
    height: int = HEIGHT,
) -> Floats:
    """Make the panorama of a place and a moment.

    Args:
        position: Where the sun stands.
        air: The weather, and the ground as it lights the sky.
        site: What stands there; what is near is left out.
        clouds: The part of the sky that they cover, 0 to 1.
        north: Degrees from +Y to north, counter-clockwise seen from above.
        illuminance: Horizontal, under the open sky, lux; by default what the moment gives.
        height: Rows, a multiple of four; there are twice as many columns.

    Returns:
        (H, 2 H, 3) nits, scene-linear Rec.709, laid out as `directions`.
    """
    # The scene looks along +Y; all is drawn in its frame, and turned at the end.
    columns, seed = site.turn(height), site.seed
    turn = columns * 180.0 / height
    day = daylight_of(
        generator(seed, "outside", "clouds"),
        position,
        air,
        north=north - turn,
        clouds=clouds,
        height=height,
    )
    whole, made = site.far(height)
    surfaces = site.surfaces()
    world = World(day, _shadows(day, whole), site.eye)
    land = ground(world, made.zones, surfaces, height)
    panorama = np.concatenate([day.sky + day.disk, land])
    canvas = Canvas(height, *(math.radians(edge) for edge in _BAND_DEG))
    for thing in sorted(made.things, key=lambda thing: thing.distance):
        if isinstance(thing, House):
            thing.draw(canvas, world, surfaces)
        else:
            thing.draw(canvas, world)
    hills(canvas, world, made.ridges, surfaces, generator(seed, "outside", "hills"))
    canvas.over(panorama)
    if illuminance is not None:
        panorama *= illuminance / float(luminance(day.level))
    return np.roll(_stored(panorama, day), -columns, axis=1)


def _shadows(day: Daylight, scene: Scene) -> Shadows:
    shadows = Shadows()
    own = (np.abs(shadows.x) < OWN_HALF_M) & (np.abs(shadows.y) < OWN_HALF_M)
    shadows.stand((scene.own * own).astype(np.float32))
    for thing in scene.things:
        thing.stand(shadows)
    shadows.cast(day.sun)
    return shadows


def _stored(panorama: Floats, day: Daylight) -> Floats:
    """Values as they are kept: what machines' last bits differ in is cut off."""
    kept = _rounded(panorama, _BITS)
    high = np.flatnonzero(day.disk.reshape(len(day.disk), -1).any(axis=1))
    rows, columns = np.nonzero(day.disk[high].any(axis=-1))
    rows = high[rows]
    kept[rows, columns] = _rounded(panorama[rows, columns], _SUN_BITS)
    return kept


def _rounded(values: Floats, bits: int) -> Floats:
    """Values to so many significant bits, none below 0."""
    cut = _MANTISSA_BITS - bits
    words = np.maximum(values, np.float32(0.0)).view(np.uint32)
    words += np.uint32(1 << (cut - 1))
    words &= np.uint32(0xFFFFFFFF << cut & 0xFFFFFFFF)
    return np.asarray(words.view(np.float32))
