"""Metal and what time makes of it: castings, spangled zinc, verdigris, rust, tarnish.

Where the metal is covered, the metalness is 0 and the colour is that of the oxide, chosen by eye.
"""

from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.library.textures.metal.metals import (
    BRASS,
    BRONZE,
    COPPER,
    IRON,
    SILVER,
    STEEL,
    ZINC,
    bare,
    drawn_metal,
)
from openrooms_usd.tables import read_table

_PALETTES: Final = read_table(__file__, "palettes.toml")

RUST: Final[tuple[tx.Color, ...]] = ((0.24, 0.085, 0.032), (0.16, 0.055, 0.028), (0.30, 0.13, 0.05))
OLD_RUST: Final[tuple[tx.Color, ...]] = ((0.065, 0.034, 0.026), (0.09, 0.042, 0.028))
VERDIGRIS: Final[tuple[tx.Color, ...]] = _PALETTES["corroded_verdigris"]
TARNISH: Final[tuple[tx.Color, ...]] = ((0.085, 0.05, 0.036), (0.06, 0.04, 0.032))


def cast_iron(order: tx.Order) -> tx.Maps:
    """Iron as it left the sand: the mould's grains, a few blisters and pits, darkened by oil."""
    metal, matt = 0.42 * drawn_metal(order, IRON), tx.drawn_roughness(order, 0.5, 0.66)
    sand = tx.fractal(order, 0.0035, 0.15)
    lump = tx.noise(order, 0.006) + 0.6 * tx.noise(order, 0.02)
    pit = tx.covered(order, tx.pits(order, 0.02, (0.0004, 0.0018)).inside)
    shade = np.maximum(1.0 + 0.07 * sand + 0.05 * lump, 0.3) * (1.0 - 0.4 * pit)
    height = 45e-6 * sand + 110e-6 * lump - 0.0005 * pit
    return bare(order, metal, shade, height, matt + 0.03 * sand + 0.1 * pit)


def galvanised_steel(order: tx.Order) -> tx.Maps:
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


def patina_copper(order: tx.Order) -> tx.Maps:
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


def rusted_iron(order: tx.Order) -> tx.Maps:
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


def tarnished_brass(order: tx.Order) -> tx.Maps:
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
}
