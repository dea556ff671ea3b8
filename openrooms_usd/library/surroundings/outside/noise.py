"""Fractal noise on tiles that repeat without a seam."""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.floating[Any]]

_TILE: Final = 512


def fractal_tile(rng: np.random.Generator, roughness: float, coarsest: int = 4) -> Floats:
    """(512, 512) periodic noise of mean 0 and standard deviation 1.

    Its amplitude falls as 1 / f^roughness, from `coarsest` waves across the tile.

    Args:
        rng: Draws it.
        roughness: 0 white, 1 rough as leaves, 2 smooth as hills.
        coarsest: Waves across the tile of its largest features.
    """
    spectrum = np.fft.rfft2(rng.standard_normal((_TILE, _TILE)))
    waves = np.hypot(*np.meshgrid(np.fft.fftfreq(_TILE), np.fft.rfftfreq(_TILE), indexing="ij"))
    waves *= _TILE
    spectrum *= np.where(waves >= coarsest, 1.0 / np.maximum(waves, 1.0) ** roughness, 0.0)
    tile = np.fft.irfft2(spectrum, s=(_TILE, _TILE))
    return np.asarray(tile / tile.std(), dtype=np.float32)


def sampled(tile: Floats, u: Floats, v: Floats) -> Floats:
    """A tile between its four nearest pixels, at coordinates in tiles, broadcast together."""
    height, width = tile.shape
    x, y = u * width, v * height
    left, top = np.floor(x), np.floor(y)
    across, down = x - left, y - top
    first, above = left.astype(np.int32) % width, top.astype(np.int32) % height
    second, below = (first + 1) % width, (above + 1) % height
    upper = tile[above, first] * (1.0 - across) + tile[above, second] * across
    lower = tile[below, first] * (1.0 - across) + tile[below, second] * across
    return np.asarray(upper * (1.0 - down) + lower * down, dtype=np.float32)


def nearest(tile: Floats, u: Floats, v: Floats) -> Floats:
    """A tile's nearest pixel: where noise is finer than what is drawn."""
    height, width = tile.shape
    columns = np.floor(u * width).astype(np.int32) % width
    rows = np.floor(v * height).astype(np.int32) % height
    return np.asarray(tile[rows, columns])


def step(low: float, high: float, value: Floats) -> Floats:
    """0 below ``low``, 1 above ``high``, a smooth step between."""
    t = np.clip((value - np.float32(low)) / np.float32(high - low), 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t), dtype=np.float32)
