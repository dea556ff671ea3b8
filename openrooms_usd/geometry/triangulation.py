"""Polygons to triangles: convex ones by fans, concave ones by clipping ears."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Floats, Mask
from openrooms_usd.geometry.vectors import crossed

Ints = NDArray[np.int32]

# Sine of the angle by which a corner must turn the wrong way to count as reflex.
REFLEX = 1e-6
# Twice the area over the squared longest side below which a triangle has no area.
FLAT = 1e-14

_BOX = np.array(
    [
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ],
    dtype=np.int32,
)


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """Triangles in a local frame; equal prims share one object.

    Attributes:
        points: (N, 3) in the local frame.
        triangles: (M, 3) rows of ``points``, counter-clockwise seen from outside.
        faces: (M,) the source face of each triangle.
        normals: (M, 3, 3) unit normal at each corner; None where the mesh has none.
        uvs: (M, 3, 2) texture coordinates at each corner, by their name.
        corners: (M, 3) the corner of the polygons that each corner is, in the order of their
            ``faceVertexIndices``; None where they come of no polygons.
        colors: (M, 3, 3) colours at each corner, by their name.
    """

    points: Array
    triangles: Ints
    faces: Ints
    normals: Floats | None = None
    uvs: Mapping[str, Floats] = field(default_factory=dict)
    corners: Ints | None = None
    colors: Mapping[str, Floats] = field(default_factory=dict)

    @property
    def st(self) -> Floats | None:
        """(M, 3, 2) the texture coordinates named ``st``, or else the first; None without any."""
        return self.uvs.get("st", next(iter(self.uvs.values()), None))


def triangulate(points: Array, counts: Ints, indices: Ints) -> tuple[Ints, Ints]:
    """Cut polygons into triangles with their own winding; triangles without area are left out.

    Args:
        points: (N, 3) finite coordinates.
        counts: (F,) corners of each face; faces of less than three are left out.
        indices: (K,) point of each corner.

    Returns:
        (M, 3) corners (into ``indices``) of each triangle, and (M,) the face it is from.
    """
    firsts = np.cumsum(counts) - counts
    reflex = _reflex(points, counts, indices, firsts)
    number = np.bincount(_faces(counts), weights=reflex, minlength=len(counts))
    apexes = _apexes(counts, firsts, reflex)
    fans, fan_faces = _fans(counts, firsts, apexes, number < 2)
    ears = [
        _ears(points, indices, face, firsts[face], counts[face]) for face in _where(number >= 2)
    ]
    corners, faces = fans, fan_faces
    if ears:
        corners = np.concatenate([fans, *(ear for ear, _ in ears)])
        faces = np.concatenate([fan_faces, *(face for _, face in ears)])
        order = np.argsort(faces, kind="stable")
        corners, faces = corners[order], faces[order]
    solid = has_area(points[indices[corners]])
    return corners[solid].astype(np.int32), faces[solid].astype(np.int32)


def has_area(triangles: Array) -> Mask:
    """(M,) whether each of (M, 3, 3) triangles is more than a line or a point."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    sides = b - a, c - a, c - b
    longest = np.maximum.reduce([_dots(side, side) for side in sides])
    doubled = crossed(sides[0], sides[1])
    return np.asarray(np.sqrt(_dots(doubled, doubled)) > FLAT * longest)


def bounding_box(mesh: TriangleMesh) -> TriangleMesh:
    """The twelve triangles of a mesh's axis-parallel box, seen from outside."""
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    steps = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)])
    return TriangleMesh(low + steps * (high - low), _BOX, np.arange(len(_BOX), dtype=np.int32))


def _dots(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("ij,ij->i", a, b))


def _where(condition: Mask) -> list[int]:
    return [int(row) for row in np.flatnonzero(condition)]


def _faces(counts: Ints) -> Ints:
    return np.repeat(np.arange(len(counts), dtype=np.int32), counts)


def _reflex(points: Array, counts: Ints, indices: Ints, firsts: Ints) -> Mask:
    """(K,) corners at which a face of four or more turns against its own normal."""
    if not (counts > 3).any():
        return np.zeros(len(indices), dtype=np.bool_)
    if (counts == counts[0]).all():
        return _reflex_of_alike(points[indices].reshape(len(counts), -1, 3)).ravel()
    faces = _faces(counts)
    start, size = firsts[faces], counts[faces]
    local = np.arange(len(indices)) - start
    here = points[indices]
    after, before = start + (local + 1) % size, start + (local - 1) % size
    out, into = here[after] - here, here - here[before]
    # Newell's normal, about a point of the face: robust for warped and concave polygons.
    base = here[start]
    sums = crossed(here - base, here[after] - base)
    of_faces = [np.bincount(faces, sums[:, k], len(counts)).astype(np.float64) for k in range(3)]
    normals = np.stack(of_faces, axis=1)[faces]
    turn = _dots(crossed(into, out), normals)
    scale = np.prod([np.sqrt(_dots(v, v)) for v in (into, out, normals)], axis=0)
    return np.asarray((turn < -REFLEX * scale) & (size > 3))


def _reflex_of_alike(here: Array) -> Mask:
    """(F, N) the same of (F, N, 3) faces of as many corners each, which takes half the time."""
    after = np.roll(here, -1, axis=1)
    out = after - here
    into = np.roll(out, 1, axis=1)
    base = here[:, :1]
    normals = np.einsum("fni->fi", crossed(here - base, after - base))
    turn = np.einsum("fni,fi->fn", crossed(into, out), normals)
    lengths = np.sqrt(np.einsum("fni,fni->fn", out, out))
    scale = lengths * np.roll(lengths, 1, axis=1) * np.sqrt(_dots(normals, normals))[:, None]
    return np.asarray(turn < -REFLEX * scale)


def _apexes(counts: Ints, firsts: Ints, reflex: Mask) -> Ints:
    """(F,) the corner, within its face, that sees all others: the reflex one, if there is one."""
    faces = _faces(counts)
    apexes = np.zeros(len(counts), dtype=np.int32)
    at = np.flatnonzero(reflex)
    apexes[faces[at]] = at - firsts[faces[at]]
    return apexes


def _fans(
    counts: Ints, firsts: Ints, apexes: Ints, chosen: Mask
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    size = np.where(chosen, np.maximum(counts - 2, 0), 0)
    faces = np.repeat(np.arange(len(counts)), size)
    step = np.arange(len(faces)) - np.repeat(np.cumsum(size) - size, size)
    turns = np.stack([np.zeros_like(step), step + 1, step + 2], axis=1) + apexes[faces][:, None]
    return firsts[faces][:, None] + turns % counts[faces][:, None], faces


def _ears(
    points: Array, indices: Ints, face: int, first: int, count: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Triangles of one polygon with several reflex corners."""
    from mapbox_earcut import triangulate_float64

    ring = points[indices[first : first + count]]
    ring = ring - ring[0]
    normal = np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0)
    # Seen along the axis that the face is most nearly square to.
    axis = int(np.abs(normal).argmax())
    flat = np.ascontiguousarray(ring[:, [(axis + 1) % 3, (axis + 2) % 3]])
    cut = triangulate_float64(flat, np.array([count], dtype=np.uint32)).reshape(-1, 3)
    cut = cut.astype(np.int64)
    a, b, c = np.moveaxis(flat[cut], 1, 0)
    turned = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    wrong = turned * normal[axis] < 0
    cut[wrong] = cut[wrong][:, ::-1]
    return first + cut, np.full(len(cut), face)
