"""Reads USD files as pieces: one a gprim, with its bound UsdPreviewSurface."""

from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.library.models.pieces import ModelPart, Reading, colored
from openrooms_usd.portable import relative_text

if TYPE_CHECKING:
    from pxr import Usd

    from openrooms_usd.usd.shading.materials import PreviewSurface
    from openrooms_usd.usd.shapes.meshes import PlacedMesh

USD_SUFFIXES: Final = (".usd", ".usda", ".usdc", ".usdz")


def read_usd(path: Path) -> Reading:
    """Read a USD, USDA, USDC or USDZ file.

    Layers outside its folder that it refers to are read, which is noted.

    Raises:
        InputError: It is not a readable USD file, or refers to something that is not a file.
    """
    from openrooms_usd.usd.files.diagnostics import reading
    from openrooms_usd.usd.files.layers import open_stage

    notes = _layers_elsewhere(path)
    stage = open_stage(path)
    with reading(path):
        return _read(stage, path, notes)


def _read(stage: "Usd.Stage", path: Path, notes: list[str]) -> Reading:
    from pxr import UsdGeom

    from openrooms_usd.usd.places.frames import stated_metres, up_axis, world_from_stage
    from openrooms_usd.usd.shapes.meshes import read_meshes

    reading = read_meshes(stage)
    stage_from_world = np.linalg.inv(world_from_stage(stage))
    notes += [f"{prim}: {outcome}, {reason}" for prim, outcome, reason in reading.losses]
    pieces = []
    for placed in reading:
        stage_from_local = stage_from_world @ placed.world_from_local
        surface = _surface(placed, path, notes)
        pieces.append(
            ModelPart(placed.prim.GetName(), _mesh(placed).transformed(stage_from_local), surface)
        )
    up: Literal["Y", "Z"] = "Y" if up_axis(stage) == UsdGeom.Tokens.y else "Z"
    return Reading(pieces, notes, up, stated_metres(stage), _licence(stage))


def _layers_elsewhere(path: Path) -> list[str]:
    """Notes on the layers outside a file's folder that it is composed of."""
    from openrooms_usd.usd.files.preflight import check_stage_file

    home, start = path.parent.resolve(), path.parent.absolute()
    files = {Path(layer.realPath.partition("[")[0]) for layer in check_stage_file(path)}
    outside = (file for file in files if not file.resolve().is_relative_to(home))
    names = sorted(relative_text(file, start) for file in outside)
    return [f"{name!r}, outside the model's folder, is read, too" for name in names]


def layers_of(path: Path) -> list[Path]:
    """All files that a USD file refers to, directly or through others; absolute paths."""
    from pxr import UsdUtils

    from openrooms_usd.usd.files.diagnostics import UNREADABLE
    from openrooms_usd.usd.files.preflight import check_stage_file

    try:
        check_stage_file(path)
        layers, assets, _ = UsdUtils.ComputeAllDependencies(str(path))
    except (*UNREADABLE, InputError):
        # What is broken is said when the file is read.
        return []
    files = (Path(file) for file in [*(layer.realPath for layer in layers), *assets])
    return [file.resolve() for file in files if file.is_file()]


def _licence(stage: "Usd.Stage") -> str:
    """The distinct terms that the prims of a stage state."""
    from pxr import Usd

    infos = (prim.GetAssetInfo() for prim in stage.Traverse(Usd.TraverseInstanceProxies()))
    stated = (info.get("license") or info.get("licence") for info in infos)
    return "; ".join(dict.fromkeys(str(terms) for terms in stated if terms))


def _mesh(placed: "PlacedMesh") -> Mesh:
    mesh = placed.mesh
    return Mesh(
        points=mesh.points,
        counts=np.full(len(mesh.triangles), 3, dtype=np.int32),
        indices=mesh.triangles.reshape(-1),
        normals=None if mesh.normals is None else mesh.normals.reshape(-1, 3),
        st=None if mesh.st is None else mesh.st.reshape(-1, 2),
    )


def _surface(placed: "PlacedMesh", path: Path, notes: list[str]) -> "PreviewSurface | None":
    """The bound material, without pictures from elsewhere; without one, the displayed colour."""
    from pxr import UsdGeom

    from openrooms_usd.usd.shading.materialreader import read_preview_surface
    from openrooms_usd.usd.shading.materials import PreviewSurface, Texture, bound_material

    material = bound_material(placed.prim)
    if not material:
        shown = UsdGeom.Gprim(placed.prim).GetDisplayColorAttr().Get()
        name = placed.prim.GetName()
        return colored(name, None, np.asarray(shown, np.float64), notes) if shown else None
    surface, losses = read_preview_surface(material)
    notes.extend(f"{material.GetPath()}: {loss}" for loss in losses)
    kept = {}
    for name, value in vars(surface).items():
        if isinstance(value, Texture) and not _inside(value.file, path):
            notes.append(f"{value.file!r} lies outside the model's folder and is ignored")
            kept[name] = getattr(PreviewSurface, name)
        else:
            kept[name] = value
    return PreviewSurface(**kept)


def _inside(file: str, model: Path) -> bool:
    """Whether a picture is a file in or below the model's folder, or packed with it."""
    from openrooms_usd.usd.shading import textures

    # Tiles are many files, and a model takes single ones along.
    if textures.is_udim(file):
        return False
    outer = Path(file.partition("[")[0])
    untrusted.check_path(outer)
    return outer.is_file() and outer.resolve().is_relative_to(model.parent.resolve())
