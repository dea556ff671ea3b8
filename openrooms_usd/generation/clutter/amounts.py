"""How much lies on a surface, by what it is used for."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from openrooms_usd.furniture.placements import Place

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
    shares: tuple[float, float, float] = (0.55, 0.6, 0.7)


_BOARD: Final = Amount(30.0, 7, 0.95)
_HIDDEN: Final = Amount(5.0, 1, 0.3, (0.5, 0.5, 0.5))
_ELSEWHERE: Final = Amount(5.0, 4)

AMOUNTS: Final[Mapping[Place, Amount]] = {
    "worktop": Amount(11.0, 9),
    "sink_edge": Amount(12.0, 5),
    "hob": Amount(6.0, 2, 0.7),
    "dining_table": Amount(4.0, 8),
    "coffee_table": Amount(12.0, 7),
    "side_table": Amount(22.0, 4),
    "desk": Amount(13.0, 12),
    "bedside": Amount(34.0, 5),
    "dresser_top": Amount(18.0, 9),
    "cabinet_top": Amount(14.0, 9),
    "media_top": Amount(9.0, 7),
    "appliance_top": Amount(9.0, 4),
    "shop_counter": Amount(5.0, 6),
    "window_sill": Amount(16.0, 5, 0.75),
    "mantel": Amount(18.0, 6),
    "basin_edge": Amount(34.0, 7),
    "bath_rim": Amount(14.0, 5),
    "cistern": Amount(30.0, 2),
    "shelf": _BOARD,
    "low_shelf": Amount(20.0, 5, 0.9),
    "wardrobe_shelf": Amount(12.0, 4, 0.9),
    "cupboard": _HIDDEN,
    "drawer": _HIDDEN,
    "bed_head": Amount(1.6, 1, 0.08),
    "bed_foot": Amount(2.5, 2, 0.75),
    "sofa_seat": Amount(2.5, 4),
    "armchair_seat": Amount(2.4, 1, 0.5),
    "chair_seat": Amount(2.0, 1, 0.15),
    "in_basket": Amount(30.0, 3, 0.8, (0.8, 0.4, 0.4)),
    "on_tray": Amount(40.0, 4, 1.0, (0.8, 0.4, 0.4)),
    "in_bowl": Amount(60.0, 6, 0.65, (0.7, 0.4, 0.4)),
    "in_bin": Amount(45.0, 4, 0.75, (0.6, 0.5, 0.5)),
    "on_stack": Amount(40.0, 1, 0.4),
}


def amount_of(place: Place) -> Amount:
    """What is usual on a kind of surface."""
    return AMOUNTS.get(place, _ELSEWHERE)


# How often a cloth is hung over an edge, by level.
DRAPED: Final[Mapping[Place, tuple[float, ...]]] = {
    "towel_rail": (0.95, 0.3, 0.0),
    "sofa_arm": (0.25, 0.3, 0.2),
    "chair_back": (0.03, 0.05, 0.1),
}
# How often something hangs on a hook, or on a place of a rail for one hanger, by level.
HUNG: Final[Mapping[Place, tuple[float, ...]]] = {
    "hook": (0.5, 0.45, 0.3),
    "clothes_rail": (0.5, 0.2, 0.2),
}
# How often a table is laid, by room type; elsewhere the last.
LAID: Final[Mapping[str, float]] = {"dining_room": 0.9, "kitchen": 0.6, "": 0.3}

# On the floor and on the walls of a room: least and greatest number by level.
ROOM_AMOUNTS: Final[Mapping[Place, tuple[tuple[int, int], ...]]] = {
    "floor_by_door": ((0, 1), (1, 1), (1, 2)),
    "floor_corner": ((0, 1), (0, 1), (1, 1)),
    "floor_by_wall": ((0, 1), (0, 1), (1, 2)),
    "floor_beside_bed": ((0, 1), (0, 1), (1, 2)),
    "floor_beside_sofa": ((0, 0), (0, 1), (1, 2)),
    "floor_by_media": ((0, 1), (1, 1), (0, 1)),
    "floor_under_desk": ((0, 1), (0, 1), (1, 1)),
    "floor_before_basin": ((0, 1), (0, 0), (0, 1)),
    "floor_open": ((0, 0), (0, 1), (2, 4)),
    "beside_toilet": ((1, 1), (0, 1), (0, 1)),
    "wall": ((0, 1), (1, 2), (0, 1)),
}
