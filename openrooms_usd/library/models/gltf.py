"""Reads GLB, PLY and STL files through trimesh: nodes as pieces, of one colour each."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import untrusted
from openrooms_usd.arrays import Array, Floats
from openrooms_usd.colorimetry import linear_from_srgb
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.library.models.pieces import ModelPart, Reading, colored
from openrooms_usd.scan.models.meshscene import ShownMesh, glb_header, shown_meshes

if TYPE_CHECKING:
    from openrooms_usd.usd.shading.materials import PreviewSurface


# Base colour of a material that says none, scene-linear.
_UNSAID: Final = (0.6, 0.6, 0.6)
# What is read of GLB and PLY files; primitives of these modes have triangles, or strips of them.
_ATTRIBUTES: Final = ("POSITION", "NORMAL", "TEXCOORD_0", "COLOR_0")
_EXTENSIONS: Final = ("KHR_draco_mesh_compression",)
_TRIANGLES: Final = (4, 5)
_FANS: Final = 6
_PROPERTIES: Final = frozenset(
    "x y z nx ny nz red green blue alpha vertex_indices vertex_index".split()
)
_PLY_HEADER: Final = 1 << 16  # bytes


def read_glb(path: Path) -> Reading:
    """Read a binary glTF 2.0 file.

    Raises:
        InputError: It is not a GLB file, or it is truncated.
        MissingPackageError: It is compressed by Draco and DracoPy is not installed.
    """
    content = untrusted.read_bytes(path, "model")
    header = glb_header(content, path)
    notes = _unused(header)
    pieces = _pieces(shown_meshes(path, content), path.stem, notes)
    return Reading(pieces, notes, licence=_copyright(header))


def read_ply(path: Path) -> Reading:
    """Read a PLY mesh; it is taken to be Z up, as scans are.

    Raises:
        InputError: It is not a PLY file, is truncated, or holds points without faces.
    """
    content = untrusted.read_bytes(path, "model")
    if not content.startswith(b"ply"):
        raise InputError("not a PLY file", place=path, remedy="export the mesh again")
    shown, notes = shown_meshes(path, content), list[str]()
    for one in shown:
        notes += _unused_properties(one.mesh.metadata.get("_ply_raw", {}))
    if re.search(rb"^comment TextureFile", content[:_PLY_HEADER], re.MULTILINE):
        notes.append("the picture that the PLY file names is not used")
    return Reading(_pieces(shown, path.stem, notes, encoded=True), notes, up="Z")


def read_stl(path: Path) -> Reading:
    """Read an STL mesh; it is taken to be Z up, as programs for parts are.

    Raises:
        InputError: It is not an STL file, or it is truncated.
    """
    content = untrusted.read_bytes(path, "model")
    shown, notes = shown_meshes(path, content), list[str]()
    if any(np.any(one.mesh.face_attributes.get("stl", 0)) for one in shown):
        notes.append("the colours of the STL file's facets are not used")
    return Reading(_pieces(shown, path.stem, notes, encoded=True), notes, up="Z")


def _unused(header: dict[str, Any]) -> list[str]:
    """What a GLB file has and is not used, in a sentence or two."""
    count = len(_rows(header, "images"))
    notes = [f"{count} textures in the GLB file are left out"] if count else []
    unused = [name for name in ("animations", "skins", "cameras") if header.get(name)]
    for mesh in _rows(header, "meshes"):
        for primitive in _rows(mesh, "primitives"):
            attributes = primitive.get("attributes")
            named = attributes if isinstance(attributes, dict) else ()
            unused += [name for name in named if name not in _ATTRIBUTES]
            unused += ["morph targets"] if primitive.get("targets") else []
            if (mode := primitive.get("mode", _TRIANGLES[0])) not in _TRIANGLES:
                unused.append("triangle fans" if mode == _FANS else "points and lines")
    for material in _rows(header, "materials"):
        glow = material.get("emissiveFactor")
        unused += ["emission"] if isinstance(glow, list) and any(glow) else []
        unused += ["masks"] if material.get("alphaMode") == "MASK" else []
    extensions = header.get("extensionsUsed")
    listed = map(str, extensions) if isinstance(extensions, list) else ()
    unused += [name for name in listed if name not in _EXTENSIONS]
    if unused:
        notes.append(f"not used of the GLB file: {', '.join(dict.fromkeys(unused))[:300]}")
    return notes


def _rows(header: dict[str, Any], name: str) -> list[dict[str, Any]]:
    """The objects of a list, which may be anything in a file of others."""
    rows = header.get(name)
    return [row for row in rows if isinstance(row, dict)] if isinstance(rows, list) else []


def _unused_properties(elements: dict[str, Any]) -> list[str]:
    """What the vertices and faces of a PLY file have besides, in a sentence."""
    unused = [
        name
        for element in ("vertex", "face")
        for name in elements.get(element, {}).get("properties", ())
        if name not in _PROPERTIES
    ]
    return [f"not used of the PLY file: {', '.join(unused)[:300]}"] if unused else []


def _copyright(header: dict[str, Any]) -> str:
    asset = header.get("asset")
    return str(asset.get("copyright") or "") if isinstance(asset, dict) else ""


def _pieces(
    shown: Sequence[ShownMesh], title: str, notes: list[str], *, encoded: bool = False
) -> list[ModelPart]:
    """A piece for each mesh; its colours are for screens where they are encoded, else linear."""
    # What has no name in the file is called so by trimesh.
    named = {one.name for one in shown} - {"geometry_0"}
    with np.errstate(invalid="ignore", over="ignore"):  # what is not finite is refused later
        pieces = []
        for one in shown:
            name, surface = one.name if named else title, _surface(one.mesh.visual)
            if (colors := _colors(one.mesh.visual)) is not None:
                linear = linear_from_srgb(colors) if encoded else colors
                surface = colored(name, surface, linear, notes)
            mesh = _mesh(one.mesh).transformed(one.file_from_mesh)
            pieces.append(ModelPart(name, mesh, surface))
        return pieces


def _colors(visual: Any) -> Array | None:
    """(N, 3) the colours of vertices or faces, from 0 to 1; None without any."""
    if visual.kind in ("vertex", "face"):
        values = visual.vertex_colors if visual.kind == "vertex" else visual.face_colors
        return np.asarray(values, dtype=np.float64)[:, :3] / 255.0
    given = getattr(visual, "vertex_attributes", {}).get("color")
    return None if given is None else np.asarray(given, dtype=np.float64)[:, :3]


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


def _at(corners: NDArray[np.int32], values: Any, count: int, width: int) -> Floats | None:
    """What each corner has of values of the points; None where they are not theirs."""
    if values is None or np.shape(values) != (count, width):
        return None
    return np.asarray(values, dtype=np.float32)[corners]


def _surface(visual: Any) -> "PreviewSurface | None":
    """The constants of a glTF material; what it leaves out is as the format has it, but grey.

    The format's default white reflects all light and is a metal, which files without a material do
    not intend.
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
