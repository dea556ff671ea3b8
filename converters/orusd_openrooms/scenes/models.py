"""A model of the dataset as one USD file: its meshes by material, with the materials of the scene.

What an OBJ file calls a material has no meaning without the scene, so an import writes each model
once, with its maps beside it, in the axes and the unit of its file.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd import names, untrusted
from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.library.models.pieces import ModelPart, prim_names
from openrooms_usd.library.models.wavefront import read_obj
from openrooms_usd.scratch import scratch_folder
from orusd_openrooms.scenes.materials import Find, pictures_of, stand_in, surface_of
from orusd_openrooms.scenes.records import Bsdf
from orusd_openrooms.scenes.roots import Named
from orusd_openrooms.scenes.sceneobjects import SceneObject, is_light

FILE: Final = "model.usdc"
_GREY: Final = Bsdf("", albedo=(0.5, 0.5, 0.5), roughness=1.0)
_MOST_M: Final = 1e5


class CadModel:
    """A model whose files are there.

    Attributes:
        item: An object that shows it.
        pieces: Its meshes by the names of their prims.
        wears: What each is made of; None for what emits.
        notes: What was guessed.
    """

    def __init__(self, item: SceneObject, files: list[Path], bsdfs: Mapping[str, Bsdf]) -> None:
        """Read the meshes.

        Args:
            item: An object that shows it.
            files: Those of its meshes, in the order of ``item.files``.
            bsdfs: The materials of the scene.

        Raises:
            InputError: A mesh is broken.
        """
        self.item = item
        self.notes: list[str] = []
        titles, pieces, wears = [], [], []
        for (name, radiance), file in zip(item.files, files, strict=True):
            lit = is_light(name, radiance)
            for piece in read_obj(file).pieces:
                _check(piece, file)
                bsdf = None if lit else self._material_of(piece, bsdfs)
                titles.append(names.LIGHT_BULB if bsdf is None else _part(bsdf, item))
                pieces.append(piece)
                wears.append(bsdf)
        prims = prim_names(titles)
        self.pieces: dict[str, ModelPart] = dict(zip(prims, pieces, strict=True))
        self.wears: dict[str, Bsdf | None] = dict(zip(prims, wears, strict=True))

    def _material_of(self, piece: ModelPart, bsdfs: Mapping[str, Bsdf]) -> Bsdf:
        """The material of a piece; of several that its shape may name the one of that name."""
        refs = self.item.refs
        if piece.material in refs:
            return bsdfs[piece.material]
        if len(refs) == 1:
            return bsdfs[refs[0]]
        self.notes.append(
            f"{'/'.join(self.item.model.parts)}: its shape has no material "
            f"{piece.material[:80]!r}: grey stands for it"
        )
        return _GREY

    @property
    def extent(self) -> Array:
        """(2, 3) least and greatest coordinates, in the file's axes."""
        points = np.concatenate([piece.mesh.points for piece in self.pieces.values()])
        return np.stack([points.min(axis=0), points.max(axis=0)])

    def looks(self, find: Find) -> dict[str, dict[str, str]]:
        """What stands for those materials whose maps are not there, by part."""
        worn = ((part, bsdf) for part, bsdf in self.wears.items() if bsdf is not None)
        return {part: stand_in(b) for part, b in worn if pictures_of(b, find) is None}

    def files(self, find: Find) -> Iterator[tuple[str, bytes | Path]]:
        """What an import writes of it: `FILE`, and its maps in a folder beside it.

        Raises:
            InputError: A mesh or a map cannot be read.
        """
        pictures: dict[str, Path] = {}
        surfaces = {}
        for part, bsdf in self.wears.items():
            found = None if bsdf is None else pictures_of(bsdf, find)
            if bsdf is None or found is None:
                continue
            own = {
                kind: f"textures/{path.parent.parent.name}_{path.name}"
                for kind, path in found.items()
            }
            pictures |= {own[kind]: path for kind, path in found.items()}
            surfaces[part] = surface_of(bsdf, {kind: f"./{file}" for kind, file in own.items()})
        yield FILE, _written(self.pieces, surfaces)
        yield from pictures.items()


def file_of(model: Named) -> Named:
    """Where an import writes a model, below the folder of the dataset that it makes."""
    return Named("uv_mapped", f"{model.path}/{FILE}")


def extent_of_file(path: Path) -> Array:
    """(2, 3) least and greatest coordinates of what an import wrote.

    Raises:
        InputError: It is not such a file.
    """
    from openrooms_usd.library.models.usdfile import read_usd

    pieces = read_usd(path).pieces
    if not pieces:
        raise InputError("it holds no mesh", place=path, remedy="import the scene again")
    points = np.concatenate([piece.mesh.points for piece in pieces])
    return np.stack([points.min(axis=0), points.max(axis=0)])


def _part(bsdf: Bsdf, item: SceneObject) -> str:
    """What a material's name adds to its model's."""
    prefix = f"{'_'.join(item.model.parts)}_"
    return bsdf.id.removeprefix(prefix) or "part"


def _check(piece: ModelPart, file: Path) -> None:
    points = piece.mesh.points
    if not np.isfinite(points).all() or (np.abs(points) > _MOST_M).any():
        raise InputError(
            "the mesh has coordinates that are not finite", place=file, remedy="export it again"
        )


def _written(pieces: Mapping[str, ModelPart], surfaces: Mapping[str, object]) -> bytes:
    from pxr import Usd, UsdGeom, UsdShade

    from openrooms_usd.usd.files.layers import export
    from openrooms_usd.usd.shading.materials import PreviewSurface, define_preview_surface
    from openrooms_usd.usd.shapes.meshes import define_mesh

    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, "/Model").GetPrim()
    stage.SetDefaultPrim(root)
    for name, piece in pieces.items():
        mesh = define_mesh(stage, f"/Model/{name}", piece.mesh).GetPrim()
        surface = surfaces.get(name)
        if isinstance(surface, PreviewSurface):
            material = define_preview_surface(stage, f"/Model/Materials/{name}", surface)
            UsdShade.MaterialBindingAPI.Apply(mesh).Bind(material)
    with scratch_folder() as folder:
        file = folder / FILE
        export(stage.GetRootLayer(), file)
        return untrusted.read_bytes(file, "usd")
