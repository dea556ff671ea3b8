"""Families of wooden floors: planks, strips and parquets, with joints that are seen and felt."""

from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.library.textures.wood.boards import Boards, blocks, chevron, herringbone, planks
from openrooms_usd.library.textures.wood.species import BEECH, OAK, WALNUT, Timber
from openrooms_usd.library.textures.wood.timber import Face, face, lacquered

# Depth of a joint, metres.
_JOINT: Final = 0.5e-3


def _jointed(
    order: tx.Order, boards: Boards, timber: Timber, variety: float = 0.14, bevel: float = 2.5e-3
) -> tx.Maps:
    """Pieces of a floor: dark gaps, small bevels, lacquered or oiled."""
    wood = face(order, boards, timber, variety)
    gap = boards.gap(order, 1.2e-3)
    albedo = wood.colored(order, timber) * (1.0 - 0.75 * gap)[..., None]
    height = wood.height - _JOINT * boards.bevel(bevel)
    roughness = tx.drawn_roughness(order, 0.32, 0.55) + wood.gloss + 0.25 * gap
    return tx.finished(order, albedo, height, roughness)


def _planks(order: tx.Order, timber: Timber) -> tx.Maps:
    return _jointed(order, planks(order, (0.15, 0.15), (0.9, 1.5)), timber)


def _strips(order: tx.Order) -> tx.Maps:
    """Narrow strips of three a board, as ready-made parquet has."""
    return _jointed(order, planks(order, (0.066, 0.066), (0.25, 0.5)), BEECH, 0.16, 0.8e-3)


def _herringbone(order: tx.Order) -> tx.Maps:
    return _jointed(order, herringbone(order, 0.075, 6), OAK)


def _chevron(order: tx.Order) -> tx.Maps:
    return _jointed(order, chevron(order, 0.42, 0.13), replace(WALNUT, streaks=0.15), 0.2)


def _mosaic(order: tx.Order) -> tx.Maps:
    """Squares of five fingers, each turned against the next."""
    return _jointed(order, blocks(order, 0.12, 5), replace(OAK, cut="mixed"), 0.16, 0.6e-3)


def _end_grain(order: tx.Order) -> tx.Maps:
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
}
