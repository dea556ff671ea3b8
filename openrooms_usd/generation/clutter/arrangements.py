"""Things that belong together in one way only: a place laid for a meal, a mouse at its keyboard."""

from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np

from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.furniture.placements import SurfacePlacement
from openrooms_usd.generation.boxes import Pose, overlap
from openrooms_usd.generation.clutter.laying import PosedObject, fits, item_at, posed_object
from openrooms_usd.generation.clutter.scatter import Scatter
from openrooms_usd.generation.clutter.spots import SupportSurface
from openrooms_usd.generation.items import Item, placed

# How far a chair stands from the edge of the table that it belongs to, metres.
_AT_TABLE_M: Final = 0.6
# A plate's rim lies this far from the edge of the table, metres.
_FROM_EDGE_M: Final = 0.025


class ArrangedThing(NamedTuple):
    """One thing of an arrangement.

    Attributes:
        category: Of the library.
        styles: Its styles; any by default.
        side: -1 to the left, 0 in the middle, 1 to the right.
        gap: From what is in the middle, metres.
        ahead: Where its middle is: 0 beside the middle, 1 beyond it.
        chance: How often it is there.
        yaw: Degrees.
    """

    category: str
    styles: tuple[str, ...]
    side: int
    gap: float
    ahead: float
    chance: float
    yaw: float = 0.0


PLATE: Final = ArrangedThing("plate", (), 0, 0.0, 0.0, 1.0)
SETTING: Final = (
    ArrangedThing("cutlery", ("fork",), -1, 0.03, 0.0, 0.95),
    ArrangedThing("cutlery", ("knife",), 1, 0.025, 0.0, 0.95),
    ArrangedThing("cutlery", ("spoon",), 1, 0.065, 0.0, 0.4),
    ArrangedThing("napkin", (), -1, 0.075, 0.0, 0.5),
    ArrangedThing("drinking_glass", (), 1, 0.0, 1.0, 0.9),
)
"""What lies around a plate, as one sits before it."""

MOUSE: Final = ArrangedThing("mouse", (), 1, 0.05, 0.0, 0.9)


def seats_at(table: Item, items: Sequence[Item]) -> Iterator[Pose]:
    """Where people sit at a table: the middle of the edge before each chair, looking across it.

    Args:
        table: The table.
        items: What stands with it.

    Yields:
        Place in the table's frame, metres, and the direction to look in: 0 is the table's +y.
    """
    half = 0.5 * np.array(table.size[:2])
    for item in items:
        if item.category not in ("chair", "bench") or item.on not in ("floor", table.on):
            continue
        back = (0.0, 0.0, -table.yaw)
        x, y = placed(back, item.x - table.x, item.y - table.y)
        away = np.abs([x, y]) - half
        if away.max() > _AT_TABLE_M or away.max() < -0.25:
            continue
        if away[1] >= away[0]:
            near = float(np.clip(x, -half[0] + 0.3, half[0] - 0.3)) if half[0] > 0.3 else 0.0
            yield near, float(np.sign(y) * half[1]), 0.0 if y < 0 else 180.0
        else:
            yield float(np.sign(x) * half[0]), 0.0, -90.0 if x < 0 else 90.0


def laid(seat: Pose, middle: float, part: ArrangedThing, size: tuple[float, float, float]) -> Pose:
    """Where a part of a setting lies, in the table's frame.

    Args:
        seat: Where one sits, as `seats_at` says.
        middle: Width of what is in the middle, metres.
        part: The part.
        size: What it takes up, metres.
    """
    x = part.side * (0.5 * middle + part.gap + 0.5 * size[0]) if part.side else 0.0
    y = _FROM_EDGE_M + max(0.5 * middle, 0.5 * size[1])
    if part.ahead:
        x, y = part.side * 0.4 * middle, _FROM_EDGE_M + middle + 0.03 + 0.5 * size[1]
    return (*placed(seat, x, y), seat[2] + part.yaw)


def lay_table(scatter: Scatter, spot: SupportSurface, items: Sequence[Item]) -> None:
    """Lay a table for those who sit at it.

    Args:
        scatter: Lays things in this room.
        spot: Its top.
        items: What stands with it.
    """
    known = {part: _part(scatter, part) for part in (PLATE, *SETTING)}
    plate = known[PLATE]
    for seat in seats_at(spot.carrier, items) if plate else ():
        assert plate is not None
        for part, thing in known.items():
            if thing is None or scatter.rng.random() > part.chance:
                continue
            middle = laid(seat, plate.size[0], part, thing.size)
            if not _put_at(scatter, spot, thing, middle) and part is PLATE:
                break


def put_beside(scatter: Scatter, spot: SupportSurface, other: Item, part: ArrangedThing) -> None:
    """Put a thing beside another, to whose use it belongs.

    Args:
        scatter: Lays things in this room.
        spot: What both lie on.
        other: The other one.
        part: The thing.
    """
    thing = _part(scatter, part)
    if thing is not None and scatter.rng.random() < part.chance:
        back = (0.0, 0.0, -spot.carrier.yaw)
        x = part.side * (0.5 * (other.size[0] + thing.size[0]) + part.gap)
        local = placed(back, *np.subtract(other.at(x, 0.0), spot.pose[:2]).tolist())
        _put_at(scatter, spot, thing, (*local, other.yaw - spot.carrier.yaw))


def _part(scatter: Scatter, part: ArrangedThing) -> PosedObject | None:
    if part.category not in CATEGORIES:
        return None
    placement = SurfacePlacement(on=("dining_table",), styles=part.styles, max_variants=1)
    make = scatter.variants.draw(part.category, placement)
    return posed_object(scatter.surfaces, part.category, make) if make else None


def _put_at(scatter: Scatter, spot: SupportSurface, thing: PosedObject, local: Pose) -> bool:
    """Put a thing on a surface at a place in its carrier's frame, if it is free."""
    if not fits(spot, thing.size, np.array([local[:2]]), np.array([local[2]]))[0]:
        return False
    pose = (*spot.carrier.at(*local[:2]), spot.carrier.yaw + local[2])
    box = thing.standing(pose, spot.z)
    lifted = box + np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.001, 0.0])
    if overlap(lifted, scatter.taken.near(spot.box, {spot.carrier.key}), 0.002).any():
        return False
    item = item_at(thing, scatter.key(thing.name), pose, spot.z, spot.carrier.key)
    scatter.add(spot.group, item, box)
    return True
