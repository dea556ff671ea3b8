"""How much lies on a surface, by what it is used for."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from openrooms_usd.library.furniture.lying import Place

LEVELS: Final = 3
"""1 tidy, 2 lived in, 3 messy."""


@dataclass(frozen=True)
class Amount:
    """How many things (or stacks, rows, pairs) lie on a surface.

    Attributes:
        each: For each square metre.
        most: On one surface.
        chance: How often anything lies there at all.
        shares: What each level adds, as a share of the number at the second one.
    """

    each: float
    most: int
    chance: float = 1.0
    shares: tuple[float, float, float] = (0.45, 0.55, 0.9)


_BOARD: Final = Amount(14.0, 5, 0.8)
_HIDDEN: Final = Amount(8.0, 2, 0.4, (0.5, 0.5, 0.5))
_ELSEWHERE: Final = Amount(5.0, 4)

AMOUNTS: Final[Mapping[Place, Amount]] = {
    "worktop": Amount(7.0, 6),
    "sink_edge": Amount(7.0, 4),
    "hob": Amount(6.0, 2, 0.7),
    "dining_table": Amount(3.0, 7),
    "coffee_table": Amount(9.0, 6),
    "side_table": Amount(16.0, 3),
    "desk": Amount(8.0, 9),
    "bedside": Amount(26.0, 4),
    "dresser_top": Amount(10.0, 6),
    "cabinet_top": Amount(8.0, 6),
    "media_top": Amount(6.0, 5),
    "appliance_top": Amount(7.0, 3),
    "shop_counter": Amount(4.0, 4),
    "mantel": Amount(14.0, 5),
    "basin_edge": Amount(24.0, 6),
    "bath_rim": Amount(10.0, 4),
    "cistern": Amount(24.0, 2),
    "shelf": _BOARD,
    "low_shelf": Amount(10.0, 4, 0.8),
    "wardrobe_shelf": Amount(9.0, 3, 0.8),
    "cupboard": _HIDDEN,
    "drawer": _HIDDEN,
    "bed_head": Amount(1.6, 3),
    "bed_foot": Amount(1.2, 2, 0.8),
    "sofa_seat": Amount(2.5, 4),
    "armchair_seat": Amount(2.4, 1, 0.5),
    "chair_seat": Amount(2.0, 1, 0.15),
}


def amount_of(place: Place) -> Amount:
    """What is usual on a kind of surface."""
    return AMOUNTS.get(place, _ELSEWHERE)


# On the floor and on the walls of a room: least and greatest number by level.
ROOM_AMOUNTS: Final[Mapping[Place, tuple[tuple[int, int], ...]]] = {
    "floor_by_door": ((0, 1), (1, 1), (1, 2)),
    "floor_corner": ((0, 1), (0, 1), (1, 1)),
    "floor_by_wall": ((0, 1), (0, 1), (1, 2)),
    "floor_beside_bed": ((0, 1), (0, 1), (1, 2)),
    "floor_beside_sofa": ((0, 0), (0, 1), (1, 2)),
    "floor_under_desk": ((0, 1), (0, 1), (1, 1)),
    "floor_before_basin": ((0, 1), (0, 0), (0, 1)),
    "floor_open": ((0, 0), (0, 1), (2, 4)),
    "beside_toilet": ((1, 1), (0, 1), (0, 1)),
    "wall": ((0, 1), (1, 2), (0, 1)),
}
