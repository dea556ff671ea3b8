"""A plain list of boxes, as CSV or JSON, becomes a Capture.

CSV has a header with the columns id, label, x, y, z, width, depth, height and yaw (degrees,
counter-clockwise from above; at 0 the front looks along -y, in a source with Y up along +z). The
vertical column says what it is: ``z`` the base of the box, ``cz`` its middle (``y`` and ``cy`` with
Y up). A column ``unit`` or the option gives the unit of the lengths.

JSON is a list of objects ``{"id", "label", "center", "size", "yaw"}``, or with ``rotation`` in
place of ``yaw`` (3x3, its columns the box's width, depth and height). Or it is an object that holds
this list as ``objects`` beside ``floor``, ``level``, ``height``, ``openings``, ``unit``, ``up`` and
``frames``.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, get_args

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.capture import NO_OPTIONS, Capture, CapturedBox, CapturedFrame, Packed
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.rotations import about_z
from orusd_scans.frames import frames_of, in_world, read_frames
from orusd_scans.plan import (
    MAX_SIDE,
    DrawnPlan,
    Up,
    floor_in,
    height_of,
    level_of,
    openings_in,
    plan_of,
    read_plan,
)
from orusd_scans.records import (
    Node,
    choice,
    identifiers,
    number,
    positive,
    read_json,
    read_table,
    text,
)
from orusd_scans.worldframe import MAX_COORDINATE_M, Z_UP, WorldFrame, proper

UNITS: Final = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
# Boxes farther than this from the source's origin get an origin of their own, metres.
_FAR_FROM_ORIGIN_M: Final = 1000.0
# Margin of the floor around the objects of a list without one, metres.
_FLOOR_MARGIN_M: Final = 0.5
# Least side of a box, metres.
_MIN_SIDE_M: Final = 1e-3
# Smaller tilts of boxes are noise, degrees.
_MAX_NOISE_LEAN_DEG: Final = 3.0


@dataclass(frozen=True, eq=False)
class _List:
    """A parsed file whose numbers are not yet interpreted.

    Attributes:
        boxes: The records of the boxes.
        top: The record of what all share, such as the floor.
        up: The up axis.
        unit: Metres for one unit.
    """

    boxes: Sequence[Node]
    top: Node
    up: Up
    unit: float


class BoxesImporter:
    """Reads labelled boxes: CSV with a header, or JSON."""

    options: Mapping[str, str] = {
        "up": "The source's up axis: Y or Z (default Z).",
        "unit": f"The unit of all lengths: {', '.join(UNITS)} (default m).",
        "polygon": "A file with the corners of the floor: CSV or JSON.",
        "frames": "A JSON file with the cameras of photographs.",
    }
    paths = frozenset({"polygon", "frames"})

    def read(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Capture:
        """Read a list of boxes.

        Args:
            source: The CSV or JSON file.
            options: See `options`.

        Raises:
            InputError: It is missing, is not such a file, or holds nonsense; names the place.
        """
        given, notes = _listed(source, options), list[str]()
        ids = identifiers(given.boxes, "object")
        plan = _plan(given, options)
        level, height, cut = _level_height_cuts(given.top, plan)
        rows = [_row(node, given.up) for node in given.boxes]
        frame = _frame(given, plan, level, rows)
        boxes = tuple(_box(row, id_, frame, notes) for row, id_ in zip(rows, ids, strict=True))
        floor = floor_in(frame, plan, given.up) if plan else _around(boxes, notes)
        return Capture(
            source=source.name,
            source_from_world=frame.source_from_world(),
            floor=floor,
            height=height * given.unit if height else None,
            openings=() if floor is None else openings_in(frame, cut, floor),
            boxes=boxes,
            frames=in_world(_frames(given, options), frame, notes),
            notes=tuple(notes),
            remedy="give the corners of the floor: `floor` in the JSON file, or --polygon FILE",
        )

    def pack(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Packed:
        """The list and the files that the options name, beside each other.

        Raises:
            InputError: Two of them have one name.
        """
        named = {name: Path(value) for name, value in options.items() if name in self.paths}
        files = [source, *named.values()]
        if len({path.name for path in files}) < len(files):
            raise InputError(
                "two of the files have the same name", place=source, remedy="rename one"
            )
        kept = {name: value for name, value in options.items() if name not in self.paths}
        return Packed(
            file=source.name,
            contents={path.name: path for path in files},
            options=kept | {name: path.name for name, path in named.items()},
        )


def _listed(source: Path, options: Mapping[str, str]) -> _List:
    if source.suffix.lower() == ".csv":
        up = _up(Node({}, source), options)
        vertical = "z" if up == "Z" else "y"
        others = [axis for axis in "xyz" if axis != vertical]
        rows = read_table(
            source, ("label", *others, "width", "depth", "height"), ("id", "label", "unit")
        )
        return _List(rows, Node({}, source), up, _common_unit(rows, source, options))
    root = read_json(source)
    if isinstance(root.value, list):
        root = Node({"objects": root.value}, source)
    if root.get("objects") is None:
        raise root.error(
            "this is JSON, but not a list of boxes",
            'give a list of {"id", "label", "center", "size", "yaw"}, or hold it as "objects"',
        )
    return _List(root.items("objects"), root, _up(root, options), _unit(root, options))


def _up(top: Node, options: Mapping[str, str]) -> Up:
    node = _option("up", options, top) or Node("Z", top.file)
    up: Up = choice(node, get_args(Up))  # type: ignore[assignment]
    return up


def _unit(top: Node, options: Mapping[str, str]) -> float:
    node = _option("unit", options, top) or Node("m", top.file)
    return UNITS[choice(node, list(UNITS))]


def _common_unit(rows: Sequence[Node], source: Path, options: Mapping[str, str]) -> float:
    """The unit of a table: that of its first line, which the others must repeat."""
    if not rows:
        return _unit(Node({}, source), options)
    for row in rows[1:]:
        if row.value.get("unit") != rows[0].value.get("unit"):
            raise row.error("its unit is not that of the first line", "use one unit")
    return _unit(rows[0], options)


def _option(name: str, options: Mapping[str, str], top: Node) -> Node | None:
    """A given option, or else the file's own value."""
    return Node(options[name], top.file, f"--{name}") if name in options else top.get(name)


def _plan(given: _List, options: Mapping[str, str]) -> DrawnPlan | None:
    if "polygon" in options:
        return read_plan(Path(options["polygon"]), given.up)
    return plan_of(given.top, given.up)


def _level_height_cuts(
    top: Node, plan: DrawnPlan | None
) -> tuple[float, float | None, Sequence[Node]]:
    """Level, height and openings: of the drawn floor where it has them, else of the list."""
    level, height = (plan.level, plan.height) if plan else (None, None)
    return (
        (level_of(top) or 0.0) if level is None else level,
        height_of(top) if height is None else height,
        (plan.openings if plan else ()) or top.items("openings"),
    )


def _frames(given: _List, options: Mapping[str, str]) -> tuple[CapturedFrame, ...]:
    if "frames" in options:
        return read_frames(Path(options["frames"]))
    return frames_of(given.top.items("frames"))


@dataclass(frozen=True, eq=False)
class _Row:
    """A box in the source's frame and unit: its columns are width, depth and height."""

    node: Node
    label: str
    center: Array
    size: Array
    rotation: Array


def _row(node: Node, up: Up) -> _Row:
    label = text(node.need("label"))
    if node.get("center") is not None:
        size = _positive(node.need("size").numbers(3, MAX_SIDE), node.need("size"))
        return _Row(
            node, label, node.need("center").numbers(3, MAX_COORDINATE_M), size, _turn(node, up)
        )
    size = np.array([positive(node.need(key), MAX_SIDE) for key in ("width", "depth", "height")])
    vertical = "z" if up == "Z" else "y"
    middle = node.get(f"c{vertical}")
    center = np.array(
        [
            number(
                middle if middle is not None and axis == vertical else node.need(axis),
                MAX_COORDINATE_M,
            )
            for axis in "xyz"
        ]
    )
    if middle is None:
        center["xyz".index(vertical)] += 0.5 * size[2]
    return _Row(node, label, center, size, _turn(node, up))


def _positive(size: Array, node: Node) -> Array:
    if (size <= 0.0).any():
        raise node.error("a side is not positive", "give width, depth and height")
    return size


def _turn(node: Node, up: Up) -> Array:
    """(3, 3) the box's axes in the source's frame."""
    given = node.get("rotation")
    if given is not None:
        rotation = given.numbers(9, 1.0 + 1e-3).reshape(3, 3)
        proper(rotation, given)
        return np.asarray(rotation)
    yaw = node.get("yaw")
    angle = np.radians(number(yaw, 1e6)) if yaw is not None else 0.0
    return np.asarray(Z_UP[up].T @ about_z(angle))


def _frame(given: _List, plan: DrawnPlan | None, level: float, rows: Sequence[_Row]) -> WorldFrame:
    """The source's own axes, upright; its own origin unless that is far away."""
    turn = Z_UP[given.up]
    points = [row.center @ turn.T for row in rows]
    plane = plan.corners if plan else np.array([p[:2] for p in points]).reshape(-1, 2)
    corner = np.floor(plane.min(axis=0)) if len(plane) else np.zeros(2)
    if given.unit * float(np.abs(plane).max(initial=0.0)) <= _FAR_FROM_ORIGIN_M:
        corner = np.zeros(2)
    return WorldFrame(turn, np.array([*corner, level]) @ turn, given.unit)


def _box(row: _Row, identifier: str, frame: WorldFrame, notes: list[str]) -> CapturedBox:
    size = frame.unit * row.size
    if size.min() < _MIN_SIDE_M:
        raise row.node.error(
            f"its smallest side is {size.min():.3g} m", "give the unit of the file: --unit cm"
        )
    left, _, right = np.linalg.svd(frame.rotation @ row.rotation)
    rotation = left @ right
    lean = float(np.degrees(np.arccos(np.clip(rotation[2, 2], -1.0, 1.0))))
    if lean > _MAX_NOISE_LEAN_DEG:
        notes.append(f"{row.label} {identifier} leans by {lean:.0f} degrees: it is built upright")
    return CapturedBox(
        id=identifier,
        label=row.label,
        center=frame.points(row.center),
        rotation=rotation,
        size=size,
    )


def _around(boxes: Sequence[CapturedBox], notes: list[str]) -> Array | None:
    """(4, 2) the rectangle around all boxes, where nothing better is known."""
    if not boxes:
        return None
    reach = [0.5 * float(np.linalg.norm(box.size[:2])) + _FLOOR_MARGIN_M for box in boxes]
    low = np.min([b.center[:2] - r for b, r in zip(boxes, reach, strict=True)], axis=0)
    high = np.max([b.center[:2] + r for b, r in zip(boxes, reach, strict=True)], axis=0)
    notes.append("no floor is given: the rectangle around the objects is used")
    (x0, y0), (x1, y1) = np.round(low, 3), np.round(high, 3)
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
