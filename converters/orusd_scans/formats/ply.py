"""PLY files: ASCII and both binary forms, with any properties; lengths are checked before reading.

The format is that of Greg Turk's "The PLY Polygon File Format" (1994): a header that names elements
and their properties, then the elements' data in that order.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from orusd_scans.scanned import (
    LONGEST_HEADER,
    MOST_POINTS,
    Scanned,
    broken,
    cloud_of,
    counted,
    lines_of,
    opened,
    size_of,
    table,
)

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
_ORDERS: Final = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_POLYGONS: Final = ("vertex_indices", "vertex_index")
_MOST_CORNERS: Final = 1 << 16


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


def read_ply(path: Path) -> Scanned:
    """Read the points of a PLY file, and its triangles where it has faces.

    Raises:
        InputError: It is no PLY file, is cut off, or holds nonsense.
    """
    with opened(path) as stream:
        order, elements = _header(stream, path)
        reader = _Ascii(stream, path) if order == "" else _Binary(stream, path, order)
        notes: list[str] = []
        cloud, faces = None, None
        for element in elements:
            values = reader.read(element)
            if element.name == "vertex":
                columns = {n.lower(): v for n, v in values.items() if np.ndim(v) == 1}
                cloud = cloud_of(columns, path, notes)
            elif element.name == "face":
                polygons = next((values[name] for name in _POLYGONS if name in values), None)
                faces = _triangles(polygons, path) if polygons is not None else None
            if cloud is not None and faces is not None:
                break
    if cloud is None:
        raise broken(path, "it has no vertices")
    if faces is not None and len(faces) and not 0 <= faces.min() <= faces.max() < len(cloud):
        raise broken(path, "a face refers to a vertex that is not there")
    return Scanned(cloud, faces if faces is not None and len(faces) else None, notes=tuple(notes))


def _header(stream: BinaryIO, path: Path) -> tuple[str, list[_Element]]:
    if stream.readline(8).rstrip(b"\r\n") != b"ply":
        raise broken(path, "this is no PLY file: it does not begin with 'ply'")
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
                raise broken(path, f"the header has a line that is none of PLY: {line[:60]!r}")
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
        """The properties by name: arrays of values, and sequences of lists."""
        if not element.properties or not element.count:
            return {p.name: np.empty(0) for p in element.properties}
        start = self._stream.tell()
        lengths = [self._first_length(p) for p in element.properties]
        self._stream.seek(start)
        rows = self._rows(element, self._dtype(element, lengths), lengths)
        if rows is not None:
            return {p.name: rows[f"v{i}"] for i, p in enumerate(element.properties)}
        self._stream.seek(start)
        return self._uneven(element)

    def _first_length(self, property_: _Property) -> int:
        """How long the list is in the first row; 1 for a value."""
        count = 1 if property_.length is None else int(self._values(property_.length, 1)[0])
        if not 0 <= count <= _MOST_CORNERS:
            raise broken(self._path, f"a list of {count:,} values makes no sense")
        self._values(property_.type, count)
        return count

    def _values(self, kind: str, count: int) -> NDArray[Any]:
        dtype = np.dtype(kind).newbyteorder(self._order)  # type: ignore[arg-type]
        data = self._stream.read(dtype.itemsize * count)
        if len(data) < dtype.itemsize * count:
            raise broken(self._path, "it ends too early")
        return np.frombuffer(data, dtype)

    def _dtype(self, element: _Element, lengths: Sequence[int]) -> np.dtype[Any]:
        """A row, if all of them have lists of the same lengths."""
        fields: list[Any] = []
        for i, (p, count) in enumerate(zip(element.properties, lengths, strict=True)):
            if p.length is not None:
                fields.append((f"n{i}", self._order + p.length))
            shape = () if p.length is None else (count,)
            fields.append((f"v{i}", self._order + p.type, shape))
        return np.dtype(fields)

    def _rows(
        self, element: _Element, dtype: np.dtype[Any], lengths: Sequence[int]
    ) -> NDArray[Any] | None:
        """All rows at once; None where their lists differ in length."""
        short = self._stream.tell() + element.count * dtype.itemsize > self._size
        lists = [i for i, p in enumerate(element.properties) if p.length is not None]
        if short and not lists:
            raise broken(
                self._path,
                f"it ends too early: {element.count:,} of {element.name!r} are announced",
            )
        if short:
            return None
        rows = np.fromfile(self._stream, dtype, element.count)
        same = all((rows[f"n{i}"] == lengths[i]).all() for i in lists)
        return rows if same else None

    def _uneven(self, element: _Element) -> dict[str, Any]:
        """Row by row, where lists differ in length."""
        least = sum(np.dtype(p.length or p.type).itemsize for p in element.properties)
        if self._stream.tell() + element.count * least > self._size:
            raise broken(self._path, f"it ends too early: {element.count:,} lists are announced")
        found: dict[str, list[NDArray[Any]]] = {p.name: [] for p in element.properties}
        for _ in range(element.count):
            for p in element.properties:
                count = 1 if p.length is None else int(self._values(p.length, 1)[0])
                if not 0 <= count <= _MOST_CORNERS:
                    raise broken(self._path, f"a list of {count:,} values makes no sense")
                found[p.name].append(self._values(p.type, count))
        return {
            p.name: found[p.name] if p.length is not None else np.concatenate(found[p.name])
            for p in element.properties
        }


class _Ascii:
    """Elements as lines of text."""

    def __init__(self, stream: BinaryIO, path: Path) -> None:
        self._stream, self._path = stream, path
        self._size = size_of(stream)

    def read(self, element: _Element) -> dict[str, Any]:
        """The properties by name: arrays of values, and sequences of lists."""
        # A value and what ends it take two bytes at least.
        least = 2 * max(len(element.properties), 1) * element.count - 1
        if self._stream.tell() + least > self._size:
            raise broken(self._path, f"it ends too early: {element.count:,} lines are announced")
        if any(p.length is not None for p in element.properties):
            return self._lists(element)
        values = self._table(element)
        return {p.name: values[:, i] for i, p in enumerate(element.properties)}

    def _table(self, element: _Element) -> NDArray[np.float64]:
        width = len(element.properties)
        if not element.count or not width:
            return np.empty((0, width))
        values = table(islice(lines_of(self._stream), element.count), self._path)
        if values.shape != (element.count, width):
            raise broken(
                self._path,
                f"{element.count:,} lines of {width} numbers are announced for {element.name!r}, "
                f"but {len(values):,} of {values.shape[1]} are there",
            )
        return values

    def _lists(self, element: _Element) -> dict[str, Any]:
        found: dict[str, list[NDArray[Any]]] = {p.name: [] for p in element.properties}
        for line in islice(lines_of(self._stream), element.count):
            words = iter(line.split())
            try:
                for p in element.properties:
                    count = 1 if p.length is None else int(next(words))
                    numbers = [float(next(words)) for _ in range(min(count, _MOST_CORNERS))]
                    found[p.name].append(np.array(numbers))
            except (ValueError, RuntimeError, StopIteration) as error:
                raise broken(self._path, f"no {element.name}: {line[:60]!r}") from error
        if len(found[element.properties[0].name]) < element.count:
            raise broken(self._path, "it ends too early")
        return dict(found)


def _triangles(polygons: Any, path: Path) -> NDArray[np.int64]:
    """(F, 3) fans of the polygons; those of two corners or fewer are left out."""
    if not len(polygons):
        return np.empty((0, 3), np.int64)
    if isinstance(polygons, np.ndarray):
        if polygons.ndim != 2:
            raise broken(path, "its faces are no lists of vertices")
        return _fans(polygons, path)
    by_size: dict[int, list[NDArray[Any]]] = {}
    for polygon in polygons:
        by_size.setdefault(len(polygon), []).append(polygon)
    return np.concatenate([_fans(np.array(by_size[size]), path) for size in sorted(by_size)])


def _are_whole(numbers: NDArray[Any]) -> bool:
    with np.errstate(invalid="ignore"):
        return bool(((numbers % 1 == 0) & (np.abs(numbers) <= MOST_POINTS)).all())


def _fans(polygons: NDArray[Any], path: Path) -> NDArray[np.int64]:
    if polygons.dtype.kind == "f" and not _are_whole(polygons):
        raise broken(path, "a face refers to vertices by numbers that are not whole")
    corners = polygons.astype(np.int64)
    fans = [corners[:, [0, i, i + 1]] for i in range(1, corners.shape[1] - 1)]
    return np.concatenate(fans) if fans else np.empty((0, 3), np.int64)
