"""Polished stone of many parts: crystals of granite, chips of terrazzo, grains of worktops.

Albedo of stone 0.2 to 0.35 and of concrete 0.1 to 0.35 (T. R. Oke, Boundary Layer Climates, 1987);
the colours of single kinds are chosen by eye.
"""

from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.tables import read_table

_PALETTES: Final = read_table(__file__, "palettes.toml")

WHITE: Final[tuple[tx.Color, ...]] = ((0.74, 0.73, 0.71), (0.68, 0.68, 0.68), (0.76, 0.73, 0.68))
VEIN: Final[tuple[tx.Color, ...]] = ((0.26, 0.27, 0.29), (0.34, 0.33, 0.32), (0.30, 0.25, 0.19))
BRECCIA: Final[tuple[tx.Color, ...]] = _PALETTES["veins_breccia"]
CALCITE: Final[tuple[tx.Color, ...]] = ((0.68, 0.64, 0.58), (0.60, 0.52, 0.42), (0.70, 0.70, 0.69))
ONYX: Final[tuple[tx.Color, ...]] = _PALETTES["veins_onyx"]
AGATE: Final[tuple[tx.Color, ...]] = _PALETTES["veins_agate"]
# What polishing leaves: harder veins stand out by some micrometres.
_POLISH: Final = 4e-6


def carrara_marble(order: tx.TextureParams) -> tx.Maps:
    """White marble with grey clouds and a slanting net of soft veins."""
    base, vein = tx.drawn_color(order, WHITE, 0.04), tx.side_color(order, VEIN)
    gloss = tx.drawn_roughness(order, 0.06, 0.16)
    net = marble_veins(order)
    cloud, fine = tx.fractal(order, 0.35, 0.4), tx.fractal(order, 0.003, 0.1)
    grey = np.clip(0.06 + 0.06 * cloud + 0.75 * net, 0.0, 0.9)
    albedo = tx.mixed(grey, vein * np.ones((1, 1, 3)), base * (1.0 + 0.012 * fine)[..., None])
    return tx.finished(order, albedo, _POLISH * (net + 0.1 * fine), gloss + 0.02 * net)


def marble_veins(order: tx.TextureParams) -> tx.Field:
    """(N, N) strength of veins, 0..1: few strong ones, more and finer beside them."""
    drift_s, drift_t = tx.fractal(order, 0.35, 0.9), tx.fractal(order, 0.35, 0.9)
    crumple = tx.fractal(order, 0.06, 0.5)
    strong = tx.displaced(_sheets(order, 0.9), order, 0.035 * drift_s, 0.035 * drift_t)
    weak = tx.displaced(_sheets(order, 0.4), order, 0.02 * drift_t, 0.02 * drift_s)
    swell = np.clip(0.6 + 0.55 * tx.noise(order, 0.3), 0.05, 1.6)
    rag = 1.0 + 0.35 * crumple
    wide = np.exp(-np.abs(strong) / (0.15 * swell)) * np.clip(rag, 0.2, 1.8) * 0.5
    core = np.exp(-((strong / (0.03 * swell)) ** 2)) * np.clip(swell, 0.2, 1.0) * 0.9
    thin = np.exp(-np.abs(weak) / 0.035) * np.clip(0.45 + 0.5 * tx.noise(order, 0.2), 0.0, 1.0)
    return np.clip(wide + core + 0.6 * thin, 0.0, 1.0)


def _sheets(order: tx.TextureParams, length: float) -> tx.Field:
    """(N, N) a noise whose zero lines run aslant: two noises, long along t, sheared and summed."""
    wave = tx.noise(order, length * 0.33, length)
    lean = order.rng.choice([-1, 1])
    rows = np.arange(order.resolution)
    # Shearing by a whole turn over the height keeps the wrap-around.
    shift = (lean * rows) % order.resolution
    return np.asarray(wave[rows[:, None], (rows[None, :] + shift[:, None]) % order.resolution])


def breccia_marble(order: tx.TextureParams) -> tx.Maps:
    """Angular fragments of 1 to 12 cm, healed by light calcite."""
    base, calcite = tx.drawn_color(order, BRECCIA), tx.side_color(order, CALCITE, 0.05)
    gloss = tx.drawn_roughness(order, 0.06, 0.16)
    rag_s, rag_t = tx.fractal(order, 0.1, 0.55), tx.fractal(order, 0.1, 0.55)
    large = tx.scattered_cells(order, 0.13, 1.0, (0.008 * rag_s, 0.008 * rag_t))
    small = tx.scattered_cells(order, 0.035, 1.0, (0.0025 * rag_t, 0.0025 * rag_s))
    # Some of the large pieces broke again.
    crushed = (order.rng.random(large.count) < 0.45)[large.index]
    index = np.where(crushed, large.count + small.index, large.index)
    edge = np.where(crushed, np.minimum(large.edge, 1.6 * small.edge), large.edge)
    open_ = np.clip(0.0022 + 0.0022 * tx.noise(order, 0.12), 0.0002, 0.02)
    vein = 1.0 - tx.smoothstep(0.0, 1.0, (edge - 0.3 * open_) / open_)
    tone = np.exp(0.38 * order.rng.uniform(-1.0, 1.0, large.count + small.count))[index]
    cloud = tx.fractal(order, 0.06, 0.3)
    palette = np.array(BRECCIA)
    others = palette[order.rng.integers(len(palette), size=len(palette) * 64)]
    hues = base * (others / palette.mean(axis=0)) ** 0.3
    pieces = hues[index % len(hues)] * (tone * np.maximum(1.0 + 0.10 * cloud, 0.3))[..., None]
    white = calcite * (1.0 + 0.03 * cloud)[..., None]
    return tx.finished(order, tx.mixed(vein, white, pieces), _POLISH * vein, gloss + 0.03 * vein)


def banded_onyx(order: tx.TextureParams) -> tx.Maps:
    """Bands laid down by a spring, flowing along s, some sharp and white, some deep."""
    color, gloss = tx.drawn_color(order, ONYX), tx.drawn_roughness(order, 0.05, 0.12)
    up = (np.arange(order.resolution)[:, None] + 0.5) / order.resolution
    flow = 0.16 * tx.noise(order, 0.7, 0.45) + 0.05 * tx.noise(order, 0.15, 0.1)
    flow = flow + 0.006 * tx.fractal(order, 0.03, 0.4)
    depth = up * order.size + 0.35 * flow
    band = _layers(order, depth, 0.55)
    haze, fine = tx.fractal(order, 0.2, 0.5), tx.fractal(order, 0.006, 0.2)
    tone = np.exp(0.30 * band + 0.06 * haze + 0.012 * fine)
    pale = tx.smoothstep(0.8, 1.9, band)
    hue = np.exp(np.multiply.outer(0.22 * band, (-0.25, -0.05, 0.55)))
    milk = np.array([0.74, 0.71, 0.65])
    albedo = tx.mixed(0.65 * pale, milk * np.ones((1, 1, 3)), color * hue * tone[..., None])
    return tx.finished(order, albedo, _POLISH * 0.5 * band, gloss + 0.01 * pale)


def agate(order: tx.TextureParams) -> tx.Maps:
    """Slices of nodules: rings that follow the wall of each hollow, crystals in its middle."""
    color, gloss = tx.drawn_color(order, AGATE), tx.drawn_roughness(order, 0.04, 0.10)
    width = order.rng.uniform(0.14, 0.20)
    rag_s, rag_t = tx.fractal(order, width, 0.8), tx.fractal(order, width, 0.8)
    hollow = tx.scattered_cells(order, width, 1.0, (0.06 * width * rag_s, 0.06 * width * rag_t))
    scallop = 0.0008 * np.abs(tx.noise(order, 0.012)) + 0.003 * tx.noise(order, 0.04)
    depth = hollow.edge + scallop
    own = order.rng.uniform(0.0, order.size, hollow.count)[hollow.index]
    band = _layers(order, (0.9 * depth + own) % order.size, 0.05)
    middle = tx.smoothstep(0.30 * width, 0.33 * width, depth)
    rind = 1.0 - tx.smoothstep(0.0005, 0.0022, hollow.edge)
    crystal = np.abs(tx.noise(order, 0.006)) - 0.6
    tint = np.exp(0.35 * order.rng.uniform(-1.0, 1.0, hollow.count))[hollow.index]
    tone = np.exp(0.3 * band * (1.0 - middle) + 0.12 * crystal * middle) * tint
    hue = np.exp(np.multiply.outer(0.2 * band * (1.0 - middle), (-0.4, 0.0, 0.3)))
    quartz = np.array([0.55, 0.54, 0.55]) * (1.0 + 0.2 * crystal)[..., None]
    body = tx.mixed(0.55 * middle, quartz, color * hue * tone[..., None])
    albedo = tx.mixed(0.75 * rind, np.full((1, 1, 3), 0.10), body)
    return tx.finished(order, albedo, _POLISH * band, gloss + 0.05 * rind)


def _layers(order: tx.TextureParams, depth: tx.Field, thickest: float) -> tx.Field:
    """(N, N) lightness of layers by their depth in metres, deviation 1; periodic over the size."""
    count = 2048
    frequency = np.fft.rfftfreq(count, order.size / count)
    draw = order.rng.random(count) - 0.5
    falling = (1.0 + (frequency * thickest) ** 2) ** -0.45 * (frequency < 1.0 / 0.0012)
    profile = np.fft.irfft(np.fft.rfft(draw) * falling, count)
    profile = profile - profile.mean()
    profile = profile / np.sqrt(np.mean(profile**2))
    place = depth / order.size * count
    wrapped = np.append(profile, profile[0])
    return np.asarray(np.interp(place % count, np.arange(count + 1), wrapped))


FELDSPAR: Final[tuple[tx.Color, ...]] = _PALETTES["aggregates_feldspar"]
CHIPS: Final[tuple[tx.Color, ...]] = _PALETTES["aggregates_chips"]
BINDER: Final[tuple[tx.Color, ...]] = ((0.62, 0.60, 0.56), (0.46, 0.45, 0.44), (0.54, 0.47, 0.40))
CEMENT: Final[tuple[tx.Color, ...]] = _PALETTES["aggregates_cement"]
QUARTZ: Final[tuple[tx.Color, ...]] = _PALETTES["aggregates_quartz"]


def granite(order: tx.TextureParams) -> tx.Maps:
    """Crystals of 3 to 10 mm: feldspar, grey quartz, black mica in clusters."""
    feldspar, gloss = tx.drawn_color(order, FELDSPAR), tx.drawn_roughness(order, 0.06, 0.15)
    width = order.rng.uniform(0.005, 0.009)
    rag = (
        0.14 * width * tx.noise(order, 0.35 * width),
        0.14 * width * tx.noise(order, 0.35 * width),
    )
    crystals = tx.scattered_cells(order, width, 1.0, rag)
    cluster = tx.noise(order, 4.0 * width)
    # Which mineral: by lot, but the dark ones keep together.
    lot = order.rng.random(crystals.count)[crystals.index] + 0.13 * cluster
    quartz = tx.covered(order, (lot - 0.60) * width)
    mica = tx.covered(order, (lot - 0.87) * width)
    speck = tx.smoothstep(1.4, 1.9, tx.noise(order, 0.0022) + 0.5 * cluster)
    tone = np.exp(0.2 * order.rng.uniform(-1.0, 1.0, crystals.count))[crystals.index]
    fine = tx.fractal(order, 0.004, 0.2)
    body = feldspar * (tone * np.maximum(1.0 + 0.05 * fine, 0.4))[..., None]
    clear = np.array([0.24, 0.24, 0.245]) * tone[..., None]
    black = np.array([0.035, 0.034, 0.034]) * np.ones((1, 1, 3))
    albedo = tx.mixed(quartz, clear, body)
    albedo = tx.mixed(np.maximum(mica, speck * (1.0 - quartz)), black, albedo)
    height = -6e-6 * np.maximum(mica, speck) + 1e-6 * fine
    return tx.finished(order, albedo, height, gloss + 0.06 * mica - 0.01 * quartz)


def black_galaxy_granite(order: tx.TextureParams) -> tx.Maps:
    """Black gabbro, fine-grained, with scattered flakes of bronzite that shine like gold."""
    color = tx.drawn_color(order, ((0.026, 0.026, 0.027), (0.034, 0.033, 0.033)), 0.05)
    gloss = tx.drawn_roughness(order, 0.05, 0.10)
    flakes = tx.chips(order, 0.028, (0.0006, 0.0024), (4, 6))
    shine = (
        tx.covered(order, flakes.inside) * order.rng.uniform(0.25, 1.0, flakes.count)[flakes.index]
    )
    grain = tx.fractal(order, 0.004, 0.1)
    lath = tx.lines(
        order, int(4000 * order.size**2 / 0.25), (0.002, 0.006), 0.0, (0.0, 2.0 * np.pi)
    )
    gold = np.array([0.52, 0.38, 0.19]) * np.ones((1, 1, 3))
    dark = color * np.maximum(1.0 + 0.16 * grain + 0.5 * np.minimum(lath, 1.0), 0.5)[..., None]
    height = 2e-6 * grain + 4e-6 * shine
    return tx.finished(order, tx.mixed(0.85 * shine, gold, dark), height, gloss + 0.08 * shine)


def terrazzo(order: tx.TextureParams) -> tx.Maps:
    """Chips of marble from 2 to 20 mm in a ground binder."""
    binder, gloss = tx.side_color(order, BINDER, 0.06), tx.drawn_roughness(order, 0.1, 0.25)
    stones = tx.chips(
        order, order.rng.uniform(0.6, 0.95), (0.0018, order.rng.uniform(0.008, 0.014))
    )
    on = tx.covered(order, stones.inside)
    kinds = order.rng.integers(0, 4, stones.count)
    tone = np.exp(0.14 * order.rng.uniform(-1.0, 1.0, stones.count))
    hues = np.stack(
        [
            tx.drawn_color(order, CHIPS) if kind == 0 else tx.side_color(order, CHIPS)
            for kind in range(4)
        ]
    )
    cloud, fine = tx.fractal(order, 0.02, 0.35), tx.fractal(order, 0.003, 0.1)
    bodies = (hues[kinds] * tone[:, None])[stones.index] * (1.0 + 0.05 * cloud)[..., None]
    ground = binder * np.maximum(1.0 + 0.03 * fine + 0.02 * tx.noise(order, 0.3), 0.4)[..., None]
    rim = np.exp(-((stones.inside / 0.0004) ** 2))
    albedo = tx.mixed(on, bodies, ground) * (1.0 - 0.06 * rim)[..., None]
    height = 5e-6 * on - 8e-6 * rim + 1e-6 * fine
    return tx.finished(order, albedo, height, gloss - 0.03 * on)


def quartz_worktop(order: tx.TextureParams) -> tx.Maps:
    """Engineered stone: grains of quartz of 0.5 to 3 mm pressed in resin, even everywhere."""
    color, gloss = tx.drawn_color(order, QUARTZ, 0.06), tx.drawn_roughness(order, 0.1, 0.22)
    grains = tx.scattered_cells(order, order.rng.uniform(0.0018, 0.0026), 1.0)
    lot = order.rng.random(grains.count)
    step = np.where(lot < 0.12, -0.42, np.where(lot > 0.9, 0.3, 0.2 * (lot - 0.5)))
    resin = 1.0 - tx.smoothstep(0.0001, 0.0004, grains.edge)
    fine = tx.fractal(order, 0.002, 0.1)
    tone = np.exp(step)[grains.index] * (1.0 - 0.05 * resin) * np.maximum(1.0 + 0.03 * fine, 0.5)
    glint = (order.rng.random(grains.count) < 0.012)[grains.index] * (1.0 - resin)
    mirror = np.full((1, 1, 3), 0.72)
    albedo = tx.mixed(0.8 * glint, mirror, color * tone[..., None])
    return tx.finished(order, albedo, -3e-6 * resin + 0.5e-6 * fine, gloss - 0.05 * glint)


def polished_concrete(order: tx.TextureParams) -> tx.Maps:
    """A slab ground until its sand shows, clouded by the trowel, with hairline cracks."""
    color, gloss = tx.drawn_color(order, CEMENT), tx.drawn_roughness(order, 0.2, 0.38)
    cloud = tx.fractal(order, 0.6, 0.3)
    sweep = trowel_arcs(order)
    stones = tx.chips(order, 0.05, (0.0025, 0.007), (5, 8))
    bare = tx.smoothstep(-0.6, 0.8, tx.noise(order, 0.35))
    on = tx.covered(order, stones.inside) * bare
    tint = order.rng.uniform(-0.30, 0.22, stones.count)[stones.index]
    crack = hairlines(order, 0.7, 0.0004)
    fine = tx.fractal(order, 0.003, 0.1)
    shade = 1.0 + 0.10 * cloud + 0.04 * sweep + 0.03 * fine + on * tint
    shade = np.maximum(shade, 0.3) * (1.0 - 0.4 * crack)
    height = 0.0002 * tx.noise(order, 0.7) + 1.5e-6 * fine - 40e-6 * crack
    rough = gloss + 0.035 * cloud + 0.015 * sweep - 0.05 * on + 0.2 * crack
    return tx.finished(order, shade[..., None] * color, height, rough)


def trowel_arcs(order: tx.TextureParams) -> tx.Field:
    """(N, N) arcs that a power trowel leaves, deviation about 1."""
    passes = tx.scattered_cells(order, 0.45)
    ring = np.cos(passes.radius * 2.0 * np.pi / 0.035 + 4.0 * tx.noise(order, 0.2))
    return np.asarray(ring * tx.smoothstep(0.0, 0.06, passes.edge))


def hairlines(order: tx.TextureParams, width: float, opening: float) -> tx.Field:
    """(N, N) cracks, 0..1, between plates of a given width; they fade in and out."""
    rag = 0.05 * width * tx.fractal(order, width / 2, 0.6)
    edge = tx.scattered_cells(order, width, 1.0, (rag, -rag)).edge
    texel = order.size / order.resolution
    strength = np.clip(0.2 + 0.7 * tx.noise(order, 0.6 * width), 0.0, 1.0)
    return (
        strength
        * np.clip((opening / 2 + texel - edge) / texel, 0.0, 1.0)
        * min(1.0, opening / texel)
    )


FAMILIES: Final[dict[str, tx.Family]] = {
    "carrara_marble": tx.Family(carrara_marble, 1.5, frozenset({"floor", "wall", "worktop"})),
    "breccia_marble": tx.Family(breccia_marble, 1.0, frozenset({"floor", "wall", "worktop"})),
    "banded_onyx": tx.Family(banded_onyx, 1.0, frozenset({"wall", "worktop", "object"})),
    "agate": tx.Family(agate, 0.6, frozenset({"worktop", "object"})),
    "granite": tx.Family(granite, 0.6, frozenset({"floor", "wall", "worktop"})),
    "black_galaxy_granite": tx.Family(
        black_galaxy_granite, 0.5, frozenset({"floor", "wall", "worktop"})
    ),
    "terrazzo": tx.Family(terrazzo, 0.6, frozenset({"floor", "wall", "worktop"})),
    "quartz_worktop": tx.Family(quartz_worktop, 0.4, frozenset({"worktop", "wall"})),
    "polished_concrete": tx.Family(polished_concrete, 1.5, frozenset({"floor"})),
}
