"""Where the corners of meshes stand in the world: of one prototype many instances at once."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from openrooms_usd.geometry.vectors import unit
from openrooms_usd.render.scene.arrays import Floats
from openrooms_usd.render.scene.pictures import Array
from openrooms_usd.usd.meshes import PlacedMesh

# Triangles of instances that are placed at once: about half a kilobyte each, meanwhile.
_MOST_TRIANGLES: Final = 1 << 18

Placed = tuple[Array, Floats]
"""(M, 3, 3) corners and unit normals in the world."""


def placed(meshes: Sequence[PlacedMesh]) -> dict[int, Placed]:
    """The triangles of meshes in the world, by the mesh's place in the sequence."""
    instances: dict[int, list[int]] = defaultdict(list)
    for number, mesh in enumerate(meshes):
        instances[id(mesh.mesh)].append(number)
    found: dict[int, Placed] = {}
    for numbers in instances.values():
        for some in _portions(numbers, len(meshes[numbers[0]].mesh.triangles)):
            found |= zip(
                some, zip(*_instances([meshes[n] for n in some]), strict=True), strict=True
            )
    return found


def _portions(numbers: list[int], triangles: int) -> Iterator[list[int]]:
    step = max(1, _MOST_TRIANGLES // max(triangles, 1))
    for start in range(0, len(numbers), step):
        yield numbers[start : start + step]


def _instances(meshes: Sequence[PlacedMesh]) -> tuple[Array, Floats]:
    """(K, M, 3, 3) corners and normals of instances of one mesh."""
    own = meshes[0].mesh
    matrices = np.array([mesh.world_from_local for mesh in meshes])
    turns = matrices[:, :3, :3]
    points = own.points @ turns.swapaxes(1, 2) + matrices[:, None, :3, 3]
    corners = points[:, own.triangles]
    if own.normals is None:
        a, b, c = np.moveaxis(corners, 2, 0)
        flat = np.cross(b - a, c - a)
        flat[np.array([mesh.mirrored for mesh in meshes])] *= -1.0
        normals = np.broadcast_to(unit(flat).astype(np.float32)[:, :, None], corners.shape)
    else:
        local = own.normals.reshape(-1, 3).astype(np.float64)
        normals = unit(local @ np.linalg.inv(turns)).astype(np.float32).reshape(corners.shape)
    return corners, normals
