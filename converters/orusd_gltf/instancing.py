"""Nodes that show the same mesh as one node of many places, by EXT_mesh_gpu_instancing."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from orusd_gltf.document import Document, Object
from orusd_gltf.hierarchy import steps_of, transform_of

Array = NDArray[np.float64]

EXTENSION: Final = "EXT_mesh_gpu_instancing"
_AT_REST: Final = {
    "translation": (0.0, 0.0, 0.0),
    "rotation": (0.0, 0.0, 0.0, 1.0),
    "scale": (1.0, 1.0, 1.0),
}


def gather_instances(document: Document) -> None:
    """Draw each mesh that several nodes show by one node; theirs stay, with their names.

    What is mirrored or sheared keeps a node of its own.
    """
    nodes = document.objects.get("nodes", [])
    groups: dict[int, list[tuple[int, Object]]] = {}
    for number, world in _worlds(document):
        steps = steps_of(world)
        if "mesh" in nodes[number] and len(steps) == 1 and np.linalg.det(world[:3, :3]) > 0:
            groups.setdefault(nodes[number]["mesh"], []).append((number, steps[0]))
    for mesh, found in sorted(groups.items()):
        if len(found) < 2:
            continue
        prims = [nodes[number]["extras"]["prim"] for number, _ in found]
        for number, _ in found:
            del nodes[number]["mesh"]
        attributes = {
            name.upper(): document.accessor(
                np.array([step.get(name, rest) for _, step in found], dtype=np.float32)
            )
            for name, rest in _AT_REST.items()
        }
        document.use(EXTENSION, required=True)
        node: Object = {
            "name": f"{document.objects['meshes'][mesh]['name']}_instances",
            "mesh": mesh,
            "extras": {"prims": prims},
            "extensions": {EXTENSION: {"attributes": attributes}},
        }
        document.roots.append(document.add("nodes", node))


def _worlds(document: Document) -> list[tuple[int, Array]]:
    """Every node and its place, in the order of their numbers."""
    nodes = document.objects.get("nodes", [])
    found: dict[int, Array] = {}
    todo = [(number, np.eye(4)) for number in document.roots]
    while todo:
        number, above = todo.pop()
        found[number] = above @ transform_of(nodes[number])
        todo += [(child, found[number]) for child in nodes[number].get("children", [])]
    return sorted(found.items(), key=lambda item: item[0])
