"""RoomPlan's parametric USDZ as the same records that its JSON holds.

Each surface and object is a layer of its own, whose root prim carries ``Category`` and ``UUID`` as
custom data and whose geometry is a unit cube, or a mesh where it is no box. The root layer refers
to several of them from one prim, so that only one identifier survives composition: the layers are
read one by one. What the USDZ does not say (confidence, attributes, stories, parents, whether a
door stands open) is unknown.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray
from pxr import Sdf

from openrooms_usd.errors import InputError
from openrooms_usd.usd.diagnostics import reading
from orusd_scans.records.fields import text
from orusd_scans.records.jsonfile import Node
from orusd_scans.roomplan.archive import layers
from orusd_scans.roomplan.curves import fitted_arc
from orusd_scans.roomplan.meshes import rim
from orusd_scans.roomplan.records import CapturedRoom, Record, Section, misplaced

Array = NDArray[np.float64]
Read = TypeVar("Read")

_LISTS: Final = {
    "wall": "walls", "floor": "floors", "door": "doors", "window": "windows", "opening": "openings"
}  # fmt: skip
_SECTIONS: Final = "Section_grp"
_MAX_COORDINATE_M: Final = 1e8  # coordinates, metres
# Walls whose meshes are deeper than this are curved, metres; flat ones have 0.1 to 0.5 mm.
_MAX_FLAT_WALL_M: Final = 0.02
_AGAIN: Final = "export the capture again, with RoomPlan's option parametric"


def read_usdz(path: Path, notes: list[str]) -> CapturedRoom:
    """Read and check RoomPlan's parametric USDZ.

    Args:
        path: The file.
        notes: Receives a sentence for what the USDZ does not say.

    Raises:
        InputError: It is missing, damaged or no such file, or holds nonsense; names the place.
    """
    lists: dict[str, list[Record]] = {name: [] for name in (*_LISTS.values(), "objects")}
    sections: list[Section] = []
    for name, layer in layers(path):
        place = f"{path}[{name}]"
        with reading(place):
            _check_frame(layer, place)
            for prim in _walk(layer.rootPrims, _is_component):
                if _is_component(prim):
                    record = _sound(_record, prim, f"{place}{prim.path}")
                    lists[_LISTS.get(record.category, "objects")].append(record)
                elif prim.nameParent and prim.nameParent.name == _SECTIONS:
                    sections.append(_sound(_section, prim, f"{place}{prim.path}"))
    if not any(lists.values()):
        text = "this is USD, but no parametric export of RoomPlan: no prim has a category"
        raise InputError(text, place=path, remedy=_AGAIN)
    if lists["doors"]:
        notes.append("a USDZ does not say which doors stand open: all are closed")
    return CapturedRoom(
        **{name: tuple(records) for name, records in lists.items()}, sections=tuple(sections)
    )


def _check_frame(layer: Sdf.Layer, place: str) -> None:
    info = layer.pseudoRoot
    up, unit = info.GetInfo("upAxis"), info.GetInfo("metersPerUnit")
    if info.HasInfo("upAxis") and up != "Y":
        raise InputError(f"the up axis is {up}: RoomPlan writes Y", place=place, remedy=_AGAIN)
    if info.HasInfo("metersPerUnit") and unit != 1.0:
        text = f"the unit is {unit:g} m: RoomPlan writes metres"
        raise InputError(text, place=place, remedy=_AGAIN)


def _is_component(prim: Sdf.PrimSpec) -> bool:
    return bool(prim.customData.get("Category"))


def _walk(
    prims: Iterable[Sdf.PrimSpec], ends: Callable[[Sdf.PrimSpec], bool] = lambda prim: False
) -> Iterator[Sdf.PrimSpec]:
    """Prims and what is below them, parents first; nothing below those where it ends."""
    rest = list(prims)[::-1]
    while rest:
        prim = rest.pop()
        yield prim
        if not ends(prim):
            rest += list(prim.nameChildren)[::-1]


def _sound(read: Callable[[Sdf.PrimSpec, str], Read], prim: Sdf.PrimSpec, place: str) -> Read:
    try:
        return read(prim, place)
    except (TypeError, ValueError) as error:
        text = f"a value is of another type than RoomPlan writes: {error}"
        raise InputError(text, place=place, remedy=_AGAIN) from error


def _record(prim: Sdf.PrimSpec, place: str) -> Record:
    category = text(Node(prim.customData["Category"], Path(place)))
    category = category[:1].lower() + category[1:]
    geometry = next((p for p in _walk([prim]) if p.typeName in ("Cube", "Mesh")), None)
    if geometry is None:
        raise InputError("neither a cube nor a mesh is in it", place=place, remedy=_AGAIN)
    matrix, scales = _frame(geometry, place)
    identifier = text(Node(prim.customData.get("UUID", prim.name), Path(place)))
    if geometry.typeName == "Cube":
        side = float(_value(geometry, "size", 2.0))
        return _checked(Record(identifier, category, side * scales, matrix), place)
    points = _array(geometry, "points", place).reshape(-1, 3) * scales
    return _checked(_from_mesh(identifier, category, matrix, points, geometry, place), place)


def _from_mesh(
    identifier: str, category: str, matrix: Array, points: Array, mesh: Sdf.PrimSpec, place: str
) -> Record:
    low, high = points.min(axis=0), points.max(axis=0)
    if category == "floor":
        faces = [_array(mesh, key, place) for key in ("faceVertexCounts", "faceVertexIndices")]
        corners = rim(points, *(face.astype(np.int64) for face in faces))
        if corners is None:
            raise InputError("the floor's mesh is no flat polygon", place=place, remedy=_AGAIN)
        return Record(identifier, category, high - low, matrix, corners=corners)
    is_curved = category == "wall" and high[2] - low[2] > _MAX_FLAT_WALL_M
    middle = 0.5 * (low + high) * ([1.0, 1.0, 0.0] if is_curved else 1.0)
    moved = matrix.copy()
    moved[:3, 3] += matrix[:3, :3] @ middle
    arc = fitted_arc((points - middle)[:, [0, 2]]) if is_curved else None
    return Record(identifier, category, high - low, moved, arc=arc)


def _checked(record: Record, place: str) -> Record:
    is_surface = record.category in _LISTS
    if not len(record.corners) and not record.size[: 2 if is_surface else 3].all():
        raise InputError("a dimension is zero", place=place, remedy=_AGAIN)
    if is_surface:
        record.size[2] = 0.0  # sheets have a thickness here, to be seen
    return record


def _frame(prim: Sdf.PrimSpec, place: str) -> tuple[Array, Array]:
    """(4, 4) the rotation and translation of a prim for column vectors, and (3,) its scales."""
    matrix = np.eye(4)
    ancestor = prim
    while ancestor and ancestor.path != Sdf.Path.absoluteRootPath:
        matrix = _local(ancestor, place) @ matrix
        ancestor = ancestor.nameParent
    scales = np.linalg.norm(matrix[:3, :3], axis=0)
    if not scales.all():
        raise InputError("a dimension is zero", place=place, remedy=_AGAIN)
    rigid = matrix.copy()
    rigid[:3, :3] /= scales
    if text := misplaced(rigid):
        raise InputError(text, place=place, remedy=_AGAIN)
    return rigid, scales


def _local(prim: Sdf.PrimSpec, place: str) -> Array:
    """(4, 4) a prim's own transform for column vectors."""
    matrix = np.eye(4)
    for name in _value(prim, "xformOpOrder", ()):
        value = np.array(_value(prim, name, ()), dtype=np.float64)
        if not (np.abs(value) <= _MAX_COORDINATE_M).all():
            raise InputError(f"a number in {name} is out of range", place=place, remedy=_AGAIN)
        if name == "xformOp:transform" and value.shape == (4, 4):
            matrix = matrix @ value.T
        elif name == "xformOp:scale" and value.shape == (3,):
            matrix = matrix @ np.diag([*value, 1.0])
        elif name == "xformOp:translate" and value.shape == (3,):
            shift = np.eye(4)
            shift[:3, 3] = value
            matrix = matrix @ shift
        else:
            text = f"{name} is no transform that RoomPlan writes"
            raise InputError(text, place=place, remedy=_AGAIN)
    return matrix


def _value(prim: Sdf.PrimSpec, name: str, default: Any) -> Any:
    found = prim.attributes.get(name)
    return default if found is None or found.default is None else found.default


def _array(prim: Sdf.PrimSpec, name: str, place: str) -> Array:
    values = np.array(_value(prim, name, ()), dtype=np.float64)
    if not values.size or not np.isfinite(values).all() or np.abs(values).max() > _MAX_COORDINATE_M:
        raise InputError(f"the mesh has no sound {name}", place=place, remedy=_AGAIN)
    return values


def _section(prim: Sdf.PrimSpec, place: str) -> Section:
    label = re.sub(r"_?\d+$", "", prim.name)
    return Section(label or prim.name, _local(prim, place)[:3, 3])
