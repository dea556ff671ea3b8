"""Resolves penetrations of objects and walls in the plan, by sequential quadratic programs.

A quadratic program: minimise sum_i w_i |m_i|^2 / 2 under a . x >= b, where x are the total motions,
those of supports included. Its dual is a non-negative least squares problem (Lawson & Hanson 1974).
Constraints are soft (each is relaxed by its multiplier times its softness), so that infeasible ones
end in a compromise.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Final, TypeAlias

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.scan.placement.arrangement import Arrangement
from openrooms_usd.scan.placement.bodies import Body
from openrooms_usd.scan.placement.penetration import (
    COARSE_LINES,
    FINE_LINES,
    Penetration,
    directions,
    gaps,
    near,
    penetration,
)
from openrooms_usd.scan.placement.support import WALL

Pair: TypeAlias = tuple[int, int]

Walls: TypeAlias = list[dict[int, float]]

# Penetrations up to this are tolerated, metres.
TOLERATED_OVERLAP_M: Final = 0.002
# Gap between separated objects, metres.
_CLEARANCE_M: Final = 0.0005
_MAX_ROUNDS: Final = 16
# Penalty of a direction that was tried and did not separate a pair, metres.
_TRIED_WAY_PENALTY_M: Final = 0.01
# A direction with less depth left than this is kept, metres; least cosine of the same direction.
_WAY_LEFT_M: Final = 0.015
_SAME_WAY_COS: Final = 0.999
# Softness of constraints, from hard to soft: walls, largest motions, pairs, contacts.
_WALL_SOFTNESS: Final = 1e-7
_REACH_SOFTNESS: Final = 1e-6
_PAIR_SOFTNESS: Final = 1e-5
_CONTACT_SOFTNESS: Final = 1.0
# Bodies nearer than this touch, metres.
_CONTACT_M: Final = 0.004
# Least decrease of total penetration that makes another state better, metres.
_BETTER_BY_M: Final = 1e-4
_SAME_PLACE_M: Final = 1e-6
_MAX_REFINEMENTS: Final = 50
_BROKEN_M: Final = 1e-6


@dataclass(frozen=True, eq=False)
class Condition:
    """A constraint: the sum of direction_i . x_i must be at least a bound.

    Attributes:
        directions: Objects' rows, and for each (2,).
        bound: Metres.
        softness: Relaxation per multiplier; the smaller, the harder the constraint.
    """

    directions: Mapping[int, Array]
    bound: float
    softness: float


def least_motion(weights: Array, carried: Array, conditions: Sequence[Condition]) -> Array:
    """The own motion of each object, relative to its support's.

    Args:
        weights: (N,) positive.
        carried: (N, N) 1 where the object of the row moves with that of the column (itself too).
        conditions: The constraints.

    Returns:
        (N, 2) metres.
    """
    count = len(weights)
    if not conditions:
        return np.zeros((count, 2))
    rows = np.zeros((len(conditions), count, 2))
    for row, condition in zip(rows, conditions, strict=True):
        for number, direction in condition.directions.items():
            row[number] += direction
    # The Jacobian by own motions: an object takes along all that it carries.
    own = np.einsum("kid,ij->kjd", rows, carried)
    rows = own.reshape(len(conditions), -1)
    softness = np.array([condition.softness for condition in conditions])
    bounds = np.array([condition.bound for condition in conditions])
    ease = np.repeat(1.0 / weights, 2)
    active, motion = bounds > 0.0, np.zeros(2 * count)
    # Few constraints are active: only violated ones enter the working set.
    for _ in range(_MAX_REFINEMENTS):
        motion = _solved(rows[active], bounds[active], softness[active], ease)
        broken = ~active & (rows @ motion < bounds - _BROKEN_M)
        if not broken.any():
            break
        active |= broken
    return motion.reshape(count, 2)


def _solved(rows: Array, bounds: Array, softness: Array, ease: Array) -> Array:
    """The least motion under rows . x >= bounds, by the dual."""
    from scipy.optimize import nnls

    if not len(rows):
        return np.zeros(len(ease))
    lower = np.linalg.cholesky((rows * ease) @ rows.T + np.diag(softness))
    pull = nnls(lower.T, np.linalg.solve(lower, bounds), maxiter=30 * len(rows))[0]
    return np.asarray((pull @ rows) * ease)


@dataclass(eq=False)
class Spread:
    """Moves objects in the plan: constraints are linearised anew in every round.

    Attributes:
        state: The objects before.
        reach: Largest own motion of each, metres.
        rounds: How often at most.
    """

    state: Arrangement
    reach: float
    rounds: int = _MAX_ROUNDS
    _pairs: dict[Pair, Condition] = field(default_factory=dict)
    _touching: dict[Pair, Condition] = field(default_factory=dict)
    _tried: Counter[tuple[Pair, int]] = field(default_factory=Counter)
    _known: dict[tuple[Pair, int], tuple[Array, Penetration | None]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._footprints = [
            room.footprint(body)
            for room, body in zip(self.state.rooms, self.state.bodies, strict=True)
        ]
        self._ancestry = self.state.ancestry()
        self._carrier = [self.state.carrier(row) for row in range(len(self.state))]
        self._stuck = [
            bool(room.beyond(points).max() > TOLERATED_OVERLAP_M and not room.leave(points))
            for room, points in zip(self.state.rooms, self._footprints, strict=True)
        ]
        self._out = [0.0] * len(self.state)
        self._weights = np.array([self.state.weight(row) for row in range(len(self.state))])

    def run(self) -> Array:
        """(N, 2) total motions of the best state found, metres."""
        place = best = np.zeros((len(self.state), 2))
        lines, least = COARSE_LINES, np.inf
        for _ in range(self.rounds):
            pairs, walls = self._overlaps(place, lines), self._beyond(place)
            if not pairs and not any(walls) and lines == COARSE_LINES:
                # Penetrations that few lines missed, more may find.
                lines = FINE_LINES
                pairs = self._overlaps(place, lines)
            left = sum(found.depth for found in pairs.values())
            left += sum(max(way.values()) for way in walls if way)
            if left < least - _BETTER_BY_M:
                best, least = place, left
            if left == 0.0:
                break
            self._pairs |= {pair: self._separation(pair, pairs[pair], place) for pair in pairs}
            place = self._moved(place, walls)
        return best

    def _moved(self, place: Array, walls: Walls) -> Array:
        conditions = [*self._pairs.values(), *self._enclosing(place, walls), *self._limits(walls)]
        own = least_motion(self._weights, self._ancestry, [*conditions, *self._touching.values()])
        parted = self._contacts(self._ancestry @ own)
        if parted:
            self._touching |= parted
            conditions += self._touching.values()
            own = least_motion(self._weights, self._ancestry, conditions)
        return np.asarray(self._ancestry @ own)

    def _beyond(self, place: Array) -> Walls:
        """For each object the walls that it penetrates, and how far it must leave them."""
        found = []
        for room, points, shift in zip(self.state.rooms, self._footprints, place, strict=True):
            way = room.leave(points + shift)
            found.append(way if max(way.values(), default=0.0) > TOLERATED_OVERLAP_M else {})
        return found

    def _overlaps(self, place: Array, lines: int) -> dict[Pair, Penetration]:
        bodies = [
            body.moved(np.append(shift, 0.0))
            for body, shift in zip(self.state.bodies, place, strict=True)
        ]
        found = {}
        for pair in combinations(range(len(bodies)), 2):
            a, b = (bodies[row] for row in pair)
            # Objects that cannot get into their room do not push others.
            if near(a, b, -TOLERATED_OVERLAP_M) and not (
                self._stuck[pair[0]] or self._stuck[pair[1]]
            ):
                overlap = self._overlap((pair, lines), a, b, place[pair[0]] - place[pair[1]])
                if overlap is not None:
                    found[pair] = overlap
        return found

    def _overlap(self, key: tuple[Pair, int], a: Body, b: Body, apart: Array) -> Penetration | None:
        known = self._known.get(key)
        if known is None or np.abs(known[0] - apart).max() > _SAME_PLACE_M:
            (i, j), lines = key
            is_there = np.abs(apart).max() <= _SAME_PLACE_M
            known = self._known[key] = (
                apart,
                (
                    self.state.overlap(i, j, TOLERATED_OVERLAP_M, lines)
                    if is_there
                    else penetration(a, b, TOLERATED_OVERLAP_M, lines)
                ),
            )
        return known[1]

    def _contacts(self, place: Array) -> dict[Pair, Condition]:
        """Soft constraints that keep objects together which touched in their measured poses."""
        found = {}
        for pair in combinations(range(len(self.state)), 2):
            a, b = (self.state.bodies[row] for row in pair)
            apart = place[pair[0]] - place[pair[1]]
            if (
                np.abs(apart).max() < TOLERATED_OVERLAP_M
                or pair in self._pairs
                or pair in self._touching
            ):
                continue
            if self._ancestry[pair] or self._ancestry[pair[::-1]] or not near(a, b, _CONTACT_M):
                continue
            towards = _contact(a, b)
            if towards is not None:
                i, j = pair
                found[pair] = Condition({i: towards, j: -towards}, 0.0, _CONTACT_SOFTNESS)
        return found

    def _separation(self, pair: Pair, found: Penetration, place: Array) -> Condition:
        """The separating constraint of the least motion from the measured poses."""
        i, j = pair
        apart = place[i] - place[j]
        before = self._pairs.get(pair)
        costs = []
        for k, (direction, depth) in enumerate(found.ways):
            cost = float(direction @ apart) + depth + _TRIED_WAY_PENALTY_M * self._tried[pair, k]
            # A direction that all but separated them is kept.
            going = before is not None and float(before.directions[i] @ direction) > _SAME_WAY_COS
            costs.append(-np.inf if going and depth < _WAY_LEFT_M else cost)
        k = int(np.argmin(costs))
        self._tried[pair, k] += 1
        direction, depth = found.ways[k]
        bound = float(direction @ apart) + depth + _CLEARANCE_M
        return Condition({i: direction, j: -direction}, bound, _PAIR_SOFTNESS)

    def _enclosing(self, place: Array, walls: Walls) -> list[Condition]:
        conditions = []
        for row, (room, points) in enumerate(zip(self.state.rooms, self._footprints, strict=True)):
            needed = {
                wall: -max(gap - _CLEARANCE_M, 0.0)
                for wall, gap in room.gaps(points + place[row]).items()
            }
            needed |= {wall: depth + _CLEARANCE_M for wall, depth in walls[row].items()}
            hangs = self.state.supports[row].kind == WALL
            for wall, depth in needed.items():
                normal = room.inward[wall]
                bound = float(normal @ place[row]) + depth
                conditions.append(Condition({row: normal}, bound, _WALL_SOFTNESS))
            facing = room.facing(self.state.bodies[row]) if hangs else None
            if facing is not None:
                away = -room.inward[facing.wall]
                conditions.append(Condition({row: away}, 0.0, _WALL_SOFTNESS))
        return conditions

    def _limits(self, walls: Walls) -> list[Condition]:
        """Constraints on own motions, except out of a wall."""
        conditions = []
        for row in range(len(self.state)):
            self._out[row] = max(self._out[row], *walls[row].values(), 0.0)
            reach = self.reach + self._out[row]
            for direction in np.concatenate([np.eye(2), -np.eye(2)]):
                parts = {row: direction}
                if self._carrier[row] >= 0:
                    parts[self._carrier[row]] = -direction
                conditions.append(Condition(parts, -reach, _REACH_SOFTNESS))
        return conditions


def _contact(a: Body, b: Body) -> Array | None:
    """The direction (2,) of a contact between two bodies; None where there is none."""
    for direction in directions(a, b):
        back, ahead = gaps(a, b, direction)
        if min(back, ahead) < _CONTACT_M:
            return direction if ahead < back else -direction
    return None
