"""The floor of a capture: from its own polygon, or from the bases of its walls."""

from collections.abc import Sequence

import numpy as np

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.geometry.curves import signed_area
from openrooms_usd.geometry.polygons import CLEARANCE, counter_clockwise, defect

# Walls with both ends this near to another wall's ends are duplicates, metres.
TWIN_DISTANCE_M = 0.15
# Gaps between walls up to this length are closed without a note, metres.
MAX_GAP_M = 0.3
# A wall's end this near to the line across the gap beside it is not a corner, metres.
_STRAIGHT_M = 0.03
# Of more pieces the nearest ends are joined without regard to others.
_MOST_RUNS = 24


def tidied(corners: Array, notes: list[str]) -> Array | None:
    """A simple counter-clockwise polygon from captured corners.

    Args:
        corners: (N, 2) as captured, metres.
        notes: Receives a sentence when something was changed.

    Returns:
        (M, 2) the polygon, or None when nothing of it has an area.
    """
    import shapely

    steps = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
    distinct = corners[steps > 5.0 * CLEARANCE]
    if len(distinct) >= 3 and defect(distinct) is None:
        return counter_clockwise(distinct)[0]
    if len(distinct) < 3:
        return None
    # Grown and shrunk: crossings, slits and spikes vanish, corners stay.
    smooth = (
        shapely.make_valid(shapely.Polygon(distinct)).buffer(-0.01).buffer(0.01, join_style="mitre")
    )
    parts = [part for part in shapely.get_parts(smooth) if part.geom_type == "Polygon"]
    largest = max(parts, key=lambda part: part.area, default=None)
    if largest is None:
        return None
    ring = shapely.get_coordinates(shapely.get_exterior_ring(largest).simplify(CLEARANCE))[:-1]
    if defect(ring) is not None:
        return None
    notes.append("the captured floor crossed itself: its largest simple part is used")
    return counter_clockwise(ring)[0]


def chained(segments: Array, notes: list[str]) -> Array | None:
    """The polygon that walls enclose: their bases linked end to end.

    Args:
        segments: (W, 2, 2) both ends of each wall's base, metres, in any order and direction.
        notes: Receives a sentence for every guess.

    Returns:
        (N, 2) corners, or None when there are less than three walls.
    """
    import shapely

    walls = _without_twins(segments)
    if len(walls) < 3:
        return None
    chain = _linked(walls)
    if _gaps(chain).max() > MAX_GAP_M and len(runs := _runs(walls)) <= _MOST_RUNS:
        chain = _bridged(runs)
    corners = _corners(chain)
    hull = shapely.get_coordinates(shapely.MultiPoint(walls.reshape(-1, 2)).convex_hull)[:-1]
    if len(hull) < 3:
        return None
    if defect(corners) is not None or abs(signed_area(corners)) < 0.5 * abs(signed_area(hull)):
        notes.append("the walls do not close: their convex hull is used as the floor")
        return hull
    if wide := [f"{gap:.2f} m" for gap in _gaps(chain) if gap > MAX_GAP_M]:
        gaps = "a gap of" if len(wide) == 1 else "gaps of"
        closed = "was" if len(wide) == 1 else "were"
        notes.append(f"the walls leave {gaps} {', '.join(wide)}, which {closed} closed straight")
    return corners


def _gaps(chain: Array) -> Array:
    """(N,) from the end of each wall of a chain to the beginning of the next, metres."""
    return np.asarray(np.linalg.norm(np.roll(chain[:, 0], -1, axis=0) - chain[:, 1], axis=1))


def _without_twins(segments: Array) -> Array:
    """Walls by descending length, without duplicates of longer ones."""
    order = np.argsort(-np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1), kind="stable")
    kept = np.empty_like(segments)
    count = 0
    for wall in segments[order]:
        if not (_apart(wall, kept[:count]) < TWIN_DISTANCE_M).any():
            kept[count] = wall
            count += 1
    return kept[:count]


def _apart(wall: Array, others: Array) -> Array:
    """(N,) the greater distance between the ends of segments, whichever way round they fit."""
    ways = [np.linalg.norm(others - way, axis=2).max(axis=1) for way in (wall, wall[::-1])]
    return np.asarray(np.minimum(*ways))


def _linked(walls: Array) -> Array:
    """Walls chained to a ring: each followed by the one with the nearest free end."""
    chain, free = [walls[0]], np.ones(len(walls), dtype=bool)
    free[0] = False
    while free.any():
        end = chain[-1][1]
        ends = np.where(free[:, None], np.linalg.norm(walls - end, axis=2), np.inf)
        best, which = np.unravel_index(int(np.argmin(ends)), ends.shape)
        home = float(np.linalg.norm(chain[0][0] - end))
        if len(chain) > 2 and home <= min(float(ends.min()), MAX_GAP_M):
            break  # closed: what remains stands inside the room
        free[best] = False
        chain.append(walls[best] if which == 0 else walls[best][::-1])
    return np.array(chain)


def _bridged(runs: Sequence[Array]) -> Array:
    """A ring of runs of walls that leave gaps: all are on it or in it, and the gaps are short.

    The longest is closed; while others are outside, the one that lengthens the gaps least is put
    into one of them.
    """
    import shapely

    ring, *rest = runs
    while rest:
        corners = _corners(ring)
        floor = shapely.Polygon(corners) if len(corners) > 2 else shapely.Polygon()
        around = floor.buffer(MAX_GAP_M)
        others = [r for r in rest if not around.contains(shapely.MultiPoint(r.reshape(-1, 2)))]
        if not others and floor.is_valid and floor.area > 0.0:
            break
        tries = [
            (*_inserted(ring, run[::way, ::way], gap), i)
            for gap in map(int, np.flatnonzero(_gaps(ring) >= min(MAX_GAP_M, _gaps(ring).max())))
            for i, run in enumerate(others or rest)
            for way in (1, -1)
        ]
        _, ring, taken = min(tries, key=lambda one: one[0])
        rest = [run for run in rest if run is not (others or rest)[taken]]
    return ring


def _inserted(ring: Array, run: Array, gap: int) -> tuple[float, Array]:
    """A ring with a run in one of its gaps, and by how much its gaps become longer."""
    rolled = np.roll(ring, -gap - 1, axis=0)
    longer = np.concatenate([rolled, run])
    return float(_gaps(longer).sum() - _gaps(ring).sum()), longer


def _runs(walls: Array) -> list[Array]:
    """Walls that meet, end to end, in chains that do not close; the longest first."""
    from scipy.spatial import KDTree

    ends = walls.reshape(-1, 2)  # rows 2 i and 2 i + 1 are of wall i
    pairs = KDTree(ends).query_pairs(MAX_GAP_M, output_type="ndarray")
    order = np.argsort(np.linalg.norm(ends[pairs[:, 0]] - ends[pairs[:, 1]], axis=1), kind="stable")
    run, partner = np.arange(len(walls)), dict[int, int]()
    for a, b in pairs[order].tolist():
        if a not in partner and b not in partner and run[a // 2] != run[b // 2]:
            partner |= {a: b, b: a}
            run[run == run[b // 2]] = run[a // 2]
    found, seen = list[Array](), set[int]()
    for start in range(len(ends)):
        if start in partner or start // 2 in seen:
            continue
        chain, end = list[Array](), start
        while True:
            wall = walls[end // 2]
            chain.append(wall if end % 2 == 0 else wall[::-1])
            seen.add(end // 2)
            if (end ^ 1) not in partner:
                break
            end = partner[end ^ 1]
        found.append(np.array(chain))
    lengths = [np.linalg.norm(run[:, 1] - run[:, 0], axis=1).sum() for run in found]
    return [found[i] for i in np.argsort(lengths, kind="stable")[::-1]]


def _corners(chain: Array) -> Array:
    """(N, 2) the corners of a chain of walls that is closed; a wide gap has one at each end."""
    corners, ends_gap = list[Array](), list[bool]()
    for a, b in zip(chain, np.roll(chain, -1, axis=0), strict=True):
        corner = _corner(a, b)
        met = [a[1], b[0]] if corner is None else [corner]
        corners += met
        ends_gap += [corner is None] * len(met)
    # The end of a wall that goes on straight over the gap is not a corner.
    ring = np.array(corners)
    before, after = np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0)
    along, aside = after - before, ring - before
    cross = along[:, 0] * aside[:, 1] - along[:, 1] * aside[:, 0]
    off = np.abs(cross) / np.maximum(np.linalg.norm(along, axis=1), CLEARANCE)
    between = (along * aside).sum(axis=1) > 0.0
    return np.asarray(ring[~(np.array(ends_gap) & (off < _STRAIGHT_M) & between)])


def _corner(a: Array, b: Array) -> Array | None:
    """The corner of walls a and b: where their lines meet if that is near, else between their ends.

    None where these are far apart.
    """
    middle = 0.5 * (a[1] + b[0])
    along_a, along_b = a[1] - a[0], b[1] - b[0]
    cross = along_a[0] * along_b[1] - along_a[1] * along_b[0]
    if abs(cross) > 0.2 * np.linalg.norm(along_a) * np.linalg.norm(along_b):
        offset = b[0] - a[0]
        s = (offset[0] * along_b[1] - offset[1] * along_b[0]) / cross
        crossing = a[0] + s * along_a
        if np.linalg.norm(crossing - middle) < MAX_GAP_M:
            return np.asarray(crossing)
    return None if np.linalg.norm(b[0] - a[1]) > MAX_GAP_M else np.asarray(middle)


def bent(corners: Array, arcs: Sequence[Array]) -> Array:
    """A floor whose straight edges follow the arcs of curved walls.

    Args:
        corners: (N, 2) corners in order, metres; a corner on an arc is taken for a part of it.
        arcs: Each (M, 2) from one end of a curved wall to the other.

    Returns:
        (K, 2) corners in the same order; an arc that joins no two neighbours is left out.
    """
    for arc in arcs:
        corners = _bent(corners, arc)
    return corners


def _bent(corners: Array, arc: Array) -> Array:
    import shapely

    ends = [np.linalg.norm(corners - end, axis=1) for end in (arc[0], arc[-1])]
    nearest = [int(np.argmin(distance)) for distance in ends]
    if max(float(distance.min()) for distance in ends) > MAX_GAP_M or nearest[0] == nearest[1]:
        return corners
    off = np.asarray(shapely.distance(shapely.LineString(arc), shapely.points(corners)))
    keep: Mask = off > TWIN_DISTANCE_M
    keep[nearest] = True
    rest = corners[keep]
    first, last = (int(keep[:i].sum()) for i in nearest)
    if (first + 1) % len(rest) == last:
        return np.insert(rest, first + 1, arc[1:-1], axis=0)
    if (last + 1) % len(rest) == first:
        return np.insert(rest, last + 1, arc[-2:0:-1], axis=0)
    return corners


def from_lower_left(corners: Array) -> Array:
    """A floor whose first corner is the one nearest to the lower left.

    So the walls have the same numbers in every export of a room.
    """
    rounded = np.round(corners, 3)
    first = np.lexsort((rounded[:, 0], np.round(rounded.sum(axis=1), 2)))[0]
    return np.roll(corners, -int(first), axis=0)


def heading(corners: Array) -> float:
    """The angle that turns the longest edge along X or Y by the least rotation, radians."""
    along = np.roll(corners, -1, axis=0) - corners
    longest = along[int(np.argmax(np.linalg.norm(along, axis=1)))]
    angle = np.arctan2(longest[1], longest[0])
    return -float(angle - 0.5 * np.pi * np.round(angle / (0.5 * np.pi)))
