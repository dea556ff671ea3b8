"""Meshes (OBJ, GLB, STL, OFF) through trimesh, as points with triangles."""

import io
import json
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd.errors import MissingPackageError
from openrooms_usd.scan.cloud import Cloud
from orusd_scans.scanned import Scanned, broken, opened

_DRACO: Final = "KHR_draco_mesh_compression"
_CHUNK: Final = 20  # bytes before the JSON of a GLB
_LARGEST: Final = 1 << 31
# glTF fixes its vertical axis; the others do not.
_Y_UP: Final = (".glb",)


def read_mesh(path: Path) -> Scanned:
    """Read all meshes of a file in its common frame.

    Raises:
        InputError: trimesh cannot read it, or it has no triangles.
        MissingPackageError: It is compressed with Draco, which is not installed.
    """
    suffix = path.suffix.lower()
    if path.is_file() and path.stat().st_size > _LARGEST:
        raise broken(path, "it is too large for a mesh", "export it as PLY")
    with opened(path) as stream:
        content = stream.read()
    if suffix == ".glb":
        _check_draco(content, path)
    meshes = _load(content, suffix.removeprefix("."), path)
    if not meshes:
        raise broken(path, "it has no triangles")
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    points = np.concatenate([np.asarray(mesh.vertices, np.float64) for mesh in meshes])
    cloud = Cloud(points=points, colors=_colors(meshes))
    return Scanned(cloud, np.concatenate(faces).astype(np.int64), "Y" if suffix in _Y_UP else "Z")


def _check_draco(content: bytes, path: Path) -> None:
    """Without DracoPy, trimesh reads compressed meshes as zeros and only warns."""
    if len(content) < _CHUNK or content[:4] != b"glTF":
        raise broken(path, "this is no GLB file")
    size = int.from_bytes(content[12:16], "little")
    try:
        header = json.loads(content[_CHUNK : _CHUNK + size])
        used = header.get("extensionsUsed", [])
    except (ValueError, AttributeError, RecursionError) as error:
        raise broken(path, f"its JSON is not readable: {error}") from error
    if isinstance(used, list) and _DRACO in used and find_spec("DracoPy") is None:
        raise MissingPackageError(
            "this mesh is compressed with Draco, and DracoPy is not installed",
            place=path,
            remedy="pip install 'openrooms_usd[draco]', or export it without compression",
        )


def _load(content: bytes, kind: str, path: Path) -> list[Any]:
    """Meshes with their nodes' transforms; whatever trimesh stumbles over is the file's fault."""
    import trimesh

    try:
        scene = trimesh.load_scene(io.BytesIO(content), file_type=kind, process=False)
        found = []
        for node in sorted(scene.graph.nodes_geometry):
            matrix, name = scene.graph[node]
            mesh = scene.geometry[name]
            if len(getattr(mesh, "faces", ())):
                found.append(mesh.copy().apply_transform(matrix))
    except MemoryError:
        raise
    except Exception as error:
        raise broken(path, f"not a readable {kind.upper()} file: {error}") from error
    return found


def _colors(meshes: list[Any]) -> Any:
    """Colours of the points, where all meshes have them."""
    if not all(mesh.visual.kind == "vertex" for mesh in meshes):
        return None
    return np.concatenate([np.asarray(m.visual.vertex_colors)[:, :3] for m in meshes]).astype("u1")
