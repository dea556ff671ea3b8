"""Triangles as Mitsuba's meshes: plain ones, and instances kept or expanded."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.rendering.scene.instances import Instances
from openrooms_usd.rendering.scene.triangles import Triangles


@dataclass(frozen=True, eq=False)
class Vertices:
    """Triangles by the rows of their vertices, in single precision.

    Attributes:
        positions: (N, 3) relative to the origin, metres.
        normals: (N, 3) unit vectors.
        st: (N, 2) texture coordinates.
        faces: (M, 3) rows of them.
    """

    positions: Floats
    normals: Floats
    st: Floats
    faces: NDArray[np.uint32]


def vertices(triangles: Triangles, origin: Array) -> Vertices:
    """Triangles with their instances expanded, in their order.

    Triangles of instances share the vertices that are alike, which saves three quarters of the
    memory; others are taken as they come.

    Args:
        triangles: What stands in the world.
        origin: (3,) the point of the world that becomes Mitsuba's origin.
    """
    parts = [
        _welded(part, origin) if isinstance(part, Instances) else _plain(part, origin)
        for part in triangles.parts
    ]
    if len(parts) == 1:
        return parts[0]
    starts = np.cumsum([0, *(len(part.positions) for part in parts[:-1])], dtype=np.uint32)
    return Vertices(
        np.concatenate([part.positions for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.st for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=True)]),
    )


def mesh(name: str, found: Vertices, properties: Any) -> Any:
    """A Mitsuba mesh.

    Args:
        name: Its identifier.
        found: Its triangles.
        properties: `mi.Properties` with its BSDF and emitter.
    """
    made = mi.Mesh(
        name,
        vertex_count=len(found.positions),
        face_count=len(found.faces),
        has_vertex_normals=True,
        has_vertex_texcoords=True,
        props=properties,
    )
    arrays = mi.traverse(made)
    arrays["vertex_positions"] = found.positions.ravel()
    arrays["vertex_normals"] = found.normals.ravel()
    arrays["vertex_texcoords"] = found.st.ravel()
    arrays["faces"] = found.faces.ravel()
    arrays.update()
    return made


def shape_group(
    name: str, instances: Instances, origin: Array, properties: Any
) -> Iterator[tuple[str, Any]]:
    """Instances as objects of a Mitsuba scene: what they share first, then one for each.

    Args:
        name: Their identifiers begin so.
        instances: What stands in the world.
        origin: (3,) the point of the world that becomes Mitsuba's origin.
        properties: `mi.Properties` with the BSDF.
    """
    centred = instances.centred()
    shared = mesh(f"{name}_mesh", _plain(centred.prototype, np.zeros(3)), properties)
    yield name, {"type": "shapegroup", "mesh": shared}
    for number, matrix in enumerate(centred.seen_from(origin).tolist()):
        group, to_world = {"type": "ref", "id": name}, mi.ScalarTransform4f(matrix)
        yield f"{name}_{number}", {"type": "instance", "group": group, "to_world": to_world}


def _plain(triangles: Triangles, origin: Array) -> Vertices:
    return Vertices(
        (triangles.corners - origin).reshape(-1, 3).astype(np.float32),
        triangles.normals.reshape(-1, 3).astype(np.float32),
        triangles.st.reshape(-1, 2).astype(np.float32),
        np.arange(3 * len(triangles), dtype=np.uint32).reshape(-1, 3),
    )


def _welded(instances: Instances, origin: Array) -> Vertices:
    own = instances.prototype
    corners = np.column_stack(
        [own.corners.reshape(-1, 3), own.normals.reshape(-1, 3), own.st.reshape(-1, 2)]
    )
    # Equal to the last bit.
    whole = np.ascontiguousarray(corners).view(np.dtype((np.void, corners.strides[0]))).ravel()
    _, first, rows = np.unique(whole, return_index=True, return_inverse=True)
    # A vertex is placed as a triangle of one corner is.
    points = Triangles(
        own.corners.reshape(-1, 1, 3)[first],
        own.normals.reshape(-1, 1, 3)[first],
        own.st.reshape(-1, 1, 2)[first],
        np.zeros(len(first), np.int32),
    )
    placed = Instances(points, instances.world_from_prototype, instances.owners)
    faces = np.broadcast_to(
        rows.reshape(-1, 3).astype(np.uint32), (len(placed.owners), *own.corners.shape[:2])
    ).copy()
    faces[instances.mirrored] = faces[instances.mirrored][:, :, ::-1]
    faces += (np.arange(len(faces), dtype=np.uint32) * np.uint32(len(first)))[:, None, None]
    found = _plain(placed, origin)
    return Vertices(found.positions, found.normals, found.st, faces.reshape(-1, 3))
