"""Hides: the grain of leather, its creases and pores, its nap where it was buffed."""

from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import lattice
from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.tables import read_table

_PALETTES: Final = read_table(__file__, "palettes.toml")

COLORS: Final[tuple[tx.Color, ...]] = _PALETTES["hide_colors"]
_BUFFED: Final[tuple[tx.Color, ...]] = _PALETTES["hide_buffed"]
_GLAZED: Final[tuple[tx.Color, ...]] = _PALETTES["hide_glazed"]


def leather(
    order: tx.TextureParams,
    shade: tx.Field,
    height: tx.Field,
    rough: tuple[float, float],
    wear: tx.Field,
    colors: tuple[tx.Color, ...] = COLORS,
) -> tx.Maps:
    """A dyed hide; see `dyed`."""
    return tx.dyed(order, shade, height, rough, wear, colors)


def grain(order: tx.TextureParams, width: float, jitter: float = 1.0) -> lattice.LatticeCells:
    """The small fields that creases of a hide enclose, ``width`` metres wide."""
    count = lattice.whole(order, width)
    return lattice.cells(order.rng, order.resolution, count, count, jitter)


def bent(order: tx.TextureParams, field: tx.Field, length: float, far: float) -> tx.Field:
    """A field bent by about ``far`` metres within ``length``, so that no line stays straight."""
    return tx.displaced(field, order, far * tx.noise(order, length), far * tx.noise(order, length))


def pillow(border: tx.Field, width: float) -> tx.Field:
    """0 in a crease, 1 from ``width`` pitches beside it; round."""
    share = np.minimum(border / width, 1.0)
    return np.asarray(share * (2.0 - share))


def pores(order: tx.TextureParams, width: float, radius: float, share: float) -> tx.Field:
    """0..1 in hair pores: points in a share of fields ``width`` metres wide."""
    places = grain(order, width, 0.9)
    is_open = places.dealt(order.rng, 0.0, 1.0) < share
    return np.asarray(is_open * (1.0 - tx.smoothstep(0.4, 1.0, places.nearest / radius)))


def full_grain(order: tx.TextureParams) -> tx.Maps:
    """Cowhide as it grew: fine fields of uneven size, pores, and wrinkles of its life."""
    coarse = bent(order, pillow(grain(order, 0.0017).border, 0.3), 0.003, 0.0003)
    fine = pillow(grain(order, 0.0008).border, 0.5)
    holes = pores(order, 0.0016, 0.10, 0.5)
    wrinkle = np.maximum(1.0 - 3.0 * np.abs(tx.noise(order, 0.016, 0.006)), 0.0) * tx.smoothstep(
        0.0, 1.2, tx.noise(order, 0.03)
    )
    top = 0.6 * coarse + 0.4 * fine
    shade = (0.72 + 0.28 * top) * (1.0 - 0.35 * holes) * (1.0 - 0.12 * wrinkle)
    shade = shade * (1.0 + 0.05 * tx.noise(order, 0.02))
    height = 95e-6 * top - 70e-6 * holes - 60e-6 * wrinkle + 40e-6 * tx.noise(order, 0.03)
    return leather(order, shade, height, (0.42, 0.56), 0.10 * (1.0 - top) + 0.1 * wrinkle)


def pebbled(order: tx.TextureParams) -> tx.Maps:
    """Tumbled or embossed: round pebbles between deep creases."""
    width = float(order.rng.uniform(0.0024, 0.0034))
    pebble = bent(order, pillow(grain(order, width).border, 0.75), 2.0 * width, 0.12 * width)
    skin = tx.noise(order, 0.0006)
    shade = (0.55 + 0.45 * pebble) * (1.0 + 0.02 * skin)
    height = 0.00030 * pebble + 4e-6 * skin + 60e-6 * tx.noise(order, 0.012)
    return leather(order, shade, height, (0.4, 0.52), 0.14 * (1.0 - pebble))


def nappa(order: tx.TextureParams) -> tx.Maps:
    """Soft sheepskin: hardly any grain, gentle waves."""
    dimple = tx.band_noise(order.rng, order.resolution, order.size, 0.0011)
    soft = tx.noise(order, 0.014)
    cloud = tx.noise(order, 0.04)
    shade = 1.0 + 0.02 * dimple + 0.03 * soft + 0.03 * cloud
    height = 9e-6 * dimple + 110e-6 * soft
    return leather(order, shade, height, (0.36, 0.46), 0.015 * dimple)


def suede(order: tx.TextureParams) -> tx.Maps:
    """The flesh side, raised to a nap that strokes lay this way and that."""
    n, size, rng = order.resolution, order.size, order.rng
    left = tx.fibres(rng, n, size, 0.0004, 0.0022, -0.5)
    right = tx.fibres(rng, n, size, 0.0004, 0.0022, 0.6)
    side = tx.smoothstep(-0.7, 0.7, tx.noise(order, 0.018, 0.035))
    nap = side * left + (1.0 - side) * right
    shade = 1.0 + 0.12 * nap + 0.22 * (side - 0.5) + 0.05 * tx.noise(order, 0.004)
    return leather(order, shade, 35e-6 * nap + 60e-6 * side, (0.88, 0.96), -0.01 * nap, _BUFFED)


def nubuck(order: tx.TextureParams) -> tx.Maps:
    """The grain side, buffed as fine as dust; pores stay, scuffs shine."""
    dust = tx.noise(order, 0.00035)
    holes = pores(order, 0.0021, 0.13, 0.8)
    scuff = tx.smoothstep(1.2, 2.2, tx.noise(order, 0.004, 0.03))
    cloud = tx.fractal(order, 0.05, 0.4)
    shade = (1.0 + 0.035 * dust + 0.07 * cloud) * (1.0 - 0.35 * holes) * (1.0 + 0.15 * scuff)
    height = 6e-6 * dust - 80e-6 * holes + 15e-6 * cloud
    return leather(order, shade, height, (0.78, 0.88), -0.15 * scuff, _BUFFED)


def cracked(order: tx.TextureParams) -> tx.Maps:
    """Old and dry: the finish has burst along a net of cracks, and is rubbed off on the way."""
    coarse, fine = grain(order, 0.011), grain(order, 0.0036)
    wide = bent(order, coarse.border, 0.006, 0.0011)
    narrow = bent(order, fine.border, 0.002, 0.0004)
    worn = tx.smoothstep(-0.6, 1.4, tx.fractal(order, 0.05, 0.5))
    crack = np.maximum(
        1.0 - tx.smoothstep(0.03, 0.12, wide), worn * (1.0 - tx.smoothstep(0.03, 0.2, narrow))
    )
    curl = tx.smoothstep(0.0, 0.35, wide)
    pale = worn * (1.0 - curl)
    shade = (0.8 + 0.3 * curl) * (1.0 + 0.7 * pale) * (1.0 - 0.6 * crack)
    shade = shade * (1.0 + 0.12 * worn)
    height = (
        0.00016 * (1.0 - curl) * (1.0 - crack) - 0.00028 * crack + 5e-6 * tx.noise(order, 0.0008)
    )
    return leather(order, shade, height, (0.5, 0.62), 0.2 * crack + 0.12 * worn, COLORS[:5])


def patent(order: tx.TextureParams) -> tx.Maps:
    """A thick gloss of lacquer over a smooth hide."""
    swell = tx.noise(order, 0.016)
    peel = tx.band_noise(order.rng, order.resolution, order.size, 0.0035)
    shade = 1.0 + 0.012 * swell + 0.004 * peel
    height = 40e-6 * swell + 1.6e-6 * peel
    return leather(order, shade, height, (0.06, 0.1), 0.008 * swell, _GLAZED)


def saffiano(order: tx.TextureParams) -> tx.Maps:
    """Pressed with fine slanted hatching in two directions, then waxed."""
    pitch = 0.0017
    count = lattice.whole(order, pitch)
    first, second = lattice.diagonal(order.resolution, count, count)
    stray = 0.14 * tx.noise(order, 0.003)
    one = np.abs(np.cos(np.pi * (first + stray)))
    other = np.abs(np.cos(np.pi * (second - 0.8 * stray)))
    ridge = np.maximum(one, 0.85 * other) ** 2
    shade = (0.66 + 0.34 * ridge) * (1.0 + 0.02 * tx.noise(order, 0.02))
    height = 0.13 * lattice.spacing(order, pitch, count) * ridge
    return leather(order, shade, height, (0.34, 0.44), 0.16 * (1.0 - ridge))
