"""Texture coordinates that follow the grain of wood: t runs along boards, legs and rails.

A chart is a set of faces that hang together in the texture. Joiners cut a board along its longer
side, so t runs along the longer side of each chart, and ends of boards show other wood.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array, Floats, Ints, Mask
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.normals import face_vectors
from openrooms_usd.geometry.vectors import UP

# Corners whose texture coordinates are as near are one, metres.
_SAME_M: Final = 1e-5
# A chart that is longer than wide by less is as it was.
LONG_RATIO: Final = 1.15
# The ends of boards: no more of a mesh than this, ...
_MAX_END_SHARE: Final = 0.15
# ... facing along its grain to within this cosine; ...
_END_COS: Final = 0.95
# ... there the pores are cut across, so that streaks are shorter by this factor.
_END_DENSITY: Final = 4.0


@dataclass(frozen=True)
class _Faces:
    """Each face's chart, area vector, and where s and t run on it.

    Attributes:
        chart: (F,) numbers.
        vector: (F, 3) normal times area.
        along_s: (F, 3) unit direction of s on the surface, or zero.
        along_t: (F, 3) likewise.
    """

    chart: Ints
    vector: Array
    along_s: Array
    along_t: Array


def along_grain(mesh: Mesh, *, upright: bool = False, ends: bool = False) -> Mesh:
    """Turn the texture of each chart so that its t runs along the grain.

    Args:
        mesh: With texture coordinates in metres.
        upright: Whether the grain is vertical wherever it can be, as that of doors; else it runs
            along the longer side of each chart.
        ends: Whether faces at the ends of its grain show cut pores: shorter streaks.
    """
    if mesh.st is None or not len(mesh.counts):
        return mesh
    chart = charts(mesh)
    corner = np.repeat(chart, mesh.counts)
    turned = _steep(mesh, chart) if upright else _long(mesh.st, corner)
    s, t = mesh.st.T
    st = np.where(turned[corner][:, None], np.stack([-t, s], axis=1), mesh.st)
    found = replace(mesh, st=st.astype(np.float32))
    return _with_ends(found, chart, corner) if ends else found


def charts(mesh: Mesh) -> Ints:
    """(F,) the chart of each face: faces that share an edge in space and in the texture."""
    assert mesh.st is not None
    cells = np.round(mesh.st / _SAME_M).astype(np.int64)
    _, node = np.unique(np.column_stack([mesh.indices, cells]), axis=0, return_inverse=True)
    node = node.reshape(-1).astype(np.int64)
    ends = np.cumsum(mesh.counts)
    following = np.arange(len(node)) + 1
    following[ends - 1] = ends - mesh.counts
    low, high = np.sort(np.stack([node, node[following]]), axis=0)
    _, edge = np.unique(low << 32 | high, return_inverse=True)
    return _joined(np.repeat(np.arange(len(mesh.counts)), mesh.counts), edge.reshape(-1))


def _joined(face: Ints, edge: Ints) -> Ints:
    """(F,) the component of each face, given the face and the edge of each corner."""
    label = np.arange(int(face.max()) + 1)
    while True:
        least = np.full(int(edge.max()) + 1, len(label))
        np.minimum.at(least, edge, label[face])
        nearest = label.copy()
        np.minimum.at(nearest, face, least[edge])
        nearest = nearest[nearest]
        if np.array_equal(nearest, label):
            return np.unique(label, return_inverse=True)[1].reshape(-1).astype(np.int64)
        label = nearest


def _long(st: Floats, corner: Ints) -> Mask:
    """(C,) which charts are longer along s than along t."""
    number = int(corner.max()) + 1
    low, high = np.full((number, 2), np.inf), np.full((number, 2), -np.inf)
    np.minimum.at(low, corner, st)
    np.maximum.at(high, corner, st)
    s, t = (high - low).T
    return np.asarray(s > LONG_RATIO * t)


def _steep(mesh: Mesh, chart: Ints) -> Mask:
    """(C,) on which charts s rises more than t does."""
    faces = _faces(mesh, chart)
    area = np.linalg.norm(faces.vector, axis=1)
    rise = [np.bincount(chart, area * np.abs(d @ UP)) for d in (faces.along_s, faces.along_t)]
    return np.asarray(rise[0] > 1.01 * rise[1])


def _with_ends(mesh: Mesh, chart: Ints, corner: Ints) -> Mesh:
    faces = _faces(mesh, chart)
    area = np.linalg.norm(faces.vector, axis=1)
    grain = np.einsum("f,fi,fj->ij", area, faces.along_t, faces.along_t)
    axis = np.linalg.eigh(grain)[1][:, -1]
    facing = np.bincount(chart, np.abs(faces.vector @ axis))
    share = np.bincount(chart, area)
    end = (facing > _END_COS * share) & (share < _MAX_END_SHARE * share.sum())
    assert mesh.st is not None
    stretch = np.where(end[corner], _END_DENSITY, 1.0)
    st = mesh.st * np.stack([np.ones_like(stretch), stretch], axis=1)
    return replace(mesh, st=st.astype(np.float32))


def _faces(mesh: Mesh, chart: Ints) -> _Faces:
    """What faces are, from their first three corners."""
    assert mesh.st is not None
    first = np.cumsum(mesh.counts) - mesh.counts
    corners = first[:, None] + np.arange(3)
    p, st = mesh.points[mesh.indices[corners]], mesh.st[corners].astype(np.float64)
    (a, b), (u, v) = (np.moveaxis(x[:, 1:] - x[:, :1], 1, 0) for x in (p, st))
    det = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    safe = np.where(det == 0.0, 1.0, det)[:, None]
    along_s = (v[:, 1:] * a - u[:, 1:] * b) / safe
    along_t = (u[:, :1] * b - v[:, :1] * a) / safe
    flat = (det == 0.0)[:, None]
    directions = [
        np.where(flat, 0.0, d / np.maximum(np.linalg.norm(d, axis=1, keepdims=True), 1e-12))
        for d in (along_s, along_t)
    ]
    return _Faces(chart, face_vectors(mesh), *directions)


def shifted(mesh: Mesh, offset: ArrayLike) -> Mesh:
    """The mesh with its texture moved by (s, t) metres."""
    if mesh.st is None:
        return mesh
    return replace(mesh, st=(mesh.st + np.asarray(offset)).astype(np.float32))
