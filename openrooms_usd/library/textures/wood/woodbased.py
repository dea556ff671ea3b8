"""Families made of wood in pieces: strands, particles, fibres, cork, strips of bamboo."""

from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.library.textures.wood.boards import staves


def _strand_board(order: tx.Order) -> tx.Maps:
    """OSB: long strands of pine, pressed, most of them along the board."""
    laid = tx.flakes(order, 2.4, (0.06, 0.13), (0.008, 0.03), spread=1.0)
    fibre = laid.fibre(order, 0.0012, 0.03)
    tone = laid.each(order.rng.uniform(-1.0, 1.0, laid.count))
    shade = (1.0 + 0.22 * tone + 0.09 * fibre) * (
        1.0 - 0.35 * tx.smoothstep(0.0015, 0.0, laid.inside)
    )
    albedo = tx.drawn_color(order, ((0.47, 0.31, 0.15), (0.42, 0.27, 0.125))) * shade[
        ..., None
    ] ** (np.array([0.85, 1.0, 1.2]))
    height = 0.25e-3 * laid.level + 30e-6 * fibre
    return tx.finished(order, albedo, height, tx.drawn_roughness(order, 0.55, 0.75) - 0.04 * tone)


def _chipboard(order: tx.Order) -> tx.Maps:
    """Particles of all sizes, sanded flat."""
    coarse = tx.flakes(order, 1.1, (0.006, 0.016), (0.0015, 0.004), spread=np.pi)
    tone = coarse.each(order.rng.uniform(-1.0, 1.0, coarse.count))
    dust = tx.noise(order, 0.0012)
    shade = 1.0 + 0.2 * tone + 0.06 * dust
    albedo = tx.drawn_color(order, ((0.42, 0.3, 0.17), (0.37, 0.255, 0.14))) * shade[..., None]
    height = 15e-6 * dust - 40e-6 * tx.smoothstep(0.0006, 0.0, coarse.inside)
    return tx.finished(order, albedo, height, tx.drawn_roughness(order, 0.7, 0.85))


def _fibreboard(order: tx.Order) -> tx.Maps:
    """MDF: matted fibres, nearly even."""
    hair = tx.matted(order.rng, order.resolution, order.size, 0.0006, 0.006, 5)
    cloud = tx.fractal(order, 0.08, 0.3)
    shade = 1.0 + 0.05 * hair + 0.025 * cloud
    albedo = tx.drawn_color(order, ((0.36, 0.235, 0.13), (0.3, 0.19, 0.1))) * shade[..., None]
    return tx.finished(
        order, albedo, 6e-6 * hair, tx.drawn_roughness(order, 0.65, 0.8) + 0.01 * cloud
    )


def _cork(order: tx.Order) -> tx.Maps:
    """Granules of bark, pressed: each its own brown, with dark seams and pores."""
    warp = (0.0006 * tx.noise(order, 0.004), 0.0006 * tx.noise(order, 0.004))
    granules = tx.scattered_cells(order, 0.0055, 1.0, warp)
    tone = order.rng.uniform(-1.0, 1.0, granules.count)[granules.index]
    bark = tx.smoothstep(1.5, 2.2, tx.noise(order, 0.003, 0.0015))
    seam = tx.smoothstep(0.0005, 0.0, granules.edge)
    shade = (1.0 + 0.22 * tone + 0.05 * tx.noise(order, 0.001)) * (1.0 - 0.35 * seam)
    shade = shade * (1.0 - 0.55 * bark)
    albedo = tx.drawn_color(order, ((0.40, 0.24, 0.115), (0.33, 0.19, 0.09))) * shade[
        ..., None
    ] ** (np.array([0.85, 1.0, 1.15]))
    height = -60e-6 * seam - 120e-6 * bark + 15e-6 * tone
    return tx.finished(order, albedo, height, tx.drawn_roughness(order, 0.55, 0.75) + 0.05 * seam)


def _bamboo(order: tx.Order) -> tx.Maps:
    """Strips of bamboo, glued flat, each with the nodes of its cane."""
    strips = staves(order, (0.019, 0.021))
    nodes = tx.whole(order.size, 0.27)
    start = strips.each(order.rng.random(strips.count))
    place = (strips.along / order.size * nodes + start) % 1.0
    node = np.abs(place - 0.5) * (order.size / nodes)
    ring = np.exp(-((node / 0.0018) ** 2)) - 0.6 * np.exp(-(((node - 0.004) / 0.003) ** 2))
    bundle = tx.smoothstep(0.3, 1.8, strips.spread(order, tx.noise(order, 0.0007, 0.15)))
    tone = strips.each(order.rng.uniform(-1.0, 1.0, strips.count))
    shade = (1.0 + 0.09 * tone) * (1.0 - 0.14 * bundle) * (1.0 - 0.3 * ring)
    shade = shade * (1.0 - 0.3 * strips.gap(order, 0.0004))
    albedo = tx.drawn_color(order, ((0.56, 0.40, 0.20), (0.38, 0.22, 0.09))) * shade[..., None] ** (
        np.array([0.9, 1.0, 1.15])
    )
    height = 20e-6 * ring - 8e-6 * bundle
    return tx.finished(order, albedo, height, tx.drawn_roughness(order, 0.3, 0.45) + 0.05 * bundle)


_PLAIN: Final[frozenset[tx.Use]] = frozenset({"furniture", "wall", "object"})

FAMILIES: Final[dict[str, tx.Family]] = {
    "bamboo_strips": tx.Family(
        _bamboo, 0.8, frozenset({"floor", "furniture", "worktop"}), grain=True
    ),
    "chipboard": tx.Family(_chipboard, 0.3, _PLAIN),
    "cork": tx.Family(_cork, 0.3, frozenset({"floor", "wall", "object"})),
    "fibreboard": tx.Family(_fibreboard, 0.3, _PLAIN),
    "strand_board": tx.Family(_strand_board, 0.9, frozenset({"wall", "furniture"}), grain=True),
}
