"""Prims as nodes: the same names, below each other as in the stage, turned to Y up at the top."""

from typing import Final

import numpy as np
from pxr import Usd, UsdGeom

from openrooms_usd.arrays import Array
from openrooms_usd.usd.places.frames import TIME, Z_UP_FROM_Y_UP, local_to_world, world_from_stage
from orusd_gltf.document import Document, Object, numbers

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


# Cosine of the angle between two axes below which they count as square to each other.
_SQUARE_COS: Final = 1e-6
_IDENTITY: Final[Object] = {
    "translation": [0.0, 0.0, 0.0],
    "rotation": [0.0, 0.0, 0.0, 1.0],
    "scale": [1.0, 1.0, 1.0],
}


class Hierarchy:
    """Makes nodes for prims and for all that they are below, each once."""

    def __init__(self, stage: Usd.Stage, document: Document) -> None:
        self._stage = stage
        self._document = document
        self._cache = UsdGeom.XformCache(TIME)
        self._to_world = world_from_stage(stage)
        # Of each path its node and that node's place in the world. glTF's own world is Y up.
        self._nodes: dict[str, tuple[int | None, Array]] = {"": (None, Z_UP_FROM_Y_UP)}

    def node(self, path: str) -> int:
        """The node of a prim; of what a point instancer scatters by its path with brackets."""
        number, _ = self._placed(path)
        assert number is not None
        return number

    def child(self, path: str, name: str, world: Array) -> int:
        """A new node below that of a prim.

        Args:
            path: The prim's path.
            name: Of the new node.
            world: (4, 4) its place in the world, Z up and metres.
        """
        return self._added(*self._placed(path), name, world, {})[0]

    def place(self, path: str, world: Array) -> int:
        """The node of what stands at a place that only the caller knows."""
        if path not in self._nodes:
            parent, _, name = path.rpartition("/")
            said = {"extras": {"prim": path}}
            self._nodes[path] = self._added(*self._placed(parent), name, world, said)
        return self.node(path)

    def _placed(self, path: str) -> tuple[int | None, Array]:
        if path not in self._nodes:
            parent, _, name = path.rpartition("/")
            above = self._placed(parent)
            world = self._world(path, above[1])
            self._nodes[path] = self._added(*above, name, world, {"extras": {"prim": path}})
        return self._nodes[path]

    def _world(self, path: str, above: Array) -> Array:
        # What point instancers scatter has no prim there.
        prim = None if "[" in path else self._stage.GetPrimAtPath(path)
        if not prim or not prim.IsA(UsdGeom.Xformable):
            return above if path.count("/") > 1 else self._to_world
        return self._to_world @ local_to_world(prim, self._cache)

    def _added(
        self, parent: int | None, above: Array, name: str, world: Array, said: Object
    ) -> tuple[int, Array]:
        local = np.asarray(np.linalg.inv(above) @ world, dtype=np.float64)
        *outer, inner = steps_of(local)
        for step in outer:
            parent = self._append(parent, {"name": f"{name}_shear", **step})
        return self._append(parent, {"name": name, **inner, **said}), world

    def _append(self, parent: int | None, node: Object) -> int:
        number = self._document.add("nodes", node)
        if parent is None:
            self._document.roots.append(number)
        else:
            self._document.objects["nodes"][parent].setdefault("children", []).append(number)
        return number


def steps_of(local: Array) -> list[Object]:
    """A matrix as translation, rotation and scale; one that shears as two of them, in turn."""
    linear, moved = local[:3, :3], local[:3, 3]
    lengths = np.linalg.norm(linear, axis=0)
    units = linear / lengths
    cosines = units.T @ units - np.eye(3)
    if np.abs(cosines).max() < _SQUARE_COS:
        lengths[0] *= np.sign(np.linalg.det(units))
        return [_step(moved, linear / lengths, lengths)]
    left, stretch, right = np.linalg.svd(linear)
    # Both are made rotations; a mirror goes into the stretch.
    turns = np.linalg.det(left), np.linalg.det(right)
    left[:, 0] *= np.sign(turns[0])
    right[0] *= np.sign(turns[1])
    stretch[0] *= np.sign(turns[0] * turns[1])
    return [_step(moved, left, stretch), _step(np.zeros(3), right, np.ones(3))]


def transform_of(node: Object) -> Array:
    """(4, 4) what a node's translation, rotation and scale make together."""
    said = _IDENTITY | node
    x, y, z, w = said["rotation"]
    turn = np.eye(3) + 2.0 * np.array(
        [
            [-y * y - z * z, x * y - z * w, x * z + y * w],
            [x * y + z * w, -x * x - z * z, y * z - x * w],
            [x * z - y * w, y * z + x * w, -x * x - y * y],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = turn * said["scale"]
    matrix[:3, 3] = said["translation"]
    return matrix


def _step(moved: Array, rotation: Array, scale: Array) -> Object:
    said: Object = {
        "translation": numbers(moved),
        "rotation": numbers(quaternion(rotation)),
        "scale": numbers(scale),
    }
    return {name: value for name, value in said.items() if value != _IDENTITY[name]}


def quaternion(rotation: Array) -> Array:
    """(4,) x, y, z, w of a (3, 3) rotation."""
    # The largest of the four is found without a loss of digits.
    m = rotation
    trace = np.trace(m)
    squares = np.array([1 + 2 * m[i, i] - trace for i in range(3)] + [1 + trace])
    largest = int(squares.argmax())
    q = np.empty(4)
    if largest == 3:
        q[:3] = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]
        q[3] = squares[3]
    else:
        i, j, k = largest, (largest + 1) % 3, (largest + 2) % 3
        q[i], q[j], q[k], q[3] = (
            squares[i],
            m[j, i] + m[i, j],
            m[k, i] + m[i, k],
            m[k, j] - m[j, k],
        )
    q /= np.linalg.norm(q)
    # What is smaller is rounding; zeros are shorter.
    q[np.abs(q) < 1e-12] = 0.0
    return q if q[3] >= 0 else -q
