"""Normals of polygon meshes: of faces, and smooth ones that stop at creases."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.vectors import UP, unit

# Pairs of corners looked at together: bounds the memory on scanned meshes.
_BLOCK = 4_000_000


def face_vectors(mesh: Mesh) -> Array:
    """(F, 3) normal of each face with the length of its area (Newell's method)."""
    if (mesh.counts == 3).all():  # the same sums without the zeros among them, several times faster
        a, b, c = np.moveaxis(mesh.points[mesh.indices.reshape(-1, 3)], 1, 0)
        return np.asarray(0.5 * np.cross(b - a, c - a), dtype=np.float64)
    ends = np.cumsum(mesh.counts)
    starts = ends - mesh.counts
    following = np.arange(len(mesh.indices)) + 1
    following[ends - 1] = starts
    here = mesh.points[mesh.indices]
    origin = np.repeat(here[starts], mesh.counts, axis=0)
    cross = np.cross(here - origin, here[following] - origin)
    return np.asarray(0.5 * np.add.reduceat(cross, starts, axis=0), dtype=np.float64)


def with_normals(mesh: Mesh, crease: float = 40.0) -> Mesh:
    """Give a mesh smooth normals that stop at creases.

    Each corner's normal is the area-weighted mean of the normals of those faces around its point
    that turn from its own face by less than the crease angle: large flat faces stay flat beside
    narrow bevels.

    Args:
        mesh: Any polygons whose shared edges share their points.
        crease: Degrees from which an edge is sharp; 0 gives flat faces.

    Returns:
        The mesh with (K, 3) normals.
    """
    vectors = face_vectors(mesh)
    units = unit(vectors, UP)
    face = np.repeat(np.arange(len(mesh.counts)), mesh.counts)
    order = np.argsort(mesh.indices, kind="stable")  # corners, those of one point together
    valence = np.bincount(mesh.indices, minlength=len(mesh.points))
    around = valence[mesh.indices[order]]
    group = (np.cumsum(valence) - valence)[mesh.indices[order]]
    normals = np.empty((len(order), 3))
    for block in _blocks(around):
        pairs = around[block]
        starts = np.cumsum(pairs) - pairs
        within = np.arange(pairs.sum()) - np.repeat(starts, pairs)
        near = np.repeat(face[order[block]], pairs)
        other = face[order[np.repeat(group[block], pairs) + within]]
        facing = np.einsum("ij,ij->i", units[near], units[other])
        smooth = (facing > np.cos(np.radians(crease))) | (near == other)
        weighted = np.where(smooth[:, None], vectors[other], 0.0)
        normals[order[block]] = np.add.reduceat(weighted, starts, axis=0)
    return replace(mesh, normals=unit(normals, UP).astype(np.float32))


def _blocks(around: Ints) -> list[slice]:
    """Runs of corners whose pairs together stay below the block size."""
    number = np.cumsum(around) // _BLOCK
    edges = np.flatnonzero(np.diff(number)) + 1
    bounds = [0, *edges.tolist(), len(around)]
    return [slice(a, b) for a, b in pairwise(bounds) if b > a]
