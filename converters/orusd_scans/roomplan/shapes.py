"""The geometry of one component of RoomPlan's USDZ: its own frame, and its points in it.

Parametric exports have a unit cube with a scale, mesh exports a mesh, model exports a furniture
model of another layer, fitted to its box by a scale. The frame is that of the first prim that is
placed: it is the transform that the JSON holds.
"""

import posixpath
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any, Final

import numpy as np
from pxr import Sdf

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from orusd_scans.roomplan.meshes import Faces, split
from orusd_scans.roomplan.records import misplaced

AGAIN: Final = "export the capture again, with RoomPlan's option parametric"

_MAX_COORDINATE_M: Final = 1e8  # coordinates, metres
# Models lie one layer deep.
_MAX_DEPTH: Final = 3
_CORNERS: Final = np.array(list(product((-0.5, 0.5), repeat=3)))


@dataclass(frozen=True, eq=False)
class RoomPlanShape:
    """What a component looks like.

    Attributes:
        source_from_local: (4, 4) its frame in the source's, for column vectors.
        points: (N, 3) in its frame, metres.
        faces: The faces of its meshes.
        has_mesh: Whether any of it is a mesh.
        model: The name of the furniture model that it refers to; empty without one.
    """

    source_from_local: Array
    points: Array
    faces: Faces
    has_mesh: bool
    model: str = ""


def shape_of(
    prim: Sdf.PrimSpec, name: str, layers: Mapping[str, Sdf.Layer], place: str
) -> RoomPlanShape | None:
    """The geometry of a component; None where there is none.

    Args:
        prim: Its prim.
        name: The path of its layer in the archive.
        layers: All layers of the archive by their paths.
        place: What messages name.

    Raises:
        InputError: It holds nonsense; names the place.
    """
    frame = _frame(prim, place)
    local_from_source = np.linalg.inv(frame)
    points, faces, count, has_mesh = [], [], 0, False
    for geometry, matrix in _geometry(prim, np.eye(4), name, layers, place, 0):
        is_mesh = geometry.typeName == "Mesh"
        own = _points(geometry, place) if is_mesh else _CORNERS * value(geometry, "size", 2.0)
        to_frame = local_from_source @ matrix
        points.append(own @ to_frame[:3, :3].T + to_frame[:3, 3])
        faces += [face + count for face in (_faces(geometry, len(own), place) if is_mesh else [])]
        has_mesh |= is_mesh
        count += len(own)
    if not points:
        return None
    models = [asset for below in walk([prim]) for asset in _assets(below)]
    model = posixpath.basename(models[0]).partition(".")[0] if models else ""
    return RoomPlanShape(frame, np.concatenate(points), faces, has_mesh, model)


def walk(
    prims: Iterable[Sdf.PrimSpec], ends: Callable[[Sdf.PrimSpec], bool] = lambda prim: False
) -> Iterator[Sdf.PrimSpec]:
    """Prims and what is below them, parents first; nothing below those where it ends."""
    rest = list(prims)[::-1]
    while rest:
        prim = rest.pop()
        yield prim
        if not ends(prim):
            rest += list(prim.nameChildren)[::-1]


def _geometry(
    prim: Sdf.PrimSpec,
    above: Array,
    name: str,
    layers: Mapping[str, Sdf.Layer],
    place: str,
    depth: int,
) -> Iterator[tuple[Sdf.PrimSpec, Array]]:
    """All cubes and meshes at and below a prim, each with (4, 4) from its frame to the source's."""
    rest = [(prim, above)]
    while rest:
        one, matrix = rest.pop()
        matrix = matrix @ local(one, place)
        if one.typeName in ("Cube", "Mesh"):
            yield one, matrix
        for asset in _assets(one):
            path = posixpath.normpath(posixpath.join(posixpath.dirname(name), asset))
            layer = layers.get(path)
            if layer is not None and depth < _MAX_DEPTH:
                for root in layer.rootPrims:
                    yield from _geometry(root, matrix, path, layers, place, depth + 1)
        rest += [(child, matrix) for child in reversed(list(one.nameChildren))]


def _assets(prim: Sdf.PrimSpec) -> list[str]:
    found = (
        *prim.referenceList.GetAddedOrExplicitItems(),
        *prim.payloadList.GetAddedOrExplicitItems(),
    )
    return [item.assetPath for item in found if item.assetPath]


def _frame(prim: Sdf.PrimSpec, place: str) -> Array:
    """(4, 4) the rotation and translation of the first prim that is placed."""
    first = next((p for p in walk([prim]) if value(p, "xformOpOrder", ())), prim)
    matrix, one = np.eye(4), first
    while one and one.path != Sdf.Path.absoluteRootPath:
        matrix = local(one, place) @ matrix
        one = one.nameParent
    scales = np.linalg.norm(matrix[:3, :3], axis=0)
    if not scales.all():
        raise InputError("a dimension is zero", place=place, remedy=AGAIN)
    matrix[:3, :3] /= scales
    if text := misplaced(matrix):
        raise InputError(text, place=place, remedy=AGAIN)
    return matrix


def local(prim: Sdf.PrimSpec, place: str) -> Array:
    """(4, 4) a prim's own transform for column vectors.

    Raises:
        InputError: It has operations that RoomPlan does not write, or absurd numbers.
    """
    matrix = np.eye(4)
    for name in value(prim, "xformOpOrder", ()):
        given = np.array(value(prim, name, ()), dtype=np.float64)
        if not (np.abs(given) <= _MAX_COORDINATE_M).all():
            raise InputError(f"a number in {name} is out of range", place=place, remedy=AGAIN)
        if name == "xformOp:transform" and given.shape == (4, 4):
            matrix = matrix @ given.T
        elif name == "xformOp:scale" and given.shape == (3,):
            matrix = matrix @ np.diag([*given, 1.0])
        elif name == "xformOp:translate" and given.shape == (3,):
            shift = np.eye(4)
            shift[:3, 3] = given
            matrix = matrix @ shift
        else:
            text = f"{name} is not a transform that RoomPlan writes"
            raise InputError(text, place=place, remedy=AGAIN)
    return matrix


def value(prim: Sdf.PrimSpec, name: str, default: Any) -> Any:
    """An attribute's default value, or another where it has none."""
    found = prim.attributes.get(name)
    return default if found is None or found.default is None else found.default


def _points(mesh: Sdf.PrimSpec, place: str) -> Array:
    return _array(mesh, "points", place).reshape(-1, 3)


def _faces(mesh: Sdf.PrimSpec, count: int, place: str) -> Faces:
    if not value(mesh, "faceVertexCounts", ()):
        return []
    keys = ("faceVertexCounts", "faceVertexIndices")
    counts, indices = (_array(mesh, key, place).astype(np.int64) for key in keys)
    return split(counts, indices, count) or []


def _array(prim: Sdf.PrimSpec, name: str, place: str) -> Array:
    values = np.array(value(prim, name, ()), dtype=np.float64)
    if not values.size or not np.isfinite(values).all() or np.abs(values).max() > _MAX_COORDINATE_M:
        raise InputError(f"the mesh has no valid {name}", place=place, remedy=AGAIN)
    return values
