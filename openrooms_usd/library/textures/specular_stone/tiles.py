"""Glazed and polished tiles: what is on each, and the grout between.

Joints of 1 to 2 mm, as for rectified and glazed tiles. The colours are chosen by eye.
"""

from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.library.textures.specular_stone.aggregates import marble_veins
from openrooms_usd.tables import read_table

_PALETTES: Final = read_table(__file__, "palettes.toml")

PORCELAIN: Final[tuple[tx.Color, ...]] = _PALETTES["tiles_porcelain"]
GLAZE: Final[tuple[tx.Color, ...]] = _PALETTES["tiles_glaze"]
MOSAIC: Final[tuple[tx.Color, ...]] = _PALETTES["tiles_mosaic"]
ZELLIGE: Final[tuple[tx.Color, ...]] = _PALETTES["tiles_zellige"]
GROUT: Final[tuple[tx.Color, ...]] = ((0.52, 0.51, 0.49), (0.36, 0.355, 0.35), (0.60, 0.59, 0.57))
DARK_GROUT: Final[tuple[tx.Color, ...]] = ((0.17, 0.165, 0.16), (0.22, 0.21, 0.20))
DARK_STONE: Final = (0.045, 0.045, 0.048)
LIGHT_VEIN: Final = (0.45, 0.43, 0.40)

GLAZED: Final = (0.05, 0.13)
POLISHED: Final = (0.07, 0.18)


def porcelain_tiles(order: tx.TextureParams) -> tx.Maps:
    """Rectified tiles of 0.6 x 0.6 m that imitate a clouded stone, joints of 2 mm."""
    floor = tx.bond(order, (0.6, 0.6))
    color, gloss = tx.drawn_color(order, PORCELAIN), tx.drawn_roughness(order, 0.12, 0.4)
    cloud = tx.shifted_per_piece(order, tx.fractal(order, 0.35, 0.45), floor.index, floor.count)
    vein = tx.shifted_per_piece(
        order, np.abs(tx.fractal(order, 0.25, 0.8)), floor.index, floor.count
    )
    fine = tx.fractal(order, 0.004, 0.1)
    print_ = 1.0 + 0.07 * cloud + 0.02 * fine + 0.08 * tx.smoothstep(0.12, 0.0, vein)
    inside = floor.inside(0.002, 0.0005)
    body = color * np.maximum(print_, 0.3)[..., None]
    relief = 0.0012 + 0.0004 * tx.smoothstep(0.0, 0.0006, inside) + 0.5e-6 * cloud
    lippage = 0.0002 * order.rng.uniform(-1.0, 1.0, floor.count)[floor.index]
    return _grouted(order, inside, body, relief + lippage, gloss + 0.015 * cloud, DARK_GROUT)


def subway_tiles(order: tx.TextureParams) -> tx.Maps:
    """Glazed tiles of 150 x 75 mm in running bond, edges rounded by the glaze, joints of 2 mm."""
    wall = tx.bond(order, (0.152, 0.077), 0.5, 2)
    inside = wall.inside(0.002, 0.0025)
    wave = tx.shifted_per_piece(order, tx.noise(order, 0.05), wall.index, wall.count)
    relief = 0.0009 + 0.0016 * _pillow(inside, 0.006) + 0.00006 * wave
    return _glazed(order, wall.index, wall.count, inside, relief, GLAZE, varied=0.025)


def hexagon_mosaic(order: tx.TextureParams) -> tx.Maps:
    """Matt porcelain hexagons of 50 mm in two tones, joints of 2 mm."""
    cells = tx.hexagons(order, 0.052)
    inside = cells.edge - 0.001
    relief = 0.0007 + 0.0008 * _pillow(inside, 0.0015)
    return _glazed(
        order,
        cells.index,
        cells.count,
        inside,
        relief,
        MOSAIC,
        varied=0.05,
        gloss=(0.25, 0.4),
        accents=0.16,
    )


def penny_mosaic(order: tx.TextureParams) -> tx.Maps:
    """Glazed discs of 19 mm, closely packed, 21 mm apart."""
    cells = tx.hexagons(order, 0.021)
    inside = 0.0095 - cells.radius
    relief = 0.0007 + 0.0009 * _pillow(inside, 0.0025)
    return _glazed(order, cells.index, cells.count, inside, relief, GLAZE, varied=0.06)


def fish_scale_tiles(order: tx.TextureParams) -> tx.Maps:
    """Glazed scallops, 0.12 m wide, that overlap like scales, joints of 2 mm."""
    laid = tx.scales(order, 0.12)
    inside = laid.edge - 0.001
    wave = tx.shifted_per_piece(order, tx.noise(order, 0.04), laid.index, laid.count)
    relief = 0.0008 + 0.0014 * _pillow(inside, 0.005) + 0.00005 * wave
    return _glazed(order, laid.index, laid.count, inside, relief, GLAZE, varied=0.16)


def zellige(order: tx.TextureParams) -> tx.Maps:
    """Moroccan tiles of 100 mm, cut by hand and set almost without joints: none is flat or even."""
    wall = tx.bond(order, (0.101, 0.101))
    inside = wall.inside(0.001, 0.001, 0.0004 * tx.noise(order, 0.015))
    wave = tx.shifted_per_piece(order, tx.noise(order, 0.045), wall.index, wall.count)
    slope = order.rng.uniform(-0.014, 0.014, (2, wall.count))[:, wall.index]
    chip = tx.covered(order, 0.0016 * (tx.fractal(order, 0.01, 0.3) - 1.5) - inside)
    tilt = slope[0] * wall.across + slope[1] * wall.up
    relief = 0.0028 + tilt + 0.0003 * wave + 0.0009 * _pillow(inside, 0.002) - 0.0006 * chip
    maps = _glazed(
        order, wall.index, wall.count, inside, relief, ZELLIGE, varied=0.24, cloud=0.07 * wave
    )
    clay = np.array([0.52, 0.40, 0.29]) * np.ones((1, 1, 3))
    bare = chip * tx.covered(order, inside)
    rough = maps.roughness + 0.5 * bare
    return tx.finished(order, tx.mixed(0.85 * bare, clay, maps.albedo), maps.height, rough)


def checkerboard_marble(order: tx.TextureParams) -> tx.Maps:
    """Tiles of light and dark marble by turns, 0.3 x 0.3 m, joints of 1.5 mm."""
    columns = tx.whole(order.size, 0.3, 2)
    floor = tx.bond(order, (order.size / columns, order.size / columns))
    dark = ((floor.index % columns + floor.course) % 2).astype(float)
    vein = tx.shifted_per_piece(order, marble_veins(order), floor.index, floor.count)
    light, gloss = tx.side_color(order, ((0.72, 0.70, 0.66), (0.66, 0.65, 0.63)), 0.05), POLISHED
    pale = light * np.maximum(1.0 - 0.45 * vein, 0.1)[..., None]
    deep = tx.mixed(0.55 * vein, np.full((1, 1, 3), LIGHT_VEIN), np.full((1, 1, 3), DARK_STONE))
    inside = floor.inside(0.0015, 0.0003)
    relief = 0.0008 + 0.0002 * tx.smoothstep(0.0, 0.0005, inside)
    return _grouted(
        order, inside, tx.mixed(dark, deep, pale), relief, tx.drawn_roughness(order, *gloss)
    )


def crackle_glaze(order: tx.TextureParams) -> tx.Maps:
    """Large tiles whose glaze has crazed: wide cracks first, finer ones between, stained."""
    color, gloss = (
        tx.drawn_color(order, GLAZE[:2] + GLAZE[4:5], 0.05),
        tx.drawn_roughness(order, *GLAZED),
    )
    rag = 0.0006 * tx.noise(order, 0.008)
    coarse = tx.scattered_cells(order, 0.022, 1.0, (rag, -rag))
    fine = tx.scattered_cells(order, 0.009, 1.0, (0.5 * rag, 0.5 * rag))
    texel = order.size / order.resolution
    first = np.clip((0.00015 + texel - coarse.edge) / texel, 0.0, 1.0)
    second = np.clip((0.00008 + texel - fine.edge) / texel, 0.0, 1.0)
    second = second * tx.smoothstep(-0.4, 0.8, tx.noise(order, 0.07))
    crack = np.maximum(first, 0.6 * second)
    pool = tx.fractal(order, 0.08, 0.7)
    stain = tx.side_color(order, ((0.20, 0.13, 0.08), (0.12, 0.12, 0.13)))
    body = color * np.maximum(1.0 + 0.035 * pool, 0.5)[..., None]
    albedo = tx.mixed(0.75 * crack, stain * np.ones((1, 1, 3)), body)
    height = 25e-6 * pool - 30e-6 * crack
    return tx.finished(order, albedo, height, gloss + 0.12 * crack)


def _glazed(
    order: tx.TextureParams,
    index: tx.Index,
    count: int,
    inside: tx.Field,
    relief: tx.Field,
    palette: tuple[tx.Color, ...],
    *,
    varied: float,
    gloss: tuple[float, float] = GLAZED,
    cloud: tx.Field | float = 0.0,
    accents: float = 0.0,
) -> tx.Maps:
    """Glazed pieces of one colour in grout.

    Args:
        order: What is asked for.
        index: (N, N) piece.
        count: How many there are.
        inside: (N, N) distance inside the piece's edge, metres.
        relief: (N, N) height of the piece above the grout, metres.
        palette: Colours to draw from.
        varied: How much pieces differ in lightness.
        gloss: Range of the roughness.
        cloud: (N, N) light and dark within the pieces.
        accents: Share of pieces of a second colour.
    """
    color, other = tx.drawn_color(order, palette, 0.05), tx.side_color(order, palette)
    shine = tx.drawn_roughness(order, *gloss)
    tone = np.exp(varied * order.rng.uniform(-1.0, 1.0, count))
    second = order.rng.random(count) < accents
    hues = np.where(second[:, None], other, color) * tone[:, None]
    # Glaze runs off the edges while it melts, and the body shows through.
    thin = 1.0 - 0.10 * np.exp(-np.maximum(inside, 0.0) / 0.0012)
    body = hues[index] * (np.exp(cloud) * thin)[..., None]
    rough = shine + 0.01 * tx.noise(order, 0.08)
    return _grouted(order, inside, body, relief, rough)


def _grouted(
    order: tx.TextureParams,
    inside: tx.Field,
    body: tx.Field,
    relief: tx.Field,
    roughness: tx.Field | float,
    palette: tuple[tx.Color, ...] = GROUT,
) -> tx.Maps:
    """Pieces with grout between them, whose height is 0."""
    grout, sand = tx.side_color(order, palette), tx.fractal(order, 0.002, 0.1)
    on = tx.covered(order, inside)
    joint = grout * np.maximum(1.0 + 0.04 * sand + 0.05 * tx.noise(order, 0.2), 0.3)[..., None]
    height = on * relief + (1.0 - on) * 25e-6 * sand
    rough = on * roughness + (1.0 - on) * 0.85
    return tx.finished(order, tx.mixed(on, body, joint), height, rough)


def _pillow(inside: tx.Field, width: float) -> tx.Field:
    """0 at an edge, 1 beyond ``width`` metres inside, round as glaze is."""
    fall = 1.0 - np.clip(inside / width, 0.0, 1.0)
    return np.asarray(np.sqrt(1.0 - fall**2))


FAMILIES: Final[dict[str, tx.Family]] = {
    "porcelain_tiles": tx.Family(porcelain_tiles, 1.8, frozenset({"floor", "wall"})),
    "subway_tiles": tx.Family(subway_tiles, 0.92, frozenset({"wall"})),
    "hexagon_mosaic": tx.Family(hexagon_mosaic, 0.52, frozenset({"floor", "wall"})),
    "penny_mosaic": tx.Family(penny_mosaic, 0.36, frozenset({"floor", "wall"})),
    "fish_scale_tiles": tx.Family(fish_scale_tiles, 0.96, frozenset({"wall"})),
    "zellige": tx.Family(zellige, 0.808, frozenset({"wall"})),
    "checkerboard_marble": tx.Family(checkerboard_marble, 1.2, frozenset({"floor"})),
    "crackle_glaze": tx.Family(crackle_glaze, 0.3, frozenset({"wall", "object"})),
}
