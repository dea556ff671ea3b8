"""The surroundings as an opening sees them: pixels, what comes in, and a panorama."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Floats, Ints
from openrooms_usd.rendering.scene.arrays import Environment, Scene, Sun
from openrooms_usd.usd.light.lights import Portal

# Rows that a constant picture is made of, and what stands out from a picture: its sun.
_ROWS_OF_CONSTANT: Final = 32
_SUN_PER_MEDIAN: Final = 8.0


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Light from around, as pixels.

    Attributes:
        radiance: (H, W, 3) nits.
        directions: (H, W, 3) unit vectors to them, in the world.
        weights: (H, W) solid angles, sr; they sum to 4 pi.
        suns: Parallel lights, which are not in the pixels.
        world_from_light: (3, 3) the rotation of the picture.
    """

    radiance: Array
    directions: Array
    weights: Array
    suns: tuple[Sun, ...]
    world_from_light: Array


def surroundings(scene: Scene) -> Surroundings:
    """The environment and the parallel lights of a scene; black where there is none."""
    found = scene.environment
    if found is None:
        found = Environment(np.zeros((1, 1, 3), dtype=np.float32), np.eye(3))
    return _around(found, scene.suns)


def summed(one: Environment, other: Environment) -> Environment:
    """The sum of two environments, in the resolution of the finer one."""
    fine, coarse = (one, other) if one.pixels.size >= other.pixels.size else (other, one)
    if coarse.pixels.shape[:2] == (1, 1):
        return Environment(fine.pixels + coarse.pixels, fine.world_from_light)
    added = _lookup(_around(coarse, ()), _around(fine, ()).directions)
    return Environment((fine.pixels + added).astype(np.float32), fine.world_from_light)


def _around(found: Environment, suns: tuple[Sun, ...]) -> Surroundings:
    pixels = found.pixels.astype(np.float64)
    if pixels.shape[:2] == (1, 1):
        pixels = np.broadcast_to(pixels, (_ROWS_OF_CONSTANT + 1, 2 * _ROWS_OF_CONSTANT, 3))
    height, width = pixels.shape[:2]
    # Rows go from pole to pole; the first and the last have half the height.
    theta = np.linspace(0.0, np.pi, height)
    half = 0.5 * np.pi / max(1, height - 1)
    edges = np.cos(np.clip(np.append(theta - half, np.pi), 0.0, np.pi))
    phi = 2.0 * np.pi * (np.arange(width) + 0.5) / width
    sine = np.sin(theta)[:, None]
    local = np.stack(
        [sine * np.sin(phi), np.cos(theta)[:, None] * np.ones(width), -sine * np.cos(phi)], axis=-1
    )
    weights = np.repeat((edges[:-1] - edges[1:])[:, None] * 2.0 * np.pi / width, width, axis=1)
    turn = found.world_from_light
    return Surroundings(pixels, local @ turn.T, weights, suns, turn)


def passing(sky: Surroundings, outwards: Array) -> Array:
    """(3,) lux that the surroundings and parallel lights send in through a plane.

    Args:
        sky: What is around.
        outwards: (3,) the plane's unit normal, away from the room.
    """
    cosine = np.maximum(sky.directions @ outwards, 0.0) * sky.weights
    lux = np.einsum("hw,hwc->c", cosine, sky.radiance)
    for sun in sky.suns:
        lux = lux + sun.irradiance * max(0.0, float(-sun.direction @ outwards))
    return np.asarray(lux)


def panorama(sky: Surroundings, portal: Portal, height: int = 256) -> Floats:
    """What an opening's centre sees of the surroundings, with nothing in between.

    Args:
        sky: What is around.
        portal: The opening.
        height: Rows.

    Returns:
        (height, 2 height, 3) nits in the layout of a dome's picture: the upper edge is the world's
        +Z, the middle looks along -Y, a quarter from the left along +X. Black towards the room. A
        parallel light is a pixel of the same flux.
    """
    ways, weights = latlong(height)
    seen = _resampled(sky, height)
    for sun in sky.suns:
        row, column = np.unravel_index(int((ways @ -sun.direction).argmax()), weights.shape)
        seen[row, column] += sun.irradiance / weights[row, column]
    outside = ways @ portal.world_from_portal[:3, 2] > 0.0
    return np.where(outside[..., None], seen, 0.0).astype(np.float32)


def latlong(height: int) -> tuple[Array, Array]:
    """(H, 2 H, 3) directions of a panorama's pixels in the world, and (H, 2 H) solid angles."""
    theta = np.pi * (np.arange(height) + 0.5) / height
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    phi = 2.0 * np.pi * (np.arange(2 * height) + 0.5) / (2 * height)
    sine = np.sin(theta)[:, None]
    ways = np.stack(
        [sine * np.sin(phi), sine * np.cos(phi), np.cos(theta)[:, None] * np.ones(2 * height)], -1
    )
    weights = np.repeat((edges[:-1] - edges[1:])[:, None] * np.pi / height, 2 * height, axis=1)
    return ways, weights


def _resampled(sky: Surroundings, height: int) -> Array:
    """The pixels of the surroundings as a panorama of the same flux.

    Where the panorama is coarser its pixels are means, and what is much brighter than the rest, the
    sun, keeps its flux; where it is finer they lie between the four nearest.
    """
    ways, weights = latlong(height)
    if len(sky.weights) < 2 * height:
        return _lookup(sky, ways)
    cells, solid = cells_of(sky.directions.reshape(-1, 3), height), sky.weights.ravel()
    light = sky.radiance.reshape(-1, 3)
    even = np.minimum(light, _SUN_PER_MEDIAN * np.median(light, axis=0))
    covered = np.maximum(np.bincount(cells, solid, weights.size), 1e-30)[:, None]
    means = sums_by(cells, solid, even, weights.size) / covered
    bright = sums_by(cells, solid, light - even, weights.size) / weights.reshape(-1, 1)
    return np.asarray((means + bright).reshape(ways.shape))


def _lookup(sky: Surroundings, ways: Array) -> Array:
    """Radiance along directions, between the four nearest pixels."""
    x, y, z = np.moveaxis(ways @ sky.world_from_light, -1, 0)
    height, width = sky.weights.shape
    row = np.arccos(np.clip(y, -1.0, 1.0)) / np.pi * (height - 1)
    column = np.arctan2(x, -z) / (2.0 * np.pi) * width - 0.5
    top, left = np.floor(row).astype(int), np.floor(column).astype(int)
    down, across = (row - top)[..., None], (column - left)[..., None]
    below = np.minimum(top + 1, height - 1)
    first, second = left % width, (left + 1) % width
    upper = sky.radiance[top, first] * (1 - across) + sky.radiance[top, second] * across
    lower = sky.radiance[below, first] * (1 - across) + sky.radiance[below, second] * across
    return np.asarray(upper * (1 - down) + lower * down)


def cells_of(ways: Array, height: int) -> Ints:
    """(N,) the pixels of a panorama that directions (N, 3) are in."""
    x, y, z = ways.T
    rows = (np.arccos(np.clip(z, -1.0, 1.0)) / np.pi * height).astype(np.int64)
    columns = (np.arctan2(x, y) / (2.0 * np.pi) % 1.0 * 2 * height).astype(np.int64)
    return np.asarray(np.minimum(rows, height - 1) * 2 * height + columns % (2 * height))


def sums_by(cells: Ints, weights: Array, values: Array, count: int = 0) -> Array:
    """(C, 3) the weighted sums of values (N, 3) in each cell."""
    sums = [np.bincount(cells, weights * column, count) for column in values.T]
    return np.stack(sums, axis=1)
