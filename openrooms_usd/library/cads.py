"""CADs to choose from for a scan: a folder of the user's meshes, or the library's furniture."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.draws import generator
from openrooms_usd.errors import InputError
from openrooms_usd.furniture import category, make
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.library.assets import Model
from openrooms_usd.library.meshfile import read_model
from openrooms_usd.scan.models.cad import Symmetry
from openrooms_usd.scan.models.folder import INDEX, CadFile, cad_files

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
        folder: Holds meshes; see `openrooms_usd.scan.models.folder.cad_files`. The index may also
            say where a CAD's ``front`` looks once its vertical is turned to Z.

    Raises:
        InputError: It is no folder, has no mesh, or its index is broken.
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
