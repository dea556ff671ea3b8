"""Hides with scales, quills and beads: crocodile, snake, lizard, ostrich, ray."""

import numpy as np

from openrooms_usd.library.textures.base.family import Order
from openrooms_usd.library.textures.base.lattice import cells, diagonal, offset, spacing, whole
from openrooms_usd.library.textures.base.maps import Maps
from openrooms_usd.library.textures.base.noise import Field, smoothstep
from openrooms_usd.library.textures.base.recipe import noise
from openrooms_usd.library.textures.leather.hide import bent, grain, leather, pillow


def crocodile(order: Order) -> Maps:
    """Belly: rows of nearly square plates, domed and shining, with creases between."""
    rows, columns = whole(order, 0.026, 2), whole(order, 0.021)
    plates = cells(order.rng, order.resolution, columns, rows, 0.24, stagger=0.5)
    border = bent(order, plates.border, 0.015, 0.0016)
    dome = pillow(border, 0.8)
    crease = 1.0 - smoothstep(0.02, 0.16, border)
    wrinkle = pillow(grain(order, 0.0032).border, 0.5)
    tone = noise(order, 0.025)
    shade = (0.62 + 0.38 * dome) * (1.0 - 0.55 * crease) * (1.0 + 0.07 * tone)
    shade = shade * (0.93 + 0.07 * wrinkle)
    height = 0.0011 * dome - 0.0005 * crease + 40e-6 * wrinkle * (1.2 - dome)
    return leather(order, shade, height, (0.2, 0.32), 0.3 * crease + 0.04 * (1.0 - wrinkle))


def snake(order: Order) -> Maps:
    """Python: overlapping diamonds; whole scales are light or dark, in saddles."""
    width = float(order.rng.uniform(0.008, 0.011))
    columns, rows = whole(order, width), whole(order, 1.4 * width)
    first, second = diagonal(order.resolution, columns, rows)
    blotch = _of_scale(noise(order, 0.035, 0.05), first, second, columns, rows)
    spread = _of_scale(noise(order, 0.006), first, second, columns, rows)
    x, y = offset(first), offset(second)
    edge = np.maximum(np.abs(x), np.abs(y))
    # The free tip of each scale lies over the next.
    scale = (1.0 - edge**4) * (0.45 + 0.55 * (0.5 + 0.25 * (x - y)))
    keel = 1.0 - np.minimum(np.abs(x + y) * 2.0, 1.0)
    dark = smoothstep(-0.15, 0.45, blotch) * smoothstep(1.6, 1.1, blotch)
    shade = (1.0 - 0.72 * dark) * (1.0 + 0.08 * spread) * (1.0 + 0.05 * keel)
    shade = shade * (0.45 + 0.55 * np.minimum(4.0 * (1.0 - edge), 1.0))
    height = 0.05 * spacing(order, width, columns) * (scale + 0.15 * keel * scale)
    return leather(order, shade, height, (0.28, 0.4), 0.2 * edge**4)


def _of_scale(field: Field, first: Field, second: Field, columns: int, rows: int) -> Field:
    """(N, N) what a field has in the middle of the diamond that each texel lies in."""
    a, b = np.floor(first) + 0.5, np.floor(second) + 0.5
    n = len(field)
    column = np.floor((a + b) / 2 / columns * n).astype(np.int64) % n
    row = np.floor((a - b) / 2 / rows * n).astype(np.int64) % n
    return np.asarray(field[row, column])


def lizard(order: Order) -> Maps:
    """Small scales like grains of rice, in rows, with rings of lighter ones."""
    columns, rows = whole(order, 0.0021), whole(order, 0.0029, 2)
    scales = cells(order.rng, order.resolution, columns, rows, 0.25, stagger=0.5)
    dome = np.sqrt(np.maximum(1.0 - 2.6 * scales.nearest**2, 0.0))
    ring = np.maximum(1.0 - 2.5 * np.abs(np.abs(noise(order, 0.02)) - 0.5), 0.0)
    tone = scales.dealt(order.rng, -0.12, 0.12)
    shade = (0.35 + 0.65 * dome) * (1.0 + tone) * (0.9 + 0.28 * ring)
    height = 0.13 * spacing(order, 0.0025, rows) * dome
    return leather(order, shade, height, (0.26, 0.36), 0.2 * (1.0 - dome))


def ostrich(order: Order) -> Maps:
    """Quill follicles: bumps with a pit, strewn over a fine grain with long creases."""
    near = bent(order, grain(order, 0.014, 0.75).nearest, 0.004, 0.0005)
    bump = 1.0 - smoothstep(0.06, 0.20, near)
    pit = 1.0 - smoothstep(0.02, 0.07, near)
    skin = pillow(grain(order, 0.0013).border, 0.5)
    crease = np.maximum(1.0 - 4.0 * np.abs(noise(order, 0.009, 0.007)), 0.0)
    shade = (0.84 + 0.16 * skin) * (1.0 - 0.18 * bump) * (1.0 - 0.45 * pit) * (1.0 - 0.06 * crease)
    height = 0.0011 * bump - 0.0007 * pit + 45e-6 * skin - 90e-6 * crease
    return leather(order, shade, height, (0.4, 0.5), 0.1 * (1.0 - skin) - 0.08 * bump)


def shagreen(order: Order) -> Maps:
    """Ray: close beads, ground flat, so that each is a light disc in a dark net."""
    count = whole(order, 0.0014)
    beads = cells(order.rng, order.resolution, count, count, 0.8)
    grown = smoothstep(0.3, 1.6, noise(order, 0.03, 0.12))
    dome = np.sqrt(np.maximum(1.0 - 2.4 * beads.nearest**2, 0.0))
    flat = np.minimum(dome, 0.72)
    tone = beads.dealt(order.rng, -0.15, 0.15)
    shade = (0.25 + 0.75 * smoothstep(0.1, 0.72, dome)) * (1.0 + tone) * (1.0 + 0.35 * grown)
    height = spacing(order, 0.0014, count) * (0.28 * flat + 0.15 * grown)
    return leather(order, shade, height, (0.24, 0.34), 0.25 * (0.72 - flat))
