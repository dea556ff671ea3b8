"""Families made of wood in pieces: strands, particles, fibres, cork, strips of bamboo."""

from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.library.textures.wood.boards import (
    Boards,
    blocks,
    chevron,
    herringbone,
    planks,
    staves,
)
from openrooms_usd.library.textures.wood.species import BEECH, OAK, WALNUT, Timber
from openrooms_usd.library.textures.wood.timber import Face, face, lacquered


def _strand_board(order: tx.TextureParams) -> tx.Maps:
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


def _chipboard(order: tx.TextureParams) -> tx.Maps:
    """Particles of all sizes, sanded flat."""
    coarse = tx.flakes(order, 1.1, (0.006, 0.016), (0.0015, 0.004), spread=np.pi)
    tone = coarse.each(order.rng.uniform(-1.0, 1.0, coarse.count))
    dust = tx.noise(order, 0.0012)
    shade = 1.0 + 0.2 * tone + 0.06 * dust
    albedo = tx.drawn_color(order, ((0.42, 0.3, 0.17), (0.37, 0.255, 0.14))) * shade[..., None]
    height = 15e-6 * dust - 40e-6 * tx.smoothstep(0.0006, 0.0, coarse.inside)
    return tx.finished(order, albedo, height, tx.drawn_roughness(order, 0.7, 0.85))


def _fibreboard(order: tx.TextureParams) -> tx.Maps:
    """MDF: matted fibres, nearly even."""
    hair = tx.matted(order.rng, order.resolution, order.size, 0.0006, 0.006, 5)
    cloud = tx.fractal(order, 0.08, 0.3)
    shade = 1.0 + 0.05 * hair + 0.025 * cloud
    albedo = tx.drawn_color(order, ((0.36, 0.235, 0.13), (0.3, 0.19, 0.1))) * shade[..., None]
    return tx.finished(
        order, albedo, 6e-6 * hair, tx.drawn_roughness(order, 0.65, 0.8) + 0.01 * cloud
    )


def _cork(order: tx.TextureParams) -> tx.Maps:
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


def _bamboo(order: tx.TextureParams) -> tx.Maps:
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


# Depth of a joint, metres.
_JOINT: Final = 0.5e-3


def _jointed(
    order: tx.TextureParams,
    boards: Boards,
    timber: Timber,
    variety: float = 0.14,
    bevel: float = 2.5e-3,
) -> tx.Maps:
    """Pieces of a floor: dark gaps, small bevels, lacquered or oiled."""
    wood = face(order, boards, timber, variety)
    gap = boards.gap(order, 1.2e-3)
    albedo = wood.colored(order, timber) * (1.0 - 0.75 * gap)[..., None]
    height = wood.height - _JOINT * boards.bevel(bevel)
    roughness = tx.drawn_roughness(order, 0.32, 0.55) + wood.gloss + 0.25 * gap
    return tx.finished(order, albedo, height, roughness)


def _planks(order: tx.TextureParams, timber: Timber) -> tx.Maps:
    return _jointed(order, planks(order, (0.15, 0.15), (0.9, 1.5)), timber)


def _strips(order: tx.TextureParams) -> tx.Maps:
    """Narrow strips of three a board, as ready-made parquet has."""
    return _jointed(order, planks(order, (0.066, 0.066), (0.25, 0.5)), BEECH, 0.16, 0.8e-3)


def _herringbone(order: tx.TextureParams) -> tx.Maps:
    return _jointed(order, herringbone(order, 0.075, 6), OAK)


def _chevron(order: tx.TextureParams) -> tx.Maps:
    return _jointed(order, chevron(order, 0.42, 0.13), replace(WALNUT, streaks=0.15), 0.2)


def _mosaic(order: tx.TextureParams) -> tx.Maps:
    """Squares of five fingers, each turned against the next."""
    return _jointed(order, blocks(order, 0.12, 5), replace(OAK, cut="mixed"), 0.16, 0.6e-3)


def _end_grain(order: tx.TextureParams) -> tx.Maps:
    """Blocks that show the ends of their trunks: rings about a pith that lies beside them."""
    boards = blocks(order, 0.07)
    pith = order.rng.uniform(-0.09, 0.09, (2, boards.count))
    far = np.hypot(
        boards.across - boards.each(pith[0]), boards.along - 0.035 - boards.each(pith[1])
    )
    wave = 0.0007 * tx.noise(order, 0.02) + 0.0003 * tx.noise(order, 0.006)
    rings = (far + boards.spread(order, wave)) / boards.each(
        order.rng.uniform(0.0025, 0.005, boards.count)
    )
    late = tx.smoothstep(0.3, 0.85, rings % 1.0) * (1.0 - tx.smoothstep(0.88, 1.0, rings % 1.0))
    pores = tx.smoothstep(1.2, 2.4, boards.spread(order, tx.noise(order, 0.0008)))
    tone = boards.each(order.rng.uniform(-0.2, 0.2, boards.count))
    gap = boards.gap(order, 0.8e-3)
    shade = (1.0 - 0.35 * late) * (1.0 - 0.3 * pores) * (1.0 + tone) * (1.0 - 0.5 * gap)
    wood = Face(shade, -_JOINT * boards.bevel(1e-3) - 40e-6 * pores, 0.1 * pores, late, late)
    return lacquered(order, wood, replace(OAK, color=(0.33, 0.2, 0.1)), (0.4, 0.6))


_FLOORS: Final[frozenset[tx.Use]] = frozenset({"floor"})

FAMILIES: Final[dict[str, tx.Family]] = {
    "chevron_parquet": tx.Family(_chevron, 1.7, _FLOORS),
    "end_grain_blocks": tx.Family(_end_grain, 0.7, frozenset({"floor", "worktop"})),
    "herringbone_parquet": tx.Family(_herringbone, 1.3, _FLOORS),
    "mosaic_parquet": tx.Family(_mosaic, 0.72, _FLOORS),
    "oak_planks": tx.Family(partial(_planks, timber=OAK), 2.4, _FLOORS, grain=True),
    "strip_parquet": tx.Family(_strips, 1.2, _FLOORS, grain=True),
    "bamboo_strips": tx.Family(
        _bamboo, 0.8, frozenset({"floor", "furniture", "worktop"}), grain=True
    ),
    "chipboard": tx.Family(_chipboard, 0.3, _PLAIN),
    "cork": tx.Family(_cork, 0.3, frozenset({"floor", "wall", "object"})),
    "fibreboard": tx.Family(_fibreboard, 0.3, _PLAIN),
    "strand_board": tx.Family(_strand_board, 0.9, frozenset({"wall", "furniture"}), grain=True),
}
