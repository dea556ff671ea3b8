"""Corrects the poses of aligned objects to physically plausible ones.

One pass: small tilts are removed; supports are found and touched exactly; objects that penetrate a
wall at a small angle are turned along it; then all penetrations, between objects and with walls,
are resolved by the least motion. Plausible poses are returned unchanged. What is wrong after that
may be lowered, moved farther or shortened, and where that does not help either, be left out.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.words import category_of
from openrooms_usd.scan.models.cad import CadModel
from openrooms_usd.scan.placement import settling
from openrooms_usd.scan.placement.arrangement import Arrangement, arranged, posed, rotation_of
from openrooms_usd.scan.placement.fitting import (
    LAST_SHARE,
    MAX_GAP_M,
    USUAL_SHARE,
    LeftOut,
    fit,
    left_out,
    worth_left_out,
)
from openrooms_usd.scan.placement.spreading import Spread
from openrooms_usd.scan.placement.support import CEILING, FLOOR, OBJECT, WALL, Support, rest
from openrooms_usd.scan.results import FoundObject, FoundRoom

# Motions shorter than this are ignored, metres.
_NO_MOTION_M: Final = 1e-4
# Motion by which objects of real scans that overlap still come apart, whose CADs have not their
# shapes, metres: what stands still farther off stands elsewhere.
_FAR_REACH_M: Final = 0.2
# Times that objects are left out and the others placed anew: what one pushed away stays where it
# was measured without it.
_MAX_TRIES: Final = 4
# Rounds of shortening what has no room: one for each of its sides.
_MAX_FITS: Final = 4
# Motion by which what was shortened comes to rest, metres: the cut leaves it free.
_FITTED_REACH_M: Final = 0.03
_FITTED_ROUNDS: Final = 4
# Largest fall, metres: what the holes of a scan hide, such as the mattress under a pillow, or the
# legs of a table.
_MAX_FALL_M: Final = 1.0
# Least part of a base on what carries it.
_MIN_BASE_SHARE: Final = 0.3


@dataclass(frozen=True)
class Placement:
    """Objects after placement.

    Attributes:
        objects: As given, with ``placed`` and ``support``.
        unresolved: Remaining violations.
        left_out: Objects that are not among these, because they have no place.
        notes: What people should know, one sentence each.
    """

    objects: tuple[FoundObject, ...]
    unresolved: tuple[settling.Unresolved, ...]
    left_out: tuple[LeftOut, ...]
    notes: tuple[str, ...]


def place(
    objects: Sequence[FoundObject],
    models: Mapping[str, CadModel],
    rooms: Sequence[FoundRoom],
    reach: float = 0.10,
    unresolved: Literal["leave_out", "keep"] = "keep",
) -> Placement:
    """Make poses physically plausible by the least motion.

    Args:
        objects: In the level frame: Z up, metres; their order changes nothing. A given ``support``
            is kept.
        models: CADs by their ids.
        rooms: In the same frame; their walls and ceilings bound the objects.
        reach: Largest motion by penetrations of other objects, metres.
        unresolved: What becomes of objects that penetrate others or walls, or float, after this
            motion and a farther one.
    """
    found = _resolved(objects, models, rooms, reach, unresolved)
    if any(one.other is not None for one in found.left_out):
        # What was cut to have a place may take that of others.
        uncut = _resolved(objects, models, rooms, reach, unresolved, remedies=False)
        found = min(found, uncut, key=lambda one: len(one.left_out))
    return found


def _resolved(
    objects: Sequence[FoundObject],
    models: Mapping[str, CadModel],
    rooms: Sequence[FoundRoom],
    reach: float,
    unresolved: Literal["leave_out", "keep"],
    *,
    remedies: bool = True,
) -> Placement:
    """Objects by the least motion, lowered and cut or not, and without those that have no place."""
    kept = in_rows = sorted(objects, key=lambda thing: thing.instance)
    gone: dict[int, LeftOut] = {}
    state, wrong = _settled(kept, models, rooms, reach)
    returned: set[int] = set()
    for tries in range(_MAX_TRIES if unresolved == "leave_out" else 0):
        wrong = _mended(state, wrong, models) if remedies else _moved_farther(state, wrong)
        last = tries == _MAX_TRIES - 1
        out = left_out(state, wrong, with_carried=last)
        if out and remedies:
            state, wrong = _rescued(state, wrong, models)
            out = left_out(state, wrong, with_carried=last)
        gone |= {found.instance: found for found in out.values()}
        if not out or last:
            break
        # What lay in something that is gone as well may have a place now.
        back = {one.instance for one in gone.values() if one.other in gone} - returned
        returned |= back
        gone = {number: one for number, one in gone.items() if number not in back}
        kept = [thing for thing in in_rows if thing.instance not in gone]
        state, wrong = _settled(kept, models, rooms, reach)
    placed = {thing.instance: thing for thing in _placed(state)}
    in_order = tuple(placed[one.instance] for one in objects if one.instance not in gone)
    left = tuple(one for one in wrong if one.instance not in gone and one.other not in gone)
    return Placement(in_order, left, tuple(gone.values()), tuple(state.notes))


def _settled(
    objects: Sequence[FoundObject],
    models: Mapping[str, CadModel],
    rooms: Sequence[FoundRoom],
    reach: float,
) -> tuple[Arrangement, list[settling.Unresolved]]:
    """Objects by the least motion, and what is wrong with them after it."""
    state = arranged(objects, models, rooms)
    state.given = _given_supports(state)
    settling.set_upright(state)
    settling.find_supports(state)
    settling.lay_along_walls(state)
    _spread(state, Spread(state, reach))
    return state, settling.violations(state)


def _spread(state: Arrangement, spread: Spread) -> None:
    for row, shift in enumerate(spread.run()):
        if np.abs(shift).max() > _NO_MOTION_M:
            state.shift(row, np.append(shift, 0.0))
    settling.settle_again(state)


def _moved_farther(
    state: Arrangement, wrong: list[settling.Unresolved]
) -> list[settling.Unresolved]:
    """What is wrong still after objects that overlap were moved farther."""
    if any(one.kind != "floats" for one in wrong):
        _spread(state, Spread(state, _FAR_REACH_M))
        return settling.violations(state)
    return wrong


def _mended(
    state: Arrangement, wrong: list[settling.Unresolved], models: Mapping[str, CadModel]
) -> list[settling.Unresolved]:
    """What is wrong still after all that is tried before anything is left out.

    A cut of a few per cent comes before a motion by decimetres: it changes less.
    """
    if land(state, wrong):
        wrong = settling.violations(state)
    wrong = _fitted(state, wrong, models)
    return _fitted(state, _moved_farther(state, wrong), models)


def _rescued(
    state: Arrangement, wrong: list[settling.Unresolved], models: Mapping[str, CadModel]
) -> tuple[Arrangement, list[settling.Unresolved]]:
    """The same after what would be left out lost half its length, or was moved inside.

    Most of its points lie in this room, so there is such a thing here. One by one: what worthier
    ones would give way to goes itself.
    """
    tried = set[int]()
    while lost := sorted(left_out(state, wrong, with_carried=False).keys() - tried):
        row = lost[0]
        tried.add(row)
        trial = state.copy()
        remains = _fitted(trial, wrong, models, LAST_SHARE, {trial.objects[row].instance})
        room = trial.rooms[row]
        out = room.outward(room.footprint(trial.bodies[row]))
        inwards = -(out.max(axis=0).clip(0.0) + out.min(axis=0).clip(None, 0.0))
        half = 0.5 * np.ptp(trial.bodies[row].outline, axis=0) + MAX_GAP_M
        # What is farther outside is another room's.
        if np.abs(inwards).max() > MAX_GAP_M and (np.abs(inwards) < half).all():
            for each in (row, *trial.carried(row)):
                trial.shift(each, np.append(inwards, 0.0))
            settling.settle_again(trial)
            remains = settling.violations(trial)
        if worth_left_out(trial, remains) < worth_left_out(state, wrong):
            state, wrong = trial, remains
    return state, wrong


def _fitted(
    state: Arrangement,
    wrong: list[settling.Unresolved],
    models: Mapping[str, CadModel],
    share: float = USUAL_SHARE,
    only: Collection[int] | None = None,
) -> list[settling.Unresolved]:
    """What is wrong still after what has no room was shortened, some of the instances or all."""
    for _ in range(_MAX_FITS):
        if not fit(state, wrong, models, share, only):
            break
        _spread(state, Spread(state, _FITTED_REACH_M, _FITTED_ROUNDS))
        wrong = settling.violations(state)
    return wrong


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


def _given_supports(state: Arrangement) -> dict[int, Support]:
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


def land(state: Arrangement, wrong: Sequence[settling.Unresolved]) -> bool:
    """Put what floats on what is nearest below it; a lamp near the ceiling, or far from all, hangs.

    Args:
        state: The objects; changed.
        wrong: What is wrong with them.

    Returns:
        Whether anything has a support now that had none.
    """
    floating = {one.instance for one in wrong if one.kind == "floats" and one.depth > MAX_GAP_M}
    rows = [row for row, thing in enumerate(state.objects) if thing.instance in floating]
    landed = False
    for row in sorted(rows, key=lambda row: (float(state.bodies[row].low[2]), row)):
        found = min(_below(state, row), key=lambda each: each[:2], default=None)
        if _is_lamp(state, row) and (found is None or _gap_above(state, row) < found[0]):
            # One that is far from all hangs on a cable that its CAD lacks.
            state.supports[row] = Support(CEILING)
        elif found is not None and row not in state.given:
            state.supports[row] = found[2]
        else:
            continue
        before = float(state.bodies[row].low[2])
        settling.lower(state, row)
        for other in state.carried(row):
            state.shift(other, np.array([0.0, 0.0, float(state.bodies[row].low[2]) - before]))
        landed = True
    return landed


def _below(state: Arrangement, row: int) -> Iterator[tuple[float, int, Support]]:
    """What may carry an object after a fall, and how far that is."""
    body = state.bodies[row]
    gap = float(body.low[2] - state.rooms[row].floor)
    if 0.0 < gap < _MAX_FALL_M:
        yield gap, -1, Support(FLOOR)
    above = set(state.carried(row))
    for other, under in enumerate(state.bodies):
        if other == row or other in above or under.low[2] > body.low[2]:
            continue
        if under.high[2] < body.low[2] - _MAX_FALL_M:
            continue
        there = rest(body, under)
        if there is not None and there.gap < _MAX_FALL_M and there.share > _MIN_BASE_SHARE:
            yield abs(there.gap), other, Support(OBJECT, other)


def _is_lamp(state: Arrangement, row: int) -> bool:
    thing = state.objects[row]
    return any(
        "lamp" in (word or "") or "light" in (word or "")
        for word in (thing.category, thing.word, category_of(thing.word, 0.0))
    )


def _gap_above(state: Arrangement, row: int) -> float:
    ceiling = state.rooms[row].ceiling
    return np.inf if ceiling is None else abs(ceiling - float(state.bodies[row].high[2]))
