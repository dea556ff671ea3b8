"""Sun and sky of a moment as what lights the land: irradiance of any face, radiance of any way."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from openrooms_usd.library.surroundings.environments import directions
from openrooms_usd.library.surroundings.outside.noise import Floats, fractal_tile, sampled, step
from openrooms_usd.library.surroundings.sky import (
    Air,
    clear_sky,
    overcast_sky,
    solid_angles,
    sun_direction,
    sun_disk,
)
from openrooms_usd.library.surroundings.sunlight import SUN_RADIUS, SunPosition, direct_normal

# Rows of the sky as the model gives it, and of what lights faces.
_SKY_ROWS, _LIGHT_ROWS = 360, 60
_BLOCK_ROWS: Final = 8
LAND_SHARE: Final = 0.7
"""Of the light on level ground, what the land sends back upwards: part of it lies in shadow."""


@dataclass(frozen=True, eq=False)
class Daylight:
    """The light of a moment.

    Attributes:
        sky: (H, 4 H, 3) nits above the horizon, clouds included, without the sun.
        disk: (H, 4 H, 3) nits of the sun, on the same pixels.
        sun: (3,) unit vector towards it.
        beam: (3,) lux of each primary on what faces it; 0 under clouds and below the horizon.
        ground: (3,) reflectance of the land.
    """

    sky: Floats
    disk: Floats
    sun: Floats
    beam: Floats
    ground: Floats

    @cached_property
    def level(self) -> Floats:
        """(3,) lux of each primary on level ground under the open sky."""
        direct = self.beam * max(0.0, float(self.sun[2]))
        return np.asarray(self._gathered(np.array([0.0, 0.0, 1.0])) + direct, dtype=np.float32)

    @cached_property
    def land(self) -> Floats:
        """(3,) nits of the land, on the whole."""
        return np.asarray(self.ground * self.level * LAND_SHARE / math.pi, dtype=np.float32)

    @cached_property
    def haze(self) -> Floats:
        """(3,) nits of the air before things that are very far."""
        rows = max(1, len(self.sky) // 30)
        return np.asarray(np.median(self.sky[-rows:], axis=(0, 1)), dtype=np.float32)

    def ambient(self, normal: Floats) -> Floats:
        """(3,) lux of each primary from sky and land on a face, without the sun."""
        below = 0.5 * (1.0 - float(normal[2])) * math.pi * self.land
        return np.asarray(self._gathered(normal) + below, dtype=np.float32)

    def seen(self, x: Floats, y: Floats, z: Floats) -> Floats:
        """(..., 3) nits of sky or land along horizontal ways (x, y) of length 1 that rise by z."""
        rows, columns = self._coarse.shape[:2]
        column = (0.5 - np.arctan2(x, -y) / (2.0 * np.pi)) * columns
        row = (0.5 - np.arctan(z) / np.pi) * 2.0 * rows
        column, row = np.broadcast_arrays(column, row)
        found = self._coarse[
            np.clip(row.astype(np.int32), 0, rows - 1), column.astype(np.int32) % columns
        ]
        return np.where((row < rows)[..., None], found, self.land)

    @cached_property
    def _coarse(self) -> Floats:
        k = max(1, len(self.sky) // _LIGHT_ROWS)
        height, width = len(self.sky) // k, self.sky.shape[1] // k
        cut = self.sky[: height * k, : width * k]
        return np.asarray(cut.reshape(height, k, width, k, 3).mean(axis=(1, 3)))

    def _gathered(self, normal: Floats) -> Floats:
        weights = np.clip(self._ways @ normal, 0.0, None)
        return np.asarray(np.einsum("hw,hwc->c", weights, self._coarse))

    @cached_property
    def _ways(self) -> Floats:
        """(H, W, 3) unit vectors to the coarse pixels, times their solid angles."""
        half = len(self._coarse)
        angles = solid_angles(2 * half)[:half, None, None]
        return np.asarray(directions(2 * half, slice(half)) * angles, dtype=np.float32)


def daylight_of(
    rng: np.random.Generator,
    position: SunPosition,
    air: Air,
    *,
    north: float,
    clouds: float,
    height: int,
) -> Daylight:
    """The light of a moment, with clouds.

    Args:
        rng: Draws the clouds.
        position: Where the sun stands.
        air: The weather and the ground.
        north: Degrees from +Y to north, counter-clockwise seen from above.
        clouds: The part of the sky that they cover, 0 to 1; nothing under a closed cover.
        height: Rows of the whole panorama, a multiple of four.
    """
    sun, ground = sun_direction(position, north), np.array(air.ground)
    rows = min(_SKY_ROWS, height)
    way = directions(rows)
    if air.overcast:
        sky, beam = overcast_sky(way, position.elevation), np.zeros(3)
    else:
        sky = clear_sky(way, sun, position.elevation, air.turbidity, ground)
        beam = direct_normal(position.apparent, air.turbidity, position.distance)
        beam *= float(sun[2] > 0.0)
    disk = sun_disk(height, sun, SUN_RADIUS / position.distance)[: height // 2, :, None] * beam
    seen = _enlarged(sky[: rows // 2].astype(np.float32), height // 4, height)
    if clouds and not air.overcast:
        half = directions(height // 2, slice(height // 4)).astype(np.float32)
        seen = clouded(rng, half, seen, sun, beam, clouds)
    seen = _enlarged(seen, height // 2, 2 * height)
    return Daylight(*(np.asarray(row, dtype=np.float32) for row in (seen, disk, sun, beam, ground)))


def _enlarged(pixels: Floats, height: int, width: int) -> Floats:
    """(height, width, 3) pixels between the nearest ones; columns go around, rows end."""
    rows = (np.arange(height, dtype=np.float32) + 0.5) / height * len(pixels) - 0.5
    columns = (np.arange(width, dtype=np.float32) + 0.5) / width * pixels.shape[1] - 0.5
    top, left = np.floor(rows).astype(np.int32), np.floor(columns).astype(np.int32)
    down, across = (rows - top)[:, None, None], (columns - left)[None, :, None]
    last = len(pixels) - 1
    first, second = left % pixels.shape[1], (left + 1) % pixels.shape[1]
    wide = np.empty((height, width, 3), dtype=np.float32)
    # So few rows at once as processors keep near them.
    for start in range(0, height, _BLOCK_ROWS):
        block = slice(start, start + _BLOCK_ROWS)
        upper, lower = (pixels[np.clip(top[block] + k, 0, last)] for k in (0, 1))
        tall = upper * (1.0 - down[block]) + lower * down[block]
        wide[block] = tall.take(first, axis=1) * (1.0 - across) + tall.take(second, axis=1) * across
    return wide


# What of the light that falls on it a thick cloud sends to all sides.
_ALBEDO: Final = 0.75
# Tiles of noise for one height of the clouds above the eye; and how far the shade reaches.
_HEAP_SCALE, _VEIL_SCALE, _SHADE_REACH = 0.11, 0.06, 0.018
# Around the sun the sky stays clear, radians.
_CLEAR_ABOUT_SUN: Final = (0.12, 0.3)


def clouded(
    rng: np.random.Generator, way: Floats, sky: Floats, sun: Floats, beam: Floats, cover: float
) -> Floats:
    """(H, W, 3) nits of a sky with clouds before it.

    Args:
        rng: Draws them.
        way: (H, W, 3) unit vectors above the horizon.
        sky: (H, W, 3) nits without clouds.
        sun: (3,) unit vector towards the sun.
        beam: (3,) lux of each primary on what faces the sun.
        cover: The part of the sky behind heaps, 0 to 1.
    """
    if cover <= 0.0:
        return sky
    heap, veil = fractal_tile(rng, 1.75, 3), fractal_tile(rng, 1.6, 4)
    up = way[..., 2] + 0.07
    plan_x, plan_y = way[..., 0] / up, way[..., 1] / up
    away = np.arccos(np.clip(way @ sun, -1.0, 1.0))
    clear = step(*_CLEAR_ABOUT_SUN, away) * step(0.01, 0.1, way[..., 2])
    glare = 1.0 + 1.6 * np.exp(-((away / 0.6) ** 2))
    ambient = sky.mean(axis=(0, 1)) * 0.9
    light = np.asarray(beam * _ALBEDO / np.pi, dtype=np.float32)

    # Veils: long threads, thin everywhere.
    thread = sampled(veil, plan_x * _VEIL_SCALE, plan_y * _VEIL_SCALE * 0.3)
    thin = (0.3 * min(1.0, 2.0 * cover) * step(0.2, 2.2, thread) * clear)[..., None]
    found = sky * (1.0 - thin) + thin * (0.55 * light * glare[..., None] + ambient)

    edge = float(np.quantile(heap, 1.0 - cover))
    u, v = plan_x * _HEAP_SCALE, plan_y * _HEAP_SCALE
    thick = step(edge, edge + 1.1, sampled(heap, u, v)) * clear
    flat = np.asarray(sun[:2] / max(float(sun[2]), 0.35) * _SHADE_REACH, dtype=np.float32)
    before = step(edge, edge + 1.3, sampled(heap, u + flat[0], v + flat[1]))
    lit = np.exp(-1.5 * before) * (1.0 - 0.35 * thick) * glare
    color = light * lit[..., None] + ambient * (1.25 - 0.6 * thick[..., None])
    hidden = (1.0 - np.exp(-5.0 * thick))[..., None]
    return np.asarray(found * (1.0 - hidden) + color * hidden, dtype=np.float32)
