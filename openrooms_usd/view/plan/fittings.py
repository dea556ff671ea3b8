"""What stands in the outline: openings, walls that stand free, and how high the room is.

An opening is given by its rectangle on the wall's elevation, with x to the right and z up from the
floor. The wall is seen from inside, or from the side from which a partition's line runs to the
right.
"""

from dataclasses import replace
from typing import Any, Final, Literal

import numpy as np

from openrooms_usd.building.openings import clamped
from openrooms_usd.building.shell import Hole
from openrooms_usd.description.layout import Opening, Partition, named_partitions
from openrooms_usd.description.naming import unique_names
from openrooms_usd.errors import InputError
from openrooms_usd.names import PARTITION_THICKNESS
from openrooms_usd.view.plan.drawing import Drawing, Point

Kind = Literal["window", "door", "opening"]

# What begins lower than this stands on the floor, and is a door rather than a window, metres.
_STEP_M: Final = 0.12
_LEAST_M: Final = 0.05


def hole_in(plan: Drawing, opening: Opening) -> Hole:
    """The rectangle of an opening on its wall's elevation, metres."""
    middle = _turned(plan, opening.wall, opening.at or 0.0)
    width, height, sill = opening.width or 0.0, opening.height or 0.0, opening.sill or 0.0
    return Hole(middle - 0.5 * width, middle + 0.5 * width, sill, sill + height)


def add_opening(
    plan: Drawing,
    hole: Hole,
    *,
    wall: int | None = None,
    partition: str | None = None,
    kind: Kind | None = None,
    snap: bool = False,
) -> Drawing:
    """Cut an opening; what reaches the floor is a door, anything else a window, unless said."""
    place = _place(plan, wall, partition)
    if min(hole.right - hole.left, hole.top - hole.bottom) < _LEAST_M:
        raise InputError("that is too small for an opening", remedy="draw a larger rectangle")
    kind = kind or ("door" if hole.bottom < _STEP_M else "window")
    fitted = _fitted(plan, hole, wall, kind) if snap else hole
    told: dict[str, Any] = {"kind": kind, **place, **_measures(plan, fitted, wall)}
    made = Opening.model_construct(**told)
    return replace(plan, openings=(*plan.openings, made))


def set_opening(
    plan: Drawing,
    number: int,
    *,
    hole: Hole | None = None,
    kind: Kind | None = None,
    snap: bool = False,
) -> Drawing:
    """Give an opening another rectangle, or say what it is."""
    plan.check("opening", number, len(plan.openings))
    one = plan.openings[number]
    changed: dict[str, Any] = {}
    if kind is not None and kind != one.kind:
        # A name such as window_2 and a style would no longer fit.
        changed |= {"kind": kind, "name": None, "style": None}
    if hole is not None:
        fitted = _fitted(plan, hole, one.wall, kind or one.kind) if snap else hole
        changed |= _measures(plan, fitted, one.wall)
    made = one.model_copy(update=changed)
    return replace(plan, openings=(*plan.openings[:number], made, *plan.openings[number + 1 :]))


def remove_opening(plan: Drawing, number: int) -> Drawing:
    """Close an opening."""
    plan.check("opening", number, len(plan.openings))
    rest = [one for place, one in enumerate(plan.openings) if place != number]
    return replace(plan, openings=tuple(rest))


def add_partition(plan: Drawing, line: tuple[Point, Point]) -> Drawing:
    """Put up a wall that stands free."""
    taken = [(name, "partition") for name, _ in named_partitions(plan.partitions)]
    *_, name = unique_names([*taken, (None, "partition")])
    made = Partition.model_construct(
        name=name, line=line, thickness=PARTITION_THICKNESS, height=None
    )
    return replace(plan, partitions=(*_named(plan), made))


def move_partition(plan: Drawing, number: int, line: tuple[Point, Point]) -> Drawing:
    """Put a wall that stands free somewhere else; its openings go with it."""
    plan.check("partition", number, len(plan.partitions))
    rows = list(plan.partitions)
    rows[number] = rows[number].model_copy(update={"line": line})
    return replace(plan, partitions=tuple(rows))


def remove_partition(plan: Drawing, number: int) -> Drawing:
    """Take a wall that stands free away, with all that is cut into it."""
    plan.check("partition", number, len(plan.partitions))
    rows = _named(plan)
    gone = rows.pop(number).name
    openings = tuple(one for one in plan.openings if one.partition in (None, *_names(rows)))
    assert all(one.partition != gone for one in openings), "another object has this name"
    return replace(plan, partitions=tuple(rows), openings=openings)


def set_height(plan: Drawing, height: float) -> Drawing:
    """Say how high the room is."""
    return replace(plan, height=height)


def _named(plan: Drawing) -> list[Partition]:
    """The partitions, each with the name that it had: numbers that move would give it another."""
    return [
        row.model_copy(update={"name": name}) for name, row in named_partitions(plan.partitions)
    ]


def _names(rows: list[Partition]) -> list[str | None]:
    return [row.name for row in rows]


def _place(plan: Drawing, wall: int | None, partition: str | None) -> dict[str, Any]:
    names = [name for name, _ in named_partitions(plan.partitions)]
    if wall is not None:
        plan.check("wall", wall, len(plan.corners))
        return {"wall": wall, "partition": None}
    if partition not in names:
        raise InputError(f"there is no partition {partition}", remedy="choose a wall first")
    return {"wall": None, "partition": partition}


def _measures(plan: Drawing, hole: Hole, wall: int | None) -> dict[str, float]:
    return {
        "at": _turned(plan, wall, 0.5 * (hole.left + hole.right)),
        "width": hole.right - hole.left,
        "height": hole.top - hole.bottom,
        "sill": hole.bottom,
    }


def _turned(plan: Drawing, wall: int | None, at: float) -> float:
    """A distance from a wall's start to one from its left end, seen from inside, or back."""
    if wall is None or plan.clockwise:
        return at
    start, end = plan.ends(wall)
    return float(np.linalg.norm(end - start)) - at


def _fitted(plan: Drawing, hole: Hole, wall: int | None, kind: Kind) -> Hole:
    """The part of a hole that its wall has room for; doors and passages stand on the floor."""
    bottom = 0.0 if kind != "window" and hole.bottom < _STEP_M else max(0.0, hole.bottom)
    hole = replace(hole, bottom=bottom)
    return hole if wall is None else clamped(plan.walls()[wall], plan.height, hole) or hole
