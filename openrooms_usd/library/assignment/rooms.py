"""What floors and walls are made of, by the type of the room.

The substances of each type are OpenRooms' own lists: those of floors as they stand; walls have
paint and rough stone, fabric where the floor may have it, and specular stone in bathrooms. How
often each is taken, and which families of it suit the room, is ours.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Literal

import numpy as np

from openrooms_usd.description.substances import Substance
from openrooms_usd.library.assignment.weights import Weights, drawn, families_for

Place = Literal["floor", "wall", "ceiling"]
Substances = Mapping[Substance, float]


@dataclass(frozen=True)
class Surfaces:
    """What a type of room has.

    Attributes:
        floor: Substances of its floor, with weights.
        wall: Substances of its walls, with weights.
        suited: Families that suit this type better than those of `USUAL`, by place and substance.
    """

    floor: Substances
    wall: Substances
    suited: Mapping[tuple[Place, Substance], Weights] = field(default_factory=dict)


_NO_FACTORS: Final[Weights] = {}
_PAINTED: Final[Substances] = {"paint": 1.0}
_SOFT: Final[Substances] = {"paint": 10.0, "fabric": 1.5, "rough_stone": 0.5}
_HARD: Final[Substances] = {"paint": 10.0, "rough_stone": 1.0}
_BARE: Final[Substances] = {"paint": 5.0, "rough_stone": 5.0}


def _floor(
    wood: float = 0.0, fabric: float = 0.0, specular_stone: float = 0.0, rough_stone: float = 0.0
) -> Substances:
    given: Substances = {
        "wood": wood,
        "fabric": fabric,
        "specular_stone": specular_stone,
        "rough_stone": rough_stone,
    }
    return {name: weight for name, weight in given.items() if weight}


# The families of each substance that suit a place, with weights, wherever a room says nothing else.
USUAL: Final[dict[Place, dict[Substance, Weights]]] = {
    "floor": {
        "wood": {
            "oak_planks": 5, "strip_parquet": 2, "herringbone_parquet": 2, "chevron_parquet": 1,
            "bamboo_strips": 0.7, "mosaic_parquet": 0.6, "whitewashed_boards": 0.1,
            "reclaimed_planks": 0.4, "cork": 0.2,
        },
        "fabric": {
            "cut_carpet": 4, "loop_carpet": 3, "needlefelt_carpet": 1, "sisal": 0.7,
            "shag_carpet": 0.3,
        },
        "specular_stone": {
            "porcelain_tiles": 6, "terrazzo": 0.5, "carrara_marble": 1, "granite": 0.5,
            "polished_concrete": 1, "hexagon_mosaic": 0.5, "checkerboard_marble": 0.1,
        },
        "rough_stone": {
            "slate": 2, "terracotta_tiles": 2, "travertine": 2, "quarry_hexagons": 1,
            "sandstone": 1, "shell_limestone": 1, "cast_concrete": 1, "basalt": 0.3,
        },
        "plastic": {
            "linoleum": 3, "vinyl_planks": 3, "vinyl_composition_tiles": 2, "chip_vinyl": 0.3,
            "studded_vinyl": 0.2,
        },
    },
    "wall": {
        "paint": {
            "roller_matt": 9, "orange_peel": 1, "embossed_wallpaper": 0.8, "limewash": 0.6,
            "woodchip_wallpaper": 0.6, "skip_trowel": 0.4, "venetian_plaster": 0.4,

        },
        "fabric": {"linen": 4, "repp": 1, "canvas": 1, "damask": 0.1},
        "rough_stone": {
            "trowelled_plaster": 6, "running_bond_brick": 2, "whitewashed_brick": 0.5, "stucco": 1,
            "cast_concrete": 1, "split_face_ledger": 0.2, "fieldstone_wall": 0.1, "ashlar": 0.2,
        },
        "specular_stone": {
            "porcelain_tiles": 4, "subway_tiles": 4, "zellige": 0.5, "hexagon_mosaic": 0.6,
            "carrara_marble": 0.8, "penny_mosaic": 0.3,
        },
        "wood": {"knotty_pine": 1, "oak_slats": 1, "brushed_larch": 2},
    },
    "ceiling": {
        "paint": {"roller_matt": 1},
        "rough_stone": {"trowelled_plaster": 3, "cast_concrete": 1},
        "wood": {"knotty_pine": 2, "oak_slats": 1},
    },
}  # fmt: skip

# Work wears: hard pile, hard stone, bare masonry.
_WORK: Final[dict[tuple[Place, Substance], Weights]] = {
    ("floor", "fabric"): {"loop_carpet": 3, "needlefelt_carpet": 3, "cut_carpet": 1},
    ("floor", "specular_stone"): {
        "porcelain_tiles": 5, "terrazzo": 3, "polished_concrete": 2, "granite": 1,
    },
}  # fmt: skip
_PUBLIC: Final[dict[tuple[Place, Substance], Weights]] = {
    **_WORK,
    ("floor", "specular_stone"): {
        "terrazzo": 4, "porcelain_tiles": 3, "granite": 2, "polished_concrete": 1,
        "carrara_marble": 1,
    },
}  # fmt: skip
_CELLAR: Final[dict[tuple[Place, Substance], Weights]] = {
    ("floor", "rough_stone"): {
        "cast_concrete": 8, "quarry_hexagons": 0.5, "exposed_aggregate": 0.5,
    },
    ("floor", "specular_stone"): {"polished_concrete": 1},
    ("floor", "wood"): {"reclaimed_planks": 1, "end_grain_blocks": 1},
    ("wall", "rough_stone"): {
        "cast_concrete": 3, "running_bond_brick": 3, "whitewashed_brick": 2,
        "board_formed_concrete": 1,
    },
    ("wall", "paint"): {"roller_matt": 1},
}  # fmt: skip
_WET: Final[dict[tuple[Place, Substance], Weights]] = {
    ("floor", "specular_stone"): {
        "porcelain_tiles": 5, "hexagon_mosaic": 2, "penny_mosaic": 0.7, "terrazzo": 1,
        "checkerboard_marble": 0.2, "carrara_marble": 0.7,
    },
    ("floor", "rough_stone"): {"slate": 2, "travertine": 2, "quarry_hexagons": 1, "basalt": 0.5},
    ("wall", "rough_stone"): {"trowelled_plaster": 3, "travertine": 2, "slate": 1},
    ("wall", "paint"): {"roller_matt": 4, "venetian_plaster": 1},
}  # fmt: skip
_SPORT: Final[dict[tuple[Place, Substance], Weights]] = {
    ("floor", "wood"): {"strip_parquet": 4, "oak_planks": 2, "mosaic_parquet": 1},
}

ROOMS: Final[dict[str, Surfaces]] = {
    "apartment": Surfaces(_floor(7, 1, 1.5, 0.5), _SOFT),
    "bathroom": Surfaces(
        _floor(specular_stone=7, rough_stone=2),
        {"specular_stone": 6.0, "paint": 3.0, "rough_stone": 1.0},
        _WET,
    ),
    "bedroom": Surfaces(_floor(6, 3, rough_stone=0.3), _SOFT),
    "hotel": Surfaces(_floor(3, 6, rough_stone=0.3), _SOFT, _PUBLIC),
    "bookstore": Surfaces(_floor(6, 2, 1.5, 1), _SOFT, _WORK),
    "library": Surfaces(_floor(5, 4, 1, 0.5), _SOFT, _WORK),
    "classroom": Surfaces(_floor(5, 0, 3, 1), _HARD, _WORK),
    "closet": Surfaces(_floor(6, 3, 0.5, 0.3), _SOFT),
    "computer_cluster": Surfaces(_floor(4, 0, 3, 2), _HARD, _WORK),
    "conference_room": Surfaces(_floor(4, 5, 1, 0.3), _SOFT, _WORK),
    "copy_room": Surfaces(_floor(3, 0, 4, 2), _HARD, _WORK),
    "mail_room": Surfaces(_floor(3, 0, 4, 2), _HARD, _WORK),
    "dining_room": Surfaces(_floor(7, 1, 1.5, 1), _SOFT),
    "game_room": Surfaces(_floor(5, 3, 1, 0.5), _SOFT),
    "gym": Surfaces(_floor(8, 0, 0.5, 1), _HARD, _SPORT),
    "hallway": Surfaces(_floor(5, 0, 4, 1.5), _HARD, _PUBLIC),
    "kitchen": Surfaces(_floor(3, 0, 5, 2), _HARD),
    "laundry_room": Surfaces(_floor(1, 0, 6, 3), _HARD, _WET),
    "lounge": Surfaces(_floor(5, 3, 1, 0.5), _SOFT),
    "living_room": Surfaces(_floor(7, 2, 1, 0.5), _SOFT),
    "lobby": Surfaces(_floor(1.5, 1, 6, 1), _SOFT, _PUBLIC),
    "office": Surfaces(_floor(5, 4, 0.5, 0.5), _SOFT, _WORK),
    "stairs": Surfaces(_floor(4, 1, 3, 2), _SOFT, _PUBLIC),
    "storage": Surfaces(_floor(1.5, 0, 1, 6), _BARE, _CELLAR),
    "basement": Surfaces(_floor(1, 0, 1, 7), _BARE, _CELLAR),
    "garage": Surfaces(_floor(0.2, 0, 0.3, 9), _BARE, _CELLAR),
    "misc": Surfaces(_floor(6, 0, 2, 2), _HARD),
}


def substance_of(
    room: str, place: Place, rng: np.random.Generator, factors: Weights = _NO_FACTORS
) -> Substance:
    """Draw what a place in a room of this type is made of; ceilings are painted.

    Args:
        room: The type.
        place: Floor, wall or ceiling.
        rng: Draws it.
        factors: How much more or less often substances are drawn.
    """
    usual = {"floor": ROOMS[room].floor, "wall": ROOMS[room].wall}.get(place, _PAINTED)
    weights = {name: weight * factors.get(name, 1.0) for name, weight in usual.items()}
    return drawn(rng, weights if any(weights.values()) else usual)


def families_of(room: str, place: Place, substance: Substance) -> Weights:
    """The families of a substance that suit a place in a room of this type."""
    own = ROOMS[room].suited.get((place, substance))
    return own or USUAL[place].get(substance) or families_for(substance, {place})


def surface_of(room: str, place: Place, rng: np.random.Generator) -> tuple[str, Substance]:
    """Draw the family that a place in a room of this type has, and its substance."""
    substance = substance_of(room, place, rng)
    return drawn(rng, families_of(room, place, substance)), substance
