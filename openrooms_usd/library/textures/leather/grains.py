"""Leathers: hides by their grain, and what is sewn, woven or punched of them."""

from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import lattice
from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.library.textures.fabric.weave import Thread, pattern, woven
from openrooms_usd.library.textures.leather import hide
from openrooms_usd.library.textures.leather.hide import bent, grain, leather, pillow


def crocodile(order: tx.TextureParams) -> tx.Maps:
    """Belly: rows of nearly square plates, domed and shining, with creases between."""
    rows, columns = lattice.whole(order, 0.026, 2), lattice.whole(order, 0.021)
    plates = lattice.cells(order.rng, order.resolution, columns, rows, 0.24, stagger=0.5)
    border = bent(order, plates.border, 0.015, 0.0016)
    dome = pillow(border, 0.8)
    crease = 1.0 - tx.smoothstep(0.02, 0.16, border)
    wrinkle = pillow(grain(order, 0.0032).border, 0.5)
    tone = tx.noise(order, 0.025)
    shade = (0.62 + 0.38 * dome) * (1.0 - 0.55 * crease) * (1.0 + 0.07 * tone)
    shade = shade * (0.93 + 0.07 * wrinkle)
    height = 0.0011 * dome - 0.0005 * crease + 40e-6 * wrinkle * (1.2 - dome)
    return leather(order, shade, height, (0.2, 0.32), 0.3 * crease + 0.04 * (1.0 - wrinkle))


def snake(order: tx.TextureParams) -> tx.Maps:
    """Python: overlapping diamonds; whole scales are light or dark, in saddles."""
    width = float(order.rng.uniform(0.008, 0.011))
    columns, rows = lattice.whole(order, width), lattice.whole(order, 1.4 * width)
    first, second = lattice.diagonal(order.resolution, columns, rows)
    blotch = _of_scale(tx.noise(order, 0.035, 0.05), first, second, columns, rows)
    spread = _of_scale(tx.noise(order, 0.006), first, second, columns, rows)
    x, y = lattice.offset(first), lattice.offset(second)
    edge = np.maximum(np.abs(x), np.abs(y))
    # The free tip of each scale lies over the next.
    scale = (1.0 - edge**4) * (0.45 + 0.55 * (0.5 + 0.25 * (x - y)))
    keel = 1.0 - np.minimum(np.abs(x + y) * 2.0, 1.0)
    dark = tx.smoothstep(-0.15, 0.45, blotch) * tx.smoothstep(1.6, 1.1, blotch)
    shade = (1.0 - 0.72 * dark) * (1.0 + 0.08 * spread) * (1.0 + 0.05 * keel)
    shade = shade * (0.45 + 0.55 * np.minimum(4.0 * (1.0 - edge), 1.0))
    height = 0.05 * lattice.spacing(order, width, columns) * (scale + 0.15 * keel * scale)
    return leather(order, shade, height, (0.28, 0.4), 0.2 * edge**4)


def _of_scale(
    field: tx.Field, first: tx.Field, second: tx.Field, columns: int, rows: int
) -> tx.Field:
    """(N, N) what a field has in the middle of the diamond that each texel lies in."""
    a, b = np.floor(first) + 0.5, np.floor(second) + 0.5
    n = len(field)
    column = np.floor((a + b) / 2 / columns * n).astype(np.int64) % n
    row = np.floor((a - b) / 2 / rows * n).astype(np.int64) % n
    return np.asarray(field[row, column])


def lizard(order: tx.TextureParams) -> tx.Maps:
    """Small scales like grains of rice, in rows, with rings of lighter ones."""
    columns, rows = lattice.whole(order, 0.0021), lattice.whole(order, 0.0029, 2)
    scales = lattice.cells(order.rng, order.resolution, columns, rows, 0.25, stagger=0.5)
    dome = np.sqrt(np.maximum(1.0 - 2.6 * scales.nearest**2, 0.0))
    ring = np.maximum(1.0 - 2.5 * np.abs(np.abs(tx.noise(order, 0.02)) - 0.5), 0.0)
    tone = scales.dealt(order.rng, -0.12, 0.12)
    shade = (0.35 + 0.65 * dome) * (1.0 + tone) * (0.9 + 0.28 * ring)
    height = 0.13 * lattice.spacing(order, 0.0025, rows) * dome
    return leather(order, shade, height, (0.26, 0.36), 0.2 * (1.0 - dome))


def ostrich(order: tx.TextureParams) -> tx.Maps:
    """Quill follicles: bumps with a pit, strewn over a fine grain with long creases."""
    near = bent(order, grain(order, 0.014, 0.75).nearest, 0.004, 0.0005)
    bump = 1.0 - tx.smoothstep(0.06, 0.20, near)
    pit = 1.0 - tx.smoothstep(0.02, 0.07, near)
    skin = pillow(grain(order, 0.0013).border, 0.5)
    crease = np.maximum(1.0 - 4.0 * np.abs(tx.noise(order, 0.009, 0.007)), 0.0)
    shade = (0.84 + 0.16 * skin) * (1.0 - 0.18 * bump) * (1.0 - 0.45 * pit) * (1.0 - 0.06 * crease)
    height = 0.0011 * bump - 0.0007 * pit + 45e-6 * skin - 90e-6 * crease
    return leather(order, shade, height, (0.4, 0.5), 0.1 * (1.0 - skin) - 0.08 * bump)


def shagreen(order: tx.TextureParams) -> tx.Maps:
    """Ray: close beads, ground flat, so that each is a light disc in a dark net."""
    count = lattice.whole(order, 0.0014)
    beads = lattice.cells(order.rng, order.resolution, count, count, 0.8)
    grown = tx.smoothstep(0.3, 1.6, tx.noise(order, 0.03, 0.12))
    dome = np.sqrt(np.maximum(1.0 - 2.4 * beads.nearest**2, 0.0))
    flat = np.minimum(dome, 0.72)
    tone = beads.dealt(order.rng, -0.15, 0.15)
    shade = (0.25 + 0.75 * tx.smoothstep(0.1, 0.72, dome)) * (1.0 + tone) * (1.0 + 0.35 * grown)
    height = lattice.spacing(order, 0.0014, count) * (0.28 * flat + 0.15 * grown)
    return leather(order, shade, height, (0.24, 0.34), 0.25 * (0.72 - flat))


# Stitches: their length, half width of the thread, depth to which they draw the hide in. Metres.
_STITCH_M: Final = 0.0042
_THREAD_HALF_WIDTH_M: Final = 0.0007


def stitches(aside: tx.Field, along: tx.Field) -> tx.Field:
    """Height 0..1 of a line of stitches.

    Args:
        aside: Distance from the line, metres.
        along: Place along it, in stitches.
    """
    thread = np.maximum(1.0 - (aside / _THREAD_HALF_WIDTH_M) ** 2, 0.0)
    return np.asarray(thread * np.maximum(1.0 - (lattice.offset(along) / 0.8) ** 2, 0.0))


def quilted(order: tx.TextureParams) -> tx.Maps:
    """Padded diamonds, drawn in along slanted lines of stitches."""
    count = lattice.whole(order, 0.08)
    first, second = lattice.diagonal(order.resolution, count, count)
    x, y = lattice.offset(first), lattice.offset(second)
    puff = np.sqrt(np.sqrt((1.0 - x**2) * (1.0 - y**2)))
    # A diamond's half width, across its sides.
    half = order.size / count / np.sqrt(8.0)
    runs = round(2.0 * half / _STITCH_M)
    seam = np.maximum(
        stitches(half * (1.0 - np.abs(x)), runs * second),
        stitches(half * (1.0 - np.abs(y)), runs * first),
    )
    skin = pillow(grain(order, 0.0016).border, 0.5)
    fold = tx.noise(order, 0.006) * (1.0 - puff) ** 2
    shade = (0.55 + 0.45 * puff) * (0.92 + 0.08 * skin) * (1.0 + 0.25 * seam)
    depth = 0.12 * lattice.spacing(order, 0.08, count)
    height = depth * puff + 45e-6 * skin + 0.0004 * seam + 0.0005 * fold
    return leather(order, shade, height, (0.38, 0.5), 0.08 * (1.0 - skin) + 0.2 * seam)


def stitched(order: tx.TextureParams) -> tx.Maps:
    """Panels sewn together: a seam with a row of stitches on each side."""
    n = order.resolution
    count = lattice.whole(order, 0.2)
    place = lattice.phase(n, count)
    aside = (0.5 - 0.5 * np.abs(lattice.offset(place))) * (order.size / count)
    runs = count * round(order.size / count / _STITCH_M)
    along = lattice.phase(n, runs)
    seam = np.maximum(
        stitches(aside[:, None] - 0.006, along[None]), stitches(aside - 0.006, along[:, None])
    )
    near = np.minimum(aside[:, None], aside)
    gap = 1.0 - tx.smoothstep(0.0003, 0.0016, near)
    puff = tx.smoothstep(0.0, 0.03, near) + 0.25 * tx.smoothstep(0.004, 0.009, near)
    skin = bent(order, pillow(grain(order, 0.0024).border, 0.6), 0.005, 0.0003)
    shade = (0.8 + 0.2 * skin) * (1.0 - 0.7 * gap) * (1.0 + 0.5 * seam)
    shade = shade * (1.0 + 0.03 * tx.noise(order, 0.06))
    height = 0.0016 * puff - 0.0012 * gap + 0.00015 * skin + 0.0005 * seam
    return leather(order, shade, height, (0.42, 0.52), 0.1 * (1.0 - skin) + 0.2 * seam)


def plaited(order: tx.TextureParams) -> tx.Maps:
    """Flat strips woven over and under each other."""
    count = lattice.whole(order, 0.011, 2)
    thread = Thread((90.0, 90.0), slub=0.02, melange=0.05, bend=0.03)
    weave = pattern("X.", ".X")
    cloth = woven(order.rng, weave, (thread, thread), (count, count), order.resolution, 0.4)
    # Strips are flat: only their edges are round.
    flat = np.clip(cloth.height, -0.7, 0.2) + 0.25 * cloth.height
    skin = pillow(grain(order, 0.0013).border, 0.5)
    shade = cloth.tone * (0.3 + 0.7 * tx.smoothstep(-0.6, 0.5, flat)) * (0.9 + 0.1 * skin)
    height = 0.16 * lattice.spacing(order, 0.011, count) * flat + 40e-6 * skin
    return leather(order, shade, height, (0.4, 0.5), 0.08 * (1.0 - skin))


def perforated(order: tx.TextureParams) -> tx.Maps:
    """Punched with small holes, as seats that breathe."""
    pitch = 0.0062
    count = lattice.whole(order, pitch)
    first, second = lattice.diagonal(order.resolution, count, count)
    metres = order.size / count / np.sqrt(8.0)
    reach = metres * np.hypot(lattice.offset(first), lattice.offset(second))
    radius = 0.11 * lattice.spacing(order, pitch, count)
    texel = order.size / order.resolution
    hole = 1.0 - tx.smoothstep(radius - 0.6 * texel, radius + 0.6 * texel, reach)
    rim = tx.smoothstep(radius, 2.2 * radius, reach)
    skin = pillow(grain(order, 0.0012).border, 0.5)
    shade = (0.88 + 0.12 * skin) * (0.85 + 0.15 * rim) * (1.0 - 0.85 * hole)
    height = 40e-6 * skin + 0.00018 * rim - 0.0006 * hole
    return leather(order, shade, height, (0.42, 0.54), 0.1 * (1.0 - skin) + 0.3 * hole)


_SEATS: Final[frozenset[tx.Use]] = frozenset({"furniture"})
_GOODS: Final[frozenset[tx.Use]] = frozenset({"furniture", "object"})

# Hides are larger than their pictures.
_LAID: Final = {
    "cracked_leather": 2,
    "full_grain_leather": 4,
    "nappa": 4,
    "nubuck": 4,
    "pebbled_leather": 4,
    "suede": 4,
}

FAMILIES: Final[dict[str, tx.Family]] = {
    name: tx.Family(lattice.resolved(make, detail), size, uses, laid=_LAID.get(name, 1))
    for name, make, detail, size, uses in (
        ("full_grain_leather", hide.full_grain, 0.0008, 0.12, _SEATS),
        ("pebbled_leather", hide.pebbled, 0.002, 0.16, _SEATS),
        ("nappa", hide.nappa, 0.001, 0.14, _SEATS),
        ("suede", hide.suede, 0.0008, 0.15, _SEATS),
        ("nubuck", hide.nubuck, 0.0008, 0.14, _SEATS),
        ("cracked_leather", hide.cracked, 0.001, 0.2, _SEATS),
        ("patent_leather", hide.patent, 0.003, 0.2, _GOODS),
        ("saffiano", hide.saffiano, 0.0017, 0.12, _GOODS),
        ("crocodile_leather", crocodile, 0.003, 0.25, _GOODS),
        ("snakeskin", snake, 0.006, 0.2, _GOODS),
        ("lizard_leather", lizard, 0.002, 0.12, _GOODS),
        ("ostrich_leather", ostrich, 0.0013, 0.17, _GOODS),
        ("shagreen", shagreen, 0.0014, 0.12, _GOODS),
        ("quilted_leather", quilted, 0.0016, 0.24, _SEATS),
        ("stitched_leather", stitched, 0.0024, 0.4, _SEATS),
        ("woven_leather", plaited, 0.002, 0.154, _SEATS),
        ("perforated_leather", perforated, 0.0012, 0.124, _SEATS),
    )
}
