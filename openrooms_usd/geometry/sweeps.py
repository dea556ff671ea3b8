"""Closed solids from a section and a path: extruded polygons, tubes and bent sheets."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.curves import filleted, lengths, signed_area
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.normals import with_normals
from openrooms_usd.geometry.vectors import UP, unit


def extrude(polygon: ArrayLike, height: float, *, bevel: float = 0.0, base: float = 0.0) -> Mesh:
    """A prism over a simple polygon.

    Args:
        polygon: (N, 2) corners, either way round, metres.
        height: Metres, upwards.
        bevel: Radius of its rounded upper and lower rims, metres; the caps shrink by it, so it
            must be smaller than the polygon's own roundings.
        base: Height of its lower cap, metres.

    Returns:
        The closed mesh: sides of quads, caps of triangles.

    Raises:
        InputError: The polygon has fewer than three corners or no area.
    """
    corners = np.asarray(polygon, dtype=np.float64)
    area = signed_area(corners) if len(corners) >= 3 else 0.0
    if abs(area) < 1e-12:
        raise InputError("a polygon to extrude has no area", remedy="give three or more corners")
    if area < 0.0:
        corners = corners[::-1]
    bevel = min(bevel, 0.49 * height)
    rise = np.radians([-90.0, -60.0, -30.0, 0.0, 0.0, 30.0, 60.0, 90.0] if bevel > 0 else [0, 0])
    inset = bevel * (1.0 - np.cos(rise))
    middle = np.where(np.arange(len(rise)) < len(rise) // 2, bevel, height - bevel)
    z = base + middle + bevel * np.sin(rise)
    rings = np.concatenate([_inset(corners, inset), _column(z, len(corners))], axis=-1)
    return _prism(corners, rings, rise)


def _column(z: Array, count: int) -> Array:
    return np.broadcast_to(z[:, None, None], (len(z), count, 1))


def _inset(corners: Array, distance: Array) -> Array:
    """(R, N, 2) the polygon with its sides moved inwards by each distance."""
    side = _side_normals(corners)
    before = np.roll(side, 1, axis=0)
    scale = 1.0 + np.einsum("ij,ij->i", side, before)
    mitre = (side + before) / np.maximum(scale, 0.1)[:, None]
    return np.asarray(corners - distance[:, None, None] * mitre)


def _side_normals(corners: Array) -> Array:
    """(N, 2) outward unit normal of the side from each corner to the next."""
    along = np.roll(corners, -1, axis=0) - corners
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    return unit(normal)


def _prism(corners: Array, rings: Array, rise: Array) -> Mesh:
    rows, count = rings.shape[:2]
    i, j = (a.ravel() for a in np.indices((rows - 1, count)))
    following = (j + 1) % count
    row = np.stack([i, i, i + 1, i + 1], axis=1)
    column = np.stack([j, following, following, j], axis=1)
    start, end = _rounded_sides(corners)
    flat = np.stack([start[j], end[j], end[j], start[j]], axis=1)
    normals = np.concatenate(
        [np.cos(rise)[row][..., None] * flat, np.sin(rise)[row][..., None]], axis=-1
    )
    around = lengths(np.concatenate([corners, corners[:1]]))
    up = lengths(rings[:, 0])
    st = np.stack([np.stack([around[j], around[j + 1]] * 2, axis=1)[:, [0, 1, 3, 2]], up[row]], -1)
    sides = Mesh(
        points=rings.reshape(-1, 3),
        counts=np.full(len(row), 4, dtype=np.int32),
        indices=(row * count + column).reshape(-1).astype(np.int32),
        normals=normals.reshape(-1, 3).astype(np.float32),
        st=st.reshape(-1, 2).astype(np.float32),
    )
    return _capped(sides, rings, count)


def _rounded_sides(corners: Array) -> tuple[Array, Array]:
    """Normals at the start and end of each side: shared where sides turn by less than 40 deg."""
    side = _side_normals(corners)
    weight = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1, keepdims=True)
    before = np.roll(side, 1, axis=0)
    smooth = (np.einsum("ij,ij->i", side, before) > np.cos(np.radians(40.0)))[:, None]
    mean = unit(side * weight + before * np.roll(weight, 1, axis=0))
    start = np.where(smooth, mean, side)
    end = np.where(np.roll(smooth, -1, axis=0), np.roll(mean, -1, axis=0), side)
    return start, end


def _capped(sides: Mesh, rings: Array, count: int) -> Mesh:
    """Close the first and the last ring by triangles."""
    import mapbox_earcut

    top = rings[-1, :, :2]
    triangles = mapbox_earcut.triangulate_float64(top, np.array([count], dtype=np.uint32))
    upper = triangles.astype(np.int32).reshape(-1, 3)
    a, b, c = np.moveaxis(top[upper], 1, 0)
    clockwise = (b - a)[:, 0] * (c - a)[:, 1] < (b - a)[:, 1] * (c - a)[:, 0]
    upper[clockwise] = upper[clockwise][:, ::-1]
    faces = np.concatenate([upper + np.int32(len(sides.points) - count), upper[:, ::-1]])
    indices = faces.reshape(-1)
    normals = np.zeros((len(indices), 3), dtype=np.float32)
    normals[: upper.size, 2], normals[upper.size :, 2] = 1.0, -1.0
    assert sides.normals is not None and sides.st is not None
    return Mesh(
        points=sides.points,
        counts=np.concatenate([sides.counts, np.full(len(faces), 3, dtype=np.int32)]),
        indices=np.concatenate([sides.indices, indices]),
        normals=np.concatenate([sides.normals, normals]),
        st=np.concatenate([sides.st, sides.points[indices, :2].astype(np.float32)]),
    )


def tube(
    path: ArrayLike,
    radius: float | Sequence[float],
    *,
    bend: float = 0.0,
    bend_segments: int = 4,
    segments: int = 12,
    closed: bool = False,
) -> Mesh:
    """A round bar along a polyline, mitred at its corners.

    Args:
        path: (N, 3) points of its axis, metres.
        radius: Metres, one for all or one a point, those of bends included.
        bend: Of its corners, the radius of their arcs, metres.
        bend_segments: Straight pieces of each arc.
        segments: Sides around the axis.
        closed: Whether the last point joins the first; the ends are capped otherwise.

    Returns:
        The closed mesh.
    """
    axis = np.asarray(path, dtype=np.float64)
    if bend > 0.0:
        axis = filleted(axis, bend, segments=bend_segments, closed=closed)
    radii = np.broadcast_to(np.asarray(radius, dtype=np.float64), (len(axis),))
    rings = axis[:, None] + _tube_offsets(axis, segments, closed) * radii[:, None, None]
    rows = len(axis) if closed else len(axis) - 1
    i, j = (a.ravel() for a in np.indices((rows, segments)))
    row = np.stack([i, i, i + 1, i + 1], axis=1)
    column = np.stack([j, j + 1, j + 1, j], axis=1)
    along = lengths(np.concatenate([axis, axis[:1]]))
    st = np.stack([column * (2.0 * np.pi / segments * radii.max()), along[row]], axis=-1)
    body = Mesh(
        points=rings.reshape(-1, 3),
        counts=np.full(len(row), 4, dtype=np.int32),
        indices=(row % len(axis) * segments + column % segments).reshape(-1).astype(np.int32),
        st=st.reshape(-1, 2).astype(np.float32),
    )
    return with_normals(body if closed else _round_caps(body, len(axis), segments), crease=50.0)


def _tube_offsets(axis: Array, segments: int, closed: bool) -> Array:
    """(N, S, 3) unit circle slid along each piece of the path onto its mitre plane."""
    pieces = unit(np.diff(np.concatenate([axis, axis[:1]]), axis=0), UP)
    if not closed:
        pieces[-1] = pieces[-2]
    before = np.roll(pieces, 1, axis=0)
    if not closed:
        before[0] = pieces[0]
    side = np.cross(pieces[0], np.eye(3)[np.argmin(np.abs(pieces[0]))])
    side /= np.linalg.norm(side)
    angle = 2.0 * np.pi * np.arange(segments) / segments
    circle = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * np.cross(pieces[0], side)
    offsets = np.empty((len(axis), segments, 3))
    for i in range(len(axis)):
        mitre = unit((before[i] + pieces[i])[None], UP)[0]
        slide = (circle @ mitre) / (before[i] @ mitre)
        offsets[i] = circle - slide[:, None] * before[i]
        circle = offsets[i] - (offsets[i] @ pieces[i])[:, None] * pieces[i]
    return offsets


def _round_caps(body: Mesh, rows: int, segments: int) -> Mesh:
    assert body.st is not None
    around = np.arange(segments, dtype=np.int32)
    caps = np.concatenate([around[::-1], (rows - 1) * segments + around])
    angle = 2.0 * np.pi / segments * np.concatenate([around[::-1], around])
    flat = body.st[:, 0].max() / (2.0 * np.pi) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return Mesh(
        points=body.points,
        counts=np.concatenate([body.counts, np.array([segments] * 2, dtype=np.int32)]),
        indices=np.concatenate([body.indices, caps.astype(np.int32)]),
        st=np.concatenate([body.st, flat.astype(np.float32)]),
    )


def sheet(grid: ArrayLike, thickness: float) -> Mesh:
    """A curved board: a surface given by its points, thickened to its back.

    Args:
        grid: (R, C, 3) points of the front, metres; rows x columns turn counter-clockwise seen
            from the front.
        thickness: Metres, against the front's normals.

    Returns:
        The closed mesh.
    """
    front = np.asarray(grid, dtype=np.float64)
    across, along = np.gradient(front, axis=1), np.gradient(front, axis=0)
    back = front - thickness * unit(np.cross(across, along), UP)
    rows, columns = front.shape[:2]
    number = np.arange(rows * columns).reshape(rows, columns)
    s = _running(front, 1)
    t = _running(front, 0)
    st = np.stack([s, t], axis=-1).reshape(-1, 2)
    quads = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1)
    quads = quads.reshape(-1, 4)
    rim = np.concatenate([number[0, :-1], number[:-1, -1], number[-1, :0:-1], number[:0:-1, 0]])
    after = np.roll(rim, -1)
    size = rows * columns
    walls = np.stack([after, rim, rim + size, after + size], axis=1)
    faces = np.concatenate([quads, quads[:, ::-1] + size, walls])
    edge = lengths(front.reshape(-1, 3)[np.append(rim, rim[0])])
    wall_st = np.stack(
        [
            np.stack([edge[1:], edge[:-1], edge[:-1], edge[1:]], axis=1),
            np.broadcast_to([0.0, 0.0, thickness, thickness], (len(rim), 4)),
        ],
        axis=-1,
    )
    board = Mesh(
        points=np.concatenate([front.reshape(-1, 3), back.reshape(-1, 3)]),
        counts=np.full(len(faces), 4, dtype=np.int32),
        indices=faces.reshape(-1).astype(np.int32),
        st=np.concatenate(
            [st[quads].reshape(-1, 2), st[quads[:, ::-1]].reshape(-1, 2), wall_st.reshape(-1, 2)]
        ).astype(np.float32),
    )
    return with_normals(board, crease=50.0)


def _running(grid: Array, axis: int) -> Array:
    """Mean distance along one axis of a grid of points, broadcast over the other."""
    steps = np.linalg.norm(np.diff(grid, axis=axis), axis=-1).mean(axis=1 - axis)
    run = np.concatenate([[0.0], np.cumsum(steps)])
    shape = (-1, 1) if axis == 0 else (1, -1)
    return np.broadcast_to(run.reshape(shape), grid.shape[:2])
