"""Meshes of unknown origin through trimesh: one door, whose meshes have sound shapes and indices.

trimesh raises whatever a broken file leads it to, and says on standard error what it passes over.
Here both become one sentence about the file.
"""

import importlib.util
import io
import json
import logging
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError, MissingPackageError, OrusdError
from openrooms_usd.scan.models.glbarrays import TYPES, WIDTHS, with_plain_arrays

# Without a handler, Python prints a library's warnings with their tracebacks.
logging.getLogger("trimesh").addHandler(logging.NullHandler())

_MOST_TRIANGLES: Final = 20_000_000
_REMEDY: Final = "open it with a mesh viewer and export it again"


@dataclass(frozen=True, eq=False)
class ShownMesh:
    """A mesh at one place of a scene.

    Attributes:
        name: What the file calls it.
        mesh: The `trimesh.Trimesh`; its faces refer to its vertices.
        file_from_mesh: (4, 4) where it is.
    """

    name: str
    mesh: Any
    file_from_mesh: Array

    @property
    def vertices(self) -> Array:
        """(N, 3) in the file's frame."""
        turn, shift = self.file_from_mesh[:3, :3], self.file_from_mesh[:3, 3]
        with np.errstate(all="ignore"):
            return np.asarray(self.mesh.vertices, dtype=np.float64) @ turn.T + shift

    @property
    def faces(self) -> NDArray[np.int32]:
        """(F, 3) rows of the vertices."""
        return np.asarray(self.mesh.faces, dtype=np.int32)


def shown_meshes(path: Path, content: bytes) -> list[ShownMesh]:
    """The meshes with triangles that a file shows, by the ending of its name.

    Args:
        path: A PLY, GLB, STL or OFF file; no other file is read with it.
        content: Its bytes.

    Raises:
        InputError: It cannot be read, is too large, or a mesh in it is not sound.
        MissingPackageError: It is compressed and the decoder is not installed.
    """
    import trimesh

    kind = path.suffix.lower().removeprefix(".")
    if kind == "glb":
        content = _plain(content, glb_header(content, path), path)
    try:
        with np.errstate(all="ignore"):  # of this thread; what is not finite is found later
            scene = trimesh.load_scene(io.BytesIO(content), file_type=kind, process=False)
            found = [ShownMesh(n, m, _pose(p)) for n, m, p in _shown(scene)]
    except OrusdError:
        raise
    except Exception as error:
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        text = f"not a readable {kind.upper()} file: {reason}"
        raise InputError(text, place=path, remedy=_REMEDY) from error
    _check_meshes(found, path)
    return found


def _plain(content: bytes, header: dict[str, Any], place: object) -> bytes:
    try:
        return with_plain_arrays(content, header)
    except (ValueError, TypeError, LookupError, AttributeError, struct.error) as error:
        raise _broken(str(error) or type(error).__name__, place) from error


def _shown(scene: Any) -> Any:
    for node in sorted(scene.graph.nodes_geometry):
        pose, name = scene.graph[node]
        mesh = scene.geometry[name]
        if len(getattr(mesh, "faces", ())):
            yield str(name), mesh, pose


def _pose(given: Any) -> Array:
    pose = np.asarray(given, dtype=np.float64)
    if pose.shape != (4, 4) or not np.isfinite(pose).all():
        raise ValueError("the transform of a mesh is not valid")
    return pose


def _check_meshes(found: list[ShownMesh], path: Path) -> None:
    if sum(len(one.mesh.faces) for one in found) > _MOST_TRIANGLES:
        text = f"it shows more than {_MOST_TRIANGLES:,} triangles"
        raise InputError(text, place=path, remedy="export fewer triangles, or save scans as PLY")
    for one in found:
        points, faces = np.asarray(one.mesh.vertices), np.asarray(one.mesh.faces)
        if points.ndim != 2 or points.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] != 3:
            raise InputError("a mesh is not of triangles", place=path, remedy=_REMEDY)
        if not 0 <= faces.min() <= faces.max() < len(points):
            text = "a triangle refers to a missing vertex"
            raise InputError(text, place=path, remedy=_REMEDY)


_DRACO: Final = "KHR_draco_mesh_compression"
_MAGIC: Final = b"glTF"
_JSON: Final = 0x4E4F534A
_HEAD: Final = struct.calcsize("<4sIIII")
# What a file may require and is understood, or says nothing of shapes.
_HARMLESS: Final = ("KHR_materials_", "KHR_lights_", "KHR_texture_transform", "KHR_xmp", _DRACO)
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
        InputError: It is not a GLB file, is truncated, announces absurd sizes, or needs an
            unsupported extension.
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
        raise _broken("its description is not a JSON object", place)
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
        raise ValueError("its buffer views are far longer than the file")
    if any(_whole(view.get("byteStride", 1)) < 1 for view in views):
        raise ValueError("a buffer view has no stride")
    counts = [_whole(accessor["count"]) for accessor in accessors]
    sizes = [np.dtype(TYPES[a["componentType"]]).itemsize * WIDTHS[a["type"]] for a in accessors]
    if sum(count * size for count, size in zip(counts, sizes, strict=True)) > most:
        raise ValueError("its accessors announce far more data than the file holds")
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
        raise ValueError(f"{str(value)[:20]!r} is not a valid number")
    return value


def _broken(reason: str, place: object) -> InputError:
    return InputError(
        f"not a readable GLB file: {reason}", place=place, remedy="export the mesh again"
    )
