"""RoomPlan's USDZ as the same records that its JSON holds.

Each surface and object is a layer of its own, whose root prim carries ``Category`` and ``UUID`` as
custom data. The root layer refers to several of them from one prim, so that only one identifier
survives composition: the layers are read one by one. A door's state stands in its category
(``Door(Isopen: False)``), the wall of an opening in its path (``Walls/Wall3/Door0.usda``).
Passages are components of parametric exports, and holes in the walls of mesh exports. What the
USDZ does not say (confidence, attributes, stories) is unknown.
"""

import posixpath
import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray
from pxr import Sdf

from openrooms_usd.errors import InputError
from openrooms_usd.usd.diagnostics import reading
from orusd_scans.records.fields import text
from orusd_scans.records.jsonfile import Node
from orusd_scans.roomplan.archive import layers as archived
from orusd_scans.roomplan.curves import Arc, fitted_arc
from orusd_scans.roomplan.meshes import (
    Hole,
    floor_outline,
    holes,
    is_flat,
    lowered,
    middle_part,
    missing,
)
from orusd_scans.roomplan.records import CapturedRoom, Record, Section
from orusd_scans.roomplan.shapes import AGAIN, Shape, local, shape_of, walk

Array = NDArray[np.float64]
Read = TypeVar("Read")

_LISTS: Final = {
    "wall": "walls", "floor": "floors", "door": "doors", "window": "windows", "opening": "openings"
}  # fmt: skip
_IN_WALLS: Final = ("doors", "windows", "openings")
_SECTIONS: Final = "Section_grp"
# How a category with a state is written, and the JSON's names of what it says.
_STATED: Final = re.compile(r"(\w+)\s*\((.*)\)", re.DOTALL)
_DETAILS: Final = {"isopen": "isOpen"}
# A curved wall whose points lie over more than this of its radius has a front and a back, metres.
_MAX_ARC_SPREAD_M: Final = 0.05
# Sides below this are nothing, metres.
_MIN_SIDE_M: Final = 1e-6
# The part of a hole and of what fills it that are one, of both together.
_MIN_SAME_SHARE: Final = 0.3


@dataclass(frozen=True, eq=False)
class _Component:
    """A component as it was read.

    Attributes:
        folder: Of its layer: what is in one wall's folder is in that wall.
        record: What it is.
        holes: The holes in a wall.
    """

    folder: str
    record: Record
    holes: Sequence[Hole] = ()


def read_usdz(path: Path, notes: list[str]) -> CapturedRoom:
    """Read and check RoomPlan's USDZ, of any of its kinds: parametric, mesh or model.

    Args:
        path: The file.
        notes: Receives a sentence for what the USDZ does not say.

    Raises:
        InputError: It is missing, damaged or no such file, or holds nonsense; names the place.
    """
    layers = dict(archived(path))
    found: list[_Component] = []
    sections: list[Section] = []
    empty: list[str] = []
    for name, layer in layers.items():
        place = f"{path}[{name}]"
        with reading(place):
            prims = list(walk(layer.rootPrims, _is_component))
            if any(map(_is_component, prims)):
                _check_frame(layer, place)
            for prim in prims:
                where = f"{place}{prim.path}"
                if _is_component(prim):
                    one = _sound(partial(_component, name=name, layers=layers), prim, where)
                    found += [one] if one else []
                    empty += [] if one else [where]
                elif prim.nameParent and prim.nameParent.name == _SECTIONS:
                    sections.append(_sound(_section, prim, where))
    if not found:
        said = "this is USD, but no export of RoomPlan: no prim has a category"
        said, at = ("neither a cube nor a mesh is in it", empty[0]) if empty else (said, str(path))
        raise InputError(said, place=at, remedy=AGAIN)
    notes += [
        f"left out {where.rpartition('/')[2]}: the file has no shape of it" for where in empty
    ]
    room = CapturedRoom(**_lists(found), sections=tuple(sections))
    if any("isOpen" not in door.details for door in room.doors):
        notes.append("the USDZ does not say which doors stand open: they are closed")
    return room


def _lists(found: Sequence[_Component]) -> dict[str, tuple[Record, ...]]:
    """The records by the JSON's lists: with the walls that they are in, and with the passages."""
    lists: dict[str, list[Record]] = {name: [] for name in (*_LISTS.values(), "objects")}
    walls: defaultdict[str, list[_Component]] = defaultdict(list)
    for one in found:
        if one.record.category == "wall":
            walls[one.folder].append(one)
    fillings: defaultdict[str, list[Record]] = defaultdict(list)
    for one in found:
        key, own = _LISTS.get(one.record.category, "objects"), walls[one.folder]
        record = one.record
        if key in _IN_WALLS and len(own) == 1:
            record = replace(record, parent=own[0].record.id)
            fillings[record.parent or ""].append(record)
        lists[key].append(record)
    for one in (one for own in walls.values() for one in own):
        passages = _passages(one.record, one.holes, fillings[one.record.id])
        lists["openings"] += passages
    return {name: tuple(records) for name, records in lists.items()}


def _passages(wall: Record, gaps: Sequence[Hole], fillings: Sequence[Record]) -> Iterator[Record]:
    """The holes of a wall that no door and no window fills."""
    filled = [_rectangle(wall, record) for record in fillings]
    free = [gap for gap in gaps if all(_same_share(gap, one) < _MIN_SAME_SHARE for one in filled)]
    for number, gap in enumerate(free):
        matrix = wall.source_from_local.copy()
        middle = [0.5 * (gap.left + gap.right), 0.5 * (gap.bottom + gap.top), 0.0]
        matrix[:3, 3] += matrix[:3, :3] @ middle
        size = np.array([gap.right - gap.left, gap.top - gap.bottom, 0.0])
        yield Record(f"{wall.id} {number}", "opening", size, matrix, parent=wall.id)


def _rectangle(wall: Record, record: Record) -> Hole:
    """What an opening covers in its wall's x and y."""
    x, y, _ = (record.center - wall.center) @ wall.source_from_local[:3, :3]
    width, height = 0.5 * record.size[0], 0.5 * record.size[1]
    return Hole(x - width, x + width, y - height, y + height)


def _same_share(a: Hole, b: Hole) -> float:
    """The area that two rectangles share, of that which they cover together."""
    wide = min(a.right, b.right) - max(a.left, b.left)
    high = min(a.top, b.top) - max(a.bottom, b.bottom)
    common = max(wide, 0.0) * max(high, 0.0)
    areas = ((one.right - one.left) * (one.top - one.bottom) for one in (a, b))
    return common / (sum(areas) - common)


def _check_frame(layer: Sdf.Layer, place: str) -> None:
    info = layer.pseudoRoot
    up, unit = info.GetInfo("upAxis"), info.GetInfo("metersPerUnit")
    if info.HasInfo("upAxis") and up != "Y":
        raise InputError(f"the up axis is {up}: RoomPlan writes Y", place=place, remedy=AGAIN)
    if info.HasInfo("metersPerUnit") and unit != 1.0:
        said = f"the unit is {unit:g} m: RoomPlan writes metres"
        raise InputError(said, place=place, remedy=AGAIN)


def _is_component(prim: Sdf.PrimSpec) -> bool:
    return bool(prim.customData.get("Category"))


def _sound(read: Callable[[Sdf.PrimSpec, str], Read], prim: Sdf.PrimSpec, place: str) -> Read:
    try:
        return read(prim, place)
    except (TypeError, ValueError) as error:
        said = f"a value is of another type than RoomPlan writes: {error}"
        raise InputError(said, place=place, remedy=AGAIN) from error


def _component(
    prim: Sdf.PrimSpec, place: str, *, name: str, layers: Mapping[str, Sdf.Layer]
) -> _Component | None:
    category, details = _category(text(Node(prim.customData["Category"], Path(place))))
    identifier = text(Node(prim.customData.get("UUID", prim.name), Path(place)))
    shape = shape_of(prim, name, layers, place)
    if shape is None:
        return None
    folder = posixpath.dirname(name)
    if category == "floor" and shape.has_mesh:
        corners = floor_outline(shape.points, shape.faces)
        if corners is None:
            raise InputError("the floor's mesh is no flat polygon", place=place, remedy=AGAIN)
        size = np.ptp(corners, axis=0)
        floor = Record(identifier, category, size, shape.source_from_local, corners=corners)
        return _Component(folder, floor)
    if category == "wall" and shape.has_mesh:
        return _Component(folder, *_wall(identifier, shape, place))
    size, middle = _box(shape.points, category in _LISTS)
    record = Record(identifier, category, size, _moved(shape, middle), details)
    return _Component(folder, _checked(record, place))


def _category(written: str) -> tuple[str, dict[str, str]]:
    """The JSON's name of a category, and what is said of it in brackets."""
    stated = _STATED.fullmatch(written)
    name, rest = stated.groups() if stated else (written, "")
    pairs = (part.partition(":")[::2] for part in rest.split(",") if ":" in part)
    details = {_DETAILS.get(k.strip().casefold(), k.strip()): v.strip() for k, v in pairs}
    return name[:1].lower() + name[1:], details


def _box(points: Array, is_surface: bool) -> tuple[Array, Array]:
    """(3,) the sides of the box around points, and (3,) its middle.

    Surfaces are sheets at z = 0; what thickness they have is there to be seen, to one side. The
    frame of an object is in the middle of its box. The mesh export draws chairs up to another
    height, but its base is where it was captured.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    size, middle = high - low, 0.5 * (low + high)
    if is_surface:
        size[2] = 0.0
        middle[2] = np.clip(0.0, low[2], high[2])
    elif low[1] < 0.0 < high[1]:
        size[1], middle[1] = -2.0 * low[1], 0.0
    return size, middle


def _wall(identifier: str, shape: Shape, place: str) -> tuple[Record, list[Hole]]:
    """A wall that is a mesh, and its holes: flat, or a part of a cylinder."""
    half = middle_part(shape.points)
    if half <= 0.0:
        half = 0.5 * float(np.ptp(shape.points[:, 0]))
    own = shape.points[np.abs(shape.points[:, 0]) <= half + 1e-3]
    size, middle = _box(own, True)
    middle[0] = 0.0 if len(own) < len(shape.points) else middle[0]
    arc: Arc | None = None
    gaps: list[Hole] = []
    corners = np.empty((0, 3))
    if is_flat(shape.points):
        bottom, top = own[:, 1].min(), own[:, 1].max()
        parts = missing(shape.points, shape.faces, half)
        gaps, corners = holes(parts, top), lowered(parts, half, bottom, top) - middle
    else:
        middle[2] = 0.0
        arc = fitted_arc((_front(own) - middle)[:, [0, 2]])
    moved = _moved(shape, middle)
    record = Record(identifier, "wall", size, moved, corners=corners, arc=arc)
    x, y, _ = middle
    return _checked(record, place), [
        Hole(gap.left - x, gap.right - x, gap.bottom - y, gap.top - y) for gap in gaps
    ]


def _front(points: Array) -> Array:
    """The points of a curved wall that are not on the back of its thickness."""
    whole = fitted_arc(points[:, [0, 2]])
    if whole is None:
        return points
    radii = np.linalg.norm(points[:, [0, 2]] - whole.center, axis=1)
    if np.ptp(radii) < _MAX_ARC_SPREAD_M:
        return points
    # Walls are thick towards -z: their front is nearer to a centre that lies at +z of them.
    inner = radii < 0.5 * (radii.min() + radii.max())
    front = inner if whole.center[1] > points[:, 2].mean() else ~inner
    return np.asarray(points[front])


def _moved(shape: Shape, middle: Array) -> Array:
    moved = shape.source_from_local.copy()
    moved[:3, 3] += moved[:3, :3] @ middle
    return moved


def _checked(record: Record, place: str) -> Record:
    if not (record.size[: 2 if record.category in _LISTS else 3] > _MIN_SIDE_M).all():
        raise InputError("a dimension is zero", place=place, remedy=AGAIN)
    return record


def _section(prim: Sdf.PrimSpec, place: str) -> Section:
    label = re.sub(r"_?\d+$", "", prim.name)
    return Section(label or prim.name, local(prim, place)[:3, 3])
