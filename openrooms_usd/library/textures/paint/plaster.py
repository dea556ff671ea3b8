"""Families of painted plaster: what trowel, sponge, rag and hopper gun leave on walls."""

from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.tables import read_table

_PALETTES: Final = read_table(__file__, "palettes.toml")

MILK: Final[tuple[tx.Color, ...]] = _PALETTES["worn_milk"]
_WOOD: Final = np.array((0.25, 0.155, 0.085))
_PLASTER: Final = np.array((0.56, 0.52, 0.46))


def _crackled(order: tx.TextureParams) -> tx.Maps:
    """Paint over crackle glaze: fields within fields, the ground in the cracks."""
    warp = 0.0015 * tx.noise(order, 0.01), 0.0015 * tx.noise(order, 0.01)
    large = tx.scattered_cells(order, 0.022, 1.0, warp)
    small = tx.scattered_cells(order, 0.008, 1.0, warp)
    width = 0.0004 + 0.00025 * tx.noise(order, 0.05).clip(-1.2, 2.0)
    crack = np.maximum(
        tx.smoothstep(0.0, 1.0, (width - large.edge) / 0.0003 + 1.0),
        tx.smoothstep(0.0, 1.0, (0.5 * width - small.edge) / 0.0003 + 0.6),
    )
    tone = order.rng.uniform(-0.04, 0.04, large.count)[large.index]
    paint = tx.drawn_color(order, MILK) * (1.0 + tone)[..., None]
    curl = np.exp(-large.edge / 0.0018)
    height = (0.12e-3 + 0.05e-3 * curl) * (1.0 - crack)
    roughness = tx.drawn_roughness(order, 0.5, 0.7) + 0.15 * crack
    return tx.finished(order, tx.mixed(crack, _WOOD, paint), height, roughness)


def _chalk(order: tx.TextureParams) -> tx.Maps:
    """Chalk paint: brushed both ways, sanded back here and there, dark wax in the furrows."""
    color = tx.drawn_color(order, MILK)
    furrow = tx.noise(order, 0.0016, 0.05) + 0.7 * tx.noise(order, 0.05, 0.0016)
    wax = tx.smoothstep(0.4, 2.2, -furrow)
    rub = tx.smoothstep(1.5, 2.3, tx.fractal(order, 0.15, 0.4) + 0.35 * furrow)
    shade = (1.0 + 0.02 * furrow) * (1.0 - 0.22 * wax)
    albedo = tx.mixed(rub, _WOOD * 1.3, color * shade[..., None])
    height = 16e-6 * furrow - 60e-6 * rub
    return tx.finished(order, albedo, height, tx.drawn_roughness(order, 0.7, 0.88) - 0.15 * wax)


def _flaking(order: tx.TextureParams) -> tx.Maps:
    """Old wall paint that has come off in flakes down to the plaster."""
    patch = tx.fractal(order, 0.4, 0.5)
    shards = tx.scattered_cells(order, 0.03, 1.0, (0.002 * tx.noise(order, 0.01), 0.002 * patch))
    lost = patch + 0.5 * order.rng.uniform(-1.0, 1.0, shards.count)[shards.index]
    bare = tx.smoothstep(0.75, 0.79, lost)
    crack = tx.smoothstep(0.0009, 0.0, shards.edge) * tx.smoothstep(0.0, 0.6, lost) * (1.0 - bare)
    lip = np.exp(-np.abs(lost - 0.72) / 0.05) * (1.0 - bare)
    color = tx.drawn_color(order, MILK)
    ground = _PLASTER * (1.0 + 0.08 * tx.fractal(order, 0.05, 0.3))[..., None]
    paint = color * (1.0 + 0.03 * patch)[..., None] * (1.0 - 0.5 * crack)[..., None]
    height = 0.3e-3 * (1.0 - bare) + 0.2e-3 * lip - 0.2e-3 * crack + 30e-6 * tx.noise(order, 0.004)
    roughness = tx.drawn_roughness(order, 0.6, 0.8) + 0.15 * bare
    return tx.finished(order, tx.mixed(bare, ground, paint), height, roughness)


def _embossed(order: tx.TextureParams) -> tx.Maps:
    """Embossed wallpaper: rosettes and a diaper pattern, pressed into soft paper, painted over."""
    count = tx.whole(order.size, 0.12)
    place = (np.arange(order.resolution) + 0.5) / order.resolution * count
    s, t = 2.0 * np.pi * place[None, :], 2.0 * np.pi * place[:, None]
    x, y = (place[None, :] % 1.0) - 0.5, (place[:, None] % 1.0) - 0.5
    petals = np.hypot(x, y) - 0.2 - 0.09 * np.cos(8.0 * np.arctan2(y, x))
    flower = tx.smoothstep(0.03, -0.03, petals)
    heart = tx.smoothstep(0.06, 0.03, np.abs(np.hypot(x, y) - 0.07))
    lattice = tx.smoothstep(0.25, 0.0, np.abs(np.cos(s / 2.0) * np.cos(t / 2.0))) * (1.0 - flower)
    relief = flower * (0.7 - 0.45 * heart) + 0.6 * lattice
    stipple = tx.band_noise(order.rng, order.resolution, order.size, 0.0022)
    color = tx.drawn_color(order, ((0.78, 0.77, 0.73), (0.62, 0.62, 0.57), (0.36, 0.42, 0.38)))
    shade = 1.0 + 0.005 * stipple + 0.02 * relief
    height = 0.9e-3 * relief + 14e-6 * stipple
    return tx.shaded(order, color, shade, height, (0.55, 0.8))


EARTHS: Final[tuple[tx.Color, ...]] = _PALETTES["plaster_earths"]
WHITES: Final[tuple[tx.Color, ...]] = ((0.80, 0.79, 0.77), (0.76, 0.75, 0.72), (0.70, 0.69, 0.66))


def _limewash(order: tx.TextureParams) -> tx.Maps:
    """Thin coats of lime brushed crosswise: clouds, and strokes of a wide brush all ways."""
    strokes = tx.flakes(order, 2.5, (0.12, 0.28), (0.05, 0.09), spread=1.4)
    tone = strokes.each(order.rng.uniform(-1.0, 1.0, strokes.count))
    bristle = strokes.fibre(order, 0.002, 0.1)
    edge = tx.smoothstep(0.0, 0.03, strokes.inside)
    cloud = tx.fractal(order, 0.3, 0.5)
    shade = 1.0 + edge * (0.03 * tone + 0.02 * bristle) + 0.025 * cloud
    color = tx.drawn_color(order, EARTHS, 0.06)
    height = 20e-6 * bristle * edge + 60e-6 * tx.noise(order, 0.03)
    return tx.shaded(order, color, shade, height, (0.8, 0.95))


def _venetian(order: tx.TextureParams) -> tx.Maps:
    """Polished lime plaster: thin layers of a trowel's breadth, veined where they overlap."""
    strokes = tx.flakes(order, 2.2, (0.06, 0.16), (0.025, 0.06), spread=np.pi)
    tone = strokes.each(order.rng.uniform(-1.0, 1.0, strokes.count))
    edge = tx.smoothstep(0.0015, 0.0, strokes.inside)
    cloud = tx.fractal(order, 0.12, 0.5)
    color = tx.drawn_color(order, EARTHS, 0.06)
    shade = 1.0 + 0.07 * tone + 0.05 * cloud - 0.07 * edge
    burnish = 0.06 * tone + 0.04 * cloud
    height = 12e-6 * strokes.level + 6e-6 * tone + 10e-6 * tx.noise(order, 0.02)
    roughness = tx.drawn_roughness(order, 0.22, 0.38) - burnish + 0.08 * edge
    return tx.finished(order, color * shade[..., None], height, np.maximum(roughness, 0.1))


def _troweled(order: tx.TextureParams) -> tx.Maps:
    """Skip trowel: mud drawn in thin arcs, each ending in a ridge."""
    strokes = tx.flakes(order, 0.8, (0.10, 0.22), (0.04, 0.10), spread=np.pi)
    ridge = np.exp(-strokes.inside / 0.0035) * (strokes.index > 0)
    slope = np.clip(strokes.across / 0.05, -1.0, 1.0)
    ragged = tx.smoothstep(-0.4, 0.8, tx.noise(order, 0.014) + 0.5 * slope)
    height = 1.1e-3 * ridge * ragged + 0.5e-3 * slope * ragged + 0.06e-3 * tx.noise(order, 0.006)
    color = tx.drawn_color(order, WHITES, 0.04)
    shade = 1.0 + 0.01 * ragged
    return tx.shaded(order, color, shade, height, (0.75, 0.9))


def _knockdown(order: tx.TextureParams) -> tx.Maps:
    """Sprayed mud, knocked flat with a knife: islands with flat tops."""
    blob = tx.band_noise(order.rng, order.resolution, order.size, 0.020) + 0.5 * tx.noise(
        order, 0.008
    )
    island = tx.smoothstep(0.55, 0.85, blob)
    stipple = tx.band_noise(order.rng, order.resolution, order.size, 0.003)
    height = 0.8e-3 * island + 15e-6 * stipple + 0.05e-3 * tx.noise(order, 0.15)
    color = tx.drawn_color(order, WHITES, 0.04)
    shade = 1.0 + 0.006 * stipple + 0.006 * island
    return tx.shaded(order, color, shade, height, (0.75, 0.9))


def _splatter(order: tx.TextureParams) -> tx.Maps:
    """Orange-peel drywall: drops of mud from a hopper gun, round and of all sizes."""
    drops = tx.pits(order, 0.55, (0.0015, 0.006))
    dome = np.sqrt(np.clip(drops.inside, 0.0, 0.006) / 0.006)
    stipple = tx.band_noise(order.rng, order.resolution, order.size, 0.003)
    height = 0.55e-3 * dome + 15e-6 * stipple
    color = tx.drawn_color(order, WHITES, 0.04)
    shade = 1.0 + 0.006 * stipple
    return tx.shaded(order, color, shade, height, (0.75, 0.9))


def _popcorn(order: tx.TextureParams) -> tx.Maps:
    """Acoustic ceiling spray: crumbs that stand on each other."""
    coarse = tx.band_noise(order.rng, order.resolution, order.size, 0.009)
    fine = tx.band_noise(order.rng, order.resolution, order.size, 0.0045)
    crumb = np.maximum(coarse, fine - 0.2)
    lump = tx.smoothstep(-0.3, 1.8, crumb)
    height = 3e-3 * lump + 0.25e-3 * fine
    color = tx.drawn_color(order, WHITES, 0.04)
    # Deep hollows see little of the room.
    shade = 0.8 + 0.24 * lump
    return tx.shaded(order, color, shade, height, (0.88, 0.97))


def _sponged(order: tx.TextureParams) -> tx.Maps:
    """Distemper dabbed on with a sponge: blots full of holes, in two tones."""
    dab = tx.smoothstep(0.1, 0.5, tx.noise(order, 0.03) + 0.55 * tx.noise(order, 0.004))
    second = tx.smoothstep(0.4, 0.8, tx.noise(order, 0.035) + 0.6 * tx.noise(order, 0.005))
    color = tx.drawn_color(order, EARTHS, 0.06)
    shade = 1.0 - 0.16 * dab + 0.13 * second
    height = 35e-6 * (dab + second) + 12e-6 * tx.noise(order, 0.0025)
    return tx.shaded(order, color, shade, height, (0.8, 0.94))


def _rag_rolled(order: tx.TextureParams) -> tx.Maps:
    """Glaze rolled with a crumpled rag: sharp folds that run together."""
    folded = np.abs(tx.noise(order, 0.022)) + 0.5 * np.abs(tx.noise(order, 0.010))
    crease = tx.displaced(
        folded, order, 0.006 * tx.noise(order, 0.02), 0.006 * tx.noise(order, 0.02)
    )
    lift = np.exp(-crease / 0.4)
    color = tx.drawn_color(order, EARTHS, 0.06)
    shade = 1.15 - 0.35 * lift
    roughness = tx.drawn_roughness(order, 0.45, 0.65) + 0.06 * lift
    return tx.finished(order, color * shade[..., None], 10e-6 * lift, roughness)


def _combed(order: tx.TextureParams) -> tx.Maps:
    """Textured plaster drawn with a notched comb in overlapping half circles."""
    count = max(2, 2 * round(order.size / 0.2 / 2))
    place = (np.arange(order.resolution) + 0.5) / order.resolution * count
    high = np.full((order.resolution, order.resolution), 0.0)
    unit = order.size / count
    done = np.zeros(high.shape, dtype=bool)
    # Scales from the bottom up: lower rows lie over higher ones, every second one shifted by half.
    for lower in (0, 1, 2):
        row = np.floor(place * 2.0).astype(np.int64)[:, None] + lower
        down = row + 1.0 - 2.0 * place[:, None]
        shift = 0.5 * (row % 2)
        across = (place[None, :] + shift) % 1.0 - 0.5
        far = np.hypot(across, 0.5 * down) * unit
        mine = ~done & (far < 0.56 * unit)
        groove = np.abs(np.sin(np.pi * (far / 0.009))) ** 0.7
        high[mine] = groove[mine]
        done |= mine
    wobble = tx.noise(order, 0.01)
    height = 0.9e-3 * high + 0.05e-3 * wobble
    color = tx.drawn_color(order, WHITES, 0.04)
    shade = 0.96 + 0.05 * high
    return tx.shaded(order, color, shade, height, (0.75, 0.9))


def _rough_render(order: tx.TextureParams) -> tx.Maps:
    """Scratched render under paint: grains that were dragged have left furrows."""
    furrows = tx.pits(order, 0.3, (0.0012, 0.003), 1.0)
    drag = tx.smoothstep(0.9, 1.5, tx.noise(order, 0.003, 0.02))
    grain = tx.band_noise(order.rng, order.resolution, order.size, 0.0025)
    hole = np.clip(furrows.inside / 0.002, 0.0, 1.0)
    height = 0.18e-3 * grain - 0.8e-3 * drag - 0.3e-3 * hole
    color = tx.drawn_color(order, EARTHS, 0.06)
    shade = 1.0 + 0.02 * grain - 0.10 * drag
    albedo = tx.mixed(hole, 0.93 * color, color * shade[..., None])
    return tx.finished(order, albedo, height, tx.drawn_roughness(order, 0.85, 0.96))


_INSIDE: Final[frozenset[tx.Use]] = frozenset({"wall", "ceiling"})
_WALLS: Final[frozenset[tx.Use]] = frozenset({"wall"})

FAMILIES: Final[dict[str, tx.Family]] = {
    "chalk_paint": tx.Family(_chalk, 0.5, frozenset({"furniture", "object"})),
    "crackled_paint": tx.Family(_crackled, 0.35, frozenset({"furniture", "object"})),
    "embossed_wallpaper": tx.Family(_embossed, 0.6, frozenset({"wall", "ceiling"})),
    "flaking_paint": tx.Family(_flaking, 1.2, frozenset({"wall"})),
    "combed_plaster": tx.Family(_combed, 0.8, _INSIDE),
    "knockdown": tx.Family(_knockdown, 0.5, _INSIDE),
    "limewash": tx.Family(_limewash, 1.6, _INSIDE),
    "orange_peel": tx.Family(_splatter, 0.4, _INSIDE),
    "popcorn_ceiling": tx.Family(_popcorn, 0.4, frozenset({"ceiling"})),
    "rag_rolled": tx.Family(_rag_rolled, 0.8, _WALLS),
    "scratched_render": tx.Family(_rough_render, 0.4, _WALLS, grain=True),
    "skip_trowel": tx.Family(_troweled, 1.0, _INSIDE),
    "sponged_distemper": tx.Family(_sponged, 0.8, _INSIDE),
    "venetian_plaster": tx.Family(_venetian, 1.0, _WALLS),
}
