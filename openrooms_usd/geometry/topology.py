"""How the faces of a mesh hang together."""

import numpy as np

from openrooms_usd.geometry.mesh import Mesh


def is_closed(mesh: Mesh) -> bool:
    """Whether every edge belongs to two faces that run along it in opposite directions.

    Edges are told by the numbers of their points: points at the same place must be shared.
    """
    ends = np.cumsum(mesh.counts)
    following = np.arange(len(mesh.indices)) + 1
    following[ends - 1] = ends - mesh.counts
    edges = np.stack([mesh.indices, mesh.indices[following]], axis=1).astype(np.int64)
    width = len(mesh.points)
    forward = np.sort(edges[:, 0] * width + edges[:, 1])
    backward = np.sort(edges[:, 1] * width + edges[:, 0])
    return bool((np.diff(forward) > 0).all() and np.array_equal(forward, backward))
