"""Texture coordinates in metres, so that materials have their physical size on every mesh."""

from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.normals import face_vectors
from openrooms_usd.geometry.uvquality import uv_quality

# A face looks along the first axis that is this near to its nearest one: faces on a diagonal keep
# together, whatever their coordinates are rounded to.
_TIE_SHARE: Final = 1.0 - 1e-4


def cube_projection(mesh: Mesh) -> Mesh:
    """Give a mesh texture coordinates in metres, each face seen along its nearest axis.

    Seen from outside, s runs to the right and t upwards on the four sides; lengths shrink at most
    by the factor sqrt(3), on faces that look along a diagonal. Faces without an area get
    coordinates like any other.

    Args:
        mesh: Metres, Z up.

    Returns:
        The mesh with (K, 2) texture coordinates.
    """
    vectors = face_vectors(mesh)
    sizes = np.abs(vectors)
    axis = np.argmax(sizes >= _TIE_SHARE * sizes.max(axis=1, keepdims=True), axis=1)
    sign = np.where(np.take_along_axis(vectors, axis[:, None], axis=1)[:, 0] < 0.0, -1.0, 1.0)
    corner_axis, corner_sign = np.repeat(axis, mesh.counts), np.repeat(sign, mesh.counts)
    x, y, z = mesh.points[mesh.indices].T
    s = np.choose(corner_axis, [corner_sign * y, -corner_sign * x, x])
    t = np.choose(corner_axis, [z, z, corner_sign * y])
    return replace(mesh, st=np.stack([s, t], axis=1).astype(np.float32))


def centred(mesh: Mesh, *, across: bool = True, along: bool = True) -> Mesh:
    """A mesh whose texture begins in its middle, as tilers begin: what is cut at edges is equal.

    Args:
        mesh: With texture coordinates.
        across: Whether s is 0 in the middle; else it stays.
        along: Whether t is 0 in the middle; else it is 0 at the lower end, where whole pieces lie.
    """
    if mesh.st is None or not len(mesh.st):
        return mesh
    low, high = mesh.st.min(axis=0), mesh.st.max(axis=0)
    middle = 0.5 * (low + high)
    start = (middle[0] if across else 0.0, middle[1] if along else low[1])
    return replace(mesh, st=(mesh.st - np.array(start)).astype(np.float32))


def metric(mesh: Mesh) -> tuple[Mesh, str]:
    """A mesh whose texture coordinates are in metres: its own ones to scale, or projected ones.

    Its own are kept where `uv_quality` finds no fault with them, divided by their density: a
    texture that spans a metre then spans a metre on the mean of the surface. Scaled numbers under
    the usual name need nothing of a material, which many meshes share; a UsdTransform2d would ask
    for a copy of each material for each mesh.

    Args:
        mesh: Metres, Z up, with or without texture coordinates.

    Returns:
        The mesh, and why its own coordinates could not be kept; empty where they could, or where
        it had none.
    """
    if mesh.st is None:
        return cube_projection(mesh), ""
    quality = uv_quality(mesh)
    if quality.fault:
        return cube_projection(mesh), quality.fault
    return replace(mesh, st=(mesh.st / quality.density).astype(np.float32)), ""
