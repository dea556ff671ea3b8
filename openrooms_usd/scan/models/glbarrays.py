"""The arrays of a GLB file in the one form that every reader knows: dense, colours as fractions.

A sparse accessor is an array of which only some rows are written down (glTF 2.0, 3.6.2.3); colours
may be whole numbers that stand for fractions (3.7.2.1). Both are written out here.
"""

import json
import struct
from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

TYPES: Final = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
"""Types of numbers in an accessor."""
_FLOAT: Final = 5126
WIDTHS: Final = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
"""Numbers in an element of an accessor."""
_CHUNK: Final = struct.calcsize("<I4s")
_HEAD: Final = struct.calcsize("<4sII")


def with_plain_arrays(content: bytes, header: Mapping[str, Any]) -> bytes:
    """The same GLB file without sparse accessors, and with colours as floats.

    Args:
        content: The whole file.
        header: Its description, checked.

    Raises:
        ValueError: An accessor lies outside its buffer, or its rows are not in order.
    """
    accessors = [dict(one) for one in header.get("accessors", ())]
    colours = set(_colours(header))
    wanted = [n for n, one in enumerate(accessors) if "sparse" in one or n in colours]
    wanted = [n for n in wanted if "sparse" in accessors[n] or _is_whole(accessors[n])]
    if not wanted:
        return content
    body, views = _body(content), [dict(view) for view in header.get("bufferViews", ())]
    added = bytearray()
    start = len(body) + -len(body) % 4
    for number in wanted:
        one = accessors[number]
        values = _dense(one, views, body)
        if number in colours and _is_whole(one):
            values = (values / np.iinfo(values.dtype).max).astype("<f4")
            one |= {"componentType": _FLOAT, "normalized": False}
            one.pop("min", None), one.pop("max", None)
        one.pop("sparse", None)
        one |= {"bufferView": len(views), "byteOffset": 0}
        written = np.ascontiguousarray(values).tobytes()
        views.append({"buffer": 0, "byteOffset": start + len(added), "byteLength": len(written)})
        added += written + bytes(-len(written) % 4)
    body = body.ljust(start, b"\0") + added
    buffers = [{"byteLength": len(body)}, *list(header.get("buffers", ()))[1:]]
    return _glb({**header, "accessors": accessors, "bufferViews": views, "buffers": buffers}, body)


def _is_whole(accessor: Mapping[str, Any]) -> bool:
    return bool(accessor["componentType"] != _FLOAT)


def _colours(header: Mapping[str, Any]) -> Iterator[int]:
    for mesh in header.get("meshes", ()):
        for primitive in mesh["primitives"]:
            named = primitive["attributes"].items()
            yield from (number for name, number in named if name.startswith("COLOR_"))


def _dense(accessor: Mapping[str, Any], views: list[Any], body: bytes) -> NDArray[Any]:
    """(count, width) the values of an accessor."""
    kind, width = TYPES[accessor["componentType"]], WIDTHS[accessor["type"]]
    count = int(accessor["count"])
    values = np.zeros((count, width), kind)
    if "bufferView" in accessor:
        values[:] = _rows(accessor, views, body, kind, width, count)
    if (sparse := accessor.get("sparse")) is None:
        return values
    told, some = sparse["indices"], int(sparse["count"])
    at = _rows(told, views, body, TYPES[told["componentType"]], 1, some)[:, 0].astype(np.int64)
    if len(at) and (at.max() >= count or (np.diff(at) <= 0).any()):
        raise ValueError("the indices of a sparse accessor are missing or not in order")
    values[at] = _rows(sparse["values"], views, body, kind, width, some)
    return values


def _rows(
    part: Mapping[str, Any], views: list[Any], body: bytes, kind: str, width: int, count: int
) -> NDArray[Any]:
    """(count, width) as they lie in a view of the file's own buffer."""
    view = views[int(part["bufferView"])]
    if view.get("buffer", 0) != 0:
        raise ValueError("an array lies in another file")
    offset, size = int(part.get("byteOffset", 0)), np.dtype(kind).itemsize * width
    stride = int(view.get("byteStride", size))
    end = min(int(view["byteLength"]), len(body) - int(view.get("byteOffset", 0)))
    if offset < 0 or (count and offset + stride * (count - 1) + size > end):
        raise ValueError("an array lies outside its buffer")
    first = int(view.get("byteOffset", 0)) + offset
    strides = (stride, np.dtype(kind).itemsize)
    return np.ndarray((count, width), kind, body, first, strides) if count else np.zeros((0, width))


def _body(content: bytes) -> bytes:
    """The file's own buffer: its second chunk."""
    (size,) = struct.unpack_from("<I", content, _HEAD)
    start = _HEAD + _CHUNK + size
    if len(content) < start + _CHUNK:
        return b""
    (length,) = struct.unpack_from("<I", content, start)
    return content[start + _CHUNK : start + _CHUNK + length]


def _glb(header: Mapping[str, Any], body: bytes) -> bytes:
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    body = body + bytes(-len(body) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(body), b"BIN\0") + body
    return struct.pack("<4sII", b"glTF", 2, _HEAD + len(chunks)) + chunks
