"""Flat faces gathered into one mesh, and the prism over an outline."""

from collections.abc import Sequence

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.normals import with_normals
from openrooms_usd.geometry.polygons import triangulated

# A face: (K, 3) corners, counter-clockwise from outside, and (K, 2) texture coordinates, metres.
Face = tuple[Array, Array]


def polyhedron(faces: Sequence[Face]) -> Mesh:
    """Join flat faces: corners at exactly the same place become one point.

    Args:
        faces: The faces; each gets its own flat normal.

    Returns:
        The mesh; it is closed when every edge of a face is an edge of another, turned round.
    """
    corners = np.concatenate([face for face, _ in faces]) + 0.0  # -0.0 and 0.0 are one place
    unique, first, index = np.unique(corners, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first, kind="stable")  # points in the order in which they are met
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    mesh = Mesh(
        points=unique[order],
        counts=np.array([len(face) for face, _ in faces], dtype=np.int32),
        indices=rank[index.ravel()].astype(np.int32),
        st=np.concatenate([st for _, st in faces]).astype(np.float32),
    )
    return with_normals(mesh, crease=0.0)


def upright(a: Array, b: Array, bottom: float, top: float, start: float = 0.0) -> Face:
    """A vertical rectangle over the plan's edge from a to b, seen with a on its left.

    Args:
        a: (2,) metres.
        b: (2,) metres.
        bottom: Height of its lower edge, metres.
        top: Height of its upper edge, metres.
        start: Its first texture coordinate at a, metres.
    """
    corners = np.array([[*a, bottom], [*b, bottom], [*b, top], [*a, top]])
    end = start + float(np.linalg.norm(b - a))
    return corners, np.array([[start, bottom], [end, bottom], [end, top], [start, top]])


def level(ring: Array, height: float, *, up: bool) -> Face:
    """A horizontal face over a counter-clockwise (K, 2) ring, seen from above or from below."""
    plan = ring if up else ring[::-1]
    return np.column_stack([plan, np.full(len(plan), height)]), plan


def prism(outline: Array, bottom: float, top: float) -> Mesh:
    """The solid over a simple counter-clockwise (N, 2) outline, between two heights in metres."""
    rings = triangulated(outline)
    following = np.roll(outline, -1, axis=0)
    return polyhedron(
        [
            *(level(ring, top, up=True) for ring in rings),
            *(level(ring, bottom, up=False) for ring in rings),
            *(upright(a, b, bottom, top) for a, b in zip(outline, following, strict=True)),
        ]
    )
