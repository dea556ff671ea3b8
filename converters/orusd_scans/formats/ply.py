"""PLY files: ASCII and both binary forms, with any properties; lengths are checked before reading.

The format is that of Greg Turk's "The PLY Polygon File Format" (1994): a header that names elements
and their properties, then the elements' data in that order.
"""

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Ints
from openrooms_usd.spelling import listed
from orusd_scans.formats.rows import Counted, lines_before, read_rows
from orusd_scans.scanned import (
    LONGEST_HEADER,
    Scanned,
    broken,
    cloud_of,
    counted,
    opened,
    size_of,
    sound_faces,
)
from orusd_scans.surfaces import fans

_TYPES: Final = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "float32": "f4",
    "float64": "f8",
}
_CODES: Final = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I"}
_ORDERS: Final = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_CORNERS: Final = ("vertex_indices", "vertex_index")
# Elements with lists of vertices that are not surfaces.
_NO_SURFACES: Final = ("vertex", "line", "edge", "curve", "point")
# Lists up to this length may be read as parts of a row.
_MOST_IN_ROW: Final = 1 << 16
# Of a line with a list, bytes: strips have all triangles of a mesh in one.
_LONGEST_LIST: Final = 1 << 25
_LARGEST_UINT: Final = (1 << 32) - 1
_MOST_NAMED: Final = 6


@dataclass(frozen=True)
class _Property:
    """One property: of one value, or of a list with its length before it."""

    name: str
    type: str
    length: str | None = None


@dataclass(frozen=True)
class _Element:
    name: str
    count: int
    properties: list[_Property]

    @property
    def corners(self) -> str | None:
        """The list of vertices that makes triangles; None where there is none."""
        if any(word in self.name.lower() for word in _NO_SURFACES):
            return None
        lists = (p.name for p in self.properties if p.length is not None)
        return next((name for name in lists if name.lower() in _CORNERS), None)


def read_ply(path: Path) -> Scanned:
    """Read the points of a PLY file, and its triangles where it has faces, strips or lists of them.

    Raises:
        InputError: It is not a PLY file, is truncated, or holds nonsense.
    """
    notes: list[str] = []
    with opened(path) as stream:
        order, elements = _header(stream, path)
        reader = _Binary(stream, path, order) if order else _Ascii(stream, path, notes)
        cloud, faces = None, [np.empty((0, 3), np.int64)]
        used = [i for i, one in enumerate(elements) if one.name == "vertex" or one.corners]
        for element in elements[: used[-1] + 1] if used else ():
            values = reader.read(element)
            if element.corners is not None:
                faces.append(_triangles(element.name.lower(), values[element.corners]))
            elif element.name == "vertex":
                single = {p.name: p.length is None for p in element.properties}
                columns = {name.lower(): values[name] for name in single if single[name]}
                lists = [name for name in single if not single[name]]
                cloud = cloud_of(columns, path, notes, lists)
    if cloud is None:
        raise broken(path, "it has no vertices")
    unused = [f"{e.count:,} {e.name[:40]}" for i, e in enumerate(elements) if i not in used]
    if unused:
        notes.append(f"elements that are not used: {listed(unused, _MOST_NAMED)}")
    every = sound_faces(np.concatenate(faces), len(cloud), path, notes)
    return Scanned(cloud, every, notes=tuple(notes))


def _header(stream: BinaryIO, path: Path) -> tuple[str, list[_Element]]:
    if stream.readline(8).rstrip(b"\r\n") != b"ply":
        raise broken(path, "this is not a PLY file: it does not begin with 'ply'")
    order: str | None = None
    elements: list[_Element] = []
    while (line := _line(stream, path)) != "end_header":
        match line.split():
            case ["format", kind, "1.0"] if kind in _ORDERS:
                order = _ORDERS[kind]
            case ["comment" | "obj_info", *_] | []:
                continue
            case ["element", name, count]:
                elements.append(_Element(name, counted(path, count, "elements"), []))
            case ["property", "list", length, kind, name] if _whole(length) and kind in _TYPES:
                _add(elements, _Property(name, _TYPES[kind], _TYPES[length]), path)
            case ["property", kind, name] if kind in _TYPES:
                _add(elements, _Property(name, _TYPES[kind]), path)
            case _:
                raise broken(path, f"the header has a line that is not PLY: {line[:60]!r}")
    if order is None:
        raise broken(path, "the header names no format")
    return order, elements


def _line(stream: BinaryIO, path: Path) -> str:
    line = stream.readline(LONGEST_HEADER)
    if not line.endswith(b"\n") or stream.tell() > LONGEST_HEADER:
        raise broken(path, f"the header does not end within {LONGEST_HEADER >> 10} KB")
    return line.decode("latin-1").strip()


def _whole(length: str) -> bool:
    return _TYPES.get(length, "f")[0] != "f"


def _add(elements: list[_Element], property_: _Property, path: Path) -> None:
    if not elements:
        raise broken(path, "the header has a property before the first element")
    if any(known.name == property_.name for known in elements[-1].properties):
        raise broken(path, f"the header repeats the property {property_.name[:60]!r}")
    elements[-1].properties.append(property_)


class _Binary:
    """Elements as bytes."""

    def __init__(self, stream: BinaryIO, path: Path, order: str) -> None:
        self._stream, self._path, self._order = stream, path, order
        self._size = size_of(stream)

    def read(self, element: _Element) -> dict[str, Any]:
        """The properties by name: arrays of values, and sequences of lists.

        Lists of vertices are passed over where they differ in length.
        """
        if not element.properties or not element.count:
            return {p.name: np.empty(0) for p in element.properties}
        least = sum(np.dtype(p.length or p.type).itemsize for p in element.properties)
        start = self._stream.tell()
        if start + element.count * least > self._size:
            told = f"{element.count:,} of {element.name!r} are announced"
            raise broken(self._path, f"it ends too early: {told}")
        lengths = [self._first_length(p) for p in element.properties]
        self._stream.seek(start)
        rows = self._rows(element, lengths) if max(lengths) <= _MOST_IN_ROW else None
        if rows is not None:
            return {p.name: rows[f"v{i}"] for i, p in enumerate(element.properties)}
        self._stream.seek(start)
        return self._uneven(element)

    def _first_length(self, property_: _Property) -> int:
        """How long the list is in the first row; 1 for a value."""
        count = 1 if property_.length is None else int(self._values(property_.length, 1)[0])
        self._values(property_.type, count)
        return count

    def _values(self, kind: str, count: int) -> NDArray[Any]:
        if count < 0:
            raise broken(self._path, f"a list of {count:,} values makes no sense")
        dtype = np.dtype(self._order + kind)
        if dtype.itemsize * count > self._size - self._stream.tell():
            raise broken(self._path, "it ends too early")
        return np.frombuffer(self._stream.read(dtype.itemsize * count), dtype)

    def _rows(self, element: _Element, lengths: Sequence[int]) -> NDArray[Any] | None:
        """All rows at once; None where their lists differ in length."""
        fields: list[Any] = []
        for i, (p, count) in enumerate(zip(element.properties, lengths, strict=True)):
            if p.length is not None:
                fields.append((f"n{i}", self._order + p.length))
            shape = () if p.length is None else (count,)
            fields.append((f"v{i}", self._order + p.type, shape))
        dtype = np.dtype(fields)
        if self._stream.tell() + element.count * dtype.itemsize > self._size:
            return None
        rows = np.fromfile(self._stream, dtype, element.count)
        lists = [i for i, p in enumerate(element.properties) if p.length is not None]
        return rows if all((rows[f"n{i}"] == lengths[i]).all() for i in lists) else None

    def _uneven(self, element: _Element) -> dict[str, Any]:
        """Row by row, where lists differ in length: where each property is, then its values."""
        at, places, lists = self._stream.tell(), list[int](), list[tuple[str, str, int, int]]()
        data: Any = np.memmap(self._stream, np.uint8, "r")
        kept, ordered = element.corners, element.properties
        lengths = [
            None if p.length is None else struct.Struct(self._order + _CODES[p.length])
            for p in ordered
        ]
        steps = [(p, np.dtype(p.type).itemsize, n) for p, n in zip(ordered, lengths, strict=True)]
        try:
            for _ in range(element.count):
                for p, size, length in steps:
                    if length is None:
                        places.append(at)
                        at += size
                        continue
                    (count,) = length.unpack_from(data, at)
                    at += length.size
                    if p.name == kept:
                        lists.append((p.name, self._order + p.type, count, at))
                    if count < 0:
                        raise broken(self._path, f"a list of {count:,} values makes no sense")
                    at += count * size
        except struct.error as error:
            raise broken(self._path, "it ends too early") from error
        if at > self._size:
            raise broken(self._path, "it ends too early")
        self._stream.seek(at)
        single = [p for p in element.properties if p.length is None]
        starts = np.array(places, np.int64).reshape(element.count, len(single))
        found: dict[str, Any] = {p.name: [] for p in element.properties}
        for p, column in zip(single, starts.T, strict=True):
            dtype = np.dtype(self._order + p.type)
            values = data[column[:, None] + np.arange(dtype.itemsize)]
            found[p.name] = np.ascontiguousarray(values).view(dtype)[:, 0]
        for name, kind, count, place in lists:
            found[name].append(np.frombuffer(data, kind, count, place))
        return found


class _Ascii:
    """Elements as lines of text."""

    def __init__(self, stream: BinaryIO, path: Path, notes: list[str]) -> None:
        self._stream, self._path, self._notes = stream, path, notes
        self._size, self._line = size_of(stream), lines_before(stream) + 1

    def read(self, element: _Element) -> dict[str, Any]:
        """The properties by name: arrays of values, and sequences of lists."""
        # A value and what ends it take two bytes at least.
        least = 2 * max(len(element.properties), 1) * element.count - 1
        if self._stream.tell() + least > self._size:
            raise broken(self._path, f"it ends too early: {element.count:,} lines are announced")
        decoded = map(partial(str, encoding="latin-1"), self._lines())
        lines = Counted(decoded, element.count)
        if any(p.length is not None for p in element.properties):
            found, count = self._lists(element, lines)
        else:
            width = len(element.properties)
            rows = read_rows(lines, width, self._path, first=self._line)
            self._notes += rows.told
            found = {p.name: rows.values[:, i] for i, p in enumerate(element.properties)}
            count = len(rows.values)
        self._line += lines.passed
        if count < element.count and element.properties:
            told = f"{element.count:,} lines are announced for {element.name!r}"
            raise broken(self._path, f"{told}, but {count:,} are there: it ends too early")
        return found

    def _lines(self) -> Iterator[bytes]:
        return iter(partial(self._stream.readline, _LONGEST_LIST), b"")

    def _lists(self, element: _Element, lines: Counted) -> tuple[dict[str, Any], int]:
        """The properties of lines with lists, and how many lines there are."""
        found: dict[str, Any] = {p.name: [] for p in element.properties}
        count, lost, said = 0, 0, ""
        for line in filter(str.strip, lines):
            count += 1
            try:
                row = _row(element, line)
            except (ValueError, IndexError, OverflowError):
                row = {p.name: np.empty(0) if p.length else np.nan for p in element.properties}
                said = (
                    said
                    or f"the first is line {self._line + lines.passed - 1}, {line.strip()[:60]!r}"
                )
                lost += 1
            for name, value in row.items():
                found[name].append(value)
        told = f"{lost:,} of {count:,} lines are not a {element.name[:40]}"
        if lost and 2 * lost >= count:
            raise broken(self._path, f"{told}: {said}")
        if lost:
            self._notes.append(f"{told} and left out: {said}")
        single = {p.name: np.array(found[p.name]) for p in element.properties if p.length is None}
        return found | single, count


def _row(element: _Element, line: str) -> dict[str, Any]:
    """The values and lists of a line of text."""
    numbers, at, row = [float(word) for word in line.split()], 0, dict[str, Any]()
    for p in element.properties:
        if p.length is None:
            row[p.name], at = numbers[at], at + 1
            continue
        start, end = at + 1, at + 1 + int(numbers[at])
        if not start <= end <= len(numbers):
            raise ValueError(line)
        row[p.name], at = np.array(numbers[start:end]), end
    return row


def _triangles(element: str, lists: Any) -> Ints:
    """(F, 3) the triangles of an element's lists: of strips, of three corners each, or fans."""
    is_list = element.startswith("tri")  # of triangles, or of strips
    if isinstance(lists, np.ndarray) and lists.ndim == 2 and "strip" not in element:
        corners = _whole_corners(lists)
        return corners.reshape(-1, 3) if is_list and lists.shape[1] % 3 == 0 else fans(corners)
    whole = [_whole_corners(corners) for corners in lists]
    if "strip" in element:
        return np.concatenate([np.empty((0, 3), np.int64), *map(_strips, whole)])
    by_size: dict[int, list[Ints]] = {}
    for corners in whole:
        if is_list and len(corners) % 3 == 0:
            by_size.setdefault(3, []).extend(corners.reshape(-1, 3))
        else:
            by_size.setdefault(len(corners), []).append(corners)
    found = [fans(np.array(by_size[size])) for size in sorted(by_size)]
    return np.concatenate([np.empty((0, 3), np.int64), *found])


def _strips(corners: Ints) -> Ints:
    """(F, 3) the triangles of strips, which a negative number ends: every other one is turned."""
    number = np.arange(len(corners))
    is_end = (corners < 0) | (corners >= _LARGEST_UINT)
    begin = np.maximum.accumulate(np.where(is_end, number + 1, 0))[:-2]
    a, b, c = corners[:-2], corners[1:-1], corners[2:]
    odd = (number[:-2] - begin) % 2 == 1
    found = np.column_stack([np.where(odd, b, a), np.where(odd, a, b), c])
    sound = ~(is_end[:-2] | is_end[1:-1] | is_end[2:]) & (a != b) & (b != c) & (a != c)
    return np.asarray(found[sound])


def _whole_corners(corners: NDArray[Any]) -> Ints:
    """Corners as whole numbers; negative, which none is, where they are not."""
    if corners.dtype.kind == "f":
        with np.errstate(invalid="ignore"):
            whole = (corners % 1 == 0) & (np.abs(corners) <= _LARGEST_UINT)
        corners = np.where(whole, corners, -1.0)
    return corners.astype(np.int64)
