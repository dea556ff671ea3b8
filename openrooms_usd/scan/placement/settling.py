"""Removes tilt, puts objects on their supports, and turns them parallel to penetrated walls."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.words import category_of, plain
from openrooms_usd.geometry.rotations import about_z
from openrooms_usd.scan.placement.arrangement import Arrangement
from openrooms_usd.scan.placement.bodies import Body
from openrooms_usd.scan.placement.enclosure import Enclosure
from openrooms_usd.scan.placement.penetration import FINE_LINES, near
from openrooms_usd.scan.placement.support import (
    CEILING,
    FLOOR,
    MAX_DEEP_M,
    MAX_FAR_M,
    MAX_FLOATING_M,
    MAX_SUNK_M,
    OBJECT,
    WALL,
    Support,
    is_rug,
    order,
    rest,
    support_of,
)

# Tilts larger than the first are intended, those smaller than the second are ignored, degrees.
_MEANT_LEAN_DEG: Final = 15.0
_UPRIGHT_DEG: Final = 0.02
# Objects at larger angles to a wall are not meant to be parallel to it; below the second angle they
# are, degrees.
_MAX_WALL_TURN_DEG: Final = 10.0
_STRAIGHT_DEG: Final = 0.05
# Least supported part of an object's base; objects below it are shifted until they have the second.
_MIN_BASE_SHARE: Final = 0.4
_STABLE_BASE_SHARE: Final = 0.6
# Shifts that are tried for that, metres.
_SHIFT_STEPS_M: Final = (0.0, 0.02, 0.04, 0.06, 0.08, 0.1)
# Smaller gaps are ignored, metres.
_TOUCHING_M: Final = 0.002
_DOWN: Final = np.array([0.0, 0.0, -1.0])


def set_upright(state: Arrangement) -> None:
    """Remove small tilts by the least rotation about each object's middle."""
    for row, found in enumerate(state.objects):
        rotation, angle = _righted(state, row)
        if angle > _MEANT_LEAN_DEG:
            state.notes.append(f"instance {found.instance} leans by {angle:.0f} degrees")
        elif angle > _UPRIGHT_DEG:
            state.turn(row, rotation)


def _righted(state: Arrangement, row: int) -> tuple[Array, float]:
    """The least rotation (3, 3) that turns an object's nearly vertical axis up, and its degrees."""
    from scipy.spatial.transform import Rotation

    from openrooms_usd.scan.placement.arrangement import rotation_of

    axes = rotation_of(state.objects[row].pose)
    column = int(np.argmax(np.abs(axes[2])))
    up = axes[:, column] * np.sign(axes[2, column])
    axis = np.array([up[1], -up[0], 0.0])
    angle = float(np.arctan2(np.linalg.norm(axis), up[2]))
    length = np.linalg.norm(axis)
    turn = Rotation.from_rotvec(axis / max(float(length), 1e-300) * angle)
    return np.asarray(turn.as_matrix()), float(np.degrees(angle))


def find_supports(state: Arrangement) -> None:
    """Find each object's support and make it touch that exactly, from the bottom up."""
    state.supports = [Support("nothing")] * len(state)
    done: list[int] = []
    for row in _carriers_first(state):
        state.supports[row] = state.given.get(row) or _found(state, row, done)
        if state.supports[row].kind in (OBJECT, "nothing"):
            _bring_over(state, row, done)
        lower(state, row)
        done.append(row)


def _found(state: Arrangement, row: int, below: Sequence[int]) -> Support:
    thing, room = state.objects[row], state.rooms[row]
    # A box that stands for a radiator hangs where radiators do.
    stand_in = thing.category == "box" and thing.word
    meant = category_of(thing.word, 0.0) or plain(thing.word)
    category = meant if stand_in else thing.category
    return support_of(row, category, state.bodies, below, room)


def _carriers_first(state: Arrangement) -> list[int]:
    """All rows from the bottom up, given supports before what they carry."""
    rows: dict[int, None] = {}
    for row in order(state.bodies, [room.floor for room in state.rooms]):
        chain = [row]
        while (under := state.given.get(chain[-1], Support("nothing")).number) >= 0:
            chain.append(under)
        rows |= dict.fromkeys(reversed(chain))
    return list(rows)


def _bring_over(state: Arrangement, row: int, below: Sequence[int]) -> None:
    """Shift an object that overhangs its support, or is just beside it, onto it."""
    body, support = state.bodies[row], state.supports[row]
    for other in [support.number] if support.number >= 0 else below:
        under = state.bodies[other]
        way = 0.5 * (under.low + under.high - body.low - body.high)[:2]
        if not near(body, under, MAX_FLOATING_M) or is_rug(under, state.rooms[row].floor):
            continue
        length = float(np.linalg.norm(way))
        for step in _SHIFT_STEPS_M:
            nudge = min(1.0, step / max(length, 1e-9)) * way
            there = rest(body.moved(np.append(nudge, 0.0)), under)
            if (
                there is not None
                and there.gap < MAX_FLOATING_M
                and there.share > (_STABLE_BASE_SHARE if step else _MIN_BASE_SHARE)
            ):
                state.supports[row] = Support(OBJECT, other)
                if step > 0.0:
                    state.shift(row, np.append(nudge, 0.0))
                return


def settle_again(state: Arrangement) -> None:
    """Make every object touch its support, or a new one where it was moved off the old."""
    done: list[int] = []
    for row in _carriers_first(state):
        on_object = state.supports[row].kind == OBJECT and row not in state.given
        if on_object and gap_below(state, row) is None:
            state.supports[row] = _found(state, row, done)
        lower(state, row)
        done.append(row)


def lower(state: Arrangement, row: int) -> None:
    """Move an object up or down until it touches its support.

    An object far below the ceiling hangs on a cable that its CAD lacks: it stays.
    """
    gap = gap_below(state, row)
    if gap is None or abs(gap) <= (0.0 if state.has_moved(row) else _TOUCHING_M):
        return
    if state.supports[row].kind != CEILING or abs(gap) < MAX_FAR_M or row in state.given:
        state.shift(row, gap * _DOWN)


def gap_below(state: Arrangement, row: int) -> float | None:
    """The vertical gap between an object and its support, metres; None where none is defined."""
    body, room, support = state.bodies[row], state.rooms[row], state.supports[row]
    if support.kind == FLOOR:
        return float(body.low[2] - room.floor)
    if support.kind == CEILING:
        return None if room.ceiling is None else float(body.high[2] - room.ceiling)
    if support.kind == OBJECT:
        under = state.bodies[support.number]
        depths = (
            (MAX_SUNK_M, MAX_DEEP_M, np.inf) if row in state.given else (MAX_SUNK_M, MAX_DEEP_M)
        )
        found = [there.gap for sunk in depths if (there := rest(body, under, sunk=sunk))]
        return min(found, key=abs, default=None)
    return None


def lay_along_walls(state: Arrangement) -> None:
    """Turn objects that penetrate a wall at a small angle parallel to it; attach wall objects."""
    for row in range(len(state)):
        room, hangs = state.rooms[row], state.supports[row].kind == WALL
        facing = room.facing(state.bodies[row])
        if facing is None:
            continue
        if abs(np.degrees(facing.angle)) > _MAX_WALL_TURN_DEG:
            # What hangs askew does so with the corner that is nearest to the wall.
            if hangs:
                gap = room.gap(state.bodies[row], facing.wall)
                _carry(state, row, -gap * room.inward[facing.wall])
            continue
        if abs(np.degrees(facing.angle)) > _STRAIGHT_DEG and (
            hangs or _reaches(state.bodies[row], room)
        ):
            round_ = state.objects[row].symmetry == "inf"
            if not round_:
                state.turn(row, about_z(facing.angle))
        if hangs and abs(facing.gap) > _TOUCHING_M:
            _carry(state, row, -facing.gap * room.inward[facing.wall])


def _reaches(body: Body, room: Enclosure) -> bool:
    return bool(room.beyond(room.footprint(body)).max() > _TOUCHING_M)


def _carry(state: Arrangement, row: int, motion: Array) -> None:
    """Apply a motion in the plan to an object and all that it carries."""
    for each in (row, *state.carried(row)):
        state.shift(each, np.append(motion, 0.0))


# What is wrong with an arrangement: penetrations, reaches into walls, gaps below.

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
