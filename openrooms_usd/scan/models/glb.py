"""GLB (binary glTF) of unknown origin: checked and weighed before a library unpacks it.

A short description can make a reader take any amount of memory: accessors without data, thousands
of them over the same bytes, or thousands of nodes that show the same mesh. (The glTF 2.0
specification, Khronos Group 2021: sections 3.5 for nodes, 3.6 for buffers and accessors.)
"""

import importlib.util
import json
import struct
from collections.abc import Mapping, Sequence
from typing import Any, Final

from openrooms_usd.errors import InputError, MissingPackageError

_DRACO: Final = "KHR_draco_mesh_compression"
_MAGIC: Final = b"glTF"
_JSON: Final = 0x4E4F534A
_HEAD: Final = struct.calcsize("<4sIIII")
# What a file may require and is understood, or says nothing of shapes.
_HARMLESS: Final = ("KHR_materials_", "KHR_lights_", "KHR_texture_transform", "KHR_xmp", _DRACO)
_BYTES: Final = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
_NUMBERS: Final = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
# Unpacked arrays have no more bytes than this, or so many times the file; compressed ones have.
_MIN_ARRAY_BYTES: Final = 64 << 20
_MAX_COMPRESSION_GAIN: Final = 16
# Corners of all triangles that all nodes show.
_MAX_CORNERS: Final = 1 << 26


def glb_header(content: bytes, place: object) -> dict[str, Any]:
    """The description of a GLB file, its lengths and claims checked.

    Args:
        content: The whole file.
        place: The file, for messages.

    Raises:
        InputError: It is no GLB, is cut off, claims absurd amounts, or needs what is not read.
        MissingPackageError: It is compressed by Draco and the decoder is not installed.
    """
    if len(content) < _HEAD:
        raise _broken("it is too short", place)
    magic, version, length, size, kind = struct.unpack_from("<4sIIII", content)
    if magic != _MAGIC or version != 2 or kind != _JSON:
        raise _broken("it does not begin as GLB 2 does", place)
    if max(length, _HEAD + size) > len(content):
        raise _broken(f"it is truncated: {len(content)} of {length} bytes", place)
    header = _described(content[_HEAD : _HEAD + size], place)
    _weigh(header, len(content), place)
    return header


def _described(text: bytes, place: object) -> dict[str, Any]:
    try:
        header = json.loads(text.decode("utf-8", errors="replace"))
    except (ValueError, RecursionError) as error:
        raise _broken(str(error), place) from error
    if not isinstance(header, dict):
        raise _broken("its description is no JSON object", place)
    return header


def _weigh(header: Mapping[str, Any], size: int, place: object) -> None:
    """Refuse what cannot be read, or unpacks to many times the ``size`` of the file in bytes."""
    try:
        _check_extensions(header, place)
        _check_amounts(header, max(_MIN_ARRAY_BYTES, _MAX_COMPRESSION_GAIN * size))
    except (ValueError, TypeError, LookupError, AttributeError) as error:
        raise _broken(str(error) or type(error).__name__, place) from error


def _check_extensions(header: Mapping[str, Any], place: object) -> None:
    required = [str(name) for name in header.get("extensionsRequired", ())]
    used = [str(name) for name in header.get("extensionsUsed", ())]
    unknown = [name for name in required if not name.startswith(_HARMLESS)]
    if unknown:
        raise InputError(
            f"it requires {', '.join(unknown)[:200]}, which cannot be read",
            place=place,
            remedy="export it without compressed pictures and meshes, or compressed by Draco",
        )
    if _DRACO in required + used and importlib.util.find_spec("DracoPy") is None:
        raise MissingPackageError(
            "its meshes are compressed by Draco, and the decoder DracoPy is not installed",
            place=place,
            remedy="pip install 'openrooms-usd[draco]', or export it without compression",
        )


def _check_amounts(header: Mapping[str, Any], most: int) -> None:
    """Refuse what unpacks to more than a file of that size can mean."""
    views, accessors = header.get("bufferViews", []), header.get("accessors", [])
    if sum(_whole(view["byteLength"]) for view in views) > most:
        raise ValueError("its buffer views are many times as long as the file")
    if any(_whole(view.get("byteStride", 1)) < 1 for view in views):
        raise ValueError("a buffer view has no stride")
    counts = [_whole(accessor["count"]) for accessor in accessors]
    sizes = [_BYTES[a["componentType"]] * _NUMBERS[a["type"]] for a in accessors]
    if sum(count * size for count, size in zip(counts, sizes, strict=True)) > most:
        raise ValueError("its accessors announce many times as much as the file holds")
    corners = [
        sum(_corners(primitive, counts) for primitive in mesh["primitives"])
        for mesh in header.get("meshes", [])
    ]
    nodes = header.get("nodes", [])
    shown = sum(corners[_whole(node["mesh"])] for node in nodes if "mesh" in node)
    if max(shown, sum(corners)) > _MAX_CORNERS:
        raise ValueError(f"its nodes show more than {_MAX_CORNERS:,} corners")
    _check_tree(nodes)


def _corners(primitive: Mapping[str, Any], counts: Sequence[int]) -> int:
    """The longest of a primitive's arrays."""
    named = [*primitive["attributes"].values()]
    named += [primitive["indices"]] if "indices" in primitive else []
    return max((counts[_whole(index)] for index in named), default=0)


def _check_tree(nodes: Sequence[Mapping[str, Any]]) -> None:
    """Nodes form trees: a node with two parents, or among its own descendants, never ends."""
    parents: dict[int, int] = {}
    for number, node in enumerate(nodes):
        for child in node.get("children", ()):
            if not 0 <= _whole(child) < len(nodes) or child in parents:
                raise ValueError(f"the node {str(child)[:20]} is missing, or has two parents")
            parents[child] = number
    # With one parent each, what no root leads to goes round in circles.
    reached, waiting = 0, [number for number in range(len(nodes)) if number not in parents]
    while waiting:
        reached += 1
        waiting += nodes[waiting.pop()].get("children", ())
    if reached < len(nodes):
        raise ValueError("a node is among its own descendants")


def _whole(value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise ValueError(f"{str(value)[:20]!r} is no number of anything")
    return value


def _broken(reason: str, place: object) -> InputError:
    return InputError(
        f"not a readable GLB file: {reason}", place=place, remedy="export the mesh again"
    )
