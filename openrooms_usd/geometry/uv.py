"""Texture coordinates for meshes that bring none."""

from dataclasses import replace

import numpy as np

from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.normals import face_vectors


def cube_projection(mesh: Mesh) -> Mesh:
    """Give a mesh texture coordinates in metres, each face seen along its nearest axis.

    Seen from outside, s runs to the right and t upwards on the four sides; areas shrink at most
    by the factor sqrt(3), on faces that look along a diagonal.

    Args:
        mesh: Metres, Z up.

    Returns:
        The mesh with (K, 2) texture coordinates.
    """
    vectors = face_vectors(mesh)
    axis = np.argmax(np.abs(vectors), axis=1)
    sign = np.where(vectors[np.arange(len(axis)), axis] < 0.0, -1.0, 1.0)
    corner_axis, corner_sign = np.repeat(axis, mesh.counts), np.repeat(sign, mesh.counts)
    x, y, z = mesh.points[mesh.indices].T
    s = np.choose(corner_axis, [corner_sign * y, -corner_sign * x, x])
    t = np.choose(corner_axis, [z, z, corner_sign * y])
    return replace(mesh, st=np.stack([s, t], axis=1).astype(np.float32))
