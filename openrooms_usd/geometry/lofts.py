"""Closed solids through a stack of rings: basins, tubs, trays, panels and hollow boxes."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.curves import filleted, lengths, rectangle
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.normals import face_vectors, with_normals
from openrooms_usd.geometry.uv import cube_projection
from openrooms_usd.geometry.vectors import UP, unit


def loft(rings: ArrayLike, *, crease: float = 40.0, closed: bool = False) -> Mesh:
    """The solid whose skin runs from ring to ring, its first and last ring closed by flat faces.

    A skin that turns back inside itself makes a vessel: up on the outside, over the rim, down on
    the inside.

    Args:
        rings: (R, N, 3) corners, metres; counter-clockwise seen from where the stack goes on the
            outside, so that faces look outwards. The first and last ring must be flat and convex.
        crease: Degrees from which an edge is sharp.
        closed: Whether the last ring joins the first instead: a frame around a hole.

    Returns:
        The closed mesh: sides of quads, and polygons as caps. Texture coordinates run around and
        along the skin where it is steep, and are seen from above where it is flat.
    """
    skin = np.asarray(rings, dtype=np.float64)
    rows, count = skin.shape[:2]
    if closed:
        skin = np.concatenate([skin, skin[:1]])
    i, j = (a.ravel() for a in np.indices((len(skin) - 1, count)))
    row = np.stack([i, i, i + 1, i + 1], axis=1)
    column = np.stack([j, j + 1, j + 1, j], axis=1)
    around = lengths(np.concatenate([skin[rows // 2], skin[rows // 2, :1]]))
    along = np.concatenate([[0.0], np.cumsum(_steps(skin))])
    mesh = Mesh(
        points=skin[:rows].reshape(-1, 3),
        counts=np.full(len(row), 4, dtype=np.int32),
        indices=(row % rows * count + column % count).reshape(-1).astype(np.int32),
        st=np.stack([around[column], along[row]], axis=-1).reshape(-1, 2).astype(np.float32),
    )
    return _seen_from_above(
        with_normals(mesh if closed else _capped(mesh, rows, count), crease=crease)
    )


def _capped(skin: Mesh, rows: int, count: int) -> Mesh:
    """Close the first and the last ring by one polygon each."""
    assert skin.st is not None
    around = np.arange(count, dtype=np.int32)
    corners = np.concatenate([around[::-1], (rows - 1) * count + around]).astype(np.int32)
    caps = cube_projection(Mesh(skin.points, np.array([count, count], dtype=np.int32), corners))
    assert caps.st is not None
    return Mesh(
        points=skin.points,
        counts=np.concatenate([skin.counts, caps.counts]),
        indices=np.concatenate([skin.indices, caps.indices]),
        st=np.concatenate([skin.st, caps.st]),
    )


def _seen_from_above(mesh: Mesh) -> Mesh:
    """Texture flat faces by x and y, so that a grain runs on across a frame and its panel."""
    assert mesh.st is not None
    flat = np.abs(unit(face_vectors(mesh), UP)[:, 2]) > np.sqrt(0.5)
    corner = np.repeat(flat, mesh.counts)
    above = mesh.points[mesh.indices, :2].astype(np.float32)
    return replace(mesh, st=np.where(corner[:, None], above, mesh.st))


def _steps(skin: Array) -> Array:
    """(R - 1,) mean distance from each ring to the next."""
    return np.asarray(np.linalg.norm(np.diff(skin, axis=0), axis=-1).mean(axis=1))


def superellipse(width: float, depth: float, power: float = 2.0, segments: int = 40) -> Array:
    """(N, 2) points of |2x/width|^p + |2y/depth|^p = 1, counter-clockwise.

    The power 2 gives an ellipse, more comes closer to a rectangle.
    """
    angle = 2.0 * np.pi * np.arange(segments) / segments
    c, s = np.cos(angle), np.sin(angle)
    # Equal angles, not equal parameters: corners of high powers are not left without points.
    radius = (np.abs(c) ** power + np.abs(s) ** power) ** (-1.0 / power)
    return np.stack([0.5 * width * radius * c, 0.5 * depth * radius * s], axis=1)


def rounded_rectangle(width: float, depth: float, radius: float, segments: int = 4) -> Array:
    """A rectangle about the origin, counter-clockwise, metres.

    Args:
        width: Along X.
        depth: Along Y.
        radius: Of its corners; as much as there is room for.
        segments: Straight pieces of each corner; 0 leaves it sharp.

    Returns:
        (4 (segments + 1), 2) its points.
    """
    sharp = rectangle(width, depth)
    if segments == 0:
        return sharp
    radius = max(min(radius, 0.498 * min(width, depth)), 1e-4)
    return filleted(sharp, radius, segments=segments, closed=True)


def ring(outline: Array, z: float, center: ArrayLike = (0.0, 0.0)) -> Array:
    """(N, 3) a flat outline (N, 2) laid at a height, moved sideways, metres."""
    flat = outline + np.asarray(center, dtype=np.float64)
    return np.concatenate([flat, np.full((len(flat), 1), z)], axis=1)


def vessel(
    outer: Sequence[float],
    inner: Sequence[float],
    *,
    wall_edge: float = 0.002,
    corner: float = 0.0,
    inner_corner: float | None = None,
) -> Mesh:
    """A box that is open at its top, with its walls and its floor.

    Args:
        outer: Least and greatest corner of the box: x, y, z, x, y, z in metres.
        inner: Least corner x, y, z of the hollow and its greatest x, y, metres.
        wall_edge: Chamfer of its edges, metres.
        corner: Radius of the upright edges outside, metres; 0 leaves them sharp.
        inner_corner: The same inside; as outside where it is not given.

    Returns:
        The closed mesh.
    """
    x0, y0, z0, x1, y1, z1 = outer
    a0, b0, floor, a1, b1 = inner
    e = wall_edge
    hollow = corner if inner_corner is None else inner_corner
    segments = 3 if max(corner, hollow) > 0.0 else 0
    middle, core = (0.5 * (x0 + x1), 0.5 * (y0 + y1)), (0.5 * (a0 + a1), 0.5 * (b0 + b1))

    def out(inset: float, z: float) -> Array:
        flat = rounded_rectangle(x1 - x0 - inset, y1 - y0 - inset, corner, segments)
        return ring(flat, z, middle)

    def within(grow: float, z: float) -> Array:
        flat = rounded_rectangle(a1 - a0 + grow, b1 - b0 + grow, hollow, segments)
        return ring(flat, z, core)

    rings = [
        out(2 * e, z0),
        out(0.0, z0 + e),
        out(0.0, z1 - e),
        out(2 * e, z1),
        within(2 * e, z1),
        within(0.0, z1 - e),
        within(0.0, floor + e),
        within(-2 * e, floor),
    ]
    return loft(rings)
