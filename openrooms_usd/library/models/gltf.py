"""Reads GLB, PLY and STL files through trimesh: nodes as pieces, with constant materials."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.library.models.pieces import Piece, Reading
from openrooms_usd.scan.models.meshscene import ShownMesh, glb_header, shown_meshes

if TYPE_CHECKING:
    from openrooms_usd.usd.shading.materials import PreviewSurface


# Base colour of a material that says none, scene-linear.
_UNSAID: Final = (0.6, 0.6, 0.6)


def read_glb(path: Path) -> Reading:
    """Read a binary glTF 2.0 file.

    Raises:
        InputError: It is no GLB file, or it is truncated.
        MissingPackageError: It is compressed by Draco and DracoPy is not installed.
    """
    content = untrusted.read_bytes(path, "model")
    header = glb_header(content, path)
    pieces = _pieces(shown_meshes(path, content), path.stem)
    return Reading(pieces, _picture_notes(header), licence=_copyright(header))


def read_ply(path: Path) -> Reading:
    """Read a PLY mesh; it is taken to be Z up, as scans are.

    Raises:
        InputError: It is no PLY file, is truncated, or holds points without faces.
    """
    content = untrusted.read_bytes(path, "model")
    if not content.startswith(b"ply"):
        raise InputError("not a PLY file", place=path, remedy="export the mesh again")
    return Reading(_pieces(shown_meshes(path, content), path.stem), up="Z")


def read_stl(path: Path) -> Reading:
    """Read an STL mesh; it is taken to be Z up, as programs for parts are.

    Raises:
        InputError: It is no STL file, or it is truncated.
    """
    content = untrusted.read_bytes(path, "model")
    return Reading(_pieces(shown_meshes(path, content), path.stem), up="Z")


def _picture_notes(header: dict[str, Any]) -> list[str]:
    count = len(header.get("images", []))
    return [f"{count} textures in the GLB file are left out"] if count else []


def _copyright(header: dict[str, Any]) -> str:
    asset = header.get("asset")
    return str(asset.get("copyright") or "") if isinstance(asset, dict) else ""


def _pieces(shown: Sequence[ShownMesh], title: str) -> list[Piece]:
    # What has no name in the file is called so by trimesh.
    named = {one.name for one in shown} - {"geometry_0"}
    with np.errstate(invalid="ignore", over="ignore"):  # what is not finite is refused later
        return [
            Piece(
                one.name if named else title,
                _mesh(one.mesh).transformed(one.file_from_mesh),
                _surface(one.mesh.visual),
            )
            for one in shown
        ]


def _mesh(mesh: Any) -> Mesh:
    points, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces)
    corners = faces.astype(np.int32).reshape(-1)
    # Normals that trimesh would make up are worse than ours, which know creases.
    given = "vertex_normals" in mesh._cache.cache
    return Mesh(
        points=points,
        counts=np.full(len(faces), 3, dtype=np.int32),
        indices=corners,
        normals=_at(corners, mesh.vertex_normals if given else None, len(points), 3),
        st=_at(corners, getattr(mesh.visual, "uv", None), len(points), 2),
    )


def _at(
    corners: NDArray[np.int32], values: Any, count: int, width: int
) -> NDArray[np.float32] | None:
    """What each corner has of values of the points; None where they are not theirs."""
    if values is None or np.shape(values) != (count, width):
        return None
    return np.asarray(values, dtype=np.float32)[corners]


def _surface(visual: Any) -> "PreviewSurface | None":
    """The constants of a glTF material; what it leaves out is as the format has it, but grey.

    The format's own white reflects all light and is a metal, which nobody means who says nothing.
    """
    from openrooms_usd.usd.shading.materials import PreviewSurface

    material: Any = getattr(visual, "material", None)
    factor = getattr(material, "baseColorFactor", None)
    if not hasattr(material, "baseColorFactor") or material.baseColorTexture is not None:
        return None
    if factor is None:
        roughness = 0.8 if material.roughnessFactor is None else float(material.roughnessFactor)
        return PreviewSurface(
            base_color=_UNSAID, metallic=float(material.metallicFactor or 0.0), roughness=roughness
        )
    r, g, b, a = (float(v) / 255.0 for v in np.asarray(factor, dtype=np.float64)[:4])
    metallic, roughness = material.metallicFactor, material.roughnessFactor
    return PreviewSurface(
        base_color=(r, g, b),
        metallic=1.0 if metallic is None else float(metallic),
        roughness=1.0 if roughness is None else float(roughness),
        opacity=a if material.alphaMode == "BLEND" else 1.0,
    )
