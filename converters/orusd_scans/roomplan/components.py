"""One component of RoomPlan's USDZ as the record that its JSON holds."""

import posixpath
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from pxr import Sdf

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from orusd_scans.records import Node, text
from orusd_scans.roomplan.curves import Arc, fitted_arc
from orusd_scans.roomplan.meshes import Hole, floor_outline, holes, is_flat, lowered, missing, span
from orusd_scans.roomplan.records import Record
from orusd_scans.roomplan.shapes import AGAIN, RoomPlanShape, shape_of

LISTS: Final = {
    "wall": "walls",
    "floor": "floors",
    "door": "doors",
    "window": "windows",
    "opening": "openings",
}
"""The JSON's lists of surfaces by their categories; all else is an object."""

# How a category with a state is written, and the JSON's names of what it says.
_STATED: Final = re.compile(r"(\w+)\s*\((.*)\)", re.DOTALL)
_DETAILS: Final = {"isopen": "isOpen"}
# A curved wall whose points lie over more than this of its radius has a front and a back, metres.
_MAX_ARC_SPREAD_M: Final = 0.05
# What single precision leaves of equal coordinates, metres.
_ROUNDING_M: Final = 1e-4
# Sides below this are nothing, metres.
_MIN_SIDE_M: Final = 1e-6


@dataclass(frozen=True, eq=False)
class Component:
    """A component as it was read.

    Attributes:
        folder: Of its layer: what is in one wall's folder is in that wall.
        record: What it is.
        holes: The holes in a wall.
    """

    folder: str
    record: Record
    holes: Sequence[Hole] = ()


def component(
    prim: Sdf.PrimSpec, place: str, *, name: str, layers: Mapping[str, Sdf.Layer]
) -> Component | None:
    """Read a component; None where the file has no shape of it.

    Args:
        prim: Its prim.
        place: What messages name.
        name: The path of its layer in the archive.
        layers: All layers of the archive by their paths.

    Raises:
        InputError: It holds nonsense; names the place.
    """
    category, details = _category(text(Node(prim.customData["Category"], Path(place))))
    identifier = text(Node(prim.customData.get("UUID", prim.name), Path(place)))
    shape = shape_of(prim, name, layers, place)
    if shape is None:
        return None
    folder = posixpath.dirname(name)
    if category == "floor" and shape.has_mesh:
        corners = floor_outline(shape.points, shape.faces)
        if corners is None:
            raise InputError("the floor's mesh is not a flat polygon", place=place, remedy=AGAIN)
        size = np.ptp(corners, axis=0)
        floor = Record(identifier, category, size, shape.source_from_local, corners=corners)
        return Component(folder, floor)
    if category == "wall" and shape.has_mesh:
        return Component(folder, *_wall(identifier, shape, place))
    details |= _of_model(category, shape.model)
    size, middle = _box(shape.points, category in LISTS)
    record = Record(identifier, category, size, _moved(shape, middle), details)
    return Component(folder, _checked(record, place))


def _category(written: str) -> tuple[str, dict[str, str]]:
    """The JSON's name of a category, and what is said of it in brackets."""
    stated = _STATED.fullmatch(written)
    name, rest = stated.groups() if stated else (written, "")
    pairs = (part.partition(":")[::2] for part in rest.split(",") if ":" in part)
    details = {_DETAILS.get(k.strip().casefold(), k.strip()): v.strip() for k, v in pairs}
    return name[:1].lower() + name[1:], details


def _of_model(category: str, model: str) -> dict[str, str]:
    """The attribute that a furniture model's name says: DiningChair_wBack is of type dining."""
    kind = model.partition("_")[0]
    word = category[:1].upper() + category[1:]
    said = kind.removesuffix(word)
    return {f"{word}Type": said[:1].lower() + said[1:]} if said else {}


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


def _wall(identifier: str, shape: RoomPlanShape, place: str) -> tuple[Record, list[Hole]]:
    """A wall that is a mesh, and its holes: flat, or a part of a cylinder."""
    ends = span(shape.points)
    x = shape.points[:, 0]
    own = shape.points[(x >= ends[0] - _ROUNDING_M) & (x <= ends[1] + _ROUNDING_M)]
    size, middle = _box(own, True)
    arc: Arc | None = None
    gaps: list[Hole] = []
    corners = np.empty((0, 3))
    if is_flat(shape.points):
        bottom, top = own[:, 1].min(), own[:, 1].max()
        parts = missing(shape.points, shape.faces, ends)
        gaps, corners = holes(parts, top), lowered(parts, ends, bottom, top) - middle
    else:
        middle[2] = 0.0
        arc = fitted_arc((_front(own) - middle)[:, [0, 2]])
    moved = _moved(shape, middle)
    record = Record(identifier, "wall", size, moved, corners=corners, arc=arc)
    right, up, _ = middle
    return _checked(record, place), [
        Hole(gap.left - right, gap.right - right, gap.bottom - up, gap.top - up) for gap in gaps
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


def _moved(shape: RoomPlanShape, middle: Array) -> Array:
    moved = shape.source_from_local.copy()
    moved[:3, 3] += moved[:3, :3] @ middle
    return moved


def _checked(record: Record, place: str) -> Record:
    if not (record.size[: 2 if record.category in LISTS else 3] > _MIN_SIDE_M).all():
        raise InputError("a dimension is zero", place=place, remedy=AGAIN)
    return record
