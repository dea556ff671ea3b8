"""Reads OBJ files: groups and materials as pieces, polygons kept, MTL constants and pictures."""

import math
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from openrooms_usd import untrusted
from openrooms_usd.arrays import Array, Floats
from openrooms_usd.colorimetry import linear_from_srgb
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.library.models.pieces import ModelPart, Reading, colored
from openrooms_usd.scan.models.objtext import standard_obj, statements

if TYPE_CHECKING:
    from openrooms_usd.usd.shading.materials import PreviewSurface, Texture

Corner = tuple[int, int | None, int | None]

# Words of a vertex with a colour: x, y, z and r, g, b.
_COLORED: Final = 7
# Statements that say nothing of shapes or looks.
_READ_OF_MTL: Final = frozenset(("Kd", "Ns", "d", "map_Kd", "illum", "Ka"))
_SHAPELESS: Final = frozenset(("s", "mg"))
# Folders beside a model's own that may hold its pictures.
_PICTURE_FOLDERS: Final = ("images", "textures", "texture")


@dataclass
class _Obj:
    """A file that is being read: vertices so far, and corners by (group, material)."""

    path: Path
    v: list[list[float]] = field(default_factory=list)
    colors: list[list[float]] = field(default_factory=list)
    vt: list[list[float]] = field(default_factory=list)
    vn: list[list[float]] = field(default_factory=list)
    faces: dict[tuple[str, str], list[list[Corner]]] = field(default_factory=dict)
    libraries: list[str] = field(default_factory=list)
    unused: dict[str, None] = field(default_factory=dict)
    group: str = ""
    material: str = ""


def read_obj(path: Path) -> Reading:
    """Read an OBJ file.

    Args:
        path: The file. Material libraries and pictures are only looked for below its folder.

    Returns:
        One piece for each group and material.

    Raises:
        InputError: It is not an OBJ file, or a face names a vertex that does not exist.
    """
    obj = _Obj(path)
    text, told = standard_obj(untrusted.read_text(path, "model"), path)
    for number, words in _lines(text):
        try:
            _statement(obj, words)
        except (ValueError, IndexError) as error:
            raise InputError(
                f"not a valid OBJ statement: {' '.join(words)[:60]!r} ({error})",
                place=f"{path}:{number}",
                remedy="export the mesh again",
            ) from error
    notes: list[str] = []
    if obj.unused:
        notes.append(f"not used of the OBJ file: {', '.join(obj.unused)[:300]}")
    surfaces, painted = _read_libraries(obj, notes), _colors(obj)
    groups = Counter(group for group, _ in obj.faces)
    pieces = [
        ModelPart(
            f"{group}_{material}" if groups[group] > 1 and material else group or path.stem,
            _mesh(obj, corners),
            _painted(painted, corners, group or path.stem, surfaces.get(material), notes),
            material=material,
        )
        for (group, material), corners in obj.faces.items()
    ]
    return Reading(pieces, [*told, *notes])


def libraries_of(path: Path) -> Iterator[Path]:
    """The material libraries of an OBJ file and their pictures, as far as they are read."""
    text = untrusted.read_text(path, "model")
    for line in re.findall(r"^[ \t]*mtllib[ \t]+([^\n]+)", statements(text), re.MULTILINE):
        library = beside(path, " ".join(line.split()), [])
        if library is not None:
            yield library
            pictures = (
                words[-1]
                for _, words in _lines(statements(untrusted.read_text(library, "model")))
                if words[0] == "map_Kd"
            )
            yield from filter(None, (beside(library, name, []) for name in pictures))


def _lines(text: str) -> Iterator[tuple[int, list[str]]]:
    """The words of statements, with their line numbers."""
    for number, line in enumerate(text.split("\n"), start=1):
        if words := line.split():
            yield number, words


def _statement(obj: _Obj, words: list[str]) -> None:
    match words[0]:
        case "v":
            x, y, z = (float(word) for word in words[1:4])
            obj.v.append([x, y, z])
            if len(words) >= _COLORED:
                obj.colors.append([float(word) for word in words[4:7]])
        case "vt":
            obj.vt.append([float(word) for word in [*words[1:3], "0"][:2]])
        case "vn":
            x, y, z = (float(word) for word in words[1:4])
            obj.vn.append([x, y, z])
        case "f":
            face = [_corner(obj, word) for word in words[1:]]
            if len(face) < 3:
                raise ValueError("a face needs three corners")
            obj.faces.setdefault((obj.group, obj.material), []).append(face)
        case "g" | "o":
            obj.group = " ".join(words[1:])
        case "usemtl":
            obj.material = " ".join(words[1:])
        case "mtllib":
            obj.libraries.append(" ".join(words[1:]))
        case unused if unused not in _SHAPELESS:
            obj.unused[unused] = None


def _corner(obj: _Obj, word: str) -> Corner:
    fields = [*word.split("/"), "", ""]
    v = _index(fields[0], len(obj.v))
    if v is None:
        raise ValueError("a corner without a vertex")
    return v, _index(fields[1], len(obj.vt)), _index(fields[2], len(obj.vn))


def _index(text: str, count: int) -> int | None:
    """OBJ counts from 1, and backwards from the last with negative numbers."""
    if not text:
        return None
    number = int(text)
    index = number - 1 if number > 0 else count + number
    if number == 0 or not 0 <= index < count:
        raise ValueError(f"index {number} of {count}")
    return index


def _mesh(obj: _Obj, faces: list[list[Corner]]) -> Mesh:
    corners = [corner for face in faces for corner in face]
    v = np.array([corner[0] for corner in corners])
    used, indices = np.unique(v, return_inverse=True)
    st = [corner[1] for corner in corners]
    normals = [corner[2] for corner in corners]
    return Mesh(
        points=np.array([obj.v[i] for i in used.tolist()], dtype=np.float64),
        counts=np.array([len(face) for face in faces], dtype=np.int32),
        indices=indices.astype(np.int32),
        normals=_gathered(obj.vn, normals),
        st=_gathered(obj.vt, st),
    )


def _colors(obj: _Obj) -> Array | None:
    """(N, 3) the colours of the vertices, scene-linear; None where not all vertices have one."""
    if not obj.colors or len(obj.colors) < len(obj.v):
        return None
    colors = np.array(obj.colors)
    is_bytes = bool((colors[np.isfinite(colors)] > 1.0).any())
    return linear_from_srgb(colors / 255.0 if is_bytes else colors)


def _painted(
    colors: Array | None,
    faces: list[list[Corner]],
    title: str,
    surface: "PreviewSurface | None",
    notes: list[str],
) -> "PreviewSurface | None":
    """The surface with the colours of the vertices, where these have some."""
    if colors is None:
        return surface
    rows = sorted({corner[0] for face in faces for corner in face})
    return colored(title, surface, colors[rows], notes)


def _gathered(rows: list[list[float]], indices: list[int | None]) -> Floats | None:
    found = [index for index in indices if index is not None]
    if len(found) < len(indices):
        return None
    return np.array([rows[index] for index in found], dtype=np.float32)


def _read_libraries(obj: _Obj, notes: list[str]) -> "dict[str, PreviewSurface]":
    surfaces: dict[str, PreviewSurface] = {}
    for name in dict.fromkeys(obj.libraries):
        path = beside(obj.path, name, notes)
        if path is not None:
            surfaces |= _read_mtl(path, notes)
    return surfaces


def beside(model: Path, name: str, notes: list[str]) -> Path | None:
    """A file that a model names, if it lies in or below the model's folder, or one for pictures.

    ShapeNet and PartNet keep the pictures of ``models/model_normalized.obj`` and
    ``objs/original-1.obj`` in the folder ``images`` beside theirs.
    """
    folder = model.parent.resolve()
    path = folder / name.replace("\\", "/")
    try:
        untrusted.check_path(path)
        path = path.resolve()
    except (InputError, OSError, RuntimeError):  # links in a circle
        notes.append(f"{name[:60]!r} cannot be the path of a file and is ignored")
        return None
    from openrooms_usd.usd.files.strayed import is_in, meant

    allowed = [folder, *(folder.parent / beside for beside in _PICTURE_FOLDERS)]
    inside = is_in(path, allowed)
    if inside and path.is_file():
        return path
    found = meant(folder, name, allowed)
    why = "does not exist" if inside else "lies outside the model's folder"
    without = "" if inside else " and is ignored"
    notes.append(f"{name!r} {why}" + (f", {found.name} is used" if found else without))
    return found


def _read_mtl(path: Path, notes: list[str]) -> "dict[str, PreviewSurface]":
    blocks: dict[str, dict[str, list[str]]] = {}
    block: dict[str, list[str]] = {}
    for _, words in _lines(statements(untrusted.read_text(path, "model"))):
        if words[0] == "newmtl":
            block = blocks.setdefault(" ".join(words[1:]), {})
        else:
            block[words[0]] = words[1:]
    surfaces = {}
    for name, values in blocks.items():
        unused = [word for word in values if word not in _READ_OF_MTL]
        if unused:
            notes.append(f"not used of the material {name!r}: {', '.join(unused)[:200]}")
        try:
            surfaces[name] = _surface(path, values, notes)
        except (ValueError, IndexError):
            notes.append(f"the material {name!r} in {path.name} is not valid and is ignored")
    return surfaces


def _surface(path: Path, values: dict[str, list[str]], notes: list[str]) -> "PreviewSurface":
    """Constants and the diffuse picture; the gloss exponent as GGX roughness.

    Roughness from the Blinn-Phong exponent n: alpha = sqrt(2 / (n + 2)) (Walter et al. 2007),
    perceptual roughness is its root.
    """
    from openrooms_usd.usd.shading.materials import PreviewSurface

    r, g, b = (_clipped(v, 1.0) for v in values.get("Kd", ["0.8"] * 3)[:3])
    exponent = _clipped(values.get("Ns", ["10"])[0], 1e6)
    opacity = _clipped(values["d"][-1], 1.0) if "d" in values else 1.0
    picture = _picture(path, values["map_Kd"][-1], notes) if "map_Kd" in values else None
    return PreviewSurface(
        base_color=picture or (r, g, b),
        roughness=round((2.0 / (exponent + 2.0)) ** 0.25, 4),
        opacity=opacity,
    )


def _clipped(word: str, most: float) -> float:
    number = float(word)
    if not math.isfinite(number):
        raise ValueError(f"{word} is not a number")
    return min(max(number, 0.0), most)


def _picture(path: Path, name: str, notes: list[str]) -> "Texture | None":
    from openrooms_usd.usd.shading.materials import Texture
    from openrooms_usd.usd.shading.textures import flaw

    file = beside(path, name, notes)
    if file is None:
        return None
    if why := flaw(str(file)):
        notes.append(why)
        return None
    return Texture(str(file), color_space="sRGB")
