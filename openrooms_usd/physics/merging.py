"""Fewer convex pieces: neighbours become one where their common hull is still good enough."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.physics.hulls import quick_hull

Pair = tuple[int, int]


# What a hull may add to the volumes of two and count as adding nothing, as a share of its own.
NO_VOLUME_SHARE: Final = 1e-6


@dataclass(frozen=True, eq=False)
class Cluster:
    """What one hull stands for.

    Attributes:
        hull: The hull, metres.
        volume: Of the hull, cubic metres.
        members: The rows of the pieces.
        off: How far it seems to be off, metres; infinite if not measured yet.
    """

    hull: TriangleMesh
    volume: float
    members: tuple[int, ...]
    off: float


def merged(
    clusters: Sequence[Cluster],
    tolerance: float,
    may: Callable[[Array], Mask],
    judge: Callable[[Sequence[Array]], Sequence[float]],
) -> list[Cluster]:
    """Merge in rounds, the pairs first that add the least volume, until none is good enough.

    Args:
        clusters: What there is.
        tolerance: How far they may be off; only what is closer than twice as much along every
            axis is tried, metres.
        may: A quick look: which points a hull may hold.
        judge: How far sets of (M, 3, 3) triangles are off, metres.

    Returns:
        What is left, in the order of the first members.
    """
    alive = dict(enumerate(clusters))
    number = len(alive)
    fresh = set(alive)
    while fresh:
        pairs = _possible(alive, _pairs(alive, fresh, 2.0 * tolerance), may)
        common = {pair: _common(alive[pair[0]], alive[pair[1]]) for pair in pairs}
        asked = [pair for pair in pairs if common[pair].off == np.inf]
        judged = [_judged(alive[a], alive[b], common[a, b].hull) for a, b in asked]
        offs = judge([triangles for triangles, _ in judged]) if asked else []
        for pair, off, (_, known) in zip(asked, offs, judged, strict=True):
            common[pair] = replace(common[pair], off=max(off, known))
        good = [pair for pair in pairs if common[pair].off <= tolerance]
        good.sort(key=lambda pair: (_added(alive, pair, common[pair]), pair))
        fresh, gone = set(), set()
        for a, b in good:
            if a in gone or b in gone:
                continue
            gone |= {a, b}
            alive[number] = common[a, b]
            fresh.add(number)
            number += 1
        alive = {k: cluster for k, cluster in alive.items() if k not in gone}
    return sorted(alive.values(), key=lambda cluster: cluster.members[0])


def _pairs(alive: dict[int, Cluster], fresh: set[int], near: float) -> list[Pair]:
    """Pairs with at least one that is new, whose boxes nearly touch."""
    keys = sorted(alive)
    low = np.array([alive[k].hull.points.min(axis=0) for k in keys]) - near / 2.0
    high = np.array([alive[k].hull.points.max(axis=0) for k in keys]) + near / 2.0
    found = []
    for row, key in enumerate(keys):
        if key in fresh:
            touch = ((low <= high[row]) & (high >= low[row])).all(axis=1)
            found += [(min(key, keys[o]), max(key, keys[o])) for o in np.flatnonzero(touch)]
    return sorted({pair for pair in found if pair[0] != pair[1]})


def _possible(
    alive: dict[int, Cluster], pairs: list[Pair], may: Callable[[Array], Mask]
) -> list[Pair]:
    """Pairs for which the middles between the outermost corners of both may be filled."""
    if not pairs:
        return []
    outermost = {k: _outermost(alive[k].hull.points) for pair in pairs for k in pair}
    middles = [_middles(outermost[a], outermost[b]) for a, b in pairs]
    sizes = [len(m) for m in middles]
    fine = may(np.concatenate(middles))
    starts = (np.cumsum(sizes) - sizes).astype(np.int64)
    whole = np.minimum.reduceat(fine, starts)
    return [pair for pair, good in zip(pairs, whole, strict=True) if good]


def _outermost(points: Array) -> Array:
    rows = np.concatenate([points.argmax(axis=0), points.argmin(axis=0)])
    return np.asarray(points[np.unique(rows)])


def _middles(a: Array, b: Array) -> Array:
    return np.asarray(((a[:, None] + b[None]) / 2.0).reshape(-1, 3))


def _common(a: Cluster, b: Cluster) -> Cluster:
    """The common hull of two, `off` infinite unless they are all that it fills."""
    hull, volume = quick_hull(np.concatenate([a.hull.points, b.hull.points]))
    nothing = NO_VOLUME_SHARE * volume
    apart = _shared_box(a.hull.points, b.hull.points) <= nothing
    filled = a.volume + b.volume if apart else max(a.volume, b.volume)
    solid = volume > 0.0 and volume - filled <= nothing
    off = max(a.off, b.off) if solid else np.inf
    return Cluster(hull, volume, tuple(sorted(a.members + b.members)), off)


def _judged(a: Cluster, b: Cluster, common: TriangleMesh) -> tuple[Array, float]:
    """The triangles of a common hull that are new, and how far the others are off.

    A triangle between corners of one hull lies in that hull and on the common one, hence on both
    surfaces.
    """
    known = np.zeros(len(common.triangles), dtype=np.bool_)
    off, keys = 0.0, _keys(common.points)
    for old in (a, b):
        if old.off < np.inf:
            corners = set(_keys(old.hull.points))
            among = np.array([key in corners for key in keys])
            known |= among[common.triangles].all(axis=1)
            off = max(off, old.off)
    return common.points[common.triangles[~known]], off


def _keys(points: Array) -> list[bytes]:
    """The bits of each point."""
    rows = np.ascontiguousarray(points)
    return rows.view(f"V{rows.shape[1] * rows.itemsize}").ravel().tolist()


def _shared_box(a: Array, b: Array) -> float:
    """The volume that the bounding boxes of two sets share."""
    low, high = np.maximum(a.min(axis=0), b.min(axis=0)), np.minimum(a.max(axis=0), b.max(axis=0))
    return float(np.prod(np.clip(high - low, 0.0, None)))


def _added(alive: dict[int, Cluster], pair: Pair, common: Cluster) -> float:
    """What a common hull has more than both, cubic metres."""
    return common.volume - alive[pair[0]].volume - alive[pair[1]].volume
