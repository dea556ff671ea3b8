"""The support relation: what carries each object, of floor, objects, walls and ceiling."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.registry import record
from openrooms_usd.scan.placement.bodies import Body
from openrooms_usd.scan.placement.enclosure import Enclosure
from openrooms_usd.scan.placement.penetration import Chords, Lattice, chords, paired

FLOOR: Final = "floor"
WALL: Final = "wall"
CEILING: Final = "ceiling"
OBJECT: Final = "object"

# Largest penetration of a support, and largest gap above it, in a measured pose, metres.
MAX_SUNK_M: Final = 0.08
MAX_FLOATING_M: Final = 0.12
# Where there is no support within these: larger limits, metres; the gap of tall things is up to a
# part of their height, because they would not hang so low.
MAX_DEEP_M: Final = 0.16
_TALL_FALL_M: Final = 0.2
_TALL_FALL_SHARE: Final = 0.25
MAX_FAR_M: Final = 0.4
# Largest gap to the wall or ceiling that an object hangs on, and to a wall for objects other than
# panels, metres.
_HANGING_GAP_M: Final = 0.2
_BULKY_HANGING_GAP_M: Final = 0.06
# Prior of standing over hanging, as a difference of gaps, metres: smaller for panels, which are
# thinner than this, and than this share of their other sides.
_STANDING_BONUS_M: Final = 0.1
_PANEL_STANDING_BONUS_M: Final = 0.03
_PANEL_THICKNESS_M: Final = 0.15
_PANEL_THICKNESS_SHARE: Final = 0.5
# Least part of an object's base on its support,
_MIN_BASE_SHARE: Final = 0.3
# and where the floor is close below as well.
_MIN_BASE_SHARE_NEAR_FLOOR: Final = 0.7
# Objects on the floor lower than this are rugs, which support whatever overlaps them by this part.
_RUG_HEIGHT_M: Final = 0.04
_MIN_ON_RUG_SHARE: Final = 0.08
# Height above the lowest points within which lines belong to an object's base, metres.
_BASE_HEIGHT_M: Final = 0.012
# The same for its lowest corners, and about how many of them are tested.
_TIP_HEIGHT_M: Final = 0.003
_MAX_TIPS: Final = 64
# Priors, as differences of gaps, metres: of the floor over other things, and of a thing between an
# object and the floor, such as the lowest board of a shelf, over the floor.
_FLOOR_BONUS_M: Final = 0.02
_BETWEEN_BONUS_M: Final = 0.06
_VERTICAL: Final = (2, 0, 1)


@dataclass(frozen=True)
class Rest:
    """A body above another one.

    Attributes:
        gap: Vertical gap, metres; negative for a penetration.
        share: The part of its base that the other would support.
    """

    gap: float
    share: float


@dataclass(frozen=True)
class Support:
    """The support of an object.

    Attributes:
        kind: ``floor``, ``object``, ``wall``, ``ceiling``, or ``nothing``.
        number: The row of the supporting object; -1 for other kinds.
    """

    kind: str
    number: int = -1


def rest(body: Body, under: Body, lines: int = 1500, sunk: float = MAX_SUNK_M) -> Rest | None:
    """The gap and supported base of a body above another one; None where they do not overlap.

    Args:
        body: The upper body.
        under: The lower one.
        lines: Number of vertical lines.
        sunk: Tops that penetrate the body by more than this do not support it, metres.
    """
    low, high = np.maximum(body.low, under.low)[:2], np.minimum(body.high, under.high)[:2]
    if (high <= low).any() or under.low[2] > body.low[2] + sunk:
        return None
    lattice = Lattice.over(body.low[:2], body.high[:2], lines)
    bottom = _lowest(chords(body.triangles[..., _VERTICAL], lattice))
    top = chords(under.triangles[..., _VERTICAL], lattice)
    i, j = paired(bottom, top)
    gaps = bottom.low[i] - top.high[j]
    over = gaps > -sunk
    if not over.any():
        return None
    i, gaps = i[over], gaps[over]
    gap = min(float(gaps.min()), _lowest_gap(body, under, sunk))
    base = bottom.low < body.low[2] + _BASE_HEIGHT_M
    carried = np.unique(i[base[i] & (gaps < gap + _BASE_HEIGHT_M)])
    return Rest(gap, len(carried) / max(1, int(base.sum())))


def _lowest_gap(body: Body, under: Body, sunk: float) -> float:
    """The gap below a body's lowest corners, which the lines may miss."""
    corners = body.triangles.reshape(-1, 3)
    corners = corners[corners[:, 2] < body.low[2] + _TIP_HEIGHT_M]
    corners = corners[:: 1 + len(corners) // _MAX_TIPS]
    limit = body.low[2] + sunk
    inside = (under.triangles[..., :2] > corners[:, :2].min(axis=0)).any(axis=1).all(axis=1)
    inside &= (under.triangles[..., :2] < corners[:, :2].max(axis=0)).any(axis=1).all(axis=1)
    inside &= (under.triangles[..., 2] < limit).any(axis=1)
    heights = _heights(corners, under.triangles[inside])
    heights = np.where(heights < limit, heights, -np.inf)
    return float((corners[:, 2] - heights.max(axis=1, initial=-np.inf)).min(initial=np.inf))


def _heights(points: Array, triangles: Array) -> Array:
    """(P, T) heights at which vertical lines through points intersect triangles; else -inf."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    e, f = b - a, c - a
    area = e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0]
    x, y = points[:, None, 0] - a[:, 0], points[:, None, 1] - a[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        v, w = (x * f[:, 1] - y * f[:, 0]) / area, (e[:, 0] * y - e[:, 1] * x) / area
        met = (v >= 0.0) & (w >= 0.0) & (v + w <= 1.0) & (area != 0.0)
        return np.where(met, a[:, 2] + v * e[:, 2] + w * f[:, 2], -np.inf)


def _lowest(found: Chords) -> Chords:
    """The first chord of each line."""
    _, first = np.unique(found.line, return_index=True)
    return Chords(found.line[first], found.low[first], found.high[first])


def order(bodies: Sequence[Body], floor: Sequence[float]) -> list[int]:
    """Rows of bodies from the bottom up: supports before what they carry."""
    return sorted(
        range(len(bodies)),
        key=lambda i: (not is_rug(bodies[i], floor[i]), float(bodies[i].low[2]), i),
    )


def is_rug(body: Body, floor: float) -> bool:
    """Whether a body is flat on the floor, so that others may stand on it."""
    return bool(
        body.high[2] - body.low[2] < _RUG_HEIGHT_M
        and abs(body.low[2] - floor) < MAX_FLOATING_M
        and min(body.high[:2] - body.low[:2]) > 0.25
    )


def usual_support(category: str) -> str | None:
    """The support of a category's objects, whatever was measured; None: the measurement decides.

    Objects that usually stand, on the floor or on an object, may do either, but never hang.
    """
    known = record(category)
    if known is None or known.support is None:
        return None
    carriers = {known.support, *known.alternative_supports}
    if carriers <= {"floor", "surface"}:
        return FLOOR if carriers == {"floor"} else OBJECT
    return known.support if len(carriers) == 1 else None


def support_of(
    number: int, category: str, bodies: Sequence[Body], below: Sequence[int], room: Enclosure
) -> Support:
    """The support of an object: the one with the least gap, priors included.

    Args:
        number: Its row.
        category: Its category.
        bodies: All objects; those of ``below`` are already on their supports.
        below: Rows of the objects that may support it.
        room: The room around it.
    """
    usual, body = usual_support(category), bodies[number]
    if usual == CEILING or (usual == WALL and room.facing(body) is not None):
        return Support(usual)
    fall = min(max(_TALL_FALL_M, _TALL_FALL_SHARE * float(body.high[2] - body.low[2])), MAX_FAR_M)
    fall = MAX_FAR_M if usual == FLOOR else fall
    found = _standing(body, bodies, below, room, MAX_SUNK_M, MAX_FLOATING_M)
    found = found or _standing(body, bodies, below, room, MAX_DEEP_M, fall)
    if usual not in (FLOOR, OBJECT):
        found += _hanging(body, room)
    if not found:
        # Far above all that may carry it, beside a wall: a shelf or a bracket that is not modelled.
        return Support("nothing" if room.facing(body) is None else WALL)
    return min(found, key=lambda item: item[0])[1]


def _hanging(body: Body, room: Enclosure) -> Iterator[tuple[float, Support]]:
    """The wall and the ceiling, where they are near, with their costs."""
    facing = room.facing(body)
    if facing is not None and abs(facing.gap) < _HANGING_GAP_M:
        normal = room.inward[facing.wall]
        depth = float(np.ptp(body.outline @ normal))
        width = float(np.ptp(body.outline @ np.array([-normal[1], normal[0]])))
        smaller = min(width, float(body.high[2] - body.low[2]))
        panel = depth < min(_PANEL_THICKNESS_M, _PANEL_THICKNESS_SHARE * smaller)
        if panel or abs(facing.gap) < _BULKY_HANGING_GAP_M:
            yield (
                abs(facing.gap) + (_PANEL_STANDING_BONUS_M if panel else _STANDING_BONUS_M),
                Support(WALL),
            )
    if room.ceiling is not None and abs(room.ceiling - body.high[2]) < _HANGING_GAP_M:
        yield abs(room.ceiling - float(body.high[2])) + _STANDING_BONUS_M, Support(CEILING)


def _standing(
    body: Body,
    bodies: Sequence[Body],
    below: Sequence[int],
    room: Enclosure,
    sunk: float,
    floating: float,
) -> list[tuple[float, Support]]:
    """The floor, a rug on it, and objects with near tops, with their costs."""
    found: list[tuple[float, Support]] = []
    gap = float(body.low[2] - room.floor)
    on_floor = gap < floating
    if on_floor:
        found.append((abs(gap) - _FLOOR_BONUS_M, Support(FLOOR)))
    grounded = body.moved(np.array([0.0, 0.0, -gap]))
    for other in below:
        under = bodies[other]
        if on_floor and is_rug(under, room.floor):
            there = rest(grounded, under)
            if there is not None and there.share > _MIN_ON_RUG_SHARE:
                return [(abs(gap) - _FLOOR_BONUS_M, Support(OBJECT, other))]
        if under.high[2] < body.low[2] - floating:
            continue
        there = rest(body, under, sunk=sunk)
        if (
            there is not None
            and there.gap < floating
            and there.share > (_MIN_BASE_SHARE_NEAR_FLOOR if on_floor else _MIN_BASE_SHARE)
        ):
            found.append((abs(there.gap) - _BETWEEN_BONUS_M * on_floor, Support(OBJECT, other)))
    return found
