"""Where walls run on without a break: the paths of what is fixed along them."""

from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np

from openrooms_usd.arrays import Array

# A gap belongs to the face that it lies on within this, metres.
_ON_FACE_M: Final = 2e-3
# Pieces that are shorter are left out, and corners where a mitre would reach farther than this
# many depths end a run.
_SHORTEST_M: Final = 0.02
_MITRE_LIMIT: Final = 3.0


class Run(NamedTuple):
    """A path along walls with the floor on its left.

    Attributes:
        path: (N, 2) corners in the plan, metres.
        closed: Whether it goes all the way round.
    """

    path: Array
    closed: bool

    @property
    def length(self) -> float:
        """Metres."""
        ends = np.roll(self.path, -1, axis=0) if self.closed else self.path[1:]
        return float(np.linalg.norm(ends - self.path[: len(ends)], axis=1).sum())


def free_rings(corners: Array, standing: Sequence[Array]) -> list[Array]:
    """The outlines of the floor that walls inside leave free.

    Args:
        corners: (N, 2) the room, counter-clockwise, metres.
        standing: (K, 2) each, what walls that stand free cover.

    Returns:
        Rings with the floor on their left.
    """
    import shapely

    if not standing:
        return [corners]
    # Walls that end at others leave no slits.
    walls = shapely.union_all(
        [shapely.Polygon(ring).buffer(1e-4, join_style="mitre") for ring in standing]
    )
    floor = shapely.orient_polygons(shapely.Polygon(corners).difference(walls))
    rings = shapely.get_rings(shapely.get_parts(floor))
    found = [shapely.get_coordinates(ring.simplify(1e-6))[:-1] for ring in rings]
    return [ring for ring in found if len(ring) >= 3]


def runs(rings: Sequence[Array], gaps: Sequence[tuple[Array, Array]], depth: float) -> list[Run]:
    """The runs along some rings, interrupted by gaps.

    Args:
        rings: (N, 2) each, as `free_rings` gives them.
        gaps: (2,) both ends of each gap, on a face; metres.
        depth: How far what is fixed there stands out: short pieces and sharp corners cannot hold
            its mitres.
    """
    return [run for ring in rings for run in _runs(ring, gaps, depth)]


def _runs(ring: Array, gaps: Sequence[tuple[Array, Array]], depth: float) -> Iterator[Run]:
    count = len(ring)
    edges = [list(_free(ring[i], ring[(i + 1) % count], gaps, depth)) for i in range(count)]
    pieces: list[tuple[Array, Array]] = []
    joined: list[bool] = []  # to the piece before
    for i, edge in enumerate(edges):
        round_corner = bool(edges[i - 1]) and edges[i - 1][-1].to_end and _is_mitred(ring, i, depth)
        pieces += [(piece.start, piece.end) for piece in edge]
        joined += [
            number == 0 and piece.from_start and round_corner for number, piece in enumerate(edge)
        ]
    if pieces and all(joined):
        yield Run(np.array([start for start, _ in pieces]), True)
        return
    # Begin behind a break, so that no run is cut at the ring's first corner.
    first = joined.index(False) if pieces else 0
    path: list[Array] = []
    for k in range(len(pieces)):
        start, end = pieces[(first + k) % len(pieces)]
        if path and not joined[(first + k) % len(pieces)]:
            yield Run(np.array(path), False)
            path = []
        path = [*(path or [start]), end]
    if path:
        yield Run(np.array(path), False)


class _Piece(NamedTuple):
    """What gaps leave of an edge: its ends, and whether these are those of the edge."""

    start: Array
    end: Array
    from_start: bool
    to_end: bool


def _free(
    a: Array, b: Array, gaps: Sequence[tuple[Array, Array]], depth: float
) -> Iterator[_Piece]:
    length = float(np.linalg.norm(b - a))
    along = (b - a) / length
    across = np.array([-along[1], along[0]])
    taken = []
    for one, other in gaps:
        if max(abs((one - a) @ across), abs((other - a) @ across)) <= _ON_FACE_M:
            s, e = sorted((float((one - a) @ along), float((other - a) @ along)))
            if e > 0.0 and s < length:
                taken.append((s, e))
    at = 0.0
    for s, e in [*sorted(taken), (length, length)]:
        if s - at >= max(_SHORTEST_M, 2.0 * depth):
            yield _Piece(a + at * along, a + s * along, at == 0.0, s == length)
        at = max(at, e)


def _is_mitred(ring: Array, i: int, depth: float) -> bool:
    """Whether what is fixed can go round a corner."""
    before, after = ring[i] - ring[i - 1], ring[(i + 1) % len(ring)] - ring[i]
    sides = float(np.linalg.norm(before)), float(np.linalg.norm(after))
    a, b = before / sides[0], after / sides[1]
    half = 0.5 * abs(float(np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b)))
    reach = depth * float(np.tan(min(half, 1.55)))
    return 1.0 / np.cos(min(half, 1.55)) < _MITRE_LIMIT and reach < 0.5 * min(sides)
