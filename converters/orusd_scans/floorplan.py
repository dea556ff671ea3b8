"""The floor of a capture: from its own polygon, or from the bases of its walls."""

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.curves import signed_area
from openrooms_usd.geometry.polygons import CLEARANCE, counter_clockwise, defect

Array = NDArray[np.float64]

# Walls whose ends are both this near to another wall's ends are seen twice, metres.
TWIN = 0.15
# Gaps between walls up to this length are closed without a word, metres.
GAP = 0.3


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
    notes.append("the captured floor crossed itself: its largest simple part was taken")
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
    gaps = np.linalg.norm(np.roll(chain[:, 0], -1, axis=0) - chain[:, 1], axis=1)
    corners = np.array(
        [_corner(a, b) for a, b in zip(chain, np.roll(chain, -1, axis=0), strict=True)]
    )
    hull = shapely.get_coordinates(shapely.MultiPoint(walls.reshape(-1, 2)).convex_hull)[:-1]
    if len(hull) < 3:
        return None
    if defect(corners) is not None or abs(signed_area(corners)) < 0.5 * abs(signed_area(hull)):
        notes.append("the walls do not close: their convex hull was taken as the floor")
        return hull
    if gaps.max() > GAP:
        notes.append(f"the walls leave a gap of {gaps.max():.2f} m, which was closed")
    return corners


def _without_twins(segments: Array) -> Array:
    """Walls by descending length, those left out that a longer one repeats."""
    order = np.argsort(-np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1), kind="stable")
    kept: list[Array] = []
    for wall in segments[order]:
        if not any(_apart(wall, other) < TWIN for other in kept):
            kept.append(wall)
    return np.array(kept).reshape(-1, 2, 2)


def _apart(a: Array, b: Array) -> float:
    """The greater distance between the ends of two segments, whichever way round they fit."""
    return min(float(np.linalg.norm(a - c, axis=1).max()) for c in (b, b[::-1]))


def _linked(walls: Array) -> Array:
    """Walls in a round: each followed by the one with the nearest free end, until it closes."""
    chain, rest = [walls[0]], list(walls[1:])
    while rest:
        end = chain[-1][1]
        ends = np.array([[np.linalg.norm(p - end) for p in wall] for wall in rest])
        best, which = np.unravel_index(int(np.argmin(ends)), ends.shape)
        home = float(np.linalg.norm(chain[0][0] - end))
        if len(chain) > 2 and home <= min(float(ends.min()), GAP):
            break  # closed: what remains stands inside the room
        wall = rest.pop(int(best))
        chain.append(wall if which == 0 else wall[::-1])
    return np.array(chain)


def _corner(a: Array, b: Array) -> Array:
    """Where wall a ends and wall b begins: their lines' crossing if it is near, else the middle."""
    middle = 0.5 * (a[1] + b[0])
    along_a, along_b = a[1] - a[0], b[1] - b[0]
    cross = along_a[0] * along_b[1] - along_a[1] * along_b[0]
    if abs(cross) > 0.2 * np.linalg.norm(along_a) * np.linalg.norm(along_b):
        offset = b[0] - a[0]
        s = (offset[0] * along_b[1] - offset[1] * along_b[0]) / cross
        crossing = a[0] + s * along_a
        if np.linalg.norm(crossing - middle) < GAP:
            return np.asarray(crossing)
    return np.asarray(middle)


def heading(corners: Array) -> float:
    """The angle that turns the longest edge along X or Y by the least rotation, radians."""
    along = np.roll(corners, -1, axis=0) - corners
    longest = along[int(np.argmax(np.linalg.norm(along, axis=1)))]
    angle = np.arctan2(longest[1], longest[0])
    return -float(angle - 0.5 * np.pi * np.round(angle / (0.5 * np.pi)))
