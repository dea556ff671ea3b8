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
    IRON,
    NICKEL,
    SILVER,
    STEEL,
    TITANIUM,
    ZINC,
    bare,
    drawn_metal,
)
from openrooms_usd.tables import read_table


def polished_metal(order: tx.TextureParams) -> tx.Maps:
    """Plated and buffed: long waves of the sheet, wiping marks, a few hairlines."""
    metal = drawn_metal(order, CHROMIUM, NICKEL, GOLD, BRASS, SILVER, COPPER)
    gloss = tx.drawn_roughness(order, 0.04, 0.12)
    smear = tx.smoothstep(0.2, 2.2, tx.fractal(order, 0.12, 0.7))
    hair = np.minimum(_hairs(order, 700.0, (0.005, 0.03)), 1.0)
    shade = 1.0 - 0.02 * smear - 0.03 * hair
    height = 8e-6 * tx.noise(order, 0.12) - 0.3e-6 * hair
    return bare(order, metal, shade, height, gloss + 0.04 * smear + 0.06 * hair)


def _hairs(order: tx.TextureParams, density: float, length: tuple[float, float]) -> tx.Field:
    """(N, N) hairlines in all directions, ``density`` of them a square metre."""
    count = max(1, round(density * order.size**2 / 0.09))
    return tx.lines(order, count, length, 0.15, (0.0, 2.0 * np.pi))


def brushed_metal(order: tx.TextureParams) -> tx.Maps:
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


def engine_turned(order: tx.TextureParams) -> tx.Maps:
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


def _ground_profile(order: tx.TextureParams, radius: tx.Field) -> tx.Field:
    """(N, N) one random profile of grinding over the distance from a centre, deviation about 1."""
    table = np.convolve(order.rng.uniform(-1.0, 1.0, 260), [0.25, 0.5, 0.25], "valid") * 2.0
    place = np.clip(radius / 0.006, 0.0, 1.0) * (len(table) - 1)
    return np.asarray(np.interp(place, np.arange(len(table)), table))


def sandblasted_metal(order: tx.TextureParams) -> tx.Maps:
    """Blasted with sharp grit: small craters, the same in all directions."""
    metal = drawn_metal(order, STEEL, ALUMINIUM, TITANIUM)
    matt = tx.drawn_roughness(order, 0.45, 0.62)
    grit = tx.fractal(order, 0.0012, 0.05) + 0.4 * np.abs(tx.noise(order, 0.0009))
    shade = 1.0 + 0.04 * grit + 0.01 * tx.noise(order, 0.05)
    return bare(order, metal, shade, 9e-6 * grit, matt + 0.02 * grit)


def hammered_metal(order: tx.TextureParams) -> tx.Maps:
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


def anodised_aluminium(order: tx.TextureParams) -> tx.Maps:
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


def crumpled_foil(order: tx.TextureParams) -> tx.Maps:
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


def scratched_steel(order: tx.TextureParams) -> tx.Maps:
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


def orbital_sanded(order: tx.TextureParams) -> tx.Maps:
    """Sanded by a machine that circles: countless small hooks and swirls, called angel hair."""
    metal, matt = drawn_metal(order, STEEL, ALUMINIUM), tx.drawn_roughness(order, 0.3, 0.42)
    hooks = tx.lines(order, int(9000 * order.size**2 / 0.16), (0.006, 0.022), 8.0, (0.0, 2 * np.pi))
    hook = np.minimum(hooks, 2.0) - 0.6
    shade = 0.93 + 0.08 * hook
    return bare(order, metal, shade, -2.5e-6 * hook, matt + 0.035 * hook)


_PALETTES: Final = read_table(__file__, "palettes.toml")

RUST: Final[tuple[tx.Color, ...]] = ((0.24, 0.085, 0.032), (0.16, 0.055, 0.028), (0.30, 0.13, 0.05))
OLD_RUST: Final[tuple[tx.Color, ...]] = ((0.065, 0.034, 0.026), (0.09, 0.042, 0.028))
VERDIGRIS: Final[tuple[tx.Color, ...]] = _PALETTES["corroded_verdigris"]
TARNISH: Final[tuple[tx.Color, ...]] = ((0.085, 0.05, 0.036), (0.06, 0.04, 0.032))


def cast_iron(order: tx.TextureParams) -> tx.Maps:
    """Iron as it left the sand: the mould's grains, a few blisters and pits, darkened by oil."""
    metal, matt = 0.42 * drawn_metal(order, IRON), tx.drawn_roughness(order, 0.5, 0.66)
    sand = tx.fractal(order, 0.0035, 0.15)
    lump = tx.noise(order, 0.006) + 0.6 * tx.noise(order, 0.02)
    pit = tx.covered(order, tx.pits(order, 0.02, (0.0004, 0.0018)).inside)
    shade = np.maximum(1.0 + 0.07 * sand + 0.05 * lump, 0.3) * (1.0 - 0.4 * pit)
    height = 45e-6 * sand + 110e-6 * lump - 0.0005 * pit
    return bare(order, metal, shade, height, matt + 0.03 * sand + 0.1 * pit)


def galvanised_steel(order: tx.TextureParams) -> tx.Maps:
    """Hot-dip zinc: crystals of 10 to 30 mm (spangle), feathers of one grey each."""
    metal, matt = 0.92 * drawn_metal(order, ZINC), tx.drawn_roughness(order, 0.3, 0.45)
    width = order.rng.uniform(0.014, 0.026)
    rag = (
        0.07 * width * tx.noise(order, 0.15 * width),
        0.07 * width * tx.noise(order, 0.15 * width),
    )
    grains = tx.scattered_cells(order, width, 1.0, rag)
    angle = order.rng.uniform(0.0, np.pi, grains.count)[grains.index]
    along = np.cos(angle) * grains.across + np.sin(angle) * grains.up
    beside = np.abs(np.cos(angle) * grains.up - np.sin(angle) * grains.across)
    # Side branches leave the stem at 60 degrees.
    branch = np.cos(2.0 * np.pi * (along + 0.58 * beside) / (0.05 * width))
    dull = order.rng.random(grains.count)[grains.index]
    feather = branch * (0.3 + 0.7 * dull)
    cloud = tx.fractal(order, 0.1, 0.4)
    shade = 0.66 + 0.42 * dull + 0.06 * feather + 0.03 * cloud
    tilt = order.rng.uniform(-0.006, 0.006, (2, grains.count))[:, grains.index]
    inner = np.minimum(grains.edge / (0.15 * width), 1.0)
    height = inner * (tilt[0] * grains.across + tilt[1] * grains.up) + 2e-6 * feather
    rough = matt + 0.16 * (0.5 - dull) - 0.02 * feather + 0.02 * cloud
    return bare(order, metal, shade, height + 15e-6 * tx.noise(order, 0.05), rough)


def patina_copper(order: tx.TextureParams) -> tx.Maps:
    """Copper that weathered: brown tarnish, and verdigris that ran down in streaks."""
    metal, matt = drawn_metal(order, COPPER, BRONZE), tx.drawn_roughness(order, 0.3, 0.42)
    tarnish, green = tx.side_color(order, TARNISH), tx.side_color(order, VERDIGRIS)
    run = tx.noise(order, 0.025, 0.3) + 0.6 * tx.noise(order, 0.007, 0.14)
    spread, crust = tx.fractal(order, 0.25, 0.35), tx.fractal(order, 0.015, 0.15)
    amount = 0.38 * run + 0.95 * spread + 0.4 * crust + order.rng.uniform(-0.1, 0.4)
    grown = tx.smoothstep(-0.25, 0.35, amount)
    brown = np.clip(0.72 + 0.18 * spread - 0.10 * run + 0.08 * crust, 0.0, 0.95)
    chalk = np.exp(np.multiply.outer(0.09 * crust + 0.12 * run, (1.3, 0.9, 0.95)))
    skin = tx.mixed(brown, tarnish * np.ones((1, 1, 3)), metal * np.ones((1, 1, 3)))
    albedo = tx.mixed(grown, green * chalk, skin)
    height = grown * (45e-6 + 25e-6 * crust) + 10e-6 * spread
    rough = matt + 0.18 * brown + grown * (0.36 + 0.02 * crust)
    return tx.finished(order, albedo, height, rough, (1.0 - grown) * (1.0 - 0.6 * brown))


def rusted_iron(order: tx.TextureParams) -> tx.Maps:
    """Iron under rust: islands of bare dark metal, orange bloom, scale that flakes off."""
    metal, matt = 0.6 * drawn_metal(order, IRON, STEEL), tx.drawn_roughness(order, 0.35, 0.5)
    fresh, old = tx.side_color(order, RUST), tx.side_color(order, OLD_RUST)
    spread, crust = tx.fractal(order, 0.16, 0.35), tx.fractal(order, 0.02, 0.15)
    fine = tx.fractal(order, 0.003, 0.05)
    amount = spread + 0.45 * crust + order.rng.uniform(0.2, 0.6)
    rust = tx.smoothstep(-0.45, -0.1, amount)
    flake = tx.smoothstep(0.95, 1.05, amount + 0.5 * tx.noise(order, 0.01))
    age = tx.smoothstep(-0.6, 1.4, 0.8 * crust + 0.5 * spread + 0.5 * tx.noise(order, 0.03))
    tone = np.exp(0.16 * fine + 0.13 * crust)[..., None]
    body = tx.mixed(age, old * np.ones((1, 1, 3)), fresh * np.ones((1, 1, 3))) * tone
    albedo = tx.mixed(rust, body, metal * (1.0 + 0.05 * fine + 0.04 * crust)[..., None])
    height = rust * (60e-6 + 55e-6 * crust + 28e-6 * fine) + 0.00025 * flake
    rough = matt + 0.06 * crust + rust * (0.42 + 0.03 * fine)
    return tx.finished(order, albedo, height, rough, 1.0 - rust)


def tarnished_brass(order: tx.TextureParams) -> tx.Maps:
    """Handled brass, bronze or silver: tarnished in blots and drops, rubbed bright between."""
    metal, gloss = drawn_metal(order, BRASS, SILVER, BRONZE), tx.drawn_roughness(order, 0.16, 0.28)
    tarnish = tx.side_color(order, TARNISH)
    drops = tx.pits(order, 0.14, (0.0008, 0.007))
    rim = np.exp(-((drops.inside / 0.0005) ** 2))
    drop = tx.covered(order, drops.inside) * order.rng.uniform(0.1, 0.6, drops.count)[drops.index]
    blot = tx.smoothstep(0.1, 1.8, tx.fractal(order, 0.08, 0.6))
    dark = np.clip(0.8 * blot + 0.35 * drop + 0.2 * rim, 0.0, 0.9)
    albedo = tx.mixed(dark, 2.2 * tarnish * np.ones((1, 1, 3)), metal * np.ones((1, 1, 3)))
    height = 2e-6 * dark + 12e-6 * tx.noise(order, 0.03) + 3e-6 * rim
    return tx.finished(order, albedo, height, gloss + 0.35 * dark, 1.0 - 0.35 * dark)


FAMILIES: Final[dict[str, tx.Family]] = {
    "cast_iron": tx.Family(cast_iron, 0.2, frozenset({"object"}), metallic=1.0),
    "galvanised_steel": tx.Family(
        galvanised_steel, 0.4, frozenset({"object", "wall"}), metallic=1.0
    ),
    "patina_copper": tx.Family(
        patina_copper, 0.6, frozenset({"object", "wall"}), grain=True, metallic=None
    ),
    "rusted_iron": tx.Family(rusted_iron, 0.5, frozenset({"object", "wall"}), metallic=None),
    "tarnished_brass": tx.Family(tarnished_brass, 0.25, frozenset({"object"}), metallic=None),
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
