"""RoomPlan's USDZ as the same records that its JSON holds.

Each surface and object is a layer of its own, whose root prim carries ``Category`` and ``UUID`` as
custom data. The root layer refers to several of them from one prim, so that only one identifier
survives composition: the layers are read one by one. A door's state stands in its category
(``Door(Isopen: False)``), the wall of an opening in its path (``Walls/Wall3/Door0.usda``).
Passages are components of parametric exports, and holes in the walls of mesh exports. What the
USDZ does not say (confidence, stories, most attributes) is unknown.
"""

import io
import re
import zipfile
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Final, TypeVar

import numpy as np
from pxr import Sdf, Tf

from openrooms_usd.errors import InputError
from openrooms_usd.scratch import scratch_folder
from openrooms_usd.unpickling.archives import opened_archive
from openrooms_usd.usd.files.crate_reader import check_crate, check_crate_reads
from openrooms_usd.usd.files.diagnostics import quiet, reading, reason
from openrooms_usd.usd.files.preflight import check_text
from orusd_scans.roomplan.components import LISTS, Component, component
from orusd_scans.roomplan.meshes import Hole
from orusd_scans.roomplan.records import CapturedRoom, Record, Section
from orusd_scans.roomplan.shapes import AGAIN, local, walk

Read = TypeVar("Read")

_IN_WALLS: Final = ("doors", "windows", "openings")
_SECTIONS: Final = "Section_grp"
# The part of a hole and of what fills it that are one, of both together.
_MIN_SAME_SHARE: Final = 0.3
_LAYERS: Final = (".usda", ".usdc", ".usd")
# Of all layers together; a capture of a large flat is below 2 MB.
_MOST_BYTES: Final = 64 << 20
_AGAIN: Final = "export the capture again"


def read_usdz(path: Path, notes: list[str]) -> CapturedRoom:
    """Read and check RoomPlan's USDZ, of any of its kinds: parametric, mesh or model.

    Args:
        path: The file.
        notes: Receives a sentence for what the USDZ does not say.

    Raises:
        InputError: It is missing, damaged or no such file, or holds nonsense; names the place.
    """
    layers = dict(archived(path))
    found: list[Component] = []
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
                    one = _sound(partial(component, name=name, layers=layers), prim, where)
                    found += [one] if one else []
                    empty += [] if one else [where]
                elif prim.nameParent and prim.nameParent.name == _SECTIONS:
                    sections.append(_sound(_section, prim, where))
    if not found:
        said = "this is USD, but not an export of RoomPlan: no prim has a category"
        said, at = ("neither a cube nor a mesh is in it", empty[0]) if empty else (said, str(path))
        raise InputError(said, place=at, remedy=AGAIN)
    notes += [
        f"left out {where.rpartition('/')[2]}: the file has no shape of it" for where in empty
    ]
    room = CapturedRoom(**_lists(found), sections=tuple(sections))
    if any("isOpen" not in door.details for door in room.doors):
        notes.append("the USDZ does not record which doors are open: they are closed")
    return room


def _lists(found: Sequence[Component]) -> dict[str, tuple[Record, ...]]:
    """The records by the JSON's lists: with the walls that they are in, and with the passages."""
    lists: dict[str, list[Record]] = {name: [] for name in (*LISTS.values(), "objects")}
    walls: defaultdict[str, list[Component]] = defaultdict(list)
    for one in found:
        if one.record.category == "wall":
            walls[one.folder].append(one)
    fillings: defaultdict[str, list[Record]] = defaultdict(list)
    for one in found:
        key, own = LISTS.get(one.record.category, "objects"), walls[one.folder]
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


def _section(prim: Sdf.PrimSpec, place: str) -> Section:
    label = re.sub(r"_?\d+$", "", prim.name)
    return Section(label or prim.name, local(prim, place)[:3, 3])


def archived(path: Path) -> Iterator[tuple[str, Sdf.Layer]]:
    """The layers of a USDZ in its order; nothing that they refer to is opened.

    Args:
        path: The file.

    Yields:
        The layer's path in the archive and the layer.

    Raises:
        InputError: The file is missing, is damaged, encrypted or too large, or has no layers.
    """
    with opened_archive(path, "archive", remedy=_AGAIN) as archive:
        for info in _checked(path, archive):
            yield info.filename, _layer(path, info.filename, archive.read(info))


def _checked(path: Path, archive: zipfile.ZipFile) -> list[zipfile.ZipInfo]:
    """The layers in an archive that may be unpacked."""
    found = [
        info
        for info in archive.infolist()
        if PurePosixPath(info.filename).suffix.lower() in _LAYERS
    ]
    size = sum(info.file_size for info in found)
    if size > _MOST_BYTES:
        text = f"{size / 2**20:.0f} MB of layers are too much for a capture"
        raise InputError(f"{text} (at most {_MOST_BYTES >> 20} MB)", place=path, remedy=_AGAIN)
    if not found:
        raise InputError("the archive has no USD layers", place=path, remedy=_AGAIN)
    return found


def _layer(path: Path, name: str, data: bytes) -> Sdf.Layer:
    place = f"{path}[{name}]"
    try:
        with quiet():
            return _text(data, place) if data.startswith(b"#") else _binary(data, place)
    except Tf.ErrorException as error:
        text = f"not readable as USD: {reason(error)}"
        raise InputError(text, place=place, remedy=_AGAIN) from error


def _text(data: bytes, place: str) -> Sdf.Layer:
    check_text(data, place)
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(data.decode())
    return layer


def _binary(data: bytes, place: str) -> Sdf.Layer:
    """A crate, which USD reads from files only."""
    check_crate(io.BytesIO(data), len(data), place)
    with scratch_folder() as folder:
        file = folder / "layer.usdc"
        file.write_bytes(data)
        check_crate_reads(str(file), len(data), place)
        layer = Sdf.Layer.CreateAnonymous(".usdc")
        layer.Import(str(file))
        return layer
