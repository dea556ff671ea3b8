"""Metal by the tool that finished its face: polished, brushed, blasted, hammered, crumpled."""

from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.library.textures.metal.metals import (
    ALUMINIUM,
    BRASS,
    BRONZE,
    CHROMIUM,
    COPPER,
    GOLD,
    NICKEL,
    SILVER,
    STEEL,
    TITANIUM,
    bare,
    drawn_metal,
)


def polished_metal(order: tx.Order) -> tx.Maps:
    """Plated and buffed: long waves of the sheet, wiping marks, a few hairlines."""
    metal = drawn_metal(order, CHROMIUM, NICKEL, GOLD, BRASS, SILVER, COPPER)
    gloss = tx.drawn_roughness(order, 0.04, 0.12)
    smear = tx.smoothstep(0.2, 2.2, tx.fractal(order, 0.12, 0.7))
    hair = np.minimum(_hairs(order, 700.0, (0.005, 0.03)), 1.0)
    shade = 1.0 - 0.02 * smear - 0.03 * hair
    height = 8e-6 * tx.noise(order, 0.12) - 0.3e-6 * hair
    return bare(order, metal, shade, height, gloss + 0.04 * smear + 0.06 * hair)


def _hairs(order: tx.Order, density: float, length: tuple[float, float]) -> tx.Field:
    """(N, N) hairlines in all directions, ``density`` of them a square metre."""
    count = max(1, round(density * order.size**2 / 0.09))
    return tx.lines(order, count, length, 0.15, (0.0, 2.0 * np.pi))


def brushed_metal(order: tx.Order) -> tx.Maps:
    """Ground with a belt: fine furrows along t, of uneven depth and length."""
    metal = drawn_metal(order, STEEL, ALUMINIUM, BRASS, NICKEL, COPPER)
    matt = tx.drawn_roughness(order, 0.25, 0.4)
    furrow = (
        tx.noise(order, 0.0006, 0.12)
        + 0.7 * tx.noise(order, 0.0015, 0.25)
        + 0.4 * tx.noise(order, 0.006, 1.0)
    )
    furrow = furrow / 1.28
    deep = tx.smoothstep(1.6, 2.6, furrow)
    shade = 1.0 + 0.035 * furrow - 0.06 * deep
    return bare(order, metal, shade, 4e-6 * furrow - 8e-6 * deep, matt + 0.03 * furrow)


def engine_turned(order: tx.Order) -> tx.Maps:
    """Perlage: spots of 8 mm, ground by a turning peg, each over the edge of the one before."""
    metal = drawn_metal(order, STEEL, ALUMINIUM, NICKEL)
    matt = tx.drawn_roughness(order, 0.2, 0.32)
    spots = tx.scales(order, 0.008)
    radius = spots.radius + 0.00003 * tx.noise(order, 0.001)
    ring = _ground_profile(order, radius)
    # Where the rings lie across the light they shine: two fans a spot.
    fan = np.cos(2.0 * np.arctan2(spots.up, spots.across))
    rim = 1.0 - tx.smoothstep(0.0, 0.00025, spots.edge)
    shade = 0.93 + 0.07 * ring + 0.07 * fan - 0.08 * rim
    height = 2.5e-6 * ring + 45e-6 * (radius / 0.004) ** 2 - 4e-6 * rim
    return bare(order, metal, shade, height, matt + 0.04 * ring + 0.04 * fan)


def _ground_profile(order: tx.Order, radius: tx.Field) -> tx.Field:
    """(N, N) one random profile of grinding over the distance from a centre, deviation about 1."""
    table = np.convolve(order.rng.uniform(-1.0, 1.0, 260), [0.25, 0.5, 0.25], "valid") * 2.0
    place = np.clip(radius / 0.006, 0.0, 1.0) * (len(table) - 1)
    return np.asarray(np.interp(place, np.arange(len(table)), table))


def sandblasted_metal(order: tx.Order) -> tx.Maps:
    """Blasted with sharp grit: small craters, the same in all directions."""
    metal = drawn_metal(order, STEEL, ALUMINIUM, TITANIUM)
    matt = tx.drawn_roughness(order, 0.45, 0.62)
    grit = tx.fractal(order, 0.0012, 0.05) + 0.4 * np.abs(tx.noise(order, 0.0009))
    shade = 1.0 + 0.04 * grit + 0.01 * tx.noise(order, 0.05)
    return bare(order, metal, shade, 9e-6 * grit, matt + 0.02 * grit)


def hammered_metal(order: tx.Order) -> tx.Maps:
    """Raised by hand: facets of 8 to 14 mm, each a shallow bowl, with soft ridges between."""
    metal = drawn_metal(order, COPPER, BRASS, SILVER, BRONZE)
    gloss = tx.drawn_roughness(order, 0.15, 0.3)
    width = order.rng.uniform(0.009, 0.014)
    bent = (0.04 * width * tx.noise(order, width), 0.04 * width * tx.noise(order, width))
    blows = tx.scattered_cells(order, width, 0.8, bent)
    deep = order.rng.uniform(0.00018, 0.0003)
    # A bowl is steepest where it meets the next, by 4 deep / width: there the ridge is rounded off.
    round_ = 0.09 * width
    ridge = np.exp(-blows.edge / round_)
    height = deep * (blows.radius / (0.5 * width)) ** 2 - 4.0 * deep / width * round_ * ridge
    height = height + 0.00012 * tx.noise(order, 3.0 * width)
    dark = 0.05 * (1.0 - ridge) + 0.06 * tx.smoothstep(0.0, 2.0, tx.fractal(order, 0.03, 0.4))
    hair = np.minimum(_hairs(order, 900.0, (0.003, 0.012)), 1.0)
    return bare(order, metal, 1.0 - dark - 0.03 * hair, height, gloss + 0.5 * dark + 0.04 * hair)


def anodised_aluminium(order: tx.Order) -> tx.Maps:
    """Extruded, etched and anodised: die lines along t from end to end under a matt skin."""
    tints = (
        ALUMINIUM,
        (0.62, 0.60, 0.56),
        (0.30, 0.28, 0.26),
        (0.55, 0.38, 0.22),
        (0.25, 0.30, 0.38),
    )
    metal, matt = drawn_metal(order, *tints), tx.drawn_roughness(order, 0.35, 0.5)
    # A die line has no end: a long filter along t leaves only what is constant.
    die = tx.noise(order, 0.0011, 40.0 * order.size) + 0.8 * tx.noise(
        order, 0.008, 40.0 * order.size
    )
    etch = tx.fractal(order, 0.0009, 0.1)
    shade = 1.0 + 0.025 * die + 0.02 * etch
    return bare(
        order, metal, shade, 1.2e-6 * die + 2.2e-6 * etch, matt + 0.012 * die + 0.012 * etch
    )


def crumpled_foil(order: tx.Order) -> tx.Maps:
    """Foil that was crushed and smoothed out: flat facets between sharp creases."""
    metal, gloss = (
        drawn_metal(order, ALUMINIUM, GOLD, COPPER),
        tx.drawn_roughness(order, 0.12, 0.22),
    )
    height = 0.05 * 0.02 * tx.noise(order, 0.15)
    for width, steep in ((0.075, 0.30), (0.026, 0.22)):
        bent = (0.05 * width * tx.noise(order, width), 0.05 * width * tx.noise(order, width))
        facets = tx.scattered_cells(order, width, 1.0, bent)
        slope = steep * order.rng.uniform(-1.0, 1.0, facets.count)[facets.index]
        height = height + slope * facets.facet / width
    height = height + 0.00005 * np.abs(tx.noise(order, 0.006))
    rubbed = tx.fractal(order, 0.02, 0.3)
    return bare(order, metal, 1.0 + 0.01 * rubbed, height, gloss + 0.015 * rubbed)


def scratched_steel(order: tx.Order) -> tx.Maps:
    """Years of use: scratches in all directions, a few deep, over a faint old grain."""
    metal, gloss = drawn_metal(order, STEEL, CHROMIUM), tx.drawn_roughness(order, 0.2, 0.3)
    scale = order.size**2 / 0.16
    fine = tx.lines(order, int(2600 * scale), (0.01, 0.07), 0.25, (0.0, 2.0 * np.pi))
    deep = tx.lines(order, int(60 * scale), (0.03, 0.16), 0.35, (-0.6, 0.9))
    grain = tx.noise(order, 0.0012, 0.15)
    cloud = tx.fractal(order, 0.12, 0.5)
    cut = np.minimum(fine, 1.5)
    gouge = np.minimum(deep, 1.0)
    shade = 0.93 + 0.10 * cut - 0.3 * gouge + 0.015 * cloud
    height = -3e-6 * cut - 14e-6 * gouge + 0.5e-6 * grain + 20e-6 * tx.noise(order, 0.15)
    rough = gloss + 0.07 * cut + 0.15 * gouge + 0.025 * cloud
    return bare(order, metal, shade, height, rough)


def orbital_sanded(order: tx.Order) -> tx.Maps:
    """Sanded by a machine that circles: countless small hooks and swirls, called angel hair."""
    metal, matt = drawn_metal(order, STEEL, ALUMINIUM), tx.drawn_roughness(order, 0.3, 0.42)
    hooks = tx.lines(order, int(9000 * order.size**2 / 0.16), (0.006, 0.022), 8.0, (0.0, 2 * np.pi))
    hook = np.minimum(hooks, 2.0) - 0.6
    shade = 0.93 + 0.08 * hook
    return bare(order, metal, shade, -2.5e-6 * hook, matt + 0.035 * hook)


FAMILIES: Final[dict[str, tx.Family]] = {
    "polished_metal": tx.Family(
        polished_metal, 0.3, frozenset({"furniture", "object"}), metallic=1.0
    ),
    "brushed_metal": tx.Family(
        brushed_metal, 0.3, frozenset({"furniture", "object", "worktop"}), grain=True, metallic=1.0
    ),
    "engine_turned": tx.Family(engine_turned, 0.1, frozenset({"object", "wall"}), metallic=1.0),
    "sandblasted_metal": tx.Family(
        sandblasted_metal, 0.1, frozenset({"furniture", "object"}), metallic=1.0
    ),
    "hammered_metal": tx.Family(hammered_metal, 0.2, frozenset({"object"}), metallic=1.0),
    "anodised_aluminium": tx.Family(
        anodised_aluminium, 0.15, frozenset({"furniture", "object"}), grain=True, metallic=1.0
    ),
    "crumpled_foil": tx.Family(crumpled_foil, 0.3, frozenset({"object"}), metallic=1.0),
    "scratched_steel": tx.Family(
        scratched_steel, 0.4, frozenset({"worktop", "object"}), metallic=1.0
    ),
    "orbital_sanded": tx.Family(
        orbital_sanded, 0.3, frozenset({"worktop", "furniture", "object"}), metallic=1.0
    ),
}
