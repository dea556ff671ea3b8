"""Leathers: hides by their grain, and what is sewn, woven or punched of them."""

from typing import Final

import numpy as np

from openrooms_usd.library.textures.base.family import Family, Order, Use
from openrooms_usd.library.textures.base.lattice import (
    diagonal,
    offset,
    phase,
    resolved,
    spacing,
    whole,
)
from openrooms_usd.library.textures.base.maps import Maps
from openrooms_usd.library.textures.base.noise import Field, smoothstep
from openrooms_usd.library.textures.base.recipe import noise
from openrooms_usd.library.textures.fabric.weave import Thread, pattern, woven
from openrooms_usd.library.textures.leather import hide, reptile
from openrooms_usd.library.textures.leather.hide import bent, grain, leather, pillow

# Stitches: their length, half width of the thread, depth to which they draw the hide in. Metres.
_STITCH_M: Final = 0.0042
_THREAD_HALF_WIDTH_M: Final = 0.0007
_DRAWN_IN_M: Final = 0.0012


def stitches(aside: Field, along: Field) -> Field:
    """Height 0..1 of a line of stitches.

    Args:
        aside: Distance from the line, metres.
        along: Place along it, in stitches.
    """
    thread = np.maximum(1.0 - (aside / _THREAD_HALF_WIDTH_M) ** 2, 0.0)
    return np.asarray(thread * np.maximum(1.0 - (offset(along) / 0.8) ** 2, 0.0))


def quilted(order: Order) -> Maps:
    """Padded diamonds, drawn in along slanted lines of stitches."""
    count = whole(order, 0.08)
    first, second = diagonal(order.resolution, count, count)
    x, y = offset(first), offset(second)
    puff = np.sqrt(np.sqrt((1.0 - x**2) * (1.0 - y**2)))
    # A diamond's half width, across its sides.
    half = order.size / count / np.sqrt(8.0)
    runs = round(2.0 * half / _STITCH_M)
    seam = np.maximum(
        stitches(half * (1.0 - np.abs(x)), runs * second),
        stitches(half * (1.0 - np.abs(y)), runs * first),
    )
    skin = pillow(grain(order, 0.0016).border, 0.5)
    fold = noise(order, 0.006) * (1.0 - puff) ** 2
    shade = (0.55 + 0.45 * puff) * (0.92 + 0.08 * skin) * (1.0 + 0.25 * seam)
    depth = 0.12 * spacing(order, 0.08, count)
    height = depth * puff + 45e-6 * skin + 0.0004 * seam + 0.0005 * fold
    return leather(order, shade, height, (0.38, 0.5), 0.08 * (1.0 - skin) + 0.2 * seam)


def stitched(order: Order) -> Maps:
    """Panels sewn together: a seam with a row of stitches on each side."""
    n = order.resolution
    count = whole(order, 0.2)
    place = phase(n, count)
    aside = (0.5 - 0.5 * np.abs(offset(place))) * (order.size / count)
    runs = count * round(order.size / count / _STITCH_M)
    along = phase(n, runs)
    seam = np.maximum(
        stitches(aside[:, None] - 0.006, along[None]), stitches(aside - 0.006, along[:, None])
    )
    near = np.minimum(aside[:, None], aside)
    gap = 1.0 - smoothstep(0.0003, 0.0016, near)
    puff = smoothstep(0.0, 0.03, near) + 0.25 * smoothstep(0.004, 0.009, near)
    skin = bent(order, pillow(grain(order, 0.0024).border, 0.6), 0.005, 0.0003)
    shade = (0.8 + 0.2 * skin) * (1.0 - 0.7 * gap) * (1.0 + 0.5 * seam)
    shade = shade * (1.0 + 0.03 * noise(order, 0.06))
    height = 0.0016 * puff - 0.0012 * gap + 0.00015 * skin + 0.0005 * seam
    return leather(order, shade, height, (0.42, 0.52), 0.1 * (1.0 - skin) + 0.2 * seam)


def plaited(order: Order) -> Maps:
    """Flat strips woven over and under each other."""
    count = whole(order, 0.011, 2)
    thread = Thread((90.0, 90.0), slub=0.02, melange=0.05, bend=0.03)
    weave = pattern("X.", ".X")
    cloth = woven(order.rng, weave, (thread, thread), (count, count), order.resolution, 0.4)
    # Strips are flat: only their edges are round.
    flat = np.clip(cloth.height, -0.7, 0.2) + 0.25 * cloth.height
    skin = pillow(grain(order, 0.0013).border, 0.5)
    shade = cloth.tone * (0.3 + 0.7 * smoothstep(-0.6, 0.5, flat)) * (0.9 + 0.1 * skin)
    height = 0.16 * spacing(order, 0.011, count) * flat + 40e-6 * skin
    return leather(order, shade, height, (0.4, 0.5), 0.08 * (1.0 - skin))


def perforated(order: Order) -> Maps:
    """Punched with small holes, as seats that breathe."""
    pitch = 0.0062
    count = whole(order, pitch)
    first, second = diagonal(order.resolution, count, count)
    metres = order.size / count / np.sqrt(8.0)
    reach = metres * np.hypot(offset(first), offset(second))
    radius = 0.11 * spacing(order, pitch, count)
    texel = order.size / order.resolution
    hole = 1.0 - smoothstep(radius - 0.6 * texel, radius + 0.6 * texel, reach)
    rim = smoothstep(radius, 2.2 * radius, reach)
    skin = pillow(grain(order, 0.0012).border, 0.5)
    shade = (0.88 + 0.12 * skin) * (0.85 + 0.15 * rim) * (1.0 - 0.85 * hole)
    height = 40e-6 * skin + 0.00018 * rim - 0.0006 * hole
    return leather(order, shade, height, (0.42, 0.54), 0.1 * (1.0 - skin) + 0.3 * hole)


_SEATS: Final[frozenset[Use]] = frozenset({"furniture"})
_GOODS: Final[frozenset[Use]] = frozenset({"furniture", "object"})

# Hides are larger than their pictures.
_LAID: Final = {
    "cracked_leather": 2, "full_grain_leather": 4, "nappa": 4, "nubuck": 4, "pebbled_leather": 4,
    "suede": 4,
}  # fmt: skip

FAMILIES: Final[dict[str, Family]] = {
    name: Family(resolved(make, detail), size, uses, laid=_LAID.get(name, 1))
    for name, make, detail, size, uses in (
        ("full_grain_leather", hide.full_grain, 0.0008, 0.12, _SEATS),
        ("pebbled_leather", hide.pebbled, 0.002, 0.16, _SEATS),
        ("nappa", hide.nappa, 0.001, 0.14, _SEATS),
        ("suede", hide.suede, 0.0008, 0.15, _SEATS),
        ("nubuck", hide.nubuck, 0.0008, 0.14, _SEATS),
        ("cracked_leather", hide.cracked, 0.001, 0.2, _SEATS),
        ("patent_leather", hide.patent, 0.003, 0.2, _GOODS),
        ("saffiano", hide.saffiano, 0.0017, 0.12, _GOODS),
        ("crocodile_leather", reptile.crocodile, 0.003, 0.25, _GOODS),
        ("snakeskin", reptile.snake, 0.006, 0.2, _GOODS),
        ("lizard_leather", reptile.lizard, 0.002, 0.12, _GOODS),
        ("ostrich_leather", reptile.ostrich, 0.0013, 0.17, _GOODS),
        ("shagreen", reptile.shagreen, 0.0014, 0.12, _GOODS),
        ("quilted_leather", quilted, 0.0016, 0.24, _SEATS),
        ("stitched_leather", stitched, 0.0024, 0.4, _SEATS),
        ("woven_leather", plaited, 0.002, 0.154, _SEATS),
        ("perforated_leather", perforated, 0.0012, 0.124, _SEATS),
    )
}
