"""Brickwork: fired clay in a bond, with recessed mortar.

Sizes: bricks of 215 x 65 mm and long ones of 290 x 52 mm, joints of 10 mm. Albedo of brick 0.2 to
0.4 (T. R. Oke, Boundary Layer Climates, 1987); mortar and limewash are chosen by eye.
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


def running_bond_brick(order: tx.Order) -> tx.Maps:
    """Stretchers, each course shifted by half a brick; hand-moulded, so uneven."""
    return _brickwork(order, tx.bond(order, STANDARD, 0.5, 2), CLAY, uneven=1.0)


def stack_bond_brick(order: tx.Order) -> tx.Maps:
    """Long extruded bricks, joint over joint, with sharp edges and a finely dragged face."""
    return _brickwork(order, tx.bond(order, LONG), GREY_CLAY, uneven=0.25)


def whitewashed_brick(order: tx.Order) -> tx.Maps:
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


def english_bond(order: tx.Order) -> tx.Laid:
    """A course of stretchers on a course of headers, shifted by a quarter of a brick."""
    columns, rows = tx.whole(order.size, STANDARD[0]), tx.whole(order.size, STANDARD[1], 2)
    stretchers = np.full(columns, order.size / columns)
    headers = np.full(2 * columns, order.size / columns / 2)
    lengths = [headers if row % 2 else stretchers for row in range(rows)]
    starts = [stretchers[0] / 4 * (row % 2) for row in range(rows)]
    return tx.laid(order, np.full(rows, order.size / rows), lengths, starts)


def _brickwork(
    order: tx.Order, wall: tx.Laid, palette: tuple[tx.Color, ...], uneven: float
) -> tx.Maps:
    """Bricks of a bond; ``uneven`` is 0 for machined ones, 1 for hand-moulded ones."""
    color, mortar = tx.drawn_color(order, palette), tx.side_color(order, MORTAR)
    matt = tx.drawn_roughness(order, 0.82, 0.92)
    depth = order.rng.uniform(0.003, 0.006)
    broken = tx.dealt(order, tx.fractal(order, 0.06, 0.45), wall.index, wall.count)
    sand = tx.fractal(order, 0.004, 0.1)
    inside = wall.inside(JOINT, 0.001 + 0.004 * uneven, 0.0011 * uneven * tx.noise(order, 0.018))
    face = tx.covered(order, inside)
    rounded = tx.smoothstep(0.0, 0.001 + 0.006 * uneven, inside)
    crease = uneven * tx.smoothstep(1.3, 2.6, broken)
    height = face * (depth * (0.5 + 0.5 * rounded) - 0.0012 * crease)
    height = height + face * 0.00025 * uneven * broken + (1.0 - 0.6 * face) * 0.00016 * sand
    lean = tx.dealt(order, tx.noise(order, 0.4), wall.index, wall.count)
    height = height + face * 0.0004 * uneven * lean
    shade = _fired(order, wall) * (1.0 + 0.09 * broken + 0.03 * sand) * (1.0 - 0.35 * crease)
    bricks = np.maximum(shade, 0.1)[..., None] ** np.array([0.85, 1.0, 1.05]) * color
    joint = mortar * np.maximum(1.0 + 0.06 * sand + 0.04 * tx.noise(order, 0.15), 0.2)[..., None]
    # The joint lies in the shade of the bricks beside it.
    joint = joint * (0.8 + 0.2 * tx.smoothstep(0.0, JOINT / 2, -inside))[..., None]
    rough = matt + 0.03 * sand * (1.0 - face) + 0.02 * broken
    return tx.finished(order, tx.mixed(face, bricks, joint), height, rough)


def _fired(order: tx.Order, wall: tx.Laid) -> tx.Field:
    """(N, N) how light each brick came out of the kiln: some near the fire are much darker."""
    heat = order.rng.random(wall.count)
    return np.asarray((1.2 - 0.3 * heat - 0.35 * heat**6)[wall.index])


FAMILIES: Final[dict[str, tx.Family]] = {
    "running_bond_brick": tx.Family(running_bond_brick, 1.8, frozenset({"wall"})),
    "stack_bond_brick": tx.Family(stack_bond_brick, 1.8, frozenset({"wall"})),
    "whitewashed_brick": tx.Family(whitewashed_brick, 1.8, frozenset({"wall"})),
}
