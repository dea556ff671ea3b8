"""Meshes as binary PLY files, as Mitsuba reads them."""

import numpy as np

from openrooms_usd.rendering.scene.pictures import Array
from openrooms_usd.rendering.scene.triangles import Triangles

_HEADER = """ply
format binary_little_endian 1.0
element vertex {vertices}
property float x
property float y
property float z
property float nx
property float ny
property float nz
property float u
property float v
element face {faces}
property list uchar int vertex_index
end_header
"""


def ply_bytes(triangles: Triangles, origin: Array) -> bytes:
    """A PLY file of triangles; corners that agree in everything become one vertex.

    Args:
        triangles: What to write.
        origin: (3,) the point of the world that is the file's origin.
    """
    points = (triangles.corners - origin).astype(np.float32)
    corners = np.concatenate([points, triangles.normals, triangles.st], axis=2).reshape(-1, 8)
    # Adding zero makes -0 and 0 one number.
    vertices, index = np.unique(corners + np.float32(0), axis=0, return_inverse=True)
    faces = np.empty(len(triangles), dtype=[("count", "u1"), ("index", "<i4", 3)])
    faces["count"], faces["index"] = 3, index.reshape(-1, 3)
    header = _HEADER.format(vertices=len(vertices), faces=len(faces))
    return header.encode("ascii") + vertices.astype("<f4").tobytes() + faces.tobytes()
