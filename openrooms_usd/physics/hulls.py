"""Convex hulls and boxes as closed meshes, also of flat, thin and tiny sets of points."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.topology import distinct_rows
from openrooms_usd.geometry.triangulation import TriangleMesh, bounding_box
from openrooms_usd.geometry.vectors import crossed, doubled_areas, unit

# PhysX cooks at most 255; Bullet and MuJoCo are faster with few.
MOST_VERTICES: Final = 64
# Engines lose contacts of thinner shapes; sheets grow to it on both sides alike, metres.
LEAST_THICKNESS: Final = 1e-3
# A hull that has lost so little is as good as the whole one, as a share of its diagonal.
ENOUGH_SHARE: Final = 1e-3
# Of what is wider, metres, that share would be seen: its highest face keeps its corners.
WIDE_M: Final = 0.5
# Corners closer than this share of the diagonal are one: Qhull would make slivers of them.
WELD_SHARE: Final = 1e-5
# Triangles that are less high, as a share of the diagonal, have no area in float32. Where planes
# cut, corners on one line make them.
FLAT_SHARE: Final = 1e-6
# Corners that are added before the hull is made again, when one is made of few corners.
CORNERS_PER_ROUND: Final = 4


def convex_hull(
    points: ArrayLike, vertices: int = MOST_VERTICES, thickness: float = LEAST_THICKNESS
) -> TriangleMesh:
    """The convex hull as a closed mesh, its corners in lexicographic order.

    A hull of more corners than allowed is built up from the farthest ones until 0.1 % of its
    diagonal is missing or no corner is left to give. It then lies inside the full hull.

    Args:
        points: (N, 3) metres; also in one plane, on one line or all equal.
        vertices: The most corners, at least 8.
        thickness: The least width along each principal axis, metres; thinner ones grow to it
            on both sides alike.

    Raises:
        InputError: There is no point, or a coordinate is not finite.
    """
    given = finite_points(points)
    centre = (given.min(axis=0) + given.max(axis=0)) / 2.0
    local = thickened(given[distinct_rows(given)[0]] - centre, thickness)
    size = float(np.linalg.norm(np.ptp(local, axis=0)))
    distinct, _ = distinct_rows(np.round(local / size / WELD_SHARE))
    corners, triangles = _closed(local[distinct] / size)
    if len(corners) > vertices:
        corners, triangles = _closed(_farthest(corners, vertices, size > WIDE_M))
    while (flat := _between(corners, triangles)).any():
        corners, triangles = _closed(corners[~flat])
    return _ordered(corners * size + centre, triangles)


def quick_hull(points: Array) -> tuple[TriangleMesh, float]:
    """The hull of all points, not in any order, and its volume: to judge and not to keep.

    What may be thinner than `LEAST_THICKNESS` is what `convex_hull` makes of it.
    """
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return convex_hull(points, vertices=len(points) + 8), 0.0
    # A body of thickness t holds no more than t times half of its area.
    if 2.0 * hull.volume < LEAST_THICKNESS * hull.area:
        return convex_hull(points, vertices=len(points) + 8), float(hull.volume)
    rows = np.empty(len(points), dtype=np.int64)
    used = np.unique(hull.simplices)
    rows[used] = np.arange(len(used))
    triangles = _outward(points, hull.simplices.astype(np.int64), points[used].mean(axis=0))
    faces = np.arange(len(triangles), dtype=np.int32)
    return TriangleMesh(points[used], rows[triangles].astype(np.int32), faces), float(hull.volume)


def oriented_box(points: ArrayLike, thickness: float = LEAST_THICKNESS) -> TriangleMesh:
    """The smallest of four boxes: parallel to the axes, turned about one, or principal.

    Args:
        points: (N, 3) metres.
        thickness: The least side, metres.

    Raises:
        InputError: There is no point, or a coordinate is not finite.
    """
    given = finite_points(points)
    frames = [np.eye(3), *_turned(given), _principal(given)]
    boxes = [(_sides(given @ frame, thickness), frame) for frame in frames]
    # The one parallel to the axes wins unless another is clearly smaller.
    volumes = [float(np.prod(high - low)) for (low, high), _ in boxes]
    best = int(np.argmin(np.asarray(volumes) * [1.0, *[1.01] * (len(boxes) - 1)]))
    sides, frame = boxes[best]
    if np.linalg.det(frame) < 0:
        frame = frame * [1.0, 1.0, -1.0]
        sides = _sides(given @ frame, thickness)
    box = bounding_box(TriangleMesh(sides, np.empty((0, 3), np.int32), np.empty(0, np.int32)))
    return _ordered(box.points @ frame.T, box.triangles.astype(np.int64))


def half_spaces(hull: TriangleMesh) -> Array:
    """(F, 4) outward unit normals and offsets; a point is inside where n.x + d <= 0 for all."""
    corners = hull.points[hull.triangles]
    normals = doubled_areas(corners)
    lengths = np.linalg.norm(normals, axis=1)
    sound = lengths > 1e-6 * lengths.max()
    normals = normals[sound] / lengths[sound, None]
    return np.column_stack([normals, -np.einsum("ij,ij->i", normals, corners[sound, 0])])


def outside_others(pieces: Sequence[Array], slack: float) -> list[int]:
    """Which sets of points do not lie inside the hull of one that is kept so far, but for a slack.

    Args:
        pieces: (N, 3) each, metres.
        slack: By how much they may stick out of it, metres.
    """
    low = np.array([points.min(axis=0) for points in pieces])
    high = np.array([points.max(axis=0) for points in pieces])
    kept = np.ones(len(pieces), dtype=np.bool_)
    planes: dict[int, Array] = {}
    for k, points in enumerate(pieces):
        around = (low <= low[k] + slack).all(axis=1) & (high >= high[k] - slack).all(axis=1)
        around[k] = False
        for j in np.flatnonzero(around & kept).tolist():
            if j not in planes:
                planes[j] = half_spaces(quick_hull(pieces[j])[0])
            if (points @ planes[j][:, :3].T + planes[j][:, 3]).max() <= slack:
                kept[k] = False
                break
    return np.flatnonzero(kept).tolist()


def volume(mesh: TriangleMesh) -> float:
    """The volume that a closed mesh encloses, cubic metres."""
    a, b, c = np.moveaxis(mesh.points[mesh.triangles] - mesh.points.mean(axis=0), 1, 0)
    return float(np.einsum("ij,ij->", a, crossed(b, c)) / 6.0)


def finite_points(points: ArrayLike) -> Array:
    """(N, 3) points, refused where there are none or one is not finite.

    Raises:
        InputError: So it is.
    """
    given = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    if not len(given):
        raise InputError("a collision shape needs points")
    if not np.isfinite(given).all():
        raise InputError(
            "a collision shape needs finite coordinates",
            remedy="repair the mesh: a coordinate is not a number or infinite",
        )
    return given


def thickened(points: Array, thickness: float) -> Array:
    """Points, copied to both sides along each principal axis that they are too thin along."""
    frame = _principal(points)
    for axis in frame.T:
        missing = thickness - float(np.ptp(points @ axis))
        if missing > 0.0:
            points = np.concatenate([points - missing / 2 * axis, points + missing / 2 * axis])
    return points


def _principal(points: Array) -> Array:
    """(3, 3) columns: the principal axes, for points that may be many."""
    centred = points - points.mean(axis=0)
    axes: Array = np.linalg.eigh(centred.T @ centred)[1]
    return axes


def _turned(points: Array) -> list[Array]:
    """Frames turned about X, Y and Z so that the seen rectangle is smallest."""
    from scipy.spatial import ConvexHull, QhullError

    frames = []
    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        seen = points[:, [i, j]]
        try:
            ring = seen[ConvexHull(seen).vertices]
        except (QhullError, ValueError):
            continue
        along = unit(np.roll(ring, -1, axis=0) - ring)
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        areas = np.ptp(ring @ along.T, axis=0) * np.ptp(ring @ across.T, axis=0)
        k = int(np.argmin(areas))
        frame = np.zeros((3, 3))
        frame[[i, j], 0], frame[[i, j], 1], frame[axis, 2] = along[k], across[k], 1.0
        frames.append(frame)
    return frames


def _sides(local: Array, thickness: float) -> Array:
    low, high = local.min(axis=0), local.max(axis=0)
    missing = np.maximum(thickness - (high - low), 0.0) / 2.0
    return np.stack([low - missing, high + missing])


def _closed(points: Array) -> tuple[Array, Ints]:
    """The corners of the hull, and its triangles seen from outside."""
    from scipy.spatial import ConvexHull, QhullError

    for options in ("Qt", "QJ"):
        try:
            hull = ConvexHull(points, qhull_options=options)
        except QhullError:
            continue
        inside = points[hull.vertices].mean(axis=0)
        triangles = _outward(points, hull.simplices.astype(np.int64), inside)
        if _is_closed(triangles):
            rows = np.full(len(points), -1, dtype=np.int64)
            rows[hull.vertices] = np.arange(len(hull.vertices))
            # A triangulated facet may use a point on its edge that is not a vertex of the hull.
            if (rows[triangles] >= 0).all():
                return points[hull.vertices], rows[triangles]
            used, triangles = np.unique(triangles, return_inverse=True)
            return points[used], triangles.reshape(-1, 3)
    box = bounding_box(TriangleMesh(points, np.empty((0, 3), np.int32), np.empty(0, np.int32)))
    return box.points, box.triangles.astype(np.int64)


def _between(corners: Array, triangles: Ints) -> Mask:
    """(N,) which corners lie on the line between the two others of a triangle."""
    a, b, c = np.moveaxis(corners[triangles], 1, 0)
    # Each edge has the place of the corner that it faces.
    edges = np.linalg.norm(np.stack([c - b, a - c, b - a], axis=1), axis=2)
    longest = edges.argmax(axis=1)
    rows = np.arange(len(triangles))
    doubled = np.linalg.norm(crossed(b - a, c - a), axis=1)
    flat = np.zeros(len(corners), dtype=bool)
    thin = doubled <= FLAT_SHARE * edges[rows, longest]
    flat[triangles[rows, longest][thin]] = True
    return flat


def _outward(points: Array, triangles: Ints, inside: Array) -> Ints:
    a, b, c = np.moveaxis(points[triangles] - inside, 1, 0)
    wrong = np.einsum("ij,ij->i", a, crossed(b, c)) < 0.0
    triangles[wrong] = triangles[wrong][:, ::-1]
    return triangles


def _is_closed(triangles: Ints) -> bool:
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    width = int(edges.max()) + 1
    forward = np.sort(edges[:, 0] * width + edges[:, 1])
    backward = np.sort(edges[:, 1] * width + edges[:, 0])
    return bool((np.diff(forward) > 0).all() and np.array_equal(forward, backward))


def _farthest(corners: Array, most: int, wide: bool) -> Array:
    """The corners that a hull of few is best made of: always the ones farthest outside."""
    from scipy.spatial import ConvexHull, QhullError

    directions = np.concatenate([np.eye(3), -np.eye(3), _DIAGONALS, -_DIAGONALS])
    level = [*_lowest_face(corners)]
    if wide:
        level += [*_lowest_face(corners * [1.0, 1.0, -1.0])]
    chosen = np.unique([*(corners @ directions.T).argmax(axis=0), *level])
    while len(chosen) < most:
        try:
            planes = ConvexHull(corners[chosen]).equations
        except QhullError:
            return np.asarray(corners[chosen])
        heights = corners @ planes[:, :3].T + planes[:, 3]
        peaks, above = heights.argmax(axis=0), heights.max(axis=0)
        steepest = np.argsort(-above, kind="stable")
        steepest = steepest[above[steepest] > ENOUGH_SHARE]
        added = list(dict.fromkeys(peaks[steepest].tolist()))[
            : min(CORNERS_PER_ROUND, most - len(chosen))
        ]
        if not added:
            break
        chosen = np.concatenate([chosen, added])
    return np.asarray(corners[np.sort(chosen)])


def _lowest_face(corners: Array) -> Ints:
    """Some corners of the lowest face: things stand level on theirs, and on the highest one."""
    lowest = np.flatnonzero(corners[:, 2] <= corners[:, 2].min() + WELD_SHARE)
    angles = np.arange(_LEVEL_CORNERS) * (2.0 * np.pi / _LEVEL_CORNERS)
    outward = np.stack([np.cos(angles), np.sin(angles)])
    return np.asarray(lowest[(corners[lowest, :2] @ outward).argmax(axis=0)])


_LEVEL_CORNERS: Final = 12
_DIAGONALS: Final = np.array([[1, 1, 1], [1, 1, -1], [1, -1, 1], [1, -1, -1]], dtype=np.float64)


def _ordered(points: Array, triangles: Ints) -> TriangleMesh:
    """Corners in lexicographic order, each triangle from its least corner, triangles sorted."""
    order = np.lexsort(points.T[::-1])
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    rows = rank[triangles]
    turn = (rows.argmin(axis=1)[:, None] + np.arange(3)) % 3
    rows = np.take_along_axis(rows, turn, axis=1)
    sorted_rows = rows[np.lexsort(rows.T[::-1])].astype(np.int32)
    return TriangleMesh(points[order], sorted_rows, np.arange(len(rows), dtype=np.int32))
