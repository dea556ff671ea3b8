"""Reads GLB and PLY files through trimesh: nodes as pieces, with constant materials."""

import importlib.util
import json
import struct
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from openrooms_usd.errors import InputError, MissingPackageError
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.library.pieces import Piece, Reading

if TYPE_CHECKING:
    from openrooms_usd.usd.materials import PreviewSurface

DRACO: Final = "KHR_draco_mesh_compression"
_MAGIC: Final = b"glTF"
_JSON: Final = 0x4E4F534A


def read_glb(path: Path) -> Reading:
    """Read a binary glTF 2.0 file.

    Raises:
        InputError: It is no GLB file, or it is truncated.
        MissingPackageError: It is compressed by Draco and DracoPy is not installed.
    """
    content = path.read_bytes()
    header = _header(content, path)
    used = header.get("extensionsRequired", [])
    if DRACO in used and importlib.util.find_spec("DracoPy") is None:
        raise MissingPackageError(
            "its meshes are compressed by Draco, and the decoder is not installed",
            place=path,
            remedy="pip install 'openrooms-usd[draco]'",
        )
    pieces = _pieces(_load(content, "glb", path), path.stem)
    return Reading(pieces, _picture_notes(header), licence=_copyright(header))


def read_ply(path: Path) -> Reading:
    """Read a PLY mesh; it is taken to be Z up, as scans are.

    Raises:
        InputError: It is no PLY file, is truncated, or holds points without faces.
    """
    content = path.read_bytes()
    if not content.startswith(b"ply"):
        raise InputError("not a PLY file", place=path, remedy="export the mesh again")
    return Reading(_pieces(_load(content, "ply", path), path.stem), up="Z")


def _header(content: bytes, path: Path) -> dict[str, Any]:
    """The JSON of a GLB file, its lengths checked."""
    try:
        magic, version, length, size, kind = struct.unpack_from("<4sIIII", content)
        if magic != _MAGIC or version != 2 or kind != _JSON:
            raise ValueError("it does not begin as GLB 2 does")
        if length > len(content):
            raise ValueError(f"it is truncated: {len(content)} of {length} bytes")
        header = json.loads(content[20 : 20 + size])
        if not isinstance(header, dict):
            raise ValueError("its description is no JSON object")
    except (struct.error, ValueError, RecursionError) as error:
        raise InputError(
            f"not a readable GLB file: {error}", place=path, remedy="export the mesh again"
        ) from error
    return header


def _picture_notes(header: dict[str, Any]) -> list[str]:
    count = len(header.get("images", []))
    return [f"{count} textures in the GLB file are left out"] if count else []


def _copyright(header: dict[str, Any]) -> str:
    asset = header.get("asset")
    return str(asset.get("copyright") or "") if isinstance(asset, dict) else ""


def _load(content: bytes, kind: str, path: Path) -> Any:
    """A trimesh scene; whatever trimesh stumbles over is the file's fault."""
    import io

    import trimesh

    try:
        return trimesh.load_scene(io.BytesIO(content), file_type=kind, process=False)
    except MemoryError:
        raise
    except Exception as error:
        raise InputError(
            f"not a readable {kind.upper()} file: {error}",
            place=path,
            remedy="open it with a mesh viewer and export it again",
        ) from error


def _pieces(scene: Any, title: str) -> list[Piece]:
    pieces = []
    for node in sorted(scene.graph.nodes_geometry):
        matrix, name = scene.graph[node]
        mesh = scene.geometry[name]
        if len(getattr(mesh, "faces", ())):
            known = name if scene.geometry.keys() - {"geometry_0"} else title
            pieces.append(Piece(known, _mesh(mesh).transformed(matrix), _surface(mesh.visual)))
    return pieces


def _mesh(mesh: Any) -> Mesh:
    faces = np.asarray(mesh.faces, dtype=np.int32)
    corners = faces.reshape(-1)
    # Normals that trimesh would make up are worse than ours, which know creases.
    given = "vertex_normals" in mesh._cache.cache
    uv = getattr(mesh.visual, "uv", None)
    return Mesh(
        points=np.asarray(mesh.vertices, dtype=np.float64),
        counts=np.full(len(faces), 3, dtype=np.int32),
        indices=corners,
        normals=np.asarray(mesh.vertex_normals, dtype=np.float32)[corners] if given else None,
        st=None if uv is None else np.asarray(uv, dtype=np.float32)[corners],
    )


def _surface(visual: Any) -> "PreviewSurface | None":
    """The constants of a glTF material."""
    from openrooms_usd.usd.materials import PreviewSurface

    material: Any = getattr(visual, "material", None)
    factor = getattr(material, "baseColorFactor", None)
    if factor is None or getattr(material, "baseColorTexture", None) is not None:
        return None
    r, g, b, a = (float(v) / 255.0 for v in np.asarray(factor, dtype=np.float64)[:4])
    metallic, roughness = material.metallicFactor, material.roughnessFactor
    return PreviewSurface(
        base_color=(r, g, b),
        metallic=1.0 if metallic is None else float(metallic),
        roughness=1.0 if roughness is None else float(roughness),
        opacity=a if material.alphaMode == "BLEND" else 1.0,
    )
