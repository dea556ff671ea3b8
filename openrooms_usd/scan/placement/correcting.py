"""Corrects the poses of aligned objects to physically plausible ones.

One pass: small tilts are removed; supports are found and touched exactly; objects that penetrate a
wall at a small angle are turned along it; then all penetrations, between objects and with walls,
are resolved by the least motion. Plausible poses are returned unchanged. What is wrong after that
may be lowered, moved farther or shortened, and where that does not help either, be left out.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.models.cad import CadModel
from openrooms_usd.scan.placement.arrangement import Arrangement, arranged, posed, rotation_of
from openrooms_usd.scan.placement.fitting import fit
from openrooms_usd.scan.placement.landing import land
from openrooms_usd.scan.placement.leavingout import LeftOut, left_out
from openrooms_usd.scan.placement.settling import (
    find_supports,
    lay_along_walls,
    set_upright,
    settle_again,
)
from openrooms_usd.scan.placement.spreading import Spread
from openrooms_usd.scan.placement.support import CEILING, FLOOR, OBJECT, WALL, Support
from openrooms_usd.scan.placement.violations import Unresolved, violations
from openrooms_usd.scan.results import FoundObject, FoundRoom

Array = NDArray[np.float64]

# Motions shorter than this are none, metres.
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
    unresolved: tuple[Unresolved, ...]
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
) -> tuple[Arrangement, list[Unresolved]]:
    """Objects by the least motion, and what is wrong with them after it."""
    state = arranged(objects, models, rooms)
    state.given = _given(state)
    set_upright(state)
    find_supports(state)
    lay_along_walls(state)
    _spread(state, Spread(state, reach))
    return state, violations(state)


def _spread(state: Arrangement, spread: Spread) -> None:
    for row, shift in enumerate(spread.run()):
        if np.abs(shift).max() > _NO_MOTION_M:
            state.shift(row, np.append(shift, 0.0))
    settle_again(state)


def _moved_farther(state: Arrangement, wrong: list[Unresolved]) -> list[Unresolved]:
    """What is wrong still after objects that overlap were moved farther."""
    if any(one.kind != "floats" for one in wrong):
        _spread(state, Spread(state, _FAR_REACH_M))
        return violations(state)
    return wrong


def _mended(
    state: Arrangement, wrong: list[Unresolved], models: Mapping[str, CadModel]
) -> list[Unresolved]:
    """What is wrong still after all that is tried before anything is left out.

    A cut of a few per cent comes before a motion by decimetres: it changes less.
    """
    if land(state, wrong):
        wrong = violations(state)
    wrong = _fitted(state, wrong, models)
    return _fitted(state, _moved_farther(state, wrong), models)


def _fitted(
    state: Arrangement, wrong: list[Unresolved], models: Mapping[str, CadModel]
) -> list[Unresolved]:
    """What is wrong still after what has no room was shortened."""
    for _ in range(_MAX_FITS):
        if not fit(state, wrong, models):
            break
        _spread(state, Spread(state, _FITTED_REACH_M, _FITTED_ROUNDS))
        wrong = violations(state)
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
