"""Simple polygons in the plan: what is wrong with one, its orientation, growth and triangles."""

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.geometry.curves import signed_area

# A corner that comes nearer than this to an edge or to another corner is a mistake of drawing, and
# would leave no room for a wall.
CLEARANCE = 1e-3


def defect(corners: ArrayLike) -> str | None:
    """Say why corners do not bound a simple polygon.

    Args:
        corners: (N, 2) metres, in order, either way round, the first not repeated.

    Returns:
        What is wrong, to follow "the polygon", or None when nothing is.
    """
    points = np.asarray(corners, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 3:
        return f"has {len(points)} corners, at least 3 are needed"
    wild = np.asarray(~np.isfinite(points).all(axis=1))
    if wild.any():
        return f"has a corner {_first(wild)} that is not finite"
    steps = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    twins = np.asarray(steps < CLEARANCE)
    if twins.any():
        twin = _first(twins)
        return f"has corners {twin} and {(twin + 1) % len(points)} at the same place"
    if _is_clear(points):
        return None
    import shapely  # a tenth of a second, which sound polygons are spared

    polygon = shapely.Polygon(points)
    if not polygon.is_valid:
        return f"crosses or touches itself near {_place(shapely.is_valid_reason(polygon))}"
    if polygon.minimum_clearance < CLEARANCE:
        x, y = shapely.get_coordinates(shapely.minimum_clearance_line(polygon))[0]
        return f"comes nearer than {1000 * CLEARANCE:g} mm to itself near ({x:.3f}, {y:.3f})"
    return None


def _is_clear(points: Array) -> bool:
    """Whether no edge meets another, and no corner comes near an edge that does not end there."""
    along = np.roll(points, -1, axis=0) - points
    # (N, N, 2) from the beginning of each edge to each corner.
    to = points[None] - points[:, None]
    side = along[:, None, 0] * to[..., 1] - along[:, None, 1] * to[..., 0]
    parted = side * np.roll(side, -1, axis=1) <= 0.0
    share = np.clip((to * along[:, None]).sum(axis=2) / (along**2).sum(axis=1)[:, None], 0.0, 1.0)
    far = np.linalg.norm(to - share[..., None] * along[:, None], axis=2)
    one = np.eye(len(points), dtype=bool)
    beside = one | np.roll(one, 1, axis=1) | np.roll(one, -1, axis=1)
    met = (parted & parted.T & ~beside).any()
    return not met and bool((far[~(one | np.roll(one, 1, axis=1))] >= CLEARANCE).all())


def _first(mask: Mask) -> int:
    return int(np.argmax(mask))


def _place(reason: str) -> str:
    """The place in GEOS' reason, such as ``Self-intersection[1 1]``."""
    numbers = reason.partition("[")[2].rstrip("]").split()
    return f"({', '.join(f'{float(n):.3f}' for n in numbers)})" if numbers else reason


def counter_clockwise(corners: ArrayLike) -> tuple[Array, Ints]:
    """Turn a polygon counter-clockwise and remember how its edges were numbered.

    Args:
        corners: (N, 2) in order, either way round.

    Returns:
        (N, 2) the corners counter-clockwise, and (N,) for each edge of these, which runs from its
        corner to the next, its number in the given order.
    """
    points = np.asarray(corners, dtype=np.float64)
    numbers = np.arange(len(points))
    if signed_area(points) >= 0.0:
        return points, numbers
    return points[::-1].copy(), np.roll(numbers[::-1], -1)


def turns(corners: Array) -> Array:
    """(N,) angle by which a polygon turns left at each corner, radians in (-pi, pi)."""
    onward = np.roll(corners, -1, axis=0) - corners
    before = np.roll(onward, 1, axis=0)
    cross = before[:, 0] * onward[:, 1] - before[:, 1] * onward[:, 0]
    return np.asarray(np.arctan2(cross, np.einsum("ij,ij->i", before, onward)))


def grown(corners: Array, distance: float, mitre_limit: float) -> Array:
    """The outline of a polygon grown outwards, with mitred corners; gaps that close are filled.

    Args:
        corners: (N, 2) a simple polygon, metres.
        distance: How far its edges move, metres.
        mitre_limit: Where a corner would reach further than this times the distance, it is cut.

    Returns:
        (M, 2) counter-clockwise, without collinear corners.
    """
    import shapely

    wide = shapely.Polygon(corners).buffer(distance, join_style="mitre", mitre_limit=mitre_limit)
    outline = shapely.get_exterior_ring(wide).simplify(1e-9)
    ring = shapely.get_coordinates(outline)[:-1]
    return counter_clockwise(ring)[0]


def triangulated(outline: Array, holes: tuple[Array, ...] = ()) -> Array:
    """Cut a polygon with holes into triangles that use all of its corners and no others.

    Constrained Delaunay triangles keep corners that are collinear across holes (such as windows
    with equal sills), which ear clipping drops: neighbouring faces would no longer meet.

    Args:
        outline: (N, 2) simple, either way round.
        holes: Simple polygons inside it that do not touch.

    Returns:
        (M, 3, 2) counter-clockwise triangles, their corners exactly those that were given.
    """
    import shapely

    pieces = shapely.constrained_delaunay_triangles(shapely.Polygon(outline, holes))
    rings = shapely.get_coordinates(pieces).reshape(-1, 4, 2)[:, :3]
    a, b, c = np.moveaxis(rings, 1, 0)
    first, second = b - a, c - a
    clockwise = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0] < 0.0
    return np.where(clockwise[:, None, None], rings[:, ::-1], rings)
