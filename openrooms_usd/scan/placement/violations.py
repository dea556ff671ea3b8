"""What is wrong with an arrangement: penetrations, reaches into walls, gaps below."""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from openrooms_usd.scan.placement.arrangement import Arrangement
from openrooms_usd.scan.placement.penetration import FINE_LINES, near
from openrooms_usd.scan.placement.settling import gap_below
from openrooms_usd.scan.placement.support import CEILING, WALL

# Least penetration of objects, and least penetration of walls or floating gap, that is reported as
# unresolved, metres.
_UNRESOLVED_OVERLAP_M: Final = 0.004
_UNRESOLVED_GAP_M: Final = 0.008


@dataclass(frozen=True)
class Unresolved:
    """A violation that no small motion resolves.

    Attributes:
        kind: Of violation.
        instance: The instance.
        other: The instance that it overlaps with; None otherwise.
        depth: Of penetration, or of the gap, metres.
    """

    kind: Literal["overlaps", "in a wall", "floats"]
    instance: int
    other: int | None
    depth: float


def violations(state: Arrangement) -> list[Unresolved]:
    """All violations of an arrangement, by rows."""
    found = []
    for i, body in enumerate(state.bodies):
        name, room = state.objects[i].instance, state.rooms[i]
        beyond = float(room.beyond(room.footprint(body)).max())
        if beyond > _UNRESOLVED_GAP_M:
            found.append(Unresolved("in a wall", name, None, beyond))
        gap = _floating(state, i)
        if gap > _UNRESOLVED_GAP_M:
            found.append(Unresolved("floats", name, None, gap))
        for j in range(i):
            if near(body, state.bodies[j], -_UNRESOLVED_OVERLAP_M):
                overlap = state.overlap(i, j, _UNRESOLVED_OVERLAP_M, FINE_LINES)
                if overlap is not None:
                    other = state.objects[j].instance
                    found.append(Unresolved("overlaps", name, other, overlap.depth))
    return found


def _floating(state: Arrangement, row: int) -> float:
    """The gap between an object and its support, metres."""
    kind, body, room = state.supports[row].kind, state.bodies[row], state.rooms[row]
    if kind == WALL:
        facing = room.facing(body, np.inf)
        gap = min(facing.gap, room.gap(body, facing.wall)) if facing else 0.0
        return max(gap, 0.0) if facing else float(body.low[2] - room.floor)
    below = gap_below(state, row)
    if below is None:
        return 0.0 if kind == CEILING else float(body.low[2] - room.floor)
    return abs(below)
