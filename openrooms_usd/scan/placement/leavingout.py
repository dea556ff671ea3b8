"""Which objects to leave out, so that nothing is wrong with the others."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.scan.placement.arrangement import Arrangement
from openrooms_usd.scan.placement.settling import Unresolved

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
                gone[row] = _told(state, row, one, rows)
        elif one.depth > _MAX_OVERLAP_M:
            pairs.append((row, rows[one.other], one))
    while pairs := [pair for pair in pairs if pair[0] not in gone and pair[1] not in gone]:
        cost = dict.fromkeys(sorted({row for pair in pairs for row in pair[:2]}), 0.0)
        for i, j, one in pairs:
            cost[i] += one.depth / _worth(state, i)
            cost[j] += one.depth / _worth(state, j)
        worst = max(cost, key=cost.__getitem__)
        deepest = max((one for i, j, one in pairs if worst in (i, j)), key=lambda one: one.depth)
        gone[worst] = _told(state, worst, deepest, rows)
    for row in list(gone) if with_carried else ():
        for other in state.carried(row):
            reason = f"the {_word(state, row)} that carries it is left out"
            thing = LeftOut(state.objects[other].instance, _word(state, other), reason)
            gone.setdefault(other, thing)
    return gone


def _worth(state: Arrangement, row: int) -> float:
    """How much a room lacks without an object: by its area, where it was well measured."""
    body = state.bodies[row]
    return state.weight(row) * float(np.cbrt(np.prod(np.maximum(body.high - body.low, 0.01))))


def _word(state: Arrangement, row: int) -> str:
    thing = state.objects[row]
    return (thing.word or thing.category or "object").replace("_", " ")


def _told(state: Arrangement, row: int, wrong: Unresolved, rows: Mapping[int, int]) -> LeftOut:
    instance, number = state.objects[row].instance, None
    if wrong.other is None:
        reach = {"floats": "above all that may carry it", "in a wall": "beyond the walls"}
        where = reach[wrong.kind]
    else:
        number = wrong.other if wrong.instance == instance else wrong.instance
        where = f"inside the {_word(state, rows[number])} (instance {number})"
    return LeftOut(instance, _word(state, row), f"it is {wrong.depth:.2f} m {where}", number)
