"""CADs to choose from for a scan: a folder of the user's meshes, or the library's furniture."""

import json
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import untrusted
from openrooms_usd.arrays import Array
from openrooms_usd.draws import generator
from openrooms_usd.errors import InputError
from openrooms_usd.furniture import category, make
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.library.assets import Model
from openrooms_usd.library.models.meshfile import read_model
from openrooms_usd.portable import in_order
from openrooms_usd.scan.models.cad import Symmetry
from openrooms_usd.scan.models.cad import Up as AnyUp

Known = TypeVar("Known")

INDEX: Final = "index.json"
# Spellings without case: ours, the group's, and Scan2CAD's.
_SYMMETRIES: Final[dict[str, Symmetry]] = {
    **dict.fromkeys(("none", "1", "c1", "__sym_none"), "none"),
    **dict.fromkeys(("2", "c2", "__sym_rotate_up_2"), "2"),
    **dict.fromkeys(("4", "c4", "__sym_rotate_up_4"), "4"),
    **dict.fromkeys(("inf", "cinf", "__sym_rotate_up_inf"), "inf"),
}
_AXES: Final[dict[str, AnyUp]] = {"x": "X", "y": "Y", "z": "Z"}


@dataclass(frozen=True)
class CadFile:
    """A mesh file of a folder of CADs, and what the folder's index says of it.

    Attributes:
        id: What hints and reports call it.
        path: The file.
        category: By the index, else the name of its folder; empty in the folder itself.
        symmetry: About its vertical; None if unknown.
        up: Its vertical axis; None if unknown.
        entry: All that the index says.
    """

    id: str
    path: Path
    category: str
    symmetry: Symmetry | None
    up: AnyUp | None
    entry: Mapping[str, Any]


def cad_files(folder: Path, suffixes: Collection[str]) -> tuple[CadFile, ...]:
    """The mesh files of a folder and of those below it, by id.

    A CAD's id is the name of its file without suffix; where several have the same (as ShapeNet's
    ``model_normalized``), it is the first folder above that tells them apart. ``index.json`` may
    give, by id or path, a category, or ``{category, symmetry, up}``. Those that it does not name
    have the category of their folder.

    Args:
        folder: The folder.
        suffixes: Of the files that count, in lower case.

    Raises:
        InputError: The folder or the index cannot be read.
    """
    untrusted.check_path(folder)
    if not folder.is_dir():
        raise InputError("no such folder of CADs", place=folder, remedy="check furniture.cad")
    index = _read_index(folder / INDEX)
    return tuple(
        _described(folder, path, name, _entry(index, folder, path, name))
        for name, path in sorted(_named(folder, suffixes).items())
    )


def _described(folder: Path, path: Path, name: str, entry: Mapping[str, Any]) -> CadFile:
    parent = path.parent.name if path.parent != folder else ""
    return CadFile(
        name,
        path,
        str(entry.get("category", parent)),
        _chosen(_SYMMETRIES, entry, "symmetry", folder),
        _chosen(_AXES, entry, "up", folder),
        entry,
    )


def _named(folder: Path, suffixes: Collection[str]) -> dict[str, Path]:
    paths = in_order(path for path in folder.rglob("*") if path.suffix.lower() in suffixes)
    paths = [path for path in paths if path.is_file()]
    names = {path: path.relative_to(folder).with_suffix("").parts for path in paths}
    stems = Counter(parts[-1] for parts in names.values())
    return {
        parts[-1] if stems[parts[-1]] == 1 else _distinct(parts, names.values()): path
        for path, parts in names.items()
    }


def _distinct(parts: tuple[str, ...], all_parts: Collection[tuple[str, ...]]) -> str:
    """The innermost folder that no other CAD of the same name lies in, else the whole path."""
    same = [other for other in all_parts if other[-1] == parts[-1] and other != parts]
    for folder in reversed(parts[:-1]):
        if all(folder not in other[:-1] for other in same):
            return folder
    return "/".join(parts)


def _read_index(path: Path) -> Mapping[str, Any]:
    if not path.exists():
        return {}
    try:
        index = json.loads(untrusted.read_text(path, "json"))
    except (ValueError, RecursionError) as error:
        raise InputError(
            f"the index of the CADs cannot be read: {error}", place=path, remedy="correct the JSON"
        ) from error
    if not isinstance(index, dict):
        raise InputError(
            "the index of the CADs is not an object",
            place=path,
            remedy='write {"<id>": {"category": "chair", "symmetry": "none"}}',
        )
    return index


def _entry(index: Mapping[str, Any], folder: Path, path: Path, name: str) -> Mapping[str, Any]:
    """What the index says of a CAD."""
    relative = path.relative_to(folder)
    for key in _keys(relative, name):
        if key in index:
            entry = index[key]
            if isinstance(entry, str):
                return {"category": entry}
            if isinstance(entry, dict):
                return entry
            raise InputError(
                f"the entry of {key!r} is neither a category nor an object",
                place=folder / INDEX,
                remedy='write {"category": "chair", "symmetry": "none"}',
            )
    return {}


def _keys(relative: Path, name: str) -> Iterator[str]:
    yield name
    yield relative.as_posix()
    yield relative.with_suffix("").as_posix()
    yield relative.name


def _chosen(
    table: Mapping[str, Known], entry: Mapping[str, Any], key: str, folder: Path
) -> Known | None:
    value = entry.get(key)
    if value is None:
        return None
    found = table.get(str(value).lower())
    if found is None:
        raise InputError(
            f"{key} {value!r} is not known",
            place=folder / INDEX,
            remedy=f"write one of: {', '.join(sorted({str(v) for v in table.values()}))}",
        )
    return found


Up = Literal["Y", "Z"]
Front = Literal["+X", "-X", "+Y", "-Y"]

# Files of other endings in the folder are textures and the like.
_ENDINGS: Final = (".obj", ".glb", ".ply", ".usd", ".usda", ".usdc", ".usdz")
_MAX_FILES: Final = 10_000
_UPS: Final[tuple[Up, ...]] = get_args(Up)
_FRONTS: Final[tuple[Front, ...]] = get_args(Front)


@dataclass(frozen=True)
class Cad:
    """A mesh that may stand for something in a scan.

    Attributes:
        id: What descriptions and reports call it: of a file its name without the ending.
        category: What it is; empty where nothing says it.
        file: The user's file; None for furniture of the library.
        style: Of the library's furniture.
        symmetry: About its vertical; None: to be found from the mesh.
        up: The file's vertical axis; None: as its format has it.
        front: Where its front looks once that axis is turned to Z.
    """

    id: str
    category: str
    file: Path | None = None
    style: str = ""
    symmetry: Symmetry | None = None
    up: Up | None = None
    front: Front = "-Y"

    def model(self) -> Model:
        """The mesh in the object frame, metres; the file's own size, or the style's usual one.

        Raises:
            InputError: The file cannot be read.
        """
        if self.file is not None:
            return read_model(self.file, up=self.up, front=self.front, unit=1.0)
        spec = category(self.category)
        rng = generator(0, "cads", self.category, self.style)
        made = make(self.category, spec.styles[self.style].size or spec.size, self.style, rng)
        return Model(made.parts)


def furniture_cads(categories: Iterator[str] | tuple[str, ...]) -> list[Cad]:
    """One CAD for each style of some of the library's categories."""
    return [
        Cad(f"{name}.{style}", name, style=style)
        for name in categories
        for style in sorted(category(name).styles)
    ]


def folder_cads(folder: Path) -> list[Cad]:
    """The meshes of a folder and of those below it, with what its ``index.json`` says of them.

    Args:
        folder: Holds meshes; see `cad_files`. The index may also
            say where a CAD's ``front`` looks once its vertical is turned to Z.

    Raises:
        InputError: It is not a folder, has no mesh, or its index is damaged.
    """
    files = cad_files(folder, _ENDINGS)
    if not 0 < len(files) <= _MAX_FILES:
        raise InputError(
            f"it holds {len(files)} meshes, not 1 to {_MAX_FILES:,}",
            place=folder,
            remedy=f"put {', '.join(_ENDINGS)} files into it",
        )
    return [_cad(file, folder / INDEX) for file in files]


def _cad(file: CadFile, index: Path) -> Cad:
    front = file.entry.get("front", "-Y")
    for key, value, choices in (("front", front, _FRONTS), ("up", file.up, (None, *_UPS))):
        if value not in choices:
            raise InputError(
                f"{key} is {value!r}",
                place=f"{index}: {file.id}",
                remedy=f"one of {', '.join(filter(None, choices))}",
            )
    up: Up | None = "Y" if file.up == "Y" else "Z" if file.up == "Z" else None
    return Cad(file.id, file.category, file.path, symmetry=file.symmetry, up=up, front=front)


def merged(model: Model, frame: Array) -> tuple[NDArray[Any], NDArray[np.int32]]:
    """All parts of a model as triangles.

    Args:
        model: In the object frame.
        frame: (4, 4) to the frame of the result.

    Returns:
        (V, 3) vertices and (F, 3) faces.
    """
    vertices, faces, count = [], [], 0
    for mesh in model.parts.values():
        vertices.append(mesh.points @ frame[:3, :3].T + frame[:3, 3])
        faces.append(_triangles(mesh) + count)
        count += len(mesh.points)
    return np.concatenate(vertices), np.concatenate(faces).astype(np.int32)


def _triangles(mesh: Mesh) -> NDArray[np.int32]:
    corners, _ = mesh.triangles()
    return mesh.indices[corners]
