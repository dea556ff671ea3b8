"""Found objects put where they can be: upright, on what carries them, in the room, apart.

One pass: tilted objects are set upright; what carries each is found, and it is put there exactly;
what reaches into a wall at a small angle is turned along it; then all objects together go apart
and out of the walls by the least motion. What was right before is returned as it is.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.arrangement import Arrangement, arranged, posed, rotation_of
from openrooms_usd.scan.models import CadModel
from openrooms_usd.scan.penetration import FINE, near, penetration
from openrooms_usd.scan.results import FoundObject, FoundRoom
from openrooms_usd.scan.settling import (
    find_supports,
    gap_below,
    lay_along_walls,
    lower,
    set_upright,
)
from openrooms_usd.scan.spreading import Spread
from openrooms_usd.scan.support import CEILING, FLOOR, WALL, Support

Array = NDArray[np.float64]

# What is reported as unresolved: overlaps, and reaching into walls or floating, metres.
_OVERLAP: Final = 0.004
_GAP: Final = 0.008


# Motions shorter than this are none, metres.
_STILL: Final = 1e-4


@dataclass(frozen=True)
class Unresolved:
    """Something that no small motion puts right.

    Attributes:
        kind: What is wrong.
        instance: With which instance.
        other: The instance that it overlaps with; None otherwise.
        depth: How much, metres.
    """

    kind: Literal["overlaps", "in a wall", "floats"]
    instance: int
    other: int | None
    depth: float

    def __str__(self) -> str:
        subject = f"instance {self.instance} {self.kind}"
        return f"{subject}{'' if self.other is None else f' with {self.other}'}: {self.depth:.3f} m"


@dataclass(frozen=True)
class Placement:
    """Objects after placement.

    Attributes:
        objects: As given, with ``placed`` and ``support``.
        unresolved: What is still wrong.
        notes: What people should know, one sentence each.
    """

    objects: tuple[FoundObject, ...]
    unresolved: tuple[Unresolved, ...]
    notes: tuple[str, ...]


def place(
    objects: Sequence[FoundObject],
    models: Mapping[str, CadModel],
    rooms: Sequence[FoundRoom],
    reach: float = 0.10,
) -> Placement:
    """Put objects where they can be, by the least motion.

    Args:
        objects: In the level frame: Z up, metres. A ``support`` that is given is kept.
        models: CADs by their ids.
        rooms: In the same frame; their walls and ceilings bound the objects.
        reach: How far other objects may push one, metres.
    """
    state = arranged(objects, models, rooms)
    set_upright(state)
    find_supports(state, _given(objects))
    lay_along_walls(state)
    for row, shift in enumerate(Spread(state, reach).run()):
        if np.abs(shift).max() > _STILL:
            state.shift(row, np.append(shift, 0.0))
    for row in range(len(state)):
        lower(state, row)
    return Placement(_placed(state), tuple(_unresolved(state)), tuple(state.notes))


def correction(found: FoundObject) -> Array:
    """(4, 4) rigid: from where an object was measured to where it was placed."""
    motion = np.eye(4)
    if found.placed is not None and found.placed is not found.pose:
        motion[:3, :3] = rotation_of(found.placed) @ rotation_of(found.pose).T
        motion[:3, 3] = found.placed.translation - motion[:3, :3] @ found.pose.translation
    return motion


def _given(objects: Sequence[FoundObject]) -> dict[int, Support]:
    rows = {str(found.instance): row for row, found in enumerate(objects)}
    known = {kind: Support(kind) for kind in (FLOOR, WALL, CEILING)}
    known |= {name: Support("object", row) for name, row in rows.items()}
    return {row: known[o.support] for row, o in enumerate(objects) if o.support in known}


def _placed(state: Arrangement) -> tuple[FoundObject, ...]:
    placed = []
    for row, (found, support) in enumerate(zip(state.objects, state.supports, strict=True)):
        on = str(state.objects[support.number].instance) if support.number >= 0 else support.kind
        pose = posed(found.pose, state.motions[row]) if state.has_moved(row) else found.pose
        placed.append(replace(found, placed=pose, support=on))
    return tuple(placed)


def _unresolved(state: Arrangement) -> list[Unresolved]:
    found = []
    for i, body in enumerate(state.bodies):
        name, room = state.objects[i].instance, state.rooms[i]
        beyond = float(room.beyond(room.footprint(body)).max())
        if beyond > _GAP:
            found.append(Unresolved("in a wall", name, None, beyond))
        gap = gap_below(state, i)
        if state.supports[i].kind == "nothing":
            gap = float(body.low[2] - room.floor)
        if gap is not None and abs(gap) > _GAP:
            found.append(Unresolved("floats", name, None, abs(gap)))
        for j in range(i):
            if near(body, state.bodies[j], -_OVERLAP):
                overlap = penetration(body, state.bodies[j], _OVERLAP, FINE)
                if overlap is not None:
                    other = state.objects[j].instance
                    found.append(Unresolved("overlaps", name, other, overlap.depth))
    return found
