"""Walls and floors of natural stone, and unglazed tiles: pieces that differ from each other.

Albedo of stone 0.2 to 0.35 and of tiles 0.1 to 0.35 (T. R. Oke, Boundary Layer Climates, 1987); the
colours of single kinds, within and beside these, are chosen by eye.
"""

from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.tables import read_table

_PALETTES: Final = read_table(__file__, "palettes.toml")

# Length and height of a brick with its joint, and the joint: metres.
STANDARD: Final = (0.225, 0.075)
LONG: Final = (0.300, 0.062)
JOINT: Final = 0.010

CLAY: Final[tuple[tx.Color, ...]] = _PALETTES["brick_clay"]
GREY_CLAY: Final[tuple[tx.Color, ...]] = _PALETTES["brick_grey_clay"]
MORTAR: Final[tuple[tx.Color, ...]] = ((0.42, 0.39, 0.35), (0.33, 0.31, 0.29), (0.50, 0.46, 0.39))
WHITEWASH: Final[tuple[tx.Color, ...]] = _PALETTES["brick_whitewash"]


def running_bond_brick(order: tx.TextureParams) -> tx.Maps:
    """Stretchers, each course shifted by half a brick; hand-moulded, so uneven."""
    return _brickwork(order, tx.bond(order, STANDARD, 0.5, 2), CLAY, uneven=1.0)


def stack_bond_brick(order: tx.TextureParams) -> tx.Maps:
    """Long extruded bricks, joint over joint, with sharp edges and a finely dragged face."""
    return _brickwork(order, tx.bond(order, LONG), GREY_CLAY, uneven=0.25)


def whitewashed_brick(order: tx.TextureParams) -> tx.Maps:
    """English bond, a course of stretchers on a course of headers, under worn limewash."""
    wall = english_bond(order)
    clay = _brickwork(order, wall, CLAY, uneven=1.3)
    white = tx.drawn_color(order, WHITEWASH, 0.05)
    stroke = tx.noise(order, 0.05, 0.008)
    wear = tx.fractal(order, 0.12, 0.35)
    inside = wall.inside(JOINT, 0.006)
    # The wash goes first where hands and weather reach it: off the faces, not out of the joints.
    limed = tx.smoothstep(-1.75, -1.25, wear - 0.5 * tx.smoothstep(0.0, 0.006, inside))
    washed = white * (1.0 + 0.02 * stroke + 0.025 * wear)[..., None]
    bare = clay.albedo * (0.75 + 0.45 * limed)[..., None]
    height = 0.72 * clay.height + limed * (0.0004 + 60e-6 * stroke)
    rough = tx.drawn_roughness(order, 0.82, 0.93) + 0.02 * wear
    return tx.finished(order, tx.mixed(0.06 + 0.92 * limed, washed, bare), height, rough)


def english_bond(order: tx.TextureParams) -> tx.Laid:
    """A course of stretchers on a course of headers, shifted by a quarter of a brick."""
    columns, rows = tx.whole(order.size, STANDARD[0]), tx.whole(order.size, STANDARD[1], 2)
    stretchers = np.full(columns, order.size / columns)
    headers = np.full(2 * columns, order.size / columns / 2)
    lengths = [headers if row % 2 else stretchers for row in range(rows)]
    starts = [stretchers[0] / 4 * (row % 2) for row in range(rows)]
    return tx.laid(order, np.full(rows, order.size / rows), lengths, starts)


def _brickwork(
    order: tx.TextureParams, wall: tx.Laid, palette: tuple[tx.Color, ...], uneven: float
) -> tx.Maps:
    """Bricks of a bond; ``uneven`` is 0 for machined ones, 1 for hand-moulded ones."""
    color, mortar = tx.drawn_color(order, palette), tx.side_color(order, MORTAR)
    matt = tx.drawn_roughness(order, 0.82, 0.92)
    depth = order.rng.uniform(0.003, 0.006)
    broken = tx.shifted_per_piece(order, tx.fractal(order, 0.06, 0.45), wall.index, wall.count)
    sand = tx.fractal(order, 0.004, 0.1)
    inside = wall.inside(JOINT, 0.001 + 0.004 * uneven, 0.0011 * uneven * tx.noise(order, 0.018))
    face = tx.covered(order, inside)
    rounded = tx.smoothstep(0.0, 0.001 + 0.006 * uneven, inside)
    crease = uneven * tx.smoothstep(1.3, 2.6, broken)
    height = face * (depth * (0.5 + 0.5 * rounded) - 0.0012 * crease)
    height = height + face * 0.00025 * uneven * broken + (1.0 - 0.6 * face) * 0.00016 * sand
    lean = tx.shifted_per_piece(order, tx.noise(order, 0.4), wall.index, wall.count)
    height = height + face * 0.0004 * uneven * lean
    shade = _fired(order, wall) * (1.0 + 0.09 * broken + 0.03 * sand) * (1.0 - 0.35 * crease)
    bricks = np.maximum(shade, 0.1)[..., None] ** np.array([0.85, 1.0, 1.05]) * color
    joint = mortar * np.maximum(1.0 + 0.06 * sand + 0.04 * tx.noise(order, 0.15), 0.2)[..., None]
    # The joint lies in the shade of the bricks beside it.
    joint = joint * (0.8 + 0.2 * tx.smoothstep(0.0, JOINT / 2, -inside))[..., None]
    rough = matt + 0.03 * sand * (1.0 - face) + 0.02 * broken
    return tx.finished(order, tx.mixed(face, bricks, joint), height, rough)


def _fired(order: tx.TextureParams, wall: tx.Laid) -> tx.Field:
    """(N, N) how light each brick came out of the kiln: some near the fire are much darker."""
    heat = order.rng.random(wall.count)
    return np.asarray((1.2 - 0.3 * heat - 0.35 * heat**6)[wall.index])


FIELDSTONE: Final[tuple[tx.Color, ...]] = _PALETTES["masonry_fieldstone"]
SANDSTONE: Final[tuple[tx.Color, ...]] = _PALETTES["masonry_sandstone"]
LIMESTONE: Final[tuple[tx.Color, ...]] = _PALETTES["masonry_limestone"]
LEDGER: Final[tuple[tx.Color, ...]] = _PALETTES["masonry_ledger"]
SETT: Final[tuple[tx.Color, ...]] = ((0.24, 0.235, 0.23), (0.30, 0.28, 0.26), (0.19, 0.185, 0.19))
TERRACOTTA: Final[tuple[tx.Color, ...]] = _PALETTES["masonry_terracotta"]
QUARRY: Final[tuple[tx.Color, ...]] = _PALETTES["masonry_quarry"]
BED: Final[tuple[tx.Color, ...]] = ((0.38, 0.36, 0.33), (0.46, 0.42, 0.36), (0.30, 0.29, 0.28))


def fieldstone_wall(order: tx.TextureParams) -> tx.Maps:
    """Stones as they were found, 0.15 to 0.3 m wide, in wide mortar."""
    width = order.rng.uniform(0.16, 0.24)
    warp = (
        0.05 * width * tx.noise(order, 0.4 * width),
        0.05 * width * tx.noise(order, 0.4 * width),
    )
    cells = tx.scattered_cells(order, width, 1.0, warp)
    inside = cells.edge - order.rng.uniform(0.009, 0.014)
    bulge = tx.smoothstep(-0.002, 0.3 * width, inside)
    tilt = _tilted(order, cells.index, cells.count, cells.across, cells.up, 0.10)
    stone = tx.shifted_per_piece(order, tx.fractal(order, 0.06, 0.55), cells.index, cells.count)
    relief = 0.022 * bulge + tilt + 0.0012 * stone
    return _set_stones(
        order, cells.index, cells.count, inside, stone, relief, FIELDSTONE, varied=0.26
    )


def ashlar(order: tx.TextureParams) -> tx.Maps:
    """Squared blocks in courses of 0.15 to 0.3 m, faces tooled, joints of 5 mm."""
    wall = tx.random_courses(order, (0.15, 0.30), (0.28, 0.65))
    inside = wall.inside(0.005, 0.003, 0.0006 * tx.noise(order, 0.03))
    stone = tx.shifted_per_piece(order, tx.fractal(order, 0.15, 0.55), wall.index, wall.count)
    # Strokes of the chisel, 8 mm apart, slanted, each block worked at its own angle.
    slant = order.rng.uniform(-0.5, 0.5, wall.count)[wall.index]
    bent = wall.across + slant * wall.up + 0.0015 * tx.noise(order, 0.05)
    stroke = np.cos(2.0 * np.pi * bent / 0.009)
    margin = tx.smoothstep(0.016, 0.020, inside)
    relief = 0.002 * tx.smoothstep(0.0, 0.004, inside) + 0.0004 * stone
    relief = relief + margin * 0.0007 * stroke * np.clip(
        0.6 + 0.5 * tx.noise(order, 0.06), 0.0, 1.5
    )
    return _set_stones(order, wall.index, wall.count, inside, stone, relief, SANDSTONE, varied=0.10)


def split_face_ledger(order: tx.TextureParams) -> tx.Maps:
    """Narrow split strips, stacked dry, each out of the wall by its own amount."""
    wall = tx.random_courses(order, (0.020, 0.052), (0.12, 0.42))
    inside = wall.inside(0.0012, 0.0015, 0.0005 * tx.noise(order, 0.03))
    stone = tx.shifted_per_piece(order, tx.fractal(order, 0.035, 0.4), wall.index, wall.count)
    out = order.rng.uniform(0.0, 0.014, wall.count)[wall.index]
    slope = _tilted(order, wall.index, wall.count, wall.across, wall.up, 0.05)
    relief = 0.004 + out + slope + 0.0021 * stone
    return _set_stones(order, wall.index, wall.count, inside, stone, relief, LEDGER, varied=0.24)


def cobblestone(order: tx.TextureParams) -> tx.Maps:
    """Granite setts of about 0.1 m in rows, their heads worn round."""
    size = order.rng.uniform(0.09, 0.11)
    rows = tx.random_courses(order, (0.92 * size, 1.08 * size), (0.8 * size, 1.3 * size))
    wobble = 0.003 * tx.noise(order, 0.04)
    inside = rows.inside(0.013, 0.020, wobble)
    stone = tx.shifted_per_piece(order, tx.fractal(order, 0.02, 0.2), rows.index, rows.count)
    tilt = _tilted(order, rows.index, rows.count, rows.across, rows.up, 0.05)
    dome = 0.013 * (1.0 - (1.0 - np.clip(inside / (0.42 * size), 0.0, 1.0)) ** 2.2)
    relief = dome + tilt + 0.0007 * stone
    return _set_stones(order, rows.index, rows.count, inside, stone, relief, SETT, varied=0.2)


def terracotta_tiles(order: tx.TextureParams) -> tx.Maps:
    """Hand-made floor tiles of 0.2 m, hollowed a little, joints of 8 mm."""
    floor = tx.bond(order, (0.208, 0.208))
    inside = floor.inside(0.008, 0.006, 0.0012 * tx.noise(order, 0.05))
    clay = tx.shifted_per_piece(order, tx.fractal(order, 0.12, 0.7), floor.index, floor.count)
    dish = -0.0016 * tx.smoothstep(0.0, 0.09, inside)
    flame = tx.shifted_per_piece(order, tx.noise(order, 0.14), floor.index, floor.count)
    relief = 0.002 * tx.smoothstep(-0.001, 0.006, inside) + dish + 0.00015 * clay
    maps = _set_stones(
        order, floor.index, floor.count, inside, clay + 1.1 * flame, relief, TERRACOTTA, varied=0.16
    )
    return tx.finished(order, maps.albedo, maps.height, maps.roughness - 0.14)


def quarry_hexagons(order: tx.TextureParams) -> tx.Maps:
    """Pressed unglazed hexagons, 0.15 m wide, flat and sharp-edged, joints of 6 mm."""
    cells = tx.hexagons(order, 0.156)
    inside = cells.edge - 0.003
    grain = tx.shifted_per_piece(order, tx.fractal(order, 0.006, 0.2), cells.index, cells.count)
    relief = 0.0016 * tx.smoothstep(0.0, 0.0012, inside) + 30e-6 * grain
    maps = _set_stones(
        order, cells.index, cells.count, inside, 0.5 * grain, relief, QUARRY, varied=0.1, motley=0.1
    )
    return tx.finished(order, maps.albedo, maps.height, maps.roughness - 0.2)


def _set_stones(
    order: tx.TextureParams,
    index: tx.Index,
    count: int,
    inside: tx.Field,
    stone: tx.Field,
    relief: tx.Field,
    palette: tuple[tx.Color, ...],
    varied: float,
    motley: float = 0.45,
) -> tx.Maps:
    """Pieces in a bed of mortar.

    Args:
        order: What is asked for.
        index: (N, N) piece.
        count: How many there are.
        inside: (N, N) distance inside the piece's edge, metres.
        stone: (N, N) light and dark within the pieces, in standard deviations.
        relief: (N, N) height of the piece above the mortar, metres.
        palette: Colours of the pieces.
        varied: How much pieces differ in lightness.
        motley: How much they differ in hue.
    """
    bed = tx.side_color(order, BED)
    matt = tx.drawn_roughness(order, 0.8, 0.93)
    sand = tx.fractal(order, 0.005, 0.1)
    on = tx.covered(order, inside)
    shade = np.exp(varied * order.rng.uniform(-1.0, 1.0, count))[index]
    shade = np.maximum(shade * (1.0 + 0.10 * stone + 0.03 * sand), 0.15)
    pieces = shade[..., None] * _hues(order, palette, count, motley)[index]
    cavity = 0.72 + 0.28 * tx.smoothstep(0.0, 0.005, np.abs(inside))
    mortar = bed * np.maximum((1.0 + 0.06 * sand) * cavity, 0.1)[..., None]
    height = on * relief + (1.0 - on) * 0.00018 * sand
    rough = matt + 0.03 * (1.0 - on) + 0.02 * stone
    return tx.finished(order, tx.mixed(on, pieces, mortar), height, rough)


def _hues(
    order: tx.TextureParams, palette: tuple[tx.Color, ...], count: int, motley: float
) -> tx.Field:
    """(count, 3) colours: one for the wall, each piece leaning towards another of the palette."""
    base = tx.drawn_color(order, palette)
    others = np.array(palette)[order.rng.integers(len(palette), size=count)]
    lean = motley * order.rng.random((count, 1))
    return np.asarray(base * (others / np.mean(palette, axis=0)) ** lean)


def _tilted(
    order: tx.TextureParams,
    index: tx.Index,
    count: int,
    across: tx.Field,
    up: tx.Field,
    most: float,
) -> tx.Field:
    """(N, N) height of pieces that lean, each its own way, metres; ``most`` is the steepest."""
    slopes = order.rng.uniform(-most, most, (2, count))
    return np.asarray(slopes[0][index] * across + slopes[1][index] * up)


FAMILIES: Final[dict[str, tx.Family]] = {
    "running_bond_brick": tx.Family(running_bond_brick, 1.8, frozenset({"wall"})),
    "stack_bond_brick": tx.Family(stack_bond_brick, 1.8, frozenset({"wall"})),
    "whitewashed_brick": tx.Family(whitewashed_brick, 1.8, frozenset({"wall"})),
    "fieldstone_wall": tx.Family(fieldstone_wall, 2.0, frozenset({"wall"})),
    "ashlar": tx.Family(ashlar, 2.0, frozenset({"wall"})),
    "split_face_ledger": tx.Family(split_face_ledger, 1.2, frozenset({"wall"})),
    "cobblestone": tx.Family(cobblestone, 1.2, frozenset({"floor"})),
    "terracotta_tiles": tx.Family(terracotta_tiles, 1.25, frozenset({"floor"})),
    "quarry_hexagons": tx.Family(quarry_hexagons, 1.25, frozenset({"floor"})),
}
