"""Level land to the horizon (lawns, roads, paving, fields) and hills behind it."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.library.surroundings.outside.canvas import Canvas
from openrooms_usd.library.surroundings.outside.facades import FacadeMaterials
from openrooms_usd.library.surroundings.outside.faces import World
from openrooms_usd.library.surroundings.outside.noise import Floats, nearest, sampled, step

# Reflectance of ground, and how much its patches (some metres) and its grain (some centimetres)
# differ from that.
_KINDS: Final = {
    "lawn": ((0.058, 0.088, 0.026), 0.16, 0.3),
    "meadow": ((0.078, 0.098, 0.036), 0.2, 0.22),
    "field": ((0.19, 0.155, 0.075), 0.12, 0.2),
    "asphalt": ((0.088, 0.088, 0.09), 0.08, 0.1),
    "paving": ((0.27, 0.255, 0.235), 0.08, 0.08),
    "gravel": ((0.25, 0.225, 0.19), 0.08, 0.25),
    "kerb": ((0.36, 0.35, 0.33), 0.05, 0.05),
    "line": ((0.55, 0.55, 0.53), 0.05, 0.1),
    "bed": ((0.05, 0.042, 0.03), 0.2, 0.4),
}
_SLAB_M: Final = 0.5
# So many rows are worked on at once as processors keep near them.
_BLOCK_ROWS: Final = 16
# The land beside the viewer's house is at least this far away, metres; and half its side.
OWN_HALF_M: Final = 4.0
# Where the land fades into haze, metres, and how far hills stand in it.
_HAZY_M: Final = 2500.0


@dataclass(frozen=True)
class Zone:
    """A rectangle of the land of one kind, in the frame of the scene.

    Attributes:
        kind: Of `_KINDS`.
        x: Its range, metres from the eye.
        y: The same.
    """

    kind: str
    x: tuple[float, float]
    y: tuple[float, float]


@dataclass(frozen=True)
class Ridge:
    """A line of hills around the horizon.

    Attributes:
        low: Elevation of its lowest top, radians.
        high: Of its highest.
        distance: Metres, for haze.
        albedo: Its reflectance.
        trees: How much woods roughen its line and its colour, 0 to 1.
    """

    low: float
    high: float
    distance: float
    albedo: tuple[float, float, float]
    trees: float


def ground(world: World, zones: tuple[Zone, ...], surfaces: FacadeMaterials, height: int) -> Floats:
    """(H / 2, 2 H, 3) nits of the land below the horizon; ``height`` is the panorama's."""
    nits = np.empty((height // 2, 2 * height, 3), dtype=np.float32)
    for first in range(0, len(nits), _BLOCK_ROWS):
        rows = np.arange(first, min(first + _BLOCK_ROWS, len(nits)), dtype=np.float32)
        nits[first : first + _BLOCK_ROWS] = _rows(world, zones, surfaces, height, rows)
    return nits


def _rows(
    world: World, zones: tuple[Zone, ...], surfaces: FacadeMaterials, height: int, rows: Floats
) -> Floats:
    """(R, 2 H, 3) nits of some rows below the horizon."""
    depression = (rows[:, None] + 0.5) * math.pi / height
    longitude = math.pi * (1.0 - (np.arange(2 * height, dtype=np.float32) + 0.5) / height)
    away = world.eye / np.tan(depression)
    x, y = away * np.sin(longitude), -away * np.cos(longitude)
    pixel = (away + world.eye) ** 2 / world.eye * (math.pi / height)
    albedo = _albedo(zones, surfaces, x, y, pixel)
    # What stands at the foot of its own house is lit as the land beside it.
    out = np.maximum(np.maximum(np.abs(x), np.abs(y)) / (OWN_HALF_M + 0.5), 1e-3)
    push = np.maximum(1.0, 1.0 / out)
    lit = world.shadows.lit(x * push, y * push, np.zeros((1, 1), np.float32))
    day = world.day
    up = np.array([0.0, 0.0, 1.0], dtype=np.float32)
    light = day.ambient(up) + lit[..., None] * day.beam * max(0.0, float(day.sun[2]))
    nits = albedo * light / math.pi
    hazy = (1.0 - 0.5 ** (np.minimum(away, 1e5) / _HAZY_M))[..., None]
    return np.asarray(nits + (day.haze - nits) * hazy, dtype=np.float32)


def _albedo(
    zones: tuple[Zone, ...], surfaces: FacadeMaterials, x: Floats, y: Floats, pixel: Floats
) -> Floats:
    """(H, W, 3) reflectance at places whose pixels are (H, 1) metres long."""
    patches = nearest(surfaces.rough, x / 31.0, y / 31.0)
    tufts = np.clip(0.4 / pixel, 0.0, 1.0) * nearest(surfaces.rough, x / 5.3, y / 5.3)
    tufts += np.clip(0.06 / pixel, 0.0, 1.0) * nearest(surfaces.white, x / 7.7, y / 7.7)
    albedo = np.zeros((*x.shape, 3), dtype=np.float32)
    for zone in zones:
        cover = _between(x, zone.x, pixel) * _between(y, zone.y, pixel)
        part = _filled(cover)
        cover = cover[part]
        color, wide, grain = _KINDS[zone.kind]
        shade = 1.0 + wide * patches[part] + 0.5 * grain * tufts[part]
        if zone.kind == "paving":
            joint = ((x[part] / _SLAB_M) % 1.0 < 0.03) | ((y[part] / _SLAB_M) % 1.0 < 0.03)
            shade *= 1.0 - 0.35 * joint * np.clip(0.05 / pixel[part[0]], 0.0, 1.0)
        shade = np.maximum(shade, 0.2) * cover
        albedo[part] *= 1.0 - cover[..., None]
        albedo[part] += np.array(color, dtype=np.float32) * shade[..., None]
    return albedo


def _filled(cover: Floats) -> tuple[slice, slice]:
    """The rows and columns beyond which nothing is covered."""
    rows, columns = (np.flatnonzero(cover.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return slice(0), slice(0)
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def _between(places: Floats, ends: tuple[float, float], pixel: Floats) -> Floats:
    """What of pixels lies between two ends."""
    low = np.clip((places - ends[0]) / pixel + 0.5, 0.0, 1.0)
    return np.asarray(low * np.clip((ends[1] - places) / pixel + 0.5, 0.0, 1.0))


def hills(
    canvas: Canvas,
    world: World,
    ridges: tuple[Ridge, ...],
    surfaces: FacadeMaterials,
    rng: np.random.Generator,
) -> None:
    """Put lines of hills on the canvas, behind what is there; in order from the farthest."""
    rows = [float(rng.random()) for _ in ridges]
    for ridge, row in zip(reversed(ridges), reversed(rows), strict=True):
        patch = canvas.whole(-0.01, ridge.high + 0.02)
        azimuth = np.arctan2(patch.x, -patch.y) / (2.0 * np.pi)
        line = _wave(surfaces.smooth, azimuth, row)
        woods = sampled(surfaces.rough, azimuth * 9.0, np.float32(row + 0.3) + 0.0 * azimuth)
        woods = woods + sampled(surfaces.white, azimuth * 4.0, np.float32(row) + 0.0 * azimuth)
        top = ridge.low + (ridge.high - ridge.low) * line
        top = top + ridge.trees * 0.0028 * (1.0 + woods)
        elevation = np.arctan(patch.z)
        cover = np.clip((top - elevation) / patch.step + 0.5, 0.0, 1.0)
        shape = cover.shape
        seen = canvas.seen(patch, cover > 0.0)
        cover = cover[seen]
        elevation, azimuth, top, x, y = (
            np.broadcast_to(item, shape)[seen]
            for item in (elevation, azimuth, top, patch.x, patch.y)
        )
        patches = sampled(surfaces.rough, azimuth * 6.0, elevation * 2.0 + row)
        crowns = sampled(surfaces.rough, azimuth * 40.0, elevation * 9.0 + row)
        shade = 1.0 + 0.25 * patches + 0.3 * ridge.trees * crowns
        rising = 0.75 + 0.25 * step(-0.02, 0.0, elevation - top)
        # Slopes that look at the sun are brighter than those before it.
        slope = 0.35 * (1.0 - x * world.day.sun[0] - y * world.day.sun[1])
        light = world.day.ambient(np.array([0.0, 0.0, 1.0]))
        light = light + (0.3 + 0.7 * slope)[..., None] * world.day.beam * max(
            float(world.day.sun[2]), 0.12
        )
        nits = (
            np.array(ridge.albedo, dtype=np.float32) * (np.maximum(shade, 0.3) * rising)[..., None]
        )
        nits = nits * light / math.pi
        hazy = np.float32(1.0 - 0.5 ** (ridge.distance / _HAZY_M))
        canvas.paint(patch, seen, nits + (world.day.haze - nits) * hazy, cover)


def _wave(tile: Floats, azimuth: Floats, row: float) -> Floats:
    """(1, W) an outline from 0 to 1 that closes around the horizon."""
    rows = np.float32(row) + 0.0 * azimuth
    line = sampled(tile, azimuth, rows) + 0.4 * sampled(tile, azimuth * 3.0, rows + 0.5)
    return np.asarray((line - line.min()) / max(float(np.ptp(line)), 1e-6), dtype=np.float32)
