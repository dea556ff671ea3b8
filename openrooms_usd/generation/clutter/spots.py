"""Where something may lie in a furnished room: the surfaces of its furniture, by their use."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture import offered_surfaces
from openrooms_usd.furniture.placements import Place
from openrooms_usd.generation.boxes import Pose, box
from openrooms_usd.generation.clutter.forms import LevelFinder
from openrooms_usd.generation.clutter.levels import CELL_M, Level
from openrooms_usd.generation.items import Item, placed

# Boards and what is kept on them.
_BOARDS: Final[tuple[Place, ...]] = (
    "shelf", "low_shelf", "wardrobe_shelf", "cupboard", "drawer",
)  # fmt: skip
# Surfaces other than level tops: seats and beds, edges and hooks.
_NO_TOPS: Final[tuple[Place, ...]] = (
    "bed_head", "bed_foot", "sofa_seat", "armchair_seat", "chair_seat", "sofa_arm", "chair_back",
    "towel_rail", "clothes_rail", "hook", "wall", "in_bowl", "in_bin",
)  # fmt: skip
# Tops above this are out of reach, metres; boards below that are low ones.
_HIGHEST_TOP_M: Final = 1.75
_LOW_SHELF_M: Final = 0.6
# A drawer's bottom has this little above it, metres.
_DRAWER_M: Final = 0.32
# A top that is this share of the largest level is the one that people mean by it.
_SHARE_OF_TOP: Final = 0.5
_LEAST_BOARD_M2: Final = 0.008


@dataclass(frozen=True, eq=False)
class SupportSurface:
    """A surface on which something may lie.

    Attributes:
        place: What people use it for.
        carrier: What it belongs to.
        group: The index of the group of the carrier.
        level: Where it is, in the carrier's frame.
        around: Whether people use it from all sides.
    """

    place: Place
    carrier: Item
    group: int
    level: Level
    around: bool = False

    @property
    def pose(self) -> Pose:
        """Of the carrier in the room."""
        return self.carrier.x, self.carrier.y, self.carrier.yaw

    @property
    def z(self) -> float:
        """Height above the floor, metres."""
        return self.carrier.z + self.level.z

    @property
    def box(self) -> Array:
        """(8,) what may be taken up, in the room."""
        (x0, y0), (x1, y1) = self.reach
        x, y = placed(self.pose, 0.5 * (x0 + x1), 0.5 * (y0 + y1))
        high = min(float(self.level.clear.max()), 1.0)
        return box(x, y, x1 - x0, y1 - y0, self.z, self.z + high, self.carrier.yaw)

    @cached_property
    def reach(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Least and greatest x and y of its free cells, in the carrier's frame."""
        rows, columns = np.nonzero(self.level.clear > 0.0)
        low = self.level.origin + CELL_M * np.array([columns.min(), rows.min()])
        high = self.level.origin + CELL_M * (np.array([columns.max(), rows.max()]) + 1)
        (x0, y0), (x1, y1) = low.tolist(), high.tolist()
        return (x0, y0), (x1, y1)


def spots(
    groups: Sequence[tuple[str, Sequence[Item]]], surfaces: LevelFinder, room_type: str
) -> Iterator[SupportSurface]:
    """All surfaces of a furnished room.

    Args:
        groups: Titles and items, in the room's frame.
        surfaces: Knows their forms.
        room_type: One of the 27.
    """
    everything = [item for _, items in groups for item in items]
    for number, (_, items) in enumerate(groups):
        for item in items:
            if not offered_surfaces(item.category):
                continue
            carries = _places_by_group(item, items, everything, room_type)
            yield from spots_of(item, number, carries, surfaces)


def _places_by_group(
    item: Item, group: Sequence[Item], everything: Sequence[Item], room_type: str
) -> tuple[Place, ...]:
    """What the surfaces of an item are used for, by what stands with it."""
    beside = {other.category for other in group}
    meaning: dict[Place, Place] = {}
    if "bed" in beside:
        meaning["side_table"] = "bedside"
    if any(other.category == "television" and other.on == item.key for other in group):
        meaning |= {"cabinet_top": "media_top", "dresser_top": "media_top"}
    if "office_chair" in beside or room_type in ("office", "conference_room", "copy_room"):
        meaning["dining_table"] = "desk"
    if room_type not in ("kitchen", "apartment", "laundry_room", "garage", "basement"):
        meaning["worktop"] = "shop_counter"
    if room_type == "bathroom":
        meaning |= {
            "sink_edge": "basin_edge",
            "worktop": "basin_edge",
            "shop_counter": "basin_edge",
        }
    return tuple(meaning.get(place, place) for place in offered_surfaces(item.category))


def spots_of(
    item: Item, group: int, carries: tuple[Place, ...], surfaces: LevelFinder
) -> Iterator[SupportSurface]:
    """The surfaces of one object, by what they are used for."""
    levels = [level for level in surfaces.levels(item) if level.area >= _LEAST_BOARD_M2]
    tops = [place for place in carries if place not in _BOARDS and place not in _NO_TOPS]
    top = _top(levels) if tops else None
    if top is not None and item.z + top.z <= _HIGHEST_TOP_M:
        around = tops[0] in ("dining_table", "coffee_table")
        for place in tops:
            yield SupportSurface(place, item, group, top, around)
    for level in levels:
        if level is top or level.z <= 0.02:
            continue
        use = _board(level, carries, item.z, top)
        if use is not None:
            yield SupportSurface(use, item, group, level)


def _top(levels: Sequence[Level]) -> Level | None:
    """What people mean by an object's top: its highest large level with nothing close above."""
    free = [level for level in levels if level.open and np.isinf(level.headroom)]
    largest = max((level.area for level in free), default=0.0)
    return next((v for v in reversed(free) if v.area >= _SHARE_OF_TOP * largest), None)


def _board(
    level: Level, carries: tuple[Place, ...], base: float, top: Level | None
) -> Place | None:
    """What a level within an object is used for; None for one that holds nothing."""
    if level.glazed and level.open:
        return "shelf" if "cupboard" in carries or "shelf" in carries else None
    if level.open:
        if top is not None and np.isinf(level.headroom) and level.z > top.z:
            return None
        wanted: tuple[Place, ...] = ("shelf", "low_shelf", "wardrobe_shelf")
        if base + level.z < _LOW_SHELF_M:
            wanted = ("low_shelf", *wanted)
    elif level.headroom < _DRAWER_M:
        wanted = ("drawer", "cupboard")
    else:
        wanted = ("cupboard", "wardrobe_shelf")
    return next((place for place in wanted if place in carries), None)
