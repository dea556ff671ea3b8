"""The records of an Apple RoomPlan export, checked one by one.

A file holds a CapturedRoom or, of several rooms that were scanned in one go, a CapturedStructure.
Field names and layouts are those of the exports of iOS 16 to 18; what iOS 16 does not write
(floors, corners, sections, stories, parents, attributes) is optional. Transforms are column-major
4x4, Y up, metres. A surface's local x runs along its length, y up, z along its normal; an object's
local x is its width, y its height and z points out of its front.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.capture import Confidence
from orusd_scans.records import Node, read_json, text
from orusd_scans.roomplan.curves import Arc, read_curve

_MAX_COORDINATE_M: Final = 1e8  # coordinates, metres: any map projection stays below
_MAX_DIMENSION_M: Final = 1e3  # dimensions, metres
# Single precision leaves that much of a rotation's columns.
_ROTATION_TOLERANCE: Final = 1e-2
_SURFACES: Final = ("walls", "floors", "doors", "windows", "openings")
_CONFIDENCES: Final[tuple[Confidence, ...]] = ("low", "medium", "high")


@dataclass(frozen=True, eq=False)
class Record:
    """A surface or an object.

    Attributes:
        id: Its identifier, or its place in the file where it has none.
        category: Such as wall, door or chair.
        details: What the category and the attributes say besides.
        size: (3,) along the local axes, metres.
        source_from_local: (4, 4) for column vectors, in the source's frame.
        corners: (N, 3) corners in its local frame; none for rectangles.
        confidence: How sure the source is.
        arc: The plan of a surface that is a part of a cylinder.
        parent: The identifier of the wall that an opening is in.
        story: The number of its story.
    """

    id: str
    category: str
    size: Array
    source_from_local: Array
    details: Mapping[str, str] = field(default_factory=dict)
    corners: Array = field(default_factory=lambda: np.empty((0, 3)))
    confidence: Confidence | None = None
    arc: Arc | None = None
    parent: str | None = None
    story: int | None = None

    @property
    def center(self) -> Array:
        """(3,) its middle in the source's frame."""
        return self.source_from_local[:3, 3]


@dataclass(frozen=True, eq=False)
class Section:
    """A part of the plan with a use.

    Attributes:
        label: Such as livingRoom; ``unidentified`` where the source does not know.
        center: (3,) a point of it in the source's frame.
        story: The number of its story.
    """

    label: str
    center: Array
    story: int | None = None


@dataclass(frozen=True)
class CapturedRoom:
    """The records of one scan."""

    walls: tuple[Record, ...]
    floors: tuple[Record, ...]
    doors: tuple[Record, ...]
    windows: tuple[Record, ...]
    openings: tuple[Record, ...]
    objects: tuple[Record, ...]
    sections: tuple[Section, ...] = ()


def read_captured_rooms(path: Path, notes: list[str]) -> list[CapturedRoom]:
    """Read and check a RoomPlan export.

    Args:
        path: The JSON file.
        notes: Receives a sentence for what was guessed.

    Returns:
        The scanned rooms: one, or those of a structure.

    Raises:
        InputError: It is missing, is not such a file, or holds nonsense; names the place.
    """
    root = read_json(path)
    keys = root.value.keys() if isinstance(root.value, dict) else set()
    rooms = root.items("rooms") if "rooms" in keys else []
    if not rooms and not {"walls", "floors"} & keys:
        raise root.error(
            "this is JSON, but not a RoomPlan export: it has neither walls nor floors",
            "give the CapturedRoom or CapturedStructure that the app exported as JSON",
        )
    # What a structure says of all rooms together is in its rooms, too.
    return [_room(node, notes) for node in rooms or [root]]


def _room(node: Node, notes: list[str]) -> CapturedRoom:
    lists = {
        name: tuple(_record(item, name[:-1], name in _SURFACES, notes) for item in node.items(name))
        for name in (*_SURFACES, "objects")
    }
    sections = tuple(_section(item) for item in node.items("sections") if item.get("center"))
    return CapturedRoom(**lists, sections=sections)


def _record(node: Node, kind: str, is_surface: bool, notes: list[str]) -> Record:
    identifier, parent = node.get("identifier"), node.get("parentIdentifier")
    category, details = _category(node, kind)
    corners, curve = _corners(node), node.get("curve")
    return Record(
        id=text(identifier) if identifier else f"{kind} {node.path}",
        category=category,
        size=_size(node.need("dimensions"), 2 if is_surface else 3, bool(len(corners))),
        source_from_local=_transform(node.need("transform")),
        details=details,
        corners=corners,
        confidence=_confidence(node),
        arc=read_curve(curve, notes) if curve and kind == "wall" else None,
        parent=text(parent) if parent else None,
        story=_story(node),
    )


def _size(node: Node, count: int, has_corners: bool) -> Array:
    """Dimensions, the first of which must be there, unless corners say the same."""
    dimensions = node.numbers(3, _MAX_DIMENSION_M)
    if (dimensions < 0.0).any():
        raise node.error("a dimension is negative")
    if not has_corners and not dimensions[:count].all():
        raise node.error("a dimension is zero")
    return dimensions


def _section(node: Node) -> Section:
    label = node.get("label")
    name = (_key(label) if label else None) or "unidentified"
    return Section(name, node.need("center").numbers(3, _MAX_COORDINATE_M), _story(node))


def _story(node: Node) -> int | None:
    found = node.get("story")
    return int(found.numbers(1, 1e6)[0]) if found else None


def _category(node: Node, kind: str) -> tuple[str, dict[str, str]]:
    """The name of the category, written ``{"door": {"isOpen": true}}`` or ``"door"``."""
    found, attributes = node.get("category"), node.get("attributes")
    name, details = kind, {}
    if found is not None:
        name = _key(found) or kind
        inner = found.value.get(name) if isinstance(found.value, dict) else None
        details = dict(inner) if isinstance(inner, dict) else {}
    if attributes is not None and isinstance(attributes.value, dict):
        details |= attributes.value
    return name, {str(key): str(value) for key, value in details.items()}


def _key(node: Node) -> str | None:
    """The only key of an object that stands for an enumeration, or a plain text."""
    if isinstance(node.value, str):
        return text(node)
    if isinstance(node.value, dict):
        return next((text(Node(key, node.file, node.path)) for key in node.value), None)
    raise node.error("a name or an object with one key expected")


def _confidence(node: Node) -> Confidence | None:
    found = node.get("confidence")
    name = _key(found) if found else None
    return next((level for level in _CONFIDENCES if level == name), None)


def _transform(node: Node) -> Array:
    matrix = node.numbers(16, _MAX_COORDINATE_M).reshape(4, 4).T
    if reason := misplaced(matrix):
        raise node.error(reason)
    return matrix


def misplaced(matrix: Array) -> str | None:
    """Say why a matrix is not a rotation with a translation.

    Args:
        matrix: (4, 4) for column vectors.

    Returns:
        A sentence, or None when it is one.
    """
    if np.abs(matrix[3] - [0.0, 0.0, 0.0, 1.0]).max() > 1e-6:
        if not matrix[:3, 3].any() and abs(matrix[3, 3] - 1.0) < 1e-6:
            return "the transform is written row by row: RoomPlan writes it column by column"
        return "the transform's last row is not 0 0 0 1"
    scales = np.linalg.norm(matrix[:3, :3], axis=0)
    if np.abs(scales - 1.0).max() > _ROTATION_TOLERANCE:
        by = ", ".join(f"{scale:.3g}" for scale in scales)
        return f"the transform scales the axes by {by}: sizes belong to the dimensions"
    if np.abs(matrix[:3, :3].T @ matrix[:3, :3] - np.eye(3)).max() > _ROTATION_TOLERANCE:
        return "the transform shears: its axes are not at right angles"
    if np.linalg.det(matrix[:3, :3]) < 0.0:
        return "the transform is left-handed: it mirrors what it places"
    return None


def _corners(node: Node) -> Array:
    rows = [corner.numbers(3, _MAX_COORDINATE_M) for corner in node.items("polygonCorners")]
    return np.array(rows).reshape(-1, 3)
