"""From a composed USD stage to a `Scene`: arrays, surfaces, lights, labels and a report."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, cast

import numpy as np
from pxr import Usd, UsdShade

from openrooms_usd import names
from openrooms_usd.convert import Report
from openrooms_usd.render.scene import default_light as unlit
from openrooms_usd.render.scene import lamps
from openrooms_usd.render.scene.arrays import Environment, Scene, Sun
from openrooms_usd.render.scene.gathering import Gathered, shapes
from openrooms_usd.render.scene.labels import Labels, material_path
from openrooms_usd.render.scene.painted import Paint, paint, paint_over, passed_on
from openrooms_usd.render.scene.pictures import Picture, Value
from openrooms_usd.render.scene.surfaces import Surface, SurfaceReader
from openrooms_usd.render.scene.surroundings import summed
from openrooms_usd.render.scene.triangles import Floats, Ints
from openrooms_usd.render.scene.unseen import report_unseen
from openrooms_usd.usd.frames import odd_frame
from openrooms_usd.usd.lights import (
    CylinderLight,
    DiskLight,
    DistantLight,
    DomeLight,
    Light,
    MeshLight,
    RectLight,
    SphereLight,
    read_lights,
)
from openrooms_usd.usd.linking import LightLinks
from openrooms_usd.usd.materials import BARE, bound_materials, bound_subsets, read_preview_surface
from openrooms_usd.usd.meshes import PlacedMesh, TriangleMesh, read_meshes
from openrooms_usd.usd.portals import Portal, read_portals
from openrooms_usd.usd.profiles import Shaping
from openrooms_usd.usd.rendersettings import asked_purposes
from openrooms_usd.usd.surfaces import PreviewSurface

# Rows of triangles, and the material that they show.
_Part = tuple[Ints, UsdShade.Material | None]
_Parts = list[_Part]
_BLACK: Final = Surface(base_color=(0.0, 0.0, 0.0), roughness=1.0, ior=1.0)
# A lamp by itself; one that stands for the pixels of a screen has a body behind it.
_LAMP: Final = replace(_BLACK, one_sided=True)


def _surface_of(light: Usd.Prim) -> Usd.Prim:
    """The prim whose pixels the light's are: a screen's glass, or the light itself."""
    relationship = light.GetRelationship(names.SURFACE_OF)
    targets = relationship.GetTargets() if relationship else []
    surface = light.GetStage().GetPrimAtPath(targets[0]) if len(targets) == 1 else None
    return surface or light


def translate(
    stage: Usd.Stage,
    *,
    outside: bool = True,
    default_light: bool = False,
    texture_side: int | None = None,
) -> Scene:
    """Translate a stage; nothing that it holds raises.

    Args:
        stage: The composed stage, with any up axis and unit.
        outside: Whether what stands outside before the windows is part of it.
        default_light: Whether a stage without any light gets one, which the report tells.
        texture_side: The longest side of textures that are kept as they are, pixels; None: 4096, or
            less where all together would take much memory.

    Returns:
        The scene, whose report names every prim that was not translated whole.
    """
    # Absurd numbers overflow; what comes of them is looked at where it matters.
    with np.errstate(all="ignore"):
        return _translated(stage, outside, default_light, texture_side)


def _translated(
    stage: Usd.Stage, outside: bool, default_light: bool, texture_side: int | None
) -> Scene:
    lights = read_lights(stage)
    reader = SurfaceReader(texture_side)
    work = _Translation(LightLinks(stage, lights), passed_on(stage), reader)
    # 1. Light, first: a mesh has to know whether it emits.
    for light in lights:
        work.add_light(stage, light)
    work.add_portals(stage)
    # 2. Surfaces, instances expanded.
    reading = read_meshes(stage, purposes=asked_purposes(stage), outside=outside)
    for path, outcome, reason in reading.losses:
        work.report.add(path, outcome, reason)
    lossy = {path for path, _, _ in reading.losses}
    for mesh, parts in work.with_materials(reading):
        work.add_mesh(mesh, parts, whole=mesh.path not in lossy)
    if default_light and work.is_dim and unlit.is_unlit(stage):
        work.add_default_light()
    # 3. Everything else is named too.
    for reason in odd_frame(stage):
        work.report.add("/", "approximated", reason)
    report_unseen(stage, work.report)
    work.report.gather()
    return work.scene(_folder(stage))


class _Translation:
    """Gathers what will be the scene."""

    def __init__(
        self, links: LightLinks, passed_on: frozenset[str], surfaces: SurfaceReader
    ) -> None:
        self._links = links
        self._passed_on = passed_on
        self._responses: dict[str, tuple[float, float]] = {}
        self.report = Report()
        self._labels = Labels()
        self._surfaces = surfaces
        self._previews: dict[str, tuple[PreviewSurface, tuple[str, ...]]] = {}
        self._materials: dict[str, Surface] = {}
        self._paints: dict[tuple[object, ...], Paint | None] = {}
        self._dyed: dict[tuple[object, ...], Surface] = {}
        self._owners: list[tuple[str, Surface]] = []
        self._st: dict[tuple[int, int], tuple[Floats, list[str]]] = {}
        self._groups: dict[tuple[int, str, bool, tuple[str, ...]], Gathered] = {}
        self._emitting: dict[str, MeshLight] = {}
        self._environment: Environment | None = None
        self._exposure: float | None = None
        self._suns: list[Sun] = []
        self._portals: tuple[Portal, ...] = ()

    def scene(self, folder: Path | None) -> Scene:
        patches, panes = shapes(list(self._groups.values()), self._responses)
        return Scene(
            patches,
            tuple(self._labels.pieces),
            self._environment,
            tuple(self._suns),
            self._portals,
            self._labels.legend,
            tuple(self._owners),
            self.report,
            folder,
            panes,
            self._exposure,
        )

    # Light.

    def add_portals(self, stage: Usd.Stage) -> None:
        self._portals = read_portals(stage)
        for portal in self._portals:
            self.report.add(portal.path, "translated")

    @property
    def is_dim(self) -> bool:
        """Whether there is matter, none of which sends more light than what merely glows."""
        return bool(self._groups) and all(
            group.radiance is None or unlit.merely_glows(group.radiance)
            for group in self._groups.values()
        )

    def add_default_light(self) -> None:
        self._environment = unlit.default_light()
        self._exposure = unlit.EXPOSURE
        self.report.add("/", "approximated", unlit.TOLD)

    def add_light(self, stage: Usd.Stage, light: Light) -> None:
        losses = list(light.losses)
        self._responses[light.path] = light.response
        if isinstance(light, MeshLight):
            self._emitting[light.path] = light
            if not losses:
                return
        elif isinstance(light, DomeLight):
            found, lost = lamps.environment(light)
            before = self._environment
            self._environment = found if before is None else summed(before, found)
            losses += lost
        elif isinstance(light, DistantLight):
            self._suns.append(lamps.sun(light))
        elif isinstance(light, RectLight | DiskLight | SphereLight | CylinderLight):
            reason = lamps.nothing(light)
            if reason:
                self.report.add(light.path, "skipped", reason)
                return
            radiance, lost = lamps.radiance(light)
            source = stage.GetPrimAtPath(light.prim)
            surface = _surface_of(source)
            is_body = surface != source
            stands = str(surface.GetPath()) if is_body else light.path
            row = self._labels.row(stands, surface, None)
            dark = _BLACK if is_body else _LAMP
            group = self._group(light.path, dark, radiance, shaping=light.shaping)
            group.add(lamps.shape(light, row))
            losses += lost
        else:
            self.report.add(light.path, "skipped", "; ".join(losses))
            return
        self._say(light.path, losses)

    # Surfaces.

    def with_materials(self, meshes: Iterable[PlacedMesh]) -> list[tuple[PlacedMesh, _Parts]]:
        """Meshes with the materials of their triangles, whose pictures are then all read."""
        placed = list(meshes)
        bound = bound_materials([mesh.prim for mesh in placed])
        found = [(m, list(_materials(m, own))) for m, own in zip(placed, bound, strict=True)]
        for _, parts in found:
            for _, material in parts:
                if material is not None and _key(material) not in self._previews:
                    self._previews[_key(material)] = read_preview_surface(material)
        self._surfaces.prefetch(preview for preview, _ in self._previews.values())
        return found

    def add_mesh(self, mesh: PlacedMesh, parts: _Parts, *, whole: bool) -> None:
        losses: list[str] = []
        emitted = self._emitting.get(str(mesh.prim.GetPath()))
        shaping = None if emitted is None else emitted.shaping
        for rows, material in parts:
            surface, painted = self._surface(mesh, material, losses)
            radiance = lamps.emission(surface, emitted)
            if surface.pane is not None and radiance is not None:
                radiance = None
                losses.append("a clear pane emits nothing")
            if radiance is not None and mesh.double_sided:
                losses.append("it emits from its front side only")
            st = self._texture_coordinates(mesh, surface, losses) if painted is None else painted
            piece = self._labels.row(mesh.path, mesh.prim, material_path(material))
            sheet = surface.pane is not None and mesh.double_sided
            bent = None if radiance is None else shaping
            unlit = self._links.unlit_by(mesh.path)
            group = self._group(mesh.path, surface, radiance, sheet, bent, unlit)
            group.place(mesh, rows, st, piece)
        if losses or whole:
            self._say(mesh.path, losses)

    def _group(
        self,
        path: str,
        surface: Surface,
        radiance: Value | None,
        is_sheet: bool = False,
        shaping: Shaping | None = None,
        unlit: tuple[str, ...] = (),
    ) -> Gathered:
        # What emits is a shape of its own, so that it is sampled as one light.
        lamp = "" if radiance is None else path
        made = Gathered(surface, radiance, is_sheet, shaping, lamp, unlit)
        return self._groups.setdefault((id(surface), lamp, is_sheet, unlit), made)

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
        key = "" if material is None else _key(material)
        if key not in self._materials:
            preview, lost = self._previews.setdefault(key, (BARE, ()))
            made = self._materials[key] = self._surfaces.read(preview)
            if material is not None:
                self._say(str(material.GetPath()), [*lost, *made.losses])
                self._owners.append((str(material.GetPath()), made))
        surface, (preview, _) = self._materials[key], self._previews[key]
        found = {
            field: paint for field, name in preview.painted if (paint := self._paint(mesh, name))
        }
        if material is None:
            shown = "its displayColor" if "base_color" in found else "grey"
            losses.append(f"it has no material: taken as {shown}")
        if not found:
            if material is None:
                self._owners.append((mesh.path, surface))
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
        self._owners.append((mesh.path, self._dyed[key]))
        return self._dyed[key], st

    def _say(self, path: str, losses: list[str]) -> None:
        if losses:
            self.report.add(path, "approximated", "; ".join(dict.fromkeys(losses)))
        else:
            self.report.add(path, "translated")


def _folder(stage: Usd.Stage) -> Path | None:
    """Where the file of a stage lies; None of one in memory."""
    file = stage.GetRootLayer().realPath
    return Path(file).parent if file else None


def _texture_coordinates(mesh: TriangleMesh, surface: Surface) -> tuple[Floats, list[str]]:
    """(M, 3, 2) with the surface's common transform worked in, and what was lost."""
    losses: list[str] = []
    st = mesh.uvs.get(surface.primvar)
    if st is None:
        st = mesh.st
        if surface.is_textured:
            instead = "others are" if st is not None else "none are there; 0 is"
            losses.append(f"texture coordinates {surface.primvar} are missing, {instead} used")
    if st is None:
        st = np.zeros((len(mesh.triangles), 3, 2), dtype=np.float32)
    if np.array_equal(surface.uv, np.eye(3)):
        return st, losses
    return (st @ surface.uv[:2, :2].T + surface.uv[:2, 2]).astype(np.float32), losses


def _key(material: UsdShade.Material) -> str:
    """The same for all instances of one prototype, which show it under many paths."""
    prim = material.GetPrim()
    source = prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim
    return str(source.GetPath())


def _materials(mesh: PlacedMesh, own: UsdShade.Material | None) -> Iterator[_Part]:
    """(rows of triangles, their material) for each part of a mesh with a material of its own.

    Args:
        mesh: The mesh.
        own: The material of what is in no such part.
    """
    faces = mesh.mesh.faces
    rest = np.ones(len(faces), dtype=bool)
    for indices, material in bound_subsets(mesh.prim):
        rows = np.flatnonzero(rest & np.isin(faces, indices))
        if len(rows):
            rest[rows] = False
            yield rows.astype(np.int32), material
    if rest.any():
        yield np.flatnonzero(rest).astype(np.int32), own
