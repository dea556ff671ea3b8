"""Fabrics of standing, looped or matted fibres: velvet, corduroy, felt, and carpets."""

from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import lattice
from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.library.textures.fabric.dyes import COLORS, NATURALS
from openrooms_usd.tables import read_table

_PALETTES: Final = read_table(__file__, "palettes.toml")

_DEEP: Final[tuple[tx.Color, ...]] = _PALETTES["pile_deep"]
_CARPETS: Final[tuple[tx.Color, ...]] = _PALETTES["pile_carpets"]


def _pile(
    order: tx.TextureParams,
    mean: tx.Field,
    shade: tx.Field,
    height: tx.Field,
    rough: tuple[float, float],
) -> tx.Maps:
    """What lies deep is darker (already in ``shade``) and rougher."""
    deep = np.clip(tx.standardized(height), -2.0, 2.0)
    return tx.Maps(
        albedo=tx.tinted(np.maximum(shade, 0.04), mean),
        height=height,
        roughness=tx.around(tx.drawn_roughness(order, *rough), -0.015 * deep),
    )


def _curled(order: tx.TextureParams, field: tx.Field, length: float, far: float) -> tx.Field:
    """A field whose lines are bent: by about ``far`` metres within ``length``."""
    return tx.displaced(field, order, far * tx.noise(order, length), far * tx.noise(order, length))


def _corduroy(order: tx.TextureParams) -> tx.Maps:
    """Round ribs of pile along t, with bare ground between them."""
    n, rng = order.resolution, order.rng
    mean = tx.mean_color(order, COLORS)
    pitch = float(rng.uniform(0.0024, 0.0036))
    count = lattice.whole(order, pitch)
    stray = 0.05 * tx.noise(order, 3.0 * pitch, 0.03)
    across = lattice.offset(lattice.phase(n, count)[None] + stray)
    rib = np.sqrt(np.maximum(1.0 - (across / 0.92) ** 2, 0.0))
    tuft = tx.noise(order, 0.0004, 0.0009)
    crush = tx.noise(order, 0.02, 0.05)
    shade = (0.3 + 0.7 * rib) * (1.0 + 0.10 * tuft * rib + 0.06 * crush)
    depth = 0.34 * lattice.spacing(order, pitch, count)
    return _pile(order, mean, shade, depth * (rib + 0.05 * tuft * rib + 0.06 * crush), (0.82, 0.9))


def _velvet(order: tx.TextureParams) -> tx.Maps:
    """Short dense pile that leans: strokes of a hand leave it lighter and darker."""
    mean = tx.mean_color(order, _DEEP)
    nap = tx.noise(order, 0.05, 0.07) + 0.35 * tx.noise(order, 0.014, 0.03)
    stroked = nap / np.sqrt(1.0 + nap**2)
    tips = tx.fibres(order.rng, order.resolution, order.size, 0.0003, 0.0009, 0.15)
    shade = 1.0 + 0.24 * stroked + 0.13 * tips
    height = 30e-6 * tips + 250e-6 * stroked
    return _pile(order, mean, shade, height, (0.68, 0.8))


def _felt(order: tx.TextureParams) -> tx.Maps:
    """Fibres matted in all directions, pressed flat."""
    mean = tx.mean_color(order, COLORS)
    straight = tx.matted(order.rng, order.resolution, order.size, 0.0003, 0.0035, 5)
    hairs = _curled(order, straight, 0.003, 0.0006)
    cloud = tx.noise(order, 0.009)
    shade = 1.0 + 0.08 * hairs + 0.07 * cloud
    return _pile(order, mean, shade, 18e-6 * hairs + 70e-6 * cloud, (0.88, 0.96))


def _boucle(order: tx.TextureParams) -> tx.Maps:
    """Loops of a curled yarn, strewn over each other."""
    n, rng = order.resolution, order.rng
    mean = tx.mean_color(order, NATURALS + COLORS)
    top = np.zeros((n, n))
    for width, wide in ((0.0034, 0.33), (0.0045, 0.36), (0.0058, 0.38)):
        curls = lattice.cells(rng, n, lattice.whole(order, width), lattice.whole(order, width), 1.0)
        tube = 1.0 - ((curls.nearest - wide) / 0.24) ** 2
        lift = curls.dealt(rng, 0.0, 0.7)
        np.maximum(top, np.sqrt(np.maximum(tube, 0.0)) * (0.5 + lift), out=top)
    top = _curled(order, top, 0.004, 0.0007)
    fuzz = tx.noise(order, 0.0007)
    shade = (0.42 + 0.58 * top) * (1.0 + 0.07 * fuzz)
    return _pile(order, mean, shade, 0.0013 * (top + 0.04 * fuzz), (0.86, 0.95))


def _loop_carpet(order: tx.TextureParams) -> tx.Maps:
    """Rows of uncut loops, each with strands that bend over."""
    n, rng = order.resolution, order.rng
    mean = tx.mean_color(order, _CARPETS)
    columns, rows = lattice.whole(order, 0.0036), lattice.whole(order, 0.0048, 2)
    loops = lattice.cells(rng, n, columns, rows, 0.45, stagger=0.5)
    dome = np.sqrt(np.maximum(1.0 - 1.9 * loops.nearest**2, 0.0))
    strands = tx.fibres(rng, n, order.size, 0.0006, 0.004, 0.25)
    tone = 1.0 + loops.dealt(rng, -0.22, 0.22)
    worn = tx.noise(order, 0.05)
    shade = tone * (0.22 + 0.78 * dome) * (1.0 + 0.16 * strands + 0.03 * worn)
    depth = 0.6 * lattice.spacing(order, 0.0042, max(columns, rows))
    lift = loops.dealt(rng, 0.75, 1.1)
    return _pile(order, mean, shade, depth * (dome * lift + 0.07 * strands * dome), (0.88, 0.96))


def _cut_carpet(order: tx.TextureParams) -> tx.Maps:
    """Cut tufts stand like brushes; feet and the vacuum cleaner leave them leaning."""
    n, rng = order.resolution, order.rng
    mean = tx.mean_color(order, _CARPETS)
    count = lattice.whole(order, 0.0032)
    tufts = lattice.cells(rng, n, count, count, 1.0)
    tips = tx.noise(order, 0.0009)
    lean = tx.noise(order, 0.08, 0.12)
    lean = lean / np.sqrt(1.0 + lean**2)
    tone = 1.0 + tufts.dealt(rng, -0.18, 0.18)
    brush = 1.0 - np.minimum(tufts.nearest, 1.0) ** 2
    shade = _curled(order, tone * (0.55 + 0.45 * brush), 0.0016, 0.0005)
    shade = shade * (1.0 + 0.2 * tips + 0.12 * lean)
    height = lattice.spacing(order, 0.0032, count) * (0.2 * brush + 0.06 * tips + 0.25 * lean)
    return _pile(order, mean, shade, height, (0.9, 0.98))


def _shag(order: tx.TextureParams) -> tx.Maps:
    """Long strands that fall over each other, in locks."""
    n, rng, size = order.resolution, order.rng, order.size
    mean = tx.mean_color(order, _CARPETS + NATURALS)
    strands = tx.matted(rng, n, size, 0.0035, 0.05, 4, 2.4)
    hairs = tx.fibres(rng, n, size, 0.0016, 0.03, rng.uniform(-0.4, 0.4))
    locks = tx.noise(order, 0.03)
    top = _curled(order, 0.5 + 0.2 * strands + 0.08 * hairs, 0.04, 0.006) + 0.1 * locks
    top = np.clip(top, 0.0, 1.2)
    return _pile(order, mean, 0.2 + top, 0.0055 * top, (0.9, 0.97))


def _needlefelt(order: tx.TextureParams) -> tx.Maps:
    """Entrance carpet: coarse fibres needled into rows of ribs."""
    n, rng = order.resolution, order.rng
    mean = tx.mean_color(order, _CARPETS, 0.25)
    count = lattice.whole(order, 0.0055)
    across = lattice.offset(lattice.phase(n, count)[None] + 0.06 * tx.noise(order, 0.006, 0.01))
    rib = np.cos(0.5 * np.pi * across)
    hairs = tx.matted(rng, n, order.size, 0.0007, 0.012, 4, 1.6)
    fleck = np.where(hairs > 1.1, 1.35, 1.0)
    shade = (0.45 + 0.55 * rib) * (1.0 + 0.16 * hairs) * fleck
    depth = 0.3 * lattice.spacing(order, 0.0055, count)
    return _pile(order, mean, shade, depth * (rib + 0.1 * hairs), (0.92, 0.98))


_SOFT: Final[frozenset[tx.Use]] = frozenset({"textile", "furniture"})
_FLOOR: Final[frozenset[tx.Use]] = frozenset({"floor"})

PILED: Final[dict[str, tx.Family]] = {
    "corduroy": tx.Family(lattice.resolved(_corduroy, 0.0024), 0.12, _SOFT, grain=True, laid=4),
    "velvet": tx.Family(lattice.resolved(_velvet, 0.0006), 0.15, _SOFT, grain=True, laid=4),
    "felt": tx.Family(lattice.resolved(_felt, 0.0006), 0.1, _SOFT, laid=4),
    "boucle": tx.Family(lattice.resolved(_boucle, 0.0016), 0.15, _SOFT, laid=4),
    "loop_carpet": tx.Family(lattice.resolved(_loop_carpet, 0.003), 0.25, _FLOOR, laid=4),
    "cut_carpet": tx.Family(lattice.resolved(_cut_carpet, 0.0016), 0.25, _FLOOR, laid=4),
    "shag_carpet": tx.Family(lattice.resolved(_shag, 0.002), 0.4, _FLOOR, laid=2),
    "needlefelt_carpet": tx.Family(
        lattice.resolved(_needlefelt, 0.002), 0.25, _FLOOR, grain=True, laid=2
    ),
}
