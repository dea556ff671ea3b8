"""How high a room of RoomPlan is: along the tops of its walls, or level.

Where walls slope, or where those around a convex floor without walls inside differ in height, the
ceiling follows their tops. Where two meet it is as high as the higher one, so that nothing
captured is above it.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.polygons import turns
from openrooms_usd.spelling import listed
from orusd_scans.floorplan import MAX_GAP_M
from orusd_scans.roomplan.records import Record
from orusd_scans.roomplan.spaces import facets, placed, rectangle
from orusd_scans.worldframe import WorldFrame

# Walls whose tops differ by less are equally high, metres; so many identifiers are named.
_SAME_HEIGHT_M: Final = 0.1
_MOST_NAMED: Final = 4
# Bends of a top that are nearer to each other, or to a corner of the floor, are one, metres.
_SAME_PLACE_M: Final = 0.05
# How parallel a top is to the edge of the floor that it is over, and how much of the shorter one is
# beside the other.
_MIN_PARALLEL_COS: Final = 0.9
_MIN_BESIDE_SHARE: Final = 0.5
# Least height of a ceiling, metres; floors with more corners have a level one.
_LOWEST_M: Final = 0.5
_MOST_CORNERS: Final = 200
# Corners that turn inwards by less are straight, radians.
_STRAIGHT_RAD: Final = 0.02


class Ceiling(NamedTuple):
    """A ceiling.

    Attributes:
        height: At its highest, above the floor, metres; None if unknown.
        line: (M, 3) where the walls meet it, around the floor; None where it is level.
    """

    height: float | None
    line: Array | None = None


class _Piece(NamedTuple):
    """A straight piece of a wall's top, over an edge of the floor.

    Attributes:
        wall: The identifier.
        edge: The number of the edge.
        x: (2,) from where to where along the edge, metres.
        z: (2,) heights there, metres.
    """

    wall: str
    edge: int
    x: Array
    z: Array


def ceiling_over(
    floor: Array | None,
    walls: Sequence[Record],
    others: Iterable[str],
    frame: WorldFrame,
    notes: list[str],
) -> Ceiling:
    """The ceiling of a room.

    Args:
        floor: (N, 2) its corners in the world, counter-clockwise, metres; None without any.
        walls: All that were captured.
        others: Identifiers of walls that are not on the outline.
        frame: The room's.
        notes: Receives a sentence where the ceiling is not level, or walls are not as captured.
    """
    tops = [(w.id, _top(w, frame)) for w in walls if w.size[0] > 0.0 and w.size[1] > 0.0]
    if not tops:
        return Ceiling(None)
    inner = {*others}
    outer = [(name, top) for name, top in tops if name not in inner]
    level = _usual([top for _, top in tops])
    slopes = any(_is_sloped(top) for _, top in outer)
    if floor is not None and len(floor) <= _MOST_CORNERS:
        if slopes or (not inner and float(turns(floor).min()) > -_STRAIGHT_RAD):
            pieces = [row for name, top in outer for row in _pieces(name, top, floor)]
            crowns = _crowns(floor, pieces, level)
            line = _around(floor, crowns)
            if np.ptp(line[:, 2]) > 0.0:
                _tell_line(pieces, crowns, notes)
                return Ceiling(float(line[:, 2].max()), line)
            level = float(line[0, 2])
    elif slopes:
        level = max(float(top[:, 2].max()) for _, top in outer)
    _tell_level(outer, level, notes)
    return Ceiling(level)


def _top(wall: Record, frame: WorldFrame) -> Array:
    """(K, 3) the top of a wall in the world, from end to end."""
    ring = wall.corners
    if wall.arc or len(ring) < 3:
        path = frame.points(facets(wall))
        path[:, 2] = frame.points(placed(wall, ring if len(ring) else rectangle(wall)))[:, 2].max()
        return path
    a, b = ring, np.roll(ring, -1, axis=0)
    x = np.unique(np.round(ring[:, 0], 6))[:, None]
    low, high = np.minimum(a, b)[:, 0], np.maximum(a, b)[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        y = a[:, 1] + (x - a[:, 0]) / (b - a)[:, 0] * (b - a)[:, 1]
    y = np.where(high - low > 1e-4, y, np.maximum(a, b)[:, 1])
    y = np.where((x > low - 1e-5) & (x < high + 1e-5), y, -np.inf).max(axis=1)
    return frame.points(placed(wall, np.column_stack([x[:, 0], y, np.zeros(len(x))])))


def _is_sloped(top: Array) -> bool:
    """Whether a wall ends at different heights: under a roof, or beside a stair."""
    return bool(np.ptp(top[:, 2]) > _SAME_HEIGHT_M)


def _usual(tops: Sequence[Array]) -> float:
    """The median of the heights from which on walls slope or end, weighted by their lengths."""
    lows = np.array([top[:, 2].min() for top in tops])
    lengths = [np.linalg.norm(np.diff(top[:, :2], axis=0), axis=1).sum() for top in tops]
    order = np.argsort(lows, kind="stable")
    weight = np.cumsum(np.round(lengths, 6)[order])
    return float(lows[order][np.searchsorted(weight, 0.5 * weight[-1])])


def _pieces(name: str, top: Array, floor: Array) -> Iterator[_Piece]:
    """The pieces of a wall's top that are over edges of the floor."""
    steps = np.roll(floor, -1, axis=0) - floor
    lengths = np.linalg.norm(steps, axis=1)
    along = steps / lengths[:, None]
    across = np.column_stack([-along[:, 1], along[:, 0]])
    for a, b in pairwise(top):
        ends = np.stack([a[:2] - floor, b[:2] - floor], axis=1)
        x, y = (np.einsum("eki,ei->ek", ends, way) for way in (along, across))
        low, high = x.min(axis=1), x.max(axis=1)
        beside = np.minimum(high, lengths) - np.maximum(low, 0.0)
        on = np.abs(y).max(axis=1) <= MAX_GAP_M
        on &= high - low >= _MIN_PARALLEL_COS * np.linalg.norm(b[:2] - a[:2])
        on &= beside > _MIN_BESIDE_SHARE * np.minimum(high - low, lengths)
        for edge in np.flatnonzero(on).tolist():
            order = np.argsort(x[edge])
            yield _Piece(name, edge, x[edge][order], np.array([a[2], b[2]])[order])


def _crowns(floor: Array, pieces: Sequence[_Piece], level: float) -> list[Array]:
    """(K, 2) for each edge of the floor: where its wall's top bends, from its start, and heights.

    A corner is as high as the higher of its two walls.
    """
    lengths = np.linalg.norm(np.roll(floor, -1, axis=0) - floor, axis=1)
    crowns = []
    for edge, length in enumerate(lengths.tolist()):
        own = [piece for piece in pieces if piece.edge == edge]
        bends = [0.0]
        for x in sorted(float(x) for piece in own for x in piece.x):
            if bends[-1] + _SAME_PLACE_M < x < length - _SAME_PLACE_M:
                bends.append(x)
        crowns.append(np.array([[x, _height(own, x)] for x in (*bends, length)]))
    for before, after in zip(crowns, crowns[1:] + crowns[:1], strict=True):
        before[-1, 1] = after[0, 1] = np.fmax(before[-1, 1], after[0, 1])
    found = []
    for crown in crowns:
        crown[[0, -1], 1] = np.nan_to_num(crown[[0, -1], 1], nan=level)
        rows = crown[np.isfinite(crown[:, 1])]
        z = np.maximum(rows[:, 1], _LOWEST_M)
        rows[:, 1] = np.where(np.abs(z - level) < _SAME_HEIGHT_M, level, z)
        found.append(_without_straight(rows))
    return found


def _height(own: Sequence[_Piece], x: float) -> float:
    """Of the highest piece at a place of an edge; not a number where there is none near."""
    off = np.array([max(piece.x[0] - x, x - piece.x[1], 0.0) for piece in own])
    if not len(off) or off.min() > MAX_GAP_M:
        return np.nan
    near = off <= max(float(off.min()), _SAME_PLACE_M)
    return max(
        float(np.interp(x, p.x, p.z)) for p, is_near in zip(own, near, strict=True) if is_near
    )


def _without_straight(crown: Array) -> Array:
    kept = [crown[0]]
    for row, following in pairwise(crown[1:]):
        x, z = np.array([kept[-1], following]).T
        if abs(float(np.interp(row[0], x, z)) - row[1]) > 0.1 * _SAME_HEIGHT_M:
            kept.append(row)
    return np.array([*kept, crown[-1]])


def _around(floor: Array, crowns: Sequence[Array]) -> Array:
    """(M, 3) the line of the tops of all edges."""
    parts = []
    for a, b, crown in zip(floor, np.roll(floor, -1, axis=0), crowns, strict=True):
        share = crown[:-1, :1] / crown[-1, 0]
        parts.append(np.column_stack([a + share * (b - a), crown[:-1, 1]]))
    return np.concatenate(parts)


def _tell_line(pieces: Sequence[_Piece], crowns: Sequence[Array], notes: list[str]) -> None:
    """Say that the ceiling slopes, and which walls are built higher than they were captured."""
    low, high = np.concatenate(crowns)[:, 1].min(), np.concatenate(crowns)[:, 1].max()
    raised: dict[str, list[str]] = defaultdict(list)
    for name in dict.fromkeys(piece.wall for piece in pieces):
        own = [piece for piece in pieces if piece.wall == name]
        if any((np.interp(p.x, *crowns[p.edge].T) - p.z).max() > _SAME_HEIGHT_M for p in own):
            raised[f"{max(float(piece.z.max()) for piece in own):.2f} m high"].append(name)
    notes.append(
        f"the ceiling follows the tops of the walls, from {low:.2f} m to {high:.2f} m "
        "(`height` makes it level)"
        + (f", and lower walls rise to it beside higher ones: {_listed(raised)}" if raised else "")
    )


def _tell_level(tops: Sequence[tuple[str, Array]], height: float, notes: list[str]) -> None:
    """Say which walls of the outline are built to another height or shape than they have."""
    others: dict[str, list[str]] = defaultdict(list)
    for name, top in tops:
        highest = float(top[:, 2].max())
        if _is_sloped(top):
            others[f"sloped, up to {highest:.2f} m"].append(name)
        elif abs(highest - height) > _SAME_HEIGHT_M:
            others[f"{highest:.2f} m high"].append(name)
    if others:
        notes.append(
            f"the ceiling is level at {height:.2f} m (`height` changes it), and all walls of"
            f" the outline are built up to it as rectangles: {_listed(others)}"
        )


def _listed(others: Mapping[str, Sequence[str]]) -> str:
    return "; ".join(
        f"{len(ids)} {'walls are' if len(ids) > 1 else 'wall is'} {what}"
        f" ({listed(ids, _MOST_NAMED)})"
        for what, ids in sorted(others.items())
    )
