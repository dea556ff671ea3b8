"""Slabs as the quarry gives them: split, sawn or honed, without polish.

Albedo of stone 0.2 to 0.35 (T. R. Oke, Boundary Layer Climates, 1987); those of slate and basalt,
darker, and of travertine and limestone, lighter, are chosen by eye.
"""

from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.tables import read_table

_PALETTES: Final = read_table(__file__, "palettes.toml")

SLATE: Final[tuple[tx.Color, ...]] = _PALETTES["quarried_slate"]
TRAVERTINE: Final[tuple[tx.Color, ...]] = _PALETTES["quarried_travertine"]
SANDSTONE: Final[tuple[tx.Color, ...]] = _PALETTES["quarried_sandstone"]
BASALT: Final[tuple[tx.Color, ...]] = _PALETTES["quarried_basalt"]
LIMESTONE: Final[tuple[tx.Color, ...]] = _PALETTES["quarried_limestone"]
GROUT: Final[tuple[tx.Color, ...]] = ((0.28, 0.27, 0.26), (0.20, 0.195, 0.19))


def slate(order: tx.Order) -> tx.Maps:
    """Riven slate in slabs of 0.6 x 0.3 m: layers split off along ragged steps."""
    color, matt = tx.drawn_color(order, SLATE), tx.drawn_roughness(order, 0.6, 0.78)
    slabs = tx.bond(order, (0.6, 0.3), 0.5, 2)
    bulk = tx.dealt(order, tx.fractal(order, 0.3, 0.85), slabs.index, slabs.count)
    ragged = tx.dealt(order, tx.fractal(order, 0.03, 0.4, 0.015), slabs.index, slabs.count)
    layer = 1.3 * bulk + 0.2 * ragged
    step = np.floor(layer) + tx.smoothstep(0.9, 1.0, layer - np.floor(layer))
    inside = slabs.inside(0.004, 0.001, 0.0005 * tx.noise(order, 0.02))
    on = tx.covered(order, inside)
    hue = np.where(slabs.index[..., None] % 3 == 0, (1.05, 0.99, 0.95), (1.0, 1.0, 1.0))
    tone = (1.0 + 0.16 * order.rng.uniform(-1.0, 1.0, slabs.count))[slabs.index]
    sheen = np.sin(2.1 * step)
    shade = tone * np.maximum(1.0 + 0.07 * ragged + 0.09 * sheen + 0.05 * bulk, 0.3)
    grout = (
        tx.side_color(order, GROUT)
        * np.maximum(1.0 + 0.08 * tx.fractal(order, 0.005, 0.1), 0.3)[..., None]
    )
    height = on * (0.0025 + 0.0013 * step + 0.00013 * ragged + 0.0004 * bulk)
    rough = matt + 0.06 * sheen * on + 0.15 * (1.0 - on)
    return tx.finished(order, tx.mixed(on, shade[..., None] * hue * color, grout), height, rough)


def travertine(order: tx.Order) -> tx.Maps:
    """Cut across its beds and left unfilled: bands along s, and holes strung along them."""
    color, matt = tx.drawn_color(order, TRAVERTINE), tx.drawn_roughness(order, 0.45, 0.65)
    sway = 0.012 * tx.noise(order, 0.5, 0.2)
    none = np.zeros_like(sway)
    band = tx.displaced(
        tx.noise(order, 1.2, 0.018) + 0.7 * tx.noise(order, 0.5, 0.006), order, none, sway
    )
    cloud, fine = tx.fractal(order, 0.12, 0.3), tx.fractal(order, 0.006, 0.2)
    # Holes where gas gathered: along some beds only, ragged, long along them.
    gathered = tx.displaced(tx.noise(order, 0.8, 0.03), order, none, sway) + 0.35 * tx.noise(
        order, 0.1, 0.02
    )
    rag = tx.noise(order, 0.012, 0.0035) + 0.5 * tx.noise(order, 0.004, 0.0015)
    small = tx.covered(order, tx.pits(order, 0.01, (0.0004, 0.0016), 1.8).inside)
    hole = tx.smoothstep(1.75, 2.05, rag * 0.9 + 0.75 * gathered)
    hole = np.maximum(hole, small * tx.smoothstep(-0.5, 0.5, gathered))
    shade = np.maximum(1.0 + 0.055 * band + 0.03 * cloud + 0.015 * fine, 0.3)
    warm = np.exp(np.multiply.outer(0.05 * band, (-0.4, 0.0, 0.9)))
    albedo = shade[..., None] * warm * color * (1.0 - 0.55 * hole)[..., None]
    height = -0.0028 * hole + 8e-6 * fine + 10e-6 * band
    return tx.finished(order, albedo, height, matt + 0.02 * cloud + 0.25 * hole)


def sandstone(order: tx.Order) -> tx.Maps:
    """Honed sandstone: thin slanting beds, cut off by the next ones (cross-bedding), and grains."""
    color, matt = tx.drawn_color(order, SANDSTONE), tx.drawn_roughness(order, 0.75, 0.88)
    size = order.size
    s = np.broadcast_to(np.arange(order.resolution) / order.resolution, (order.resolution,) * 2)
    t = s.T
    sets = tx.whole(size, 0.32)
    # Beds of a set fall by a whole number of them across the width, so that they meet at the edge.
    place = t * sets + 0.12 * tx.noise(order, 0.8, 0.3)
    number = np.floor(place).astype(np.int64) % sets
    lean = order.rng.integers(2, 9, sets)[number] * order.rng.choice([-1, 1], sets)[number]
    beds = tx.whole(size, 0.011)
    phase = beds * t + lean * s + 0.9 * tx.noise(order, 0.3, 0.12) + 7.3 * number
    fade = np.clip(0.65 + 0.35 * tx.noise(order, 0.6, 0.05), 0.0, 1.4)
    bed = fade * (np.cos(2.0 * np.pi * phase) + 0.6 * np.cos(2.0 * np.pi * phase / 3.0 + 1.0))
    grain, cloud = tx.fractal(order, 0.0015, 0.05), tx.fractal(order, 0.3, 0.4)
    shade = np.maximum(1.0 + 0.10 * bed + 0.07 * grain + 0.05 * cloud, 0.2)
    iron = np.exp(np.multiply.outer(0.07 * bed + 0.06 * cloud, (-0.5, 0.1, 0.8)))
    height = 90e-6 * grain + 60e-6 * bed
    return tx.finished(order, shade[..., None] * iron * color, height, matt + 0.02 * grain)


def basalt(order: tx.Order) -> tx.Maps:
    """Sawn lava, full of round bubbles from 1 to 12 mm."""
    color, matt = tx.drawn_color(order, BASALT), tx.drawn_roughness(order, 0.65, 0.8)
    holes = tx.pits(order, order.rng.uniform(0.10, 0.2), (0.0006, 0.006), 1.25)
    hole = tx.covered(order, holes.inside)
    grain, cloud = tx.fractal(order, 0.0015, 0.05), tx.fractal(order, 0.15, 0.3)
    deep = np.sqrt(np.clip(holes.inside / 0.003, 0.0, 1.0))
    shade = np.maximum(1.0 + 0.10 * grain + 0.05 * cloud, 0.3) * (1.0 - 0.4 * deep)
    height = -0.0028 * deep * hole + 15e-6 * grain
    return tx.finished(order, shade[..., None] * color, height, matt + 0.03 * grain + 0.12 * hole)


def shell_limestone(order: tx.Order) -> tx.Maps:
    """Honed limestone with broken shells and fine seams."""
    color, matt = tx.drawn_color(order, LIMESTONE), tx.drawn_roughness(order, 0.5, 0.7)
    cloud, fine = tx.fractal(order, 0.2, 0.4), tx.fractal(order, 0.003, 0.1)
    shells = tx.chips(order, 0.35, (0.0015, 0.014), (3, 5))
    # A sliver is a shell cut lengthwise: only its rim, lighter or darker than the mud around it.
    rim = tx.covered(order, 0.0007 - np.abs(shells.inside - 0.0006))
    body = tx.covered(order, shells.inside)
    light = order.rng.uniform(-0.22, 0.26, shells.count)[shells.index]
    seam = _seams(order)
    shade = 1.0 + 0.035 * cloud + 0.02 * fine + light * (0.35 * body + 0.65 * rim)
    shade = np.maximum(shade, 0.3) * (1.0 - 0.4 * seam)
    worn = tx.covered(order, tx.pits(order, 0.012, (0.0004, 0.0022)).inside)
    albedo = (shade * (1.0 - 0.35 * worn))[..., None] * color
    height = 20e-6 * body * np.sign(light) + 6e-6 * fine - 120e-6 * seam - 0.0005 * worn
    return tx.finished(order, albedo, height, matt + 0.03 * fine - 0.06 * body)


def _seams(order: tx.Order) -> tx.Field:
    """(N, N) stylolites, 0..1: jagged seams along s where the stone dissolved under pressure."""
    count = order.resolution
    up = np.arange(count)[:, None] / count
    seams = tx.whole(order.size, 0.3)
    jag = 0.03 * tx.noise(order, 0.4, 2.0) + 0.006 * tx.fractal(order, 0.03, 0.1, 1.0)
    phase = up * seams + jag / 0.3 * 1.3
    away = np.abs(phase - np.rint(phase)) * order.size / seams
    strength = np.clip(0.5 + 0.6 * tx.noise(order, 0.4, 0.1), 0.0, 1.0)
    return np.asarray(strength * np.clip(1.6 - away / 0.0009, 0.0, 1.0))


FAMILIES: Final[dict[str, tx.Family]] = {
    "slate": tx.Family(slate, 1.2, frozenset({"floor", "wall"})),
    "travertine": tx.Family(travertine, 1.0, frozenset({"floor", "wall"})),
    "sandstone": tx.Family(sandstone, 1.0, frozenset({"floor", "wall"})),
    "basalt": tx.Family(basalt, 0.6, frozenset({"floor", "wall"})),
    "shell_limestone": tx.Family(shell_limestone, 0.8, frozenset({"floor", "wall", "worktop"})),
}
