"""Convex pieces of an upright wall with rectangular holes, and of slabs, exactly."""

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.physics.hulls import volume

if TYPE_CHECKING:
    from shapely import Geometry


# Corners that lie nearer to each other are on one line, metres.
_SAME_LINE_M: Final = 1e-6
# The pieces are right when their volumes add up to the wall's, but for this part of it.
_MISSING_VOLUME_SHARE: Final = 1e-3


def panel_pieces(mesh: TriangleMesh) -> list[TriangleMesh]:
    """Cut a wall apart into the convex pieces that are left around its holes.

    Args:
        mesh: A closed solid: an upright prism over a convex outline, such as a wall with mitred
            ends, with rectangular holes through it; Z up, metres. Its top may slope.

    Returns:
        Its pieces from one end to the other; none if it is not such a solid.
    """
    frame = _frame(mesh)
    if frame is None:
        return []
    local = mesh.points @ frame
    outline = _convex(local[:, :2])
    face = _face(local, mesh)
    if not _is_panel(face):
        return []
    pieces = [_prism(outline, *part) for part in _trapezoids(face)]
    solids = [_turned(piece, frame) for piece in pieces if piece is not None]
    whole = volume(mesh)
    return solids if abs(sum(map(volume, solids)) - whole) <= _MISSING_VOLUME_SHARE * whole else []


def _frame(mesh: TriangleMesh) -> Array | None:
    """(3, 3) columns: along the wall, off its largest upright face, up."""
    a, b, c = np.moveaxis(mesh.points[mesh.triangles], 1, 0)
    doubled = np.cross(b - a, c - a)
    doubled = doubled[np.abs(doubled[:, 2]) <= _SAME_LINE_M * np.linalg.norm(doubled, axis=1)]
    if not len(doubled):
        return None
    units = unit(doubled)
    same = np.linalg.norm(units[:, None] - units, axis=2) < _SAME_LINE_M
    areas = same @ np.linalg.norm(doubled, axis=1)
    normal = units[int(np.round(areas, 9).argmax())]
    return np.column_stack([np.cross(normal, [0.0, 0.0, 1.0]), normal, [0.0, 0.0, 1.0]])


def _face(local: Array, mesh: TriangleMesh) -> "Geometry":
    """The wall as it is seen from its largest face."""
    import shapely

    a, b, c = np.moveaxis(local[mesh.triangles], 1, 0)
    normals = unit(np.cross(b - a, c - a))
    facing = normals[:, 1] > 1.0 - _SAME_LINE_M
    rings = np.round(local[mesh.triangles[facing]][:, :, [0, 2]], 6)
    return shapely.union_all(shapely.polygons(rings), grid_size=_SAME_LINE_M)


def _is_panel(face: "Geometry") -> bool:
    """Whether all edges run level or upright, but for those above its foot."""
    import shapely

    foot = shapely.bounds(face)[1]
    for ring in map(shapely.get_coordinates, shapely.get_rings(face)):
        slants = np.abs(np.diff(ring, axis=0)).min(axis=1) > 2 * _SAME_LINE_M
        if (np.minimum(ring[:-1, 1], ring[1:, 1])[slants] <= foot + _SAME_LINE_M).any():
            return False
    return True


def _convex(points: Array) -> Array:
    """(K, 2) corners of a convex hull in the plane, counter-clockwise."""
    import shapely

    hull = shapely.convex_hull(shapely.multipoints(points))
    ring = np.asarray(shapely.get_coordinates(shapely.normalize(hull)))[:-1]
    x, y = ring.T
    clockwise = float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) < 0.0
    return ring[::-1] if clockwise else ring


# Heights at the left and at the right end of a piece.
_Ends: TypeAlias = tuple[float, float]


def _trapezoids(face: "Geometry") -> Iterator[tuple[_Ends, _Ends, _Ends, _Ends]]:
    """What is left between holes: its ends, where it is cut, its bottoms and tops.

    At the ends of the face nothing is cut: there the outline ends.
    """
    import shapely

    low, _, high, _ = shapely.bounds(face).tolist()
    corners = np.unique(np.round(shapely.get_coordinates(face)[:, 0], 6))
    spans: list[tuple[float, float, tuple[tuple[_Ends, _Ends], ...]]] = []
    for left, right in pairwise(corners.tolist()):
        if right - left < 2 * _SAME_LINE_M:
            continue
        upright = tuple(_uprights(face, left, right))
        if spans and spans[-1][2] == upright and all(a == b for pair in upright for a, b in pair):
            spans[-1] = (spans[-1][0], right, upright)
        else:
            spans.append((left, right, upright))
    for left, right, upright in spans:
        cuts = (-np.inf if left <= low else left, np.inf if right >= high else right)
        yield from (((left, right), cuts, *levels) for levels in upright)


def _uprights(face: "Geometry", left: float, right: float) -> Iterator[tuple[_Ends, _Ends]]:
    """Bottoms and tops of a face's parts between two uprights, from below."""
    import shapely

    _, bottom, _, top = shapely.bounds(face).tolist()
    found = []
    for share in (0.5, 0.25, 0.75):
        x = left + share * (right - left)
        crossed = shapely.intersection(face, shapely.linestrings([[x, bottom], [x, top]]))
        bounds = shapely.bounds(shapely.get_parts(crossed)).tolist()
        found.append(sorted((p[1], p[3]) for p in bounds if p[3] - p[1] > _SAME_LINE_M))
    for middle, *beside in zip(*found, strict=False):
        levels = []
        for at, a, b in zip(middle, *beside, strict=True):
            rise = b - a if abs(b - a) > _SAME_LINE_M else 0.0
            levels.append((at - rise, at + rise))
        yield levels[0], levels[1]


def slab_pieces(mesh: TriangleMesh) -> list[TriangleMesh]:
    """The convex pieces of a slab with a level top, exactly.

    The hull of one that is level below, too: a prism over the hull of its plan. Of another one the
    prism over each of its lower triangles.
    """
    levels = mesh.points[:, 2]
    a, b, c = np.moveaxis(mesh.points[mesh.triangles], 1, 0)
    lower = np.cross(b - a, c - a)[:, 2] < -(_SAME_LINE_M**2)
    rings = mesh.points[mesh.triangles[lower]][:, ::-1]
    low, high = float(levels.min()), float(levels.max())
    if rings[:, :, 2].max(initial=low) < low + _SAME_LINE_M:
        return [_solid(_convex(mesh.points[:, :2]), low, high)]
    return [_solid(ring[:, :2], ring[:, 2], high) for ring in rings]


def _prism(
    outline: Array, ends: _Ends, cuts: _Ends, bottoms: _Ends, tops: _Ends
) -> TriangleMesh | None:
    """The outline between two uprights and two heights; None where nothing is left of it."""
    kept = _distinct(_cut(_cut(outline, cuts[0], 1.0), cuts[1], -1.0))
    if len(kept) < 3:
        return None
    bottom, top = (np.interp(kept[:, 0], ends, heights) for heights in (bottoms, tops))
    return _solid(kept, bottom, top)


def _solid(ring: Array, bottom: float | Array, top: float | Array) -> TriangleMesh:
    """A prism over a convex, counter-clockwise (K, 2) ring; its ends may slope."""
    n = len(ring)
    heights = np.concatenate([np.broadcast_to(z, n) for z in (bottom, top)])
    points = np.column_stack([np.tile(ring, (2, 1)), heights])
    i = np.arange(n)
    j = (i + 1) % n
    fan = np.stack([np.zeros(n - 2, np.int64), i[1:-1], i[2:]], axis=1)
    sides = [np.stack([i, j, j + n], axis=1), np.stack([i, j + n, i + n], axis=1)]
    rows = np.concatenate([fan[:, ::-1], fan + n, *sides]).astype(np.int32)
    return TriangleMesh(points, rows, np.arange(len(rows), dtype=np.int32))


def _turned(mesh: TriangleMesh, frame: Array) -> TriangleMesh:
    return TriangleMesh(mesh.points @ frame.T, mesh.triangles, mesh.faces)


def _distinct(ring: Array) -> Array:
    """A ring without corners that coincide: a cut beside a corner makes another one there."""
    gaps = np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1)
    return np.asarray(ring[gaps > _SAME_LINE_M])


def _cut(ring: Array, at: float, side: float) -> Array:
    """The part of a convex ring where ``side * (x - at)`` is not negative."""
    if not np.isfinite(at):
        return ring
    kept: list[Array] = []
    for here, following in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        a, b = side * (here[0] - at), side * (following[0] - at)
        if a >= 0.0:
            kept.append(here)
        if a * b < 0.0:
            kept.append(here + (following - here) * a / (a - b))
    return np.array(kept).reshape(-1, 2)
