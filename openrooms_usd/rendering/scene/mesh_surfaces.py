"""What each mesh is made of: the materials of its parts, and the colours that it brings itself."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, cast

import numpy as np
from pxr import UsdShade

from openrooms_usd.arrays import Floats
from openrooms_usd.exporters import Report
from openrooms_usd.rendering.scene.displaced import MOVED, displaced, unit_ball
from openrooms_usd.rendering.scene.painted import Paint, paint, paint_over
from openrooms_usd.rendering.scene.pictures import Picture, Value, evaluate
from openrooms_usd.rendering.scene.surfaces import Surface, SurfaceReader
from openrooms_usd.rendering.scene.triangles import Ints
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.materials import (
    Part,
    bound_materials,
    material_key,
    parts_by_material,
)
from openrooms_usd.usd.shading.surfaces import BARE, PreviewSurface, Texture, completed
from openrooms_usd.usd.shapes.meshes import PlacedMesh, TriangleMesh

Parts = list[Part]


class MeshSurfaces:
    """The surfaces of a stage's meshes, each material and picture read once.

    Attributes:
        owners: (prim path, surface) of each material, and of each mesh with a surface of its own.
    """

    def __init__(self, reader: SurfaceReader, passed_on: frozenset[str], report: Report) -> None:
        """Nothing is read yet.

        Args:
            reader: What reads materials.
            passed_on: Primvars that some prim may inherit (`painted.passed_on`).
            report: Receives what is lost of materials.
        """
        self.owners: list[tuple[str, Surface]] = []
        self._reader = reader
        self._passed_on = passed_on
        self._report = report
        self._previews: dict[str, tuple[PreviewSurface, tuple[str, ...]]] = {}
        self._heights: dict[str, Value] = {}
        self._moved: dict[tuple[object, ...], TriangleMesh] = {}
        self._materials: dict[str, Surface] = {}
        self._paints: dict[tuple[object, ...], Paint | None] = {}
        self._dyed: dict[tuple[object, ...], Surface] = {}
        self._st: dict[tuple[int, int], tuple[Floats, list[str]]] = {}

    def bind(self, meshes: Iterable[PlacedMesh]) -> list[tuple[PlacedMesh, Parts]]:
        """Meshes with the materials of their triangles, whose pictures are then all read."""
        placed = list(meshes)
        bound = bound_materials([mesh.prim for mesh in placed])
        found = [
            (m, list(parts_by_material(m.prim, m.mesh.faces, own)))
            for m, own in zip(placed, bound, strict=True)
        ]
        for _, parts in found:
            for _, material in parts:
                if material is not None and material_key(material) not in self._previews:
                    preview, lost = read_preview_surface(material, moves=True)
                    self._previews[material_key(material)] = completed(preview), lost
        self._reader.prefetch(preview for preview, _ in self._previews.values())
        return found

    def read(
        self, mesh: PlacedMesh, material: UsdShade.Material | None, losses: list[str]
    ) -> tuple[Surface, Floats]:
        """The surface of a part of a mesh, and (M, 3, 2) where all its triangles lie in pictures.

        Args:
            mesh: The mesh.
            material: Of the part, which `bind` gave.
            losses: What was approximated is added.
        """
        surface, painted = self._surface(mesh, material, losses)
        if painted is not None:
            return surface, painted
        return surface, self._texture_coordinates(mesh, surface, losses)

    def moved(
        self, mesh: PlacedMesh, rows: Ints, material: UsdShade.Material | None, losses: list[str]
    ) -> PlacedMesh:
        """The mesh with a part of it where its material moves it to.

        Args:
            mesh: The mesh.
            rows: The triangles of the part.
            material: Of the part, which `bind` gave.
            losses: What was approximated is added.
        """
        name = "" if material is None else material_key(material)
        by, texture = self._heights[name], self._previews[name][0].displacement
        if by == 0.0:
            return mesh
        losses.append(MOVED)
        st, ball = np.zeros((len(rows), 3, 2), np.float32), unit_ball(mesh)
        if isinstance(texture, Texture):
            whole, lost = _coordinates(mesh.mesh, texture.primvar)
            st = whole[rows]
            losses += lost
        key = id(mesh.mesh), name, rows.tobytes(), ball.tobytes()
        if key not in self._moved:
            heights = evaluate(by, st.astype(np.float64), 1)[..., 0]
            self._moved[key] = displaced(mesh.mesh, rows, heights, ball)
        return replace(mesh, mesh=self._moved[key])

    def _texture_coordinates(self, mesh: PlacedMesh, surface: Surface, losses: list[str]) -> Floats:
        """(M, 3, 2) for a surface; instances of one mesh share them."""
        key = id(mesh.mesh), id(surface)
        if key not in self._st:
            self._st[key] = _texture_coordinates(mesh.mesh, surface)
        st, lost = self._st[key]
        losses += lost
        return st

    def _surface(
        self, mesh: PlacedMesh, material: UsdShade.Material | None, losses: list[str]
    ) -> tuple[Surface, Floats | None]:
        """What a mesh is made of, and where it lies in the picture of its own colours, if any."""
        key = "" if material is None else material_key(material)
        if key not in self._materials:
            preview, lost = self._previews.setdefault(key, (BARE, ()))
            made = self._materials[key] = self._reader.read(preview)
            height = self._heights[key] = self._reader.height(preview)
            if material is not None:
                lost = (
                    *lost,
                    *made.losses,
                    *(height.losses if isinstance(height, Picture) else ()),
                )
                self._report.say(str(material.GetPath()), lost)
                self.owners.append((str(material.GetPath()), made))
        surface, (preview, _) = self._materials[key], self._previews[key]
        found = {
            field: paint for field, name in preview.painted if (paint := self._paint(mesh, name))
        }
        if material is None:
            shown = "its displayColor" if "base_color" in found else "grey"
            losses.append(f"it has no material: {shown} is used")
        if not found:
            if material is None:
                self.owners.append((mesh.path, surface))
            return surface, None
        return self._painted(mesh, surface, preview, found, losses)

    def _paint(self, mesh: PlacedMesh, name: str) -> Paint | None:
        """What a mesh says in a primvar of colours; instances of one share it."""
        # What is one colour may be inherited, and differ between instances.
        tint = dict(mesh.tints).get(name)
        own = name in mesh.mesh.colors or name not in self._passed_on
        key = id(mesh.mesh), name, tint, "" if own else str(mesh.prim.GetPath())
        if key not in self._paints:
            self._paints[key] = paint(mesh, name)
        return self._paints[key]

    def _painted(
        self,
        mesh: PlacedMesh,
        surface: Surface,
        preview: PreviewSurface,
        found: dict[str, Paint],
        losses: list[str],
    ) -> tuple[Surface, Floats | None]:
        """A surface with what a mesh has painted, and where the mesh lies in the pictures of it."""
        values, st = paint_over(surface, preview, found, losses)
        key = (
            id(surface),
            *(
                (field, id(value) if isinstance(value, Picture) else value)
                for field, value in values.items()
            ),
        )
        if key not in self._dyed:
            self._dyed[key] = replace(surface, **cast(Any, values))
        self.owners.append((mesh.path, self._dyed[key]))
        return self._dyed[key], st


def _texture_coordinates(mesh: TriangleMesh, surface: Surface) -> tuple[Floats, list[str]]:
    """(M, 3, 2) with the surface's common transform worked in, and what was lost."""
    st, losses = _coordinates(mesh, surface.primvar)
    losses = losses if surface.is_textured else []
    if np.array_equal(surface.uv, np.eye(3)):
        return st, losses
    return (st @ surface.uv[:2, :2].T + surface.uv[:2, 2]).astype(np.float32), losses


def _coordinates(mesh: TriangleMesh, primvar: str) -> tuple[Floats, list[str]]:
    """(M, 3, 2) of a primvar, and what was lost where others have to do."""
    st = mesh.uvs.get(primvar)
    if st is not None:
        return st, []
    instead = "others are" if mesh.st is not None else "none are there; 0 is"
    losses = [f"texture coordinates {primvar} are missing, {instead} used"]
    if mesh.st is None:
        return np.zeros((len(mesh.triangles), 3, 2), dtype=np.float32), losses
    return mesh.st, losses
