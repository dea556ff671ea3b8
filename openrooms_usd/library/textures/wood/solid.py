"""Families of solid wood: veneers, staves, floors and boards. Grain runs along t."""

from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.library.textures.wood.boards import planks, staves
from openrooms_usd.library.textures.wood.species import (
    ASH,
    BEECH,
    BIRCH,
    LARCH,
    MAPLE,
    OAK,
    PINE,
    SAPELE,
    WALNUT,
    ZEBRANO,
    Timber,
)
from openrooms_usd.library.textures.wood.timber import face, lacquered

# Depth of a joint, metres.
_JOINT: Final = 0.5e-3


def _veneer(
    order: tx.TextureParams, timber: Timber, leaf: tuple[float, float] = (0.18, 0.26)
) -> tx.Maps:
    """Leaves of one log, side by side like the pages of an open book."""
    wood = face(order, staves(order, leaf, mirrored=True), timber)
    return lacquered(order, wood, timber, (0.28, 0.45))


def _panel(order: tx.TextureParams, timber: Timber, width: tuple[float, float]) -> tx.Maps:
    """Staves glued edge to edge."""
    wood = face(order, staves(order, width), timber)
    return lacquered(order, wood, timber, (0.32, 0.5))


def _butcher_block(order: tx.TextureParams) -> tx.Maps:
    """Short staves, finger-jointed end to end and glued: worktops."""
    boards = planks(order, (0.034, 0.046), (0.25, 0.6))
    wood = face(order, boards, BEECH, 0.14)
    return lacquered(order, wood.darker(1.0 - 0.25 * boards.gap(order, 0.0004)), BEECH, (0.35, 0.5))


def _panelling(order: tx.TextureParams) -> tx.Maps:
    """Knotty boards with tongue and groove: a V at every joint."""
    boards = staves(order, (0.096, 0.096))
    timber = replace(PINE, knots=26.0, knot=(0.005, 0.013))
    wood = face(order, boards, timber, 0.06)
    vee = boards.bevel(5e-3)
    wood = wood.darker((1.0 - 0.5 * boards.gap(order, 2e-3)) * (1.0 - 0.2 * vee))
    maps = lacquered(order, wood, timber, (0.3, 0.45))
    return replace(maps, height=maps.height - 4e-3 * vee)


def _brushed(order: tx.TextureParams) -> tx.Maps:
    """Larch whose soft earlywood was brushed out: the rings stand in relief."""
    boards = staves(order, (0.12, 0.17))
    wood = face(order, boards, LARCH, 0.08)
    maps = lacquered(order, wood, LARCH, (0.6, 0.8))
    scratch = tx.noise(order, 0.0008, 0.08)
    return replace(maps, height=0.8e-3 * wood.late + 30e-6 * scratch - _JOINT * boards.bevel(2e-3))


def _reclaimed(order: tx.TextureParams) -> tx.Maps:
    """Old boards: grey, cracked along the grain, of all widths, with nail holes and stains."""
    boards = planks(order, (0.09, 0.2), (0.6, 1.7))
    timber = replace(PINE, knots=8.0, late=0.3, redder=0.04, color=(0.21, 0.165, 0.125))
    wood = face(order, boards, timber, 0.35)
    cracks = tx.smoothstep(1.7, 2.3, boards.spread(order, tx.noise(order, 0.0018, 0.16)))
    stains = tx.fractal(order, 0.3, 0.3)
    saw = np.sin(2.0 * np.pi * (boards.along + 0.5 * boards.across**2) / 0.006)
    sawn = boards.each((order.rng.random(boards.count) < 0.4).astype(float)) * saw
    gap = boards.gap(order, 3e-3)
    wood = wood.darker(
        (1.0 - 0.6 * cracks) * (1.0 + 0.1 * stains + 0.04 * sawn) * (1.0 - 0.8 * gap)
    )
    rough = tx.drawn_roughness(order, 0.75, 0.92) + 0.03 * stains + wood.gloss
    relief = 0.15e-3 * wood.late + 0.1e-3 * stains + 40e-6 * sawn
    height = relief - 0.8e-3 * cracks - 2.5e-3 * boards.bevel(5e-3)
    return tx.finished(order, wood.colored(order, timber), height, rough)


def _whitewashed(order: tx.TextureParams) -> tx.Maps:
    """Boards painted long ago: the paint is worn off where feet and hands rub, along the grain."""
    boards = planks(order, (0.12, 0.12), (1.2, 2.4))
    wood = face(order, boards, PINE, 0.1)
    rubbed = boards.spread(
        order, 0.9 * tx.noise(order, 0.003, 0.06) + 0.8 * tx.noise(order, 0.05, 0.2)
    )
    worn = tx.smoothstep(0.9, 1.5, rubbed + 1.2 * boards.bevel(4e-3) + 0.5 * (wood.late - 0.5))
    brush = tx.noise(order, 0.0012, 0.12)
    paint = np.array((0.72, 0.71, 0.67)) * (1.0 + 0.02 * brush)[..., None]
    bare = replace(order, color=None)
    albedo = tx.mixed(worn, 0.7 * wood.colored(bare, PINE), paint)
    albedo = albedo * (1.0 - 0.7 * boards.gap(order, 2e-3))[..., None]
    height = 70e-6 * (1.0 - worn) + 12e-6 * brush + wood.height - 1e-3 * boards.bevel(3e-3)
    return tx.finished(order, albedo, height, tx.drawn_roughness(order, 0.5, 0.7) + 0.2 * worn)


def _slats(order: tx.TextureParams) -> tx.Maps:
    """Rounded slats on dark felt, as acoustic panels have."""
    boards = staves(order, (0.04, 0.04))
    wood = face(order, boards, OAK, 0.12)
    solid = tx.smoothstep(0.0055, 0.0065, boards.edge)
    edge = np.clip((boards.edge - 0.006) / 0.003, 0.0, 1.0)
    felt = np.array((0.03, 0.03, 0.031)) * (1.0 + 0.2 * tx.noise(order, 0.001))[..., None]
    albedo = tx.mixed(solid, wood.colored(order, OAK), np.maximum(felt, 0.02))
    height = solid * (2e-3 * np.sqrt(1.0 - (1.0 - edge) ** 2) + 4e-3) + wood.height
    rough = tx.drawn_roughness(order, 0.4, 0.55) * solid + 0.95 * (1.0 - solid)
    return tx.finished(order, albedo, height, rough)


def _charred(order: tx.TextureParams) -> tx.Maps:
    """Boards burnt at their face: the char has cracked into scales."""
    boards = staves(order, (0.13, 0.13))
    wood = face(order, boards, LARCH, 0.15)
    across = boards.spread(order, tx.noise(order, 0.05, 0.006))
    along = boards.spread(order, tx.noise(order, 0.006, 0.07))
    crack = np.maximum(1.0 - np.abs(along) / 0.10, 1.0 - np.abs(across + 0.6 * along) / 0.12).clip(
        0.0, 1.0
    )
    shade = (1.0 + 0.15 * tx.fractal(order, 0.05, 0.4)) * (1.0 - 0.55 * crack)
    albedo = np.array((0.034, 0.033, 0.034)) * np.maximum(shade, 0.6)[..., None]
    height = -0.7e-3 * crack + 0.2e-3 * along + 0.12e-3 * wood.late
    height = height - 3e-3 * boards.bevel(3e-3)
    rough = tx.drawn_roughness(order, 0.5, 0.65) + 0.15 * crack
    return tx.finished(order, np.maximum(albedo, 0.02), height, rough)


def _burl(order: tx.TextureParams) -> tx.Maps:
    """Veneer of a burl: grain that turns about countless small buds."""
    boards = staves(order, (0.3, 0.34), mirrored=True)
    timber = replace(
        WALNUT,
        cut="peeled",
        ring=(0.0022, 0.0034),
        knots=900.0,
        knot=(0.0012, 0.004),
        pore=(0.0012, 0.003),
        pores=0.25,
        late=0.42,
        color=(0.21, 0.115, 0.058),
        redder=0.14,
    )
    wood = face(order, boards, timber)
    swirl = tx.fractal(order, 0.06, 0.7)
    wood = wood.darker(1.0 - 0.22 * np.tanh(boards.spread(order, swirl)))
    return lacquered(order, wood, timber, (0.12, 0.25))


_TOPS: Final[frozenset[tx.Use]] = frozenset({"worktop", "furniture"})
_CABINETS: Final[frozenset[tx.Use]] = frozenset({"furniture", "wall", "object"})

FAMILIES: Final[dict[str, tx.Family]] = {
    "ash_veneer": tx.Family(partial(_veneer, timber=ASH), 1.0, _CABINETS, grain=True),
    "beech_staves": tx.Family(
        partial(_panel, timber=BEECH, width=(0.09, 0.14)), 0.8, _CABINETS | {"worktop"}, grain=True
    ),
    "birch_plywood": tx.Family(
        partial(_panel, timber=BIRCH, width=(1.2, 1.25)), 1.22, _CABINETS, grain=True
    ),
    "birdseye_maple": tx.Family(
        partial(
            _veneer,
            timber=replace(MAPLE, knots=2500.0, knot=(0.0007, 0.0016), ring=(0.003, 0.005)),
            leaf=(0.3, 0.3),
        ),
        0.6,
        _CABINETS,
        grain=True,
    ),
    "brushed_larch": tx.Family(_brushed, 0.9, frozenset({"wall", "furniture"}), grain=True),
    "butcher_block": tx.Family(_butcher_block, 0.9, _TOPS, grain=True),
    "charred_cedar": tx.Family(_charred, 0.8, frozenset({"wall"}), grain=True),
    "curly_maple": tx.Family(
        partial(_veneer, timber=replace(MAPLE, curl=(0.12, 0.009))), 0.6, _CABINETS, grain=True
    ),
    "knotty_pine": tx.Family(_panelling, 1.0, frozenset({"wall", "ceiling"}), grain=True),
    "oak_slats": tx.Family(_slats, 0.6, frozenset({"wall", "ceiling"}), grain=True),
    "pine_staves": tx.Family(
        partial(_panel, timber=replace(PINE, knots=14.0), width=(0.06, 0.09)),
        1.0,
        _CABINETS,
        grain=True,
    ),
    "quartered_oak": tx.Family(
        partial(
            _veneer,
            timber=replace(OAK, cut="quarter", flecks=0.2, fleck=(0.0045, 0.05, 1.15)),
            leaf=(0.14, 0.2),
        ),
        0.8,
        _CABINETS,
        grain=True,
    ),
    "reclaimed_planks": tx.Family(_reclaimed, 2.0, frozenset({"floor", "wall"}), grain=True),
    "sapele_ribbon": tx.Family(partial(_veneer, timber=SAPELE), 0.8, _CABINETS, grain=True),
    "walnut_burl": tx.Family(_burl, 0.6, frozenset({"furniture", "object"})),
    "walnut_veneer": tx.Family(
        partial(_panel, timber=WALNUT, width=(0.07, 0.2)), 1.0, _CABINETS, grain=True
    ),
    "whitewashed_boards": tx.Family(_whitewashed, 1.6, frozenset({"floor", "wall"}), grain=True),
    "zebrano": tx.Family(partial(_veneer, timber=ZEBRANO), 0.6, _CABINETS, grain=True),
}
