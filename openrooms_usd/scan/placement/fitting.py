"""Shortens objects that no motion brings out of walls or other objects.

Scans are off by a few per cent, and what stands for a thing need not have its very length: a bed
that is cut by a tenth is better than none. An object recedes at the side where it reaches into
something, along its own axis; its far side stays.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.scan.models.cad import CadModel
from openrooms_usd.scan.placement.arrangement import Arrangement, posed, rotation_of
from openrooms_usd.scan.placement.bodies import Body
from openrooms_usd.scan.placement.penetration import FINE_LINES, exits, penetration
from openrooms_usd.scan.placement.settling import Unresolved
from openrooms_usd.scan.placement.support import CEILING, WALL
from openrooms_usd.scan.registration.scalelimits import sizes_of

USUAL_SHARE: Final = 0.2
"""Largest part of an object's measured length along an axis by which it is shortened."""
LAST_SHARE: Final = 0.5
"""The same before it is left out: half a bed is better than none."""
# Least cosine between an object's axis and the direction in which it reaches into something.
_SAME_WAY_COS: Final = 0.9
# Gap that is left beside what was shortened, metres.
_CLEARANCE_M: Final = 0.0005
_TOUCHING_M: Final = 0.002
# What was moved farther than this, and lies in something still, was measured in it, metres: it is
# the same thing, or stands elsewhere.
_MAX_MOVED_M: Final = 0.32
_VERTICAL: Final = np.roll(np.eye(3), 1, axis=0)


@dataclass(frozen=True, eq=False)
class Cut:
    """One side of an object that recedes.

    Attributes:
        row: The object.
        side: (3,) unit, outwards.
        depth: How far, metres.
    """

    row: int
    side: Array
    depth: float


def fit(
    state: Arrangement,
    wrong: Sequence[Unresolved],
    models: Mapping[str, CadModel],
    share: float = USUAL_SHARE,
    only: Collection[int] | None = None,
) -> bool:
    """Shorten what reaches into walls and other objects, each object for one reason at a time.

    Args:
        state: The objects; changed.
        wrong: What is wrong with them.
        models: CADs by their ids.
        share: Largest part of a measured length that is cut off.
        only: The instances that may be shortened; None: all.

    Returns:
        Whether anything was shortened.
    """
    rows = {thing.instance: row for row, thing in enumerate(state.objects)}
    free = None if only is None else {rows[number] for number in only}
    cut: set[int] = set()
    for one in sorted(wrong, key=lambda one: (one.other is not None, -one.depth, one.instance)):
        whom = {rows[number] for number in (one.instance, one.other) if number is not None}
        if one.kind == "floats" or whom & cut:
            continue
        cuts = _of_walls(state, rows[one.instance]) if one.other is None else []
        if one.other is not None:
            cuts = _of_pair(state, rows[one.instance], rows[one.other], models, share, free)
        for each in cuts:
            if (free is None or each.row in free) and _cost(state, each, models, share) < np.inf:
                _shorten(state, each)
                cut.add(each.row)
    return bool(cut)


def _of_walls(state: Arrangement, row: int) -> list[Cut]:
    """The sides by which an object reaches beyond the walls that are about parallel to them."""
    body, room = state.bodies[row], state.rooms[row]
    out = room.outward(room.footprint(body))
    cuts = []
    for side in np.concatenate([body.axes, -body.axes]):
        reach = out @ side
        along = reach > np.maximum(_SAME_WAY_COS * np.linalg.norm(out, axis=1), _TOUCHING_M)
        depth = float(reach[along].max(initial=0.0)) + _CLEARANCE_M
        if along.any():
            cuts.append(Cut(row, np.append(side, 0.0), depth))
    return cuts


def _of_pair(
    state: Arrangement,
    i: int,
    j: int,
    models: Mapping[str, CadModel],
    share: float,
    free: Collection[int] | None,
) -> list[Cut]:
    """The least cut of one of two objects that parts them; none where none does."""
    cuts = sorted(
        (
            (_cost(state, cut, models, share), number, cut)
            for number, cut in enumerate(_ways(state, i, j, free))
            if free is None or cut.row in free
        ),
        key=lambda each: each[:2],
    )
    return [cuts[0][2]] if cuts and cuts[0][0] < np.inf else []


def _ways(state: Arrangement, i: int, j: int, free: Collection[int] | None) -> Iterator[Cut]:
    a, b = state.bodies[i], state.bodies[j]
    if any(state.moved(row) > _MAX_MOVED_M for row in (i, j) if free is None or row in free):
        return
    found = penetration(a, b, _TOUCHING_M, FINE_LINES)
    for direction, depth in found.ways if found else ():
        side = np.append(direction, 0.0)
        yield Cut(i, -side, depth + _CLEARANCE_M)
        yield Cut(j, side, depth + _CLEARANCE_M)
    down, up = exits(a, b, _VERTICAL, FINE_LINES)
    top = np.array([0.0, 0.0, 1.0])
    # What stands keeps its base, what hangs from the ceiling its top.
    for row, other, depth in ((i, j, down), (j, i, up)):
        if depth > 0.0 and state.supports[row].kind != CEILING and other != state.carrier(row):
            yield Cut(row, top, depth + _CLEARANCE_M)
        if depth > 0.0 and state.supports[other].kind in (CEILING, WALL):
            yield Cut(other, -top, depth + _CLEARANCE_M)


def _cost(state: Arrangement, cut: Cut, models: Mapping[str, CadModel], share: float) -> float:
    """The part of an object that is cut off, more for well measured ones; infinite: too much."""
    thing = state.objects[cut.row]
    number, factor = _scaling(state, cut)
    model = models[thing.cad]
    measured = thing.pose.scale * np.ptp(model.extent, axis=0)
    before = np.ones(3) if thing.fitted is None else thing.fitted
    least = sizes_of(model, np.eye(3), measured / before)[0]
    if number < 0 or before[number] * factor < 1.0 - share:
        return np.inf
    if measured[number] * factor < least[number]:
        return np.inf
    return (1.0 - factor) * state.trust(cut.row)


def _scaling(state: Arrangement, cut: Cut) -> tuple[int, float]:
    """The object's own axis along which it is cut, -1 where it has none, and the factor."""
    axes = state.motions[cut.row][:3, :3] @ rotation_of(state.objects[cut.row].pose)
    cosines = np.abs(cut.side @ axes)
    number = int(np.argmax(cosines))
    along = state.bodies[cut.row].triangles @ axes[:, number]
    factor = 1.0 - cut.depth / max(float(np.ptp(along)), 1e-9)
    return (number if cosines[number] > _SAME_WAY_COS else -1), factor


def _shorten(state: Arrangement, cut: Cut) -> None:
    row, thing, body = cut.row, state.objects[cut.row], state.bodies[cut.row]
    number, factor = _scaling(state, cut)
    motion = state.motions[row]
    axis = motion[:3, :3] @ rotation_of(thing.pose)[:, number]
    axis = axis * np.sign(axis @ cut.side)
    far = float((body.triangles @ axis).min())
    state.bodies[row] = Body(_stretched(body.triangles, axis, far, factor), body.axes)
    placed = _stretched(posed(thing.pose, motion).translation, axis, far, factor)
    scale = np.where(np.arange(3) == number, factor, 1.0)
    pose = replace(
        thing.pose,
        translation=motion[:3, :3].T @ (placed - motion[:3, 3]),
        scale=thing.pose.scale * scale,
    )
    fitted = scale if thing.fitted is None else scale * thing.fitted
    state.objects[row] = replace(thing, pose=pose, fitted=fitted)


def _stretched(points: Array, axis: Array, fixed: float, factor: float) -> Array:
    """Points (..., 3) stretched along an axis about a plane perpendicular to it."""
    return np.asarray(points + (factor - 1.0) * (points @ axis - fixed)[..., None] * axis)


# Which objects to leave out, so that nothing is wrong with the others.

# What lies deeper in each other, or farther in a wall or above what carries it, than these is not
# left standing, metres: people see it, and it is more than a scan's drift.
_MAX_OVERLAP_M: Final = 0.02
MAX_GAP_M: Final = 0.05


@dataclass(frozen=True)
class LeftOut:
    """An object that has no place.

    Attributes:
        instance: Its number.
        word: What it is.
        reason: What is wrong with it where it was measured, for people.
        other: The instance that it lies in; None where that is not why.
    """

    instance: int
    word: str
    reason: str
    other: int | None = None


def left_out(
    state: Arrangement, found: Sequence[Unresolved], *, with_carried: bool
) -> dict[int, LeftOut]:
    """Objects without which no violation is left, by rows.

    What floats or reaches into a wall goes itself. Of what overlaps the worst goes first: by the
    depth of all its overlaps over its worth, which is large for large and well measured objects.

    Args:
        state: The objects.
        found: What is wrong with them.
        with_carried: Whether what stands on them goes too.
    """
    rows = {thing.instance: row for row, thing in enumerate(state.objects)}
    gone: dict[int, LeftOut] = {}
    pairs: list[tuple[int, int, Unresolved]] = []
    for one in found:
        row = rows[one.instance]
        if one.other is None:
            if one.depth > MAX_GAP_M and row not in gone:
                gone[row] = _left_out_note(state, row, one, rows)
        elif one.depth > _MAX_OVERLAP_M:
            pairs.append((row, rows[one.other], one))
    while pairs := [pair for pair in pairs if pair[0] not in gone and pair[1] not in gone]:
        cost = dict.fromkeys(sorted({row for pair in pairs for row in pair[:2]}), 0.0)
        for i, j, one in pairs:
            cost[i] += one.depth / _worth(state, i)
            cost[j] += one.depth / _worth(state, j)
        worst = max(cost, key=cost.__getitem__)
        deepest = max((one for i, j, one in pairs if worst in (i, j)), key=lambda one: one.depth)
        gone[worst] = _left_out_note(state, worst, deepest, rows)
    for row in list(gone) if with_carried else ():
        for other in state.carried(row):
            reason = f"the {_word(state, row)} that carries it is left out"
            thing = LeftOut(state.objects[other].instance, _word(state, other), reason)
            gone.setdefault(other, thing)
    return gone


def worth_left_out(state: Arrangement, found: Sequence[Unresolved]) -> float:
    """How much the room would lack without all that would be left out.

    Args:
        state: The objects.
        found: What is wrong with them.
    """
    return sum(_worth(state, row) for row in left_out(state, found, with_carried=False))


def _worth(state: Arrangement, row: int) -> float:
    """How much a room lacks without an object: by its area, where it was well measured."""
    body = state.bodies[row]
    return state.weight(row) * float(np.cbrt(np.prod(np.maximum(body.high - body.low, 0.01))))


def _word(state: Arrangement, row: int) -> str:
    thing = state.objects[row]
    return (thing.word or thing.category or "object").replace("_", " ")


def _left_out_note(
    state: Arrangement, row: int, wrong: Unresolved, rows: Mapping[int, int]
) -> LeftOut:
    instance, number = state.objects[row].instance, None
    if wrong.other is None:
        where = whereabouts(wrong, hangs=state.supports[row].kind == WALL)
    else:
        number = wrong.other if wrong.instance == instance else wrong.instance
        where = f"inside the {_word(state, rows[number])} (instance {number})"
    return LeftOut(instance, _word(state, row), f"it is {wrong.depth:.2f} m {where}", number)


def whereabouts(wrong: Unresolved, *, hangs: bool) -> str:
    """Where something is that lies in nothing else and is wrong, in words.

    Args:
        wrong: What is wrong with it.
        hangs: Whether a wall carries it.
    """
    if wrong.kind == "in a wall":
        return "beyond the walls"
    return "away from the wall that it hangs on" if hangs else "above everything that can carry it"
