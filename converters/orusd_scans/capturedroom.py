"""The records of an Apple RoomPlan export (CapturedRoom as JSON), checked one by one.

Field names and layouts are those of the exports of iOS 16 to 18; what iOS 16 does not write is
optional. Transforms are column-major 4x4, Y up, metres. A surface's local x runs along its length,
y up, z along its normal; an object's local x is its width, y its height and z points out of its
front.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.capture import Confidence
from orusd_scans.jsonfile import Node, read_json

Array = NDArray[np.float64]

_FARTHEST: Final = 1e8  # coordinates, metres: any map projection stays below
_LARGEST: Final = 1e3  # dimensions, metres
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
        curved: Whether the surface is a part of a cylinder.
    """

    id: str
    category: str
    size: Array
    source_from_local: Array
    details: Mapping[str, str] = field(default_factory=dict)
    corners: Array = field(default_factory=lambda: np.empty((0, 3)))
    confidence: Confidence | None = None
    curved: bool = False

    @property
    def center(self) -> Array:
        """(3,) its middle in the source's frame."""
        return self.source_from_local[:3, 3]


@dataclass(frozen=True)
class CapturedRoom:
    """All records of a file."""

    walls: tuple[Record, ...]
    floors: tuple[Record, ...]
    doors: tuple[Record, ...]
    windows: tuple[Record, ...]
    openings: tuple[Record, ...]
    objects: tuple[Record, ...]


def read_captured_room(path: Path) -> CapturedRoom:
    """Read and check a RoomPlan export.

    Args:
        path: The JSON file.

    Raises:
        InputError: It is missing, is not such a file, or holds nonsense; names the place.
    """
    root = read_json(path)
    if not isinstance(root.value, dict) or not ({"walls", "floors"} & root.value.keys()):
        raise root.error(
            "this is JSON, but no RoomPlan export: it has neither walls nor floors",
            "give the CapturedRoom that the app exported as JSON",
        )
    lists = ("walls", "floors", "doors", "windows", "openings", "objects")
    return CapturedRoom(
        **{name: tuple(_record(item, name[:-1]) for item in root.items(name)) for name in lists}
    )


def _record(node: Node, kind: str) -> Record:
    identifier, size = node.get("identifier"), node.need("dimensions")
    category, details = _category(node, kind)
    dimensions = size.numbers(3, _LARGEST)
    if (dimensions < 0.0).any():
        raise size.error("a dimension is negative")
    return Record(
        id=str(identifier.value) if identifier else f"{kind} {node.path}",
        category=category,
        size=dimensions,
        source_from_local=_transform(node.need("transform")),
        details=details,
        corners=_corners(node),
        confidence=_confidence(node),
        curved=node.get("curve") is not None,
    )


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
        return node.value
    if isinstance(node.value, dict):
        return next(iter(node.value), None)
    raise node.error("a name or an object with one key expected")


def _confidence(node: Node) -> Confidence | None:
    found = node.get("confidence")
    name = _key(found) if found else None
    return next((level for level in _CONFIDENCES if level == name), None)


def _transform(node: Node) -> Array:
    matrix = node.numbers(16, _FARTHEST).reshape(4, 4).T
    rotation = matrix[:3, :3]
    rigid = np.abs(rotation.T @ rotation - np.eye(3)).max() < 1e-2 and np.linalg.det(rotation) > 0.0
    if not rigid or np.abs(matrix[3] - [0.0, 0.0, 0.0, 1.0]).max() > 1e-6:
        raise node.error("not a rotation with a translation (16 numbers, column by column)")
    return matrix


def _corners(node: Node) -> Array:
    rows = [corner.numbers(3, _FARTHEST) for corner in node.items("polygonCorners")]
    return np.array(rows).reshape(-1, 3)
