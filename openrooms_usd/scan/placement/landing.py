"""Gives a support to what floats: the nearest top below it, the floor, or a lamp's ceiling."""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from openrooms_usd.furniture.words import category_of
from openrooms_usd.scan.placement.arrangement import Arrangement
from openrooms_usd.scan.placement.leavingout import MAX_GAP_M
from openrooms_usd.scan.placement.settling import lower
from openrooms_usd.scan.placement.support import CEILING, FLOOR, OBJECT, Support, rest
from openrooms_usd.scan.placement.violations import Unresolved

# Largest fall, metres: what the holes of a scan hide, such as the mattress under a pillow.
_MAX_FALL_M: Final = 0.5
# Least part of a base on what carries it.
_MIN_BASE_SHARE: Final = 0.3


def land(state: Arrangement, wrong: Sequence[Unresolved]) -> bool:
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
        lower(state, row)
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
