"""Corrects the poses of aligned objects to physically plausible ones.

One pass: small tilts are removed; supports are found and touched exactly; objects that penetrate a
wall at a small angle are turned along it; then all penetrations, between objects and with walls,
are resolved by the least motion. Plausible poses are returned unchanged.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.models.cad import CadModel
from openrooms_usd.scan.placement.arrangement import Arrangement, arranged, posed, rotation_of
from openrooms_usd.scan.placement.penetration import FINE_LINES, near, penetration
from openrooms_usd.scan.placement.settling import (
    find_supports,
    gap_below,
    lay_along_walls,
    set_upright,
    settle_again,
)
from openrooms_usd.scan.placement.spreading import Spread
from openrooms_usd.scan.placement.support import CEILING, FLOOR, OBJECT, WALL, Support
from openrooms_usd.scan.results import FoundObject, FoundRoom

Array = NDArray[np.float64]

# Least penetration of objects, and least penetration of walls or floating gap, that is reported as
# unresolved, metres.
_UNRESOLVED_OVERLAP_M: Final = 0.004
_UNRESOLVED_GAP_M: Final = 0.008


# Motions shorter than this are none, metres.
_NO_MOTION_M: Final = 1e-4


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

    def __str__(self) -> str:
        subject = f"instance {self.instance} {self.kind}"
        return f"{subject}{'' if self.other is None else f' with {self.other}'}: {self.depth:.3f} m"


@dataclass(frozen=True)
class Placement:
    """Objects after placement.

    Attributes:
        objects: As given, with ``placed`` and ``support``.
        unresolved: Remaining violations.
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
    """Make poses physically plausible by the least motion.

    Args:
        objects: In the level frame: Z up, metres; their order changes nothing. A given ``support``
            is kept.
        models: CADs by their ids.
        rooms: In the same frame; their walls and ceilings bound the objects.
        reach: Largest motion by penetrations of other objects, metres.
    """
    rows = sorted(range(len(objects)), key=lambda row: objects[row].instance)
    state = arranged([objects[row] for row in rows], models, rooms)
    state.given = _given(state)
    set_upright(state)
    find_supports(state)
    lay_along_walls(state)
    for row, shift in enumerate(Spread(state, reach).run()):
        if np.abs(shift).max() > _NO_MOTION_M:
            state.shift(row, np.append(shift, 0.0))
    settle_again(state)
    placed = dict(zip(rows, _placed(state), strict=True))
    in_order = tuple(placed[row] for row in range(len(objects)))
    return Placement(in_order, tuple(_unresolved(state)), tuple(state.notes))


def correction(found: FoundObject) -> Array:
    """(4, 4) rigid, from an object's measured pose to its placed one."""
    motion = np.eye(4)
    if found.placed is not None and found.placed is not found.pose:
        motion[:3, :3] = rotation_of(found.placed) @ rotation_of(found.pose).T
        motion[:3, 3] = found.placed.translation - motion[:3, :3] @ found.pose.translation
    return motion


def moved_by(found: FoundObject) -> dict[str, float]:
    """The motion of an object: ``metres`` of its origin, and ``degrees`` of rotation."""
    from scipy.spatial.transform import Rotation

    placed = found.placed or found.pose
    turn = Rotation.from_matrix(correction(found)[:3, :3]).magnitude()
    away = np.linalg.norm(placed.translation - found.pose.translation)
    return {"metres": float(away), "degrees": float(np.degrees(turn))}


def _given(state: Arrangement) -> dict[int, Support]:
    """Given supports by rows, without missing instances and circles."""
    numbers = {str(found.instance): row for row, found in enumerate(state.objects)}
    known = {kind: Support(kind) for kind in (FLOOR, WALL, CEILING)}
    known |= {name: Support(OBJECT, row) for name, row in numbers.items()}
    given: dict[int, Support] = {}
    for row, found in enumerate(state.objects):
        support = known.get(found.support)
        above = support.number if support else -1
        while above >= 0 and above != row:
            above = given.get(above, Support(FLOOR)).number
        if support and above != row:
            given[row] = support
        elif found.support:
            why = "was not found" if support is None else "stands on it"
            name, under = found.instance, found.support
            state.notes.append(f"instance {name} cannot stand on {under}, which {why}")
    return given


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
        if beyond > _UNRESOLVED_GAP_M:
            found.append(Unresolved("in a wall", name, None, beyond))
        gap = _floating(state, i)
        if gap > _UNRESOLVED_GAP_M:
            found.append(Unresolved("floats", name, None, gap))
        for j in range(i):
            if near(body, state.bodies[j], -_UNRESOLVED_OVERLAP_M):
                overlap = penetration(body, state.bodies[j], _UNRESOLVED_OVERLAP_M, FINE_LINES)
                if overlap is not None:
                    other = state.objects[j].instance
                    found.append(Unresolved("overlaps", name, other, overlap.depth))
    return found


def _floating(state: Arrangement, row: int) -> float:
    """The gap between an object and its support, metres."""
    kind, body, room = state.supports[row].kind, state.bodies[row], state.rooms[row]
    if kind == WALL:
        facing = room.facing(body, np.inf)
        return max(facing.gap, 0.0) if facing else float(body.low[2] - room.floor)
    gap = gap_below(state, row)
    if gap is None:
        return 0.0 if kind == CEILING else float(body.low[2] - room.floor)
    return abs(gap)
