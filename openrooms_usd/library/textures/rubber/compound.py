"""Rubber compounds: skins, granules and foams, before any pattern is moulded into them."""

from typing import Final

import numpy as np

from openrooms_usd.arrays import Ints
from openrooms_usd.library.textures.base import lattice
from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.library.textures.leather.hide import bent
from openrooms_usd.tables import read_table

_PALETTES: Final = read_table(__file__, "palettes.toml")

BLACKS: Final[tuple[tx.Color, ...]] = _PALETTES["compound_blacks"]
COLORS: Final[tuple[tx.Color, ...]] = _PALETTES["compound_colors"]
_BRIGHT: Final[tuple[tx.Color, ...]] = _PALETTES["compound_bright"]
_SPONGES: Final[tuple[tx.Color, ...]] = _PALETTES["compound_sponges"]
_LATEX: Final[tuple[tx.Color, ...]] = _PALETTES["compound_latex"]
# What flecks are of: coloured granules of EPDM among black ones of tyres.
_FLECKS: Final[tuple[tuple[tx.Color, ...], ...]] = (
    ((0.40, 0.41, 0.41),),
    ((0.10, 0.20, 0.42), (0.35, 0.36, 0.37)),
    ((0.45, 0.10, 0.07), (0.34, 0.31, 0.27)),
    ((0.14, 0.34, 0.14), (0.40, 0.42, 0.30)),
    ((0.55, 0.42, 0.10), (0.40, 0.16, 0.06)),
)
_BLACK: Final = (0.032, 0.032, 0.033)


def rubber(
    order: tx.TextureParams,
    shade: tx.Field,
    height: tx.Field,
    rough: tuple[float, float],
    wear: tx.Field,
    colors: tuple[tx.Color, ...] = COLORS,
) -> tx.Maps:
    """Rubber of one colour; see `dyed`."""
    return tx.dyed(order, shade, height, rough, wear, colors)


def smooth(order: tx.TextureParams) -> tx.Maps:
    """Pressed sheet: the mould's fine grain, dust, and hairlines of use."""
    grain = tx.noise(order, 0.0006)
    dust = tx.fractal(order, 0.08, 0.3)
    scuffs = tx.lines(order, 60, (0.02, 0.09), 0.3, (0.0, np.pi))
    marks = np.minimum(scuffs, 1.5)
    shade = 1.0 + 0.08 * dust + 0.03 * grain + 0.25 * marks
    height = 4e-6 * grain + 25e-6 * tx.noise(order, 0.04) - 6e-6 * marks
    return rubber(order, shade, height, (0.6, 0.72), 0.03 * dust - 0.04 * marks)


def _flecked(
    order: tx.TextureParams, index: Ints, count: int, share: tuple[float, float]
) -> tx.Field:
    """(N, N, 3) colour of granules: black, but for a share of coloured ones."""
    rng = tx.apart(order.rng)
    flecks = np.array(_FLECKS[int(rng.integers(len(_FLECKS)))])
    colors = np.array(_BLACK) * rng.uniform(0.75, 1.3, (count, 1))
    is_fleck = rng.random(count) < rng.uniform(*share)
    chosen = flecks[rng.integers(0, len(flecks), count)] * rng.uniform(0.7, 1.15, (count, 1))
    colors[is_fleck] = chosen[is_fleck]
    return np.asarray(colors[index])


def crumb(order: tx.TextureParams) -> tx.Maps:
    """Granules of old tyres, glued under pressure: gaps stay, some granules are coloured."""
    rng = order.rng
    width = float(rng.uniform(0.0022, 0.0030))
    count = lattice.whole(order, width)
    granules = lattice.cells(rng, order.resolution, count, count, 1.0)
    gap = 1.0 - tx.smoothstep(0.02, 0.3, bent(order, granules.border, 0.002, 0.0003))
    lift = granules.dealt(rng, -1.0, 1.0)
    facet = tx.noise(order, 0.0012)
    shade = (1.0 - 0.6 * gap) * (1.0 + 0.08 * facet)
    colors = _flecked(order, granules.index, granules.count, (0.08, 0.22))
    height = lattice.spacing(order, width, count) * (0.09 * lift - 0.22 * gap + 0.03 * facet)
    mean = None if order.color is None else np.array(order.color)
    rough = tx.around(tx.drawn_roughness(order, 0.78, 0.88), 0.08 * gap)
    return tx.Maps(tx.tinted(colors * shade[..., None], mean), height, rough)


def speckled(order: tx.TextureParams) -> tx.Maps:
    """Gym tile: granules so fine and pressed that only the coloured ones are seen."""
    rng = order.rng
    count = lattice.whole(order, 0.0026)
    granules = lattice.cells(rng, order.resolution, count, count, 1.0)
    colors = _flecked(order, granules.index, granules.count, (0.05, 0.12))
    skin, swell = tx.noise(order, 0.0009), tx.noise(order, 0.012)
    shade = 1.0 + 0.12 * skin + 0.03 * swell
    mean = None if order.color is None else np.array(order.color)
    rough = tx.around(tx.drawn_roughness(order, 0.7, 0.82), 0.015 * skin)
    height = 14e-6 * skin + 45e-6 * swell
    return tx.Maps(tx.tinted(colors * np.maximum(shade, 0.05)[..., None], mean), height, rough)


def marbled(order: tx.TextureParams) -> tx.Maps:
    """Floor sheet of two mixed compounds, drawn into veins by the rollers."""
    stretched = tx.noise(order, 0.03, 0.09) + 0.5 * tx.noise(order, 0.012, 0.05)
    folded = bent(order, stretched, 0.07, 0.018)
    vein = np.abs((folded * 1.3) % 2.0 - 1.0)
    fine = tx.noise(order, 0.0025, 0.008)
    share = tx.smoothstep(0.3, 0.9, vein + 0.08 * fine)
    shade = 0.78 + 0.55 * share + 0.03 * fine
    height = 10e-6 * fine + 30e-6 * tx.noise(order, 0.02)
    return rubber(order, shade, height, (0.55, 0.68), 0.02 * fine, COLORS[2:])


def foam(order: tx.TextureParams) -> tx.Maps:
    """Closed-cell foam, cut open: bubbles side by side, each a shallow cup."""
    rng = order.rng
    count = lattice.whole(order, 0.0011)
    bubbles = lattice.cells(rng, order.resolution, count, count, 1.0)
    wall = 1.0 - tx.smoothstep(0.0, 0.45, bubbles.border)
    tone = bubbles.dealt(rng, -0.08, 0.08)
    dent = tx.noise(order, 0.015)
    shade = (0.82 + 0.18 * wall) * (1.0 + tone)
    height = 0.16 * lattice.spacing(order, 0.0011, count) * wall + 70e-6 * dent
    return rubber(order, shade, height, (0.82, 0.92), -0.03 * wall, _BRIGHT)


def sponge(order: tx.TextureParams) -> tx.Maps:
    """Open-cell foam: holes of all sizes, deep and dark, in a soft net."""
    n, rng = order.resolution, order.rng
    depth = np.zeros((n, n))
    for width, deep, share in ((0.011, 0.0032, 0.45), (0.0048, 0.0017, 0.7), (0.0022, 0.0008, 0.9)):
        holes = lattice.cells(rng, n, lattice.whole(order, width), lattice.whole(order, width), 0.7)
        is_open = holes.dealt(rng, 0.0, 1.0) < share
        radius = np.where(is_open, holes.dealt(rng, 0.2, 0.4), 1e-6)
        reach = bent(order, holes.nearest, 0.4 * width, 0.05 * width) / radius
        cup = np.sqrt(np.maximum(1.0 - reach**2, 0.0))
        np.maximum(depth, deep * cup, out=depth)
    hollow = depth / 0.0032
    net = tx.noise(order, 0.001)
    shade = (1.0 - 0.72 * np.sqrt(hollow)) * (1.0 + 0.05 * net)
    return rubber(order, shade, 25e-6 * net - depth, (0.86, 0.95), 0.04 * hollow, _SPONGES)


def latex(order: tx.TextureParams) -> tx.Maps:
    """Poured skin: it ran, wrinkled as it set, and shines."""
    run = bent(order, tx.noise(order, 0.012, 0.06), 0.05, 0.008)
    wrinkle = tx.band_noise(order.rng, order.resolution, order.size, 0.0055)
    folded = bent(order, wrinkle, 0.03, 0.006)
    crest = np.maximum(folded, -0.6)
    shade = 1.0 + 0.05 * crest + 0.05 * run
    height = 0.00018 * run + 0.00011 * crest
    return rubber(order, shade, height, (0.25, 0.38), 0.02 * crest, _LATEX)


def pebbled(order: tx.TextureParams) -> tx.Maps:
    """Mats with a hammered face: flat pebbles of uneven width and height."""
    rng = order.rng
    count = lattice.whole(order, 0.0055)
    pebbles = lattice.cells(rng, order.resolution, count, count, 0.9)
    border = bent(order, pebbles.border, 0.005, 0.0006)
    top = tx.smoothstep(0.04, 0.55, border)
    lift = pebbles.dealt(rng, 0.55, 1.0)
    skin = tx.noise(order, 0.0008)
    shade = (0.72 + 0.28 * top * lift) * (1.0 + 0.04 * skin)
    height = 0.12 * lattice.spacing(order, 0.0055, count) * top * lift + 6e-6 * skin
    return rubber(order, shade, height, (0.62, 0.74), 0.08 * (1.0 - top))
