"""CADs to choose from for a scan: a folder of the user's meshes, or the library's furniture."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.draws import generator
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.library.assets import Model
from openrooms_usd.library.furniture import category, make
from openrooms_usd.library.meshfile import read_model

Up = Literal["Y", "Z"]
Front = Literal["+X", "-X", "+Y", "-Y"]
Symmetry = Literal["none", "2", "4", "inf"]

INDEX: Final = "index.json"
# Files of other endings in the folder are textures and the like.
_ENDINGS: Final = (".obj", ".glb", ".ply", ".usd", ".usda", ".usdc", ".usdz")
_MOST: Final = 10_000
_LONGEST: Final = 1 << 24  # bytes
_CHOICES: Final[Mapping[str, tuple[str, ...]]] = {
    "symmetry": get_args(Symmetry), "up": get_args(Up), "front": get_args(Front),
}  # fmt: skip


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
    """The meshes below a folder, by their names; what ``index.json`` says of them comes first.

    Args:
        folder: Holds meshes, at any depth; its index has by id ``category``, ``symmetry``, ``up``,
            ``front`` and ``file``, each optional.

    Raises:
        InputError: It is no folder, has no mesh, or its index is broken.
    """
    if not folder.is_dir():
        raise InputError("no such folder", place=folder, remedy="check `alignment.cad`")
    files = sorted(path for path in folder.rglob("*") if path.suffix.lower() in _ENDINGS)
    if not 0 < len(files) <= _MOST:
        raise InputError(
            f"it holds {len(files)} meshes, not 1 to {_MOST:,}",
            place=folder,
            remedy=f"put {', '.join(_ENDINGS)} files into it",
        )
    index = _index(folder)
    found = {path.stem: Cad(path.stem, "", path) for path in reversed(files)}
    for name, entry in index.items():
        found[name] = _described(folder, name, entry, found.get(name))
    return [found[name] for name in sorted(found)]


def _index(folder: Path) -> dict[str, Any]:
    path = folder / INDEX
    if not path.is_file():
        return {}
    try:
        if path.stat().st_size > _LONGEST:
            raise ValueError("it is too large")
        data = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(
            f"no readable index: {error}", place=path, remedy="JSON is expected"
        ) from error
    if not isinstance(data, dict) or not all(isinstance(row, dict) for row in data.values()):
        raise InputError(
            "an index has an object for each id", place=path,
            remedy='such as {"chair_a": {"category": "chair", "symmetry": "none"}}',
        )  # fmt: skip
    return data


def _described(folder: Path, name: str, entry: dict[str, Any], known: Cad | None) -> Cad:
    place = f"{folder / INDEX}: {name}"
    for key, choices in _CHOICES.items():
        if entry.get(key) not in (None, *choices):
            raise InputError(
                f"{key} is {entry[key]!r}", place=place, remedy=f"one of {', '.join(choices)}"
            )
    file = known.file if known else None
    if isinstance(given := entry.get("file"), str):
        file = folder / given
        if not file.resolve().is_relative_to(folder.resolve()):
            raise InputError(
                "the file lies outside the folder", place=place, remedy="move it there"
            )
    if file is None or not file.is_file():
        raise InputError("there is no mesh of this id", place=place, remedy="give its `file`")
    kind = entry.get("category")
    return Cad(
        name, kind if isinstance(kind, str) else "", file,
        symmetry=entry.get("symmetry"), up=entry.get("up"), front=entry.get("front") or "-Y",
    )  # fmt: skip


def merged(model: Model, frame: NDArray[np.float64]) -> tuple[NDArray[Any], NDArray[np.int32]]:
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
