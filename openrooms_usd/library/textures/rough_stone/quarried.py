"""Slabs as the quarry gives them: split, sawn or honed, without polish.

Albedo of stone 0.2 to 0.35 (T. R. Oke, Boundary Layer Climates, 1987); those of slate and basalt,
darker, and of travertine and limestone, lighter, are chosen by eye.
"""

from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.tables import read_table

_PALETTES: Final = read_table(__file__, "palettes.toml")

CEMENT: Final[tuple[tx.Color, ...]] = _PALETTES["concrete_cement"]
PEBBLES: Final[tuple[tx.Color, ...]] = _PALETTES["concrete_pebbles"]
RENDER: Final[tuple[tx.Color, ...]] = _PALETTES["concrete_render"]
PLASTER: Final[tuple[tx.Color, ...]] = _PALETTES["concrete_plaster"]


def cast_concrete(order: tx.TextureParams) -> tx.Maps:
    """Concrete from smooth formwork: clouds of cement, blowholes of 1 to 8 mm."""
    color, matt = tx.drawn_color(order, CEMENT), tx.drawn_roughness(order, 0.7, 0.85)
    cloud, fine = tx.fractal(order, 0.45, 0.45), tx.fractal(order, 0.02, 0.1)
    holes = tx.pits(order, order.rng.uniform(0.006, 0.014), (0.0007, 0.0045))
    hole = tx.covered(order, holes.inside)
    # Blowholes come in swarms, where the vibrator did not reach.
    hole = hole * tx.smoothstep(
        -0.4, 0.0, tx.noise(order, 0.3) + order.rng.uniform(-1.0, 1.0, holes.count)[holes.index]
    )
    shade = np.maximum(1.0 + 0.075 * cloud + 0.03 * fine, 0.4) * (1.0 - 0.5 * hole)
    height = 0.0003 * tx.noise(order, 0.35) + 12e-6 * fine - 0.0016 * hole
    return tx.finished(order, shade[..., None] * color, height, matt + 0.03 * cloud + 0.1 * hole)


def board_formed_concrete(order: tx.TextureParams) -> tx.Maps:
    """Concrete that shows the sawn boards of its formwork, 0.1 to 0.15 m wide, grain along s."""
    color, matt = tx.drawn_color(order, CEMENT), tx.drawn_roughness(order, 0.78, 0.9)
    boards = _boards(order)
    grain = tx.shifted_per_piece(order, _turned(_sawn(order)), boards.index, boards.count)
    edge = np.minimum(boards.bed, boards.side) + 0.0004 * tx.noise(order, 0.012)
    fin = 1.0 - tx.smoothstep(0.0, 0.0035, edge)
    broken = tx.smoothstep(-0.9, 0.6, tx.noise(order, 0.06))
    level = 0.0012 * order.rng.uniform(-1.0, 1.0, boards.count)[boards.index]
    cloud, fine = tx.fractal(order, 0.4, 0.35), tx.fractal(order, 0.01, 0.1)
    hole = tx.covered(order, tx.pits(order, 0.004, (0.0007, 0.004)).inside)
    tone = (1.0 + 0.07 * order.rng.uniform(-1.0, 1.0, boards.count))[boards.index]
    shade = tone * np.maximum(1.0 + 0.05 * cloud + 0.03 * fine + 0.045 * grain, 0.3)
    shade = shade * (1.0 - 0.45 * hole) * (1.0 - 0.22 * fin)
    height = level + 0.00028 * grain + 0.0022 * fin * broken + 15e-6 * fine - 0.0012 * hole
    return tx.finished(order, shade[..., None] * color, height, matt - 0.02 * grain + 0.02 * cloud)


def _boards(order: tx.TextureParams) -> tx.Laid:
    """Boards of 0.1 to 0.15 m and 1.5 to 2.5 m, running along s."""
    rows = tx.whole(order.size, order.rng.uniform(0.10, 0.15))
    heights = order.rng.uniform(0.85, 1.15, rows)
    columns = tx.whole(order.size, 2.0)
    lengths = [np.full(columns, order.size / columns)] * rows
    starts = order.rng.uniform(0.0, order.size, rows)
    return tx.laid(order, heights * (order.size / float(heights.sum())), lengths, starts)


def _sawn(order: tx.TextureParams) -> tx.Field:
    """(N, N) the relief of a sawn face, rings brushed out by the saw; along t."""
    rings = 7.0 * tx.noise(order, 0.09, 1.2) + 1.5 * tx.noise(order, 0.02, 0.25)
    return np.asarray(np.cos(rings * 2.2) * 0.8 + 0.7 * tx.noise(order, 0.0025, 0.12))


def _turned(field: tx.Field) -> tx.Field:
    return np.ascontiguousarray(field.T)


def exposed_aggregate(order: tx.TextureParams) -> tx.Maps:
    """Concrete washed before it set: pebbles of 6 to 14 mm stand out of the cement."""
    cement, matt = tx.side_color(order, CEMENT), tx.drawn_roughness(order, 0.75, 0.88)
    width = order.rng.uniform(0.009, 0.014)
    warp = (0.07 * width * tx.noise(order, width / 2), 0.07 * width * tx.noise(order, width / 2))
    stones = tx.scattered_cells(order, width, 1.0, warp)
    margin = width * order.rng.uniform(0.04, 0.2, stones.count)[stones.index]
    inside = stones.edge - margin
    on = tx.covered(order, inside)
    base, palette = tx.drawn_color(order, PEBBLES), np.array(PEBBLES)
    others = palette[order.rng.integers(len(palette), size=stones.count)]
    hues = base * (others / palette.mean(axis=0)) ** 0.8
    fine = tx.fractal(order, 0.004, 0.15)
    pebbles = hues[stones.index] * np.maximum(1.0 + 0.06 * fine, 0.3)[..., None]
    dome = np.sqrt(np.clip(inside / (0.3 * width), 0.0, 1.0))
    sunk = order.rng.uniform(0.6, 1.0, stones.count)[stones.index]
    mortar = cement * np.maximum((1.0 + 0.07 * fine) * (0.75 + 0.25 * (1.0 - on)), 0.1)[..., None]
    height = on * dome * sunk * 0.28 * width + (1.0 - on) * 0.00012 * fine
    rough = matt + 0.08 * (1.0 - on) - 0.06 * on * (sunk - 0.8)
    return tx.finished(order, tx.mixed(on, pebbles, 0.85 * mortar), height, rough)


def stucco(order: tx.TextureParams) -> tx.Maps:
    """Render thrown on with a machine and pressed flat on top: islands with crevices between."""
    color, matt = tx.drawn_color(order, RENDER, 0.05), tx.drawn_roughness(order, 0.85, 0.95)
    coarse = order.rng.uniform(0.012, 0.022)
    splash = tx.band_noise(order.rng, order.resolution, order.size, coarse)
    splash = splash + 1.3 * tx.fractal(order, 0.03, 0.25) + 0.5 * tx.noise(order, 0.12)
    sand = tx.fractal(order, 0.003, 0.1)
    flat = tx.smoothstep(-0.9, 0.6, splash)
    height = 0.0021 * flat + 0.0001 * splash + 60e-6 * sand
    shade = (0.84 + 0.16 * flat) * np.maximum(1.0 + 0.02 * sand + 0.015 * tx.noise(order, 0.4), 0.5)
    return tx.finished(order, shade[..., None] * color, height, matt + 0.02 * sand - 0.05 * flat)


def trowelled_plaster(order: tx.TextureParams) -> tx.Maps:
    """Lime or clay plaster in overlapping strokes of a trowel, each leaving a faint ridge."""
    color, matt = tx.drawn_color(order, PLASTER, 0.05), tx.drawn_roughness(order, 0.6, 0.8)
    height, tone = np.zeros((order.resolution,) * 2), np.zeros((order.resolution,) * 2)
    for width in (0.22, 0.15):
        warp = (0.06 * width * tx.noise(order, width), 0.06 * width * tx.noise(order, width))
        strokes = tx.scattered_cells(order, width, 1.0, warp)
        angle = order.rng.uniform(0.0, np.pi, strokes.count)[strokes.index]
        run = np.cos(angle) * strokes.across + np.sin(angle) * strokes.up
        ridge = np.exp(-((strokes.edge / 0.0025) ** 2))
        height = height + 0.0035 * run * 0.5 + 0.00022 * ridge
        tone = tone + order.rng.uniform(-1.0, 1.0, strokes.count)[strokes.index]
    cloud, fine = tx.fractal(order, 0.25, 0.4), tx.fractal(order, 0.004, 0.2)
    height = height + 0.0003 * cloud + 15e-6 * fine
    shade = np.maximum(1.0 + 0.018 * tone + 0.035 * cloud + 0.012 * fine, 0.4)
    return tx.finished(order, shade[..., None] * color, height, matt - 0.02 * tone + 0.02 * fine)


SLATE: Final[tuple[tx.Color, ...]] = _PALETTES["quarried_slate"]
TRAVERTINE: Final[tuple[tx.Color, ...]] = _PALETTES["quarried_travertine"]
SANDSTONE: Final[tuple[tx.Color, ...]] = _PALETTES["quarried_sandstone"]
BASALT: Final[tuple[tx.Color, ...]] = _PALETTES["quarried_basalt"]
LIMESTONE: Final[tuple[tx.Color, ...]] = _PALETTES["quarried_limestone"]
GROUT: Final[tuple[tx.Color, ...]] = ((0.28, 0.27, 0.26), (0.20, 0.195, 0.19))


def slate(order: tx.TextureParams) -> tx.Maps:
    """Riven slate in slabs of 0.6 x 0.3 m: layers split off along ragged steps."""
    color, matt = tx.drawn_color(order, SLATE), tx.drawn_roughness(order, 0.6, 0.78)
    slabs = tx.bond(order, (0.6, 0.3), 0.5, 2)
    bulk = tx.shifted_per_piece(order, tx.fractal(order, 0.3, 0.85), slabs.index, slabs.count)
    ragged = tx.shifted_per_piece(
        order, tx.fractal(order, 0.03, 0.4, 0.015), slabs.index, slabs.count
    )
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


def travertine(order: tx.TextureParams) -> tx.Maps:
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


def sandstone(order: tx.TextureParams) -> tx.Maps:
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


def basalt(order: tx.TextureParams) -> tx.Maps:
    """Sawn lava, full of round bubbles from 1 to 12 mm."""
    color, matt = tx.drawn_color(order, BASALT), tx.drawn_roughness(order, 0.65, 0.8)
    holes = tx.pits(order, order.rng.uniform(0.10, 0.2), (0.0006, 0.006), 1.25)
    hole = tx.covered(order, holes.inside)
    grain, cloud = tx.fractal(order, 0.0015, 0.05), tx.fractal(order, 0.15, 0.3)
    deep = np.sqrt(np.clip(holes.inside / 0.003, 0.0, 1.0))
    shade = np.maximum(1.0 + 0.10 * grain + 0.05 * cloud, 0.3) * (1.0 - 0.4 * deep)
    height = -0.0028 * deep * hole + 15e-6 * grain
    return tx.finished(order, shade[..., None] * color, height, matt + 0.03 * grain + 0.12 * hole)


def shell_limestone(order: tx.TextureParams) -> tx.Maps:
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


def _seams(order: tx.TextureParams) -> tx.Field:
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
    "cast_concrete": tx.Family(cast_concrete, 1.5, frozenset({"wall", "ceiling", "floor"})),
    "board_formed_concrete": tx.Family(board_formed_concrete, 2.0, frozenset({"wall", "ceiling"})),
    "exposed_aggregate": tx.Family(exposed_aggregate, 0.6, frozenset({"floor", "wall"})),
    "stucco": tx.Family(stucco, 0.8, frozenset({"wall", "ceiling"})),
    "trowelled_plaster": tx.Family(trowelled_plaster, 1.5, frozenset({"wall", "ceiling"})),
    "slate": tx.Family(slate, 1.2, frozenset({"floor", "wall"})),
    "travertine": tx.Family(travertine, 1.0, frozenset({"floor", "wall"})),
    "sandstone": tx.Family(sandstone, 1.0, frozenset({"floor", "wall"})),
    "basalt": tx.Family(basalt, 0.6, frozenset({"floor", "wall"})),
    "shell_limestone": tx.Family(shell_limestone, 0.8, frozenset({"floor", "wall", "worktop"})),
}
