"""From a composed USD stage to a GLB file: surfaces, lamps, cameras and a report."""

from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdPhysics

from openrooms_usd.arrays import Array
from openrooms_usd.exporters import Report
from openrooms_usd.progress import Progress, each, silent
from openrooms_usd.rendering.scene.unseen import report_unseen
from openrooms_usd.usd.cameras import list_cameras
from openrooms_usd.usd.light.lights import Light, MeshLight, read_lights, read_portals
from openrooms_usd.usd.shapes.meshes import PlacedMesh, read_meshes
from orusd_gltf.baked import LIGHTMAP, BakedLight, area_of, list_atlases, place_of
from orusd_gltf.document import INDICES, VERTICES, Document, Object, packed_primitive
from orusd_gltf.geometry import Vertices, vertices
from orusd_gltf.hierarchy import Hierarchy, gather_instances
from orusd_gltf.lamps import EXTENSION, Lamp, add_camera, add_glow, add_light, authored_stops
from orusd_gltf.materials import Looks, Material, ReadMaterial, add_material
from orusd_gltf.options import Options
from orusd_gltf.pictures import Pictures
from orusd_gltf.unlit import NO_GLOSS, UNSEEN, UnlitSurfaces

_Radiance = tuple[float, ...] | None
_TRIANGLES: Final = 4
# Larger scenes are not rooms, and overflow single precision in readers.
_FARTHEST_M: Final = 1e9
_FARTHEST_LOCAL: Final = 1e18


def translate(
    stage: Usd.Stage, options: Options, progress: Progress = silent
) -> tuple[bytes, Report]:
    """Translate a stage; nothing that it holds raises.

    Args:
        stage: The composed stage, with any up axis and unit.
        options: How.
        progress: Called with each surface.

    Returns:
        The bytes of the GLB file, and a report of every prim.
    """
    work = _Translation(stage, options)
    # 1. Light, first: a mesh has to know whether it emits.
    work.add_lights()
    # 2. Surfaces; what repeats is stored once.
    work.add_meshes(progress)
    # 3. Cameras, and the names of all that is left.
    work.add_cameras()
    work.name_the_rest()
    if options.instances == "gpu":
        gather_instances(work.document)
    return work.document.glb(), work.report


@dataclass
class _Translation:
    """Gathers what will be the file."""

    stage: Usd.Stage
    options: Options
    document: Document = field(default_factory=Document)
    report: Report = field(default_factory=Report)

    def __post_init__(self) -> None:
        self._nodes = Hierarchy(self.stage, self.document)
        self._pictures = Pictures(self.document, self.options.pictures)
        self._emitting: dict[str, Array] = {}
        self._glowing: dict[str, tuple[str, ...]] = {}
        self._looks = Looks()
        self._told: set[str] = set()
        self._materials: dict[tuple[str, bool, _Radiance], Material] = {}
        self._meshes: dict[Any, tuple[int, tuple[str, ...]]] = {}
        stops = self._stops()
        self._factor = float(2.0 ** (stops or 0.0))
        self._unlit: UnlitSurfaces | None = None
        if self.options.light == "baked":
            light = BakedLight(self.stage, None if stops is None else float(2.0**stops))
            self._unlit = UnlitSurfaces(self.document, light, self.options.pictures)
        if self.options.light == "lightmaps":
            list_atlases(self.stage)

    def _stops(self) -> float | None:
        """By how much light is made brighter; None if not given."""
        asked = self.options.exposure
        wants = asked == "camera" or (asked is None and self.options.light == "baked")
        return authored_stops(self.stage) if wants else asked  # type: ignore[return-value]

    # Light.

    def add_lights(self) -> None:
        for light in map(_without_shaping, read_lights(self.stage)):
            if isinstance(light, MeshLight):
                self._emitting[light.path] = light.radiance
                self._glowing[light.path] = light.losses
                continue
            if self._unlit is not None:
                self._say(light.path, [*light.losses, UNSEEN])
                continue
            name = light.path.rpartition("/")[2]
            lamp = add_light(self.document, light, name, self._factor)
            if isinstance(lamp, str):
                self.report.add(light.path, "skipped", lamp)
                continue
            self._shine(self._nodes.child(_parent(light.path), name, lamp.world), lamp)
            self._say(light.path, [*light.losses, *lamp.losses])
        for portal in read_portals(self.stage):
            reason = "" if self._unlit else "it emits nothing: the sky shines in through it"
            self.report.add(portal.path, "skipped" if reason else "translated", reason)

    def _shine(self, node: int, lamp: Lamp) -> None:
        self.document.objects["nodes"][node]["extensions"] = {EXTENSION: {"light": lamp.number}}

    # Surfaces.

    def add_meshes(self, progress: Progress) -> None:
        reading = read_meshes(self.stage, outside=False)
        for path, outcome, reason in reading.losses:
            self.report.add(path, outcome, reason)
        lossy = {path for path, _, _ in reading.losses}
        if self._unlit is not None:
            for mesh in reading:
                self._unlit.paint(mesh, self._looks.parts(mesh))
            self._unlit.finish()
        for mesh in each(progress, "surface", reading, len(reading)):
            if _is_too_far(mesh):
                self.report.add(mesh.path, "skipped", f"it reaches farther than {_FARTHEST_M:g} m")
                continue
            losses = self._add_unlit(mesh) if self._unlit else self._add_mesh(mesh)
            if losses or mesh.path not in lossy:
                self._say(mesh.path, losses)

    def _add_mesh(self, mesh: PlacedMesh) -> list[str]:
        losses: list[str] = []
        emitted = self._emitting.get(str(mesh.prim.GetPath()))
        radiance = None if emitted is None else tuple(map(float, emitted))
        parts = [
            (rows, self._material(mesh, look, radiance, losses))
            for rows, look in self._looks.parts(mesh)
        ]
        placed = place_of(mesh) if self.options.light == "lightmaps" else None
        number, lost = self._mesh(mesh, parts, lit=placed is not None)
        node = self._nodes.place(mesh.path, mesh.world_from_local)
        self.document.objects["nodes"][node]["mesh"] = number
        if placed is not None:
            self.document.objects["nodes"][node]["extras"] |= {"lightmap": area_of(*placed)}
        if emitted is not None and emitted.max() > 0.0:
            name = f"{mesh.path.rpartition('/')[2]}_light"
            lamp = add_glow(self.document, mesh, emitted * self._factor, name)
            self._shine(self._nodes.child(mesh.path, name, lamp.world), lamp)
            losses += [*self._glowing[str(mesh.prim.GetPath())], *lamp.losses]
        return [*losses, *lost]

    def _add_unlit(self, mesh: PlacedMesh) -> list[str]:
        assert self._unlit is not None
        emitted = self._emitting.get(str(mesh.prim.GetPath()))
        radiance = None if emitted is None else tuple(map(float, emitted))
        looks = self._looks.parts(mesh)
        for _, look in looks:
            self._tell(look, (NO_GLOSS,))
        drawn, lost = self._unlit.primitives(mesh, looks, radiance)
        primitives = [self._primitive(found, material) for found, material in drawn]
        said = {"name": mesh.prim.GetName(), "primitives": primitives}
        node = self._nodes.place(mesh.path, mesh.world_from_local)
        # Repeats that lie in the same place of a lightmap are one.
        self.document.objects["nodes"][node]["mesh"] = self.document.shared("meshes", said)
        return [lost] if lost else []

    def _primitive(self, found: Vertices, material: int) -> Object:
        if self.options.compression == "draco":
            drawn = packed_primitive(self.document, found)
        else:
            attributes = {
                name: self.document.accessor(values, VERTICES)
                for name, values in found.attributes.items()
            }
            indices = self.document.accessor(found.indices, INDICES)
            drawn = {"attributes": attributes, "indices": indices}
        return drawn | {"material": material, "mode": _TRIANGLES}

    def _mesh(
        self, mesh: PlacedMesh, parts: list[tuple[NDArray[np.int32], Material]], *, lit: bool
    ) -> tuple[int, tuple[str, ...]]:
        """The number of a mesh and what was lost; repeats of one prototype share it."""
        # The triangles are kept by the reading, so that their identity is not given to others.
        key = (id(mesh.mesh), lit, *((made.number, rows.tobytes()) for rows, made in parts))
        if key not in self._meshes:
            losses: list[str] = []
            primitives = []
            for rows, material in parts:
                sets = (*material.sets, LIGHTMAP) if lit else material.sets
                found = vertices(mesh.mesh, rows, sets, material.normal_set)
                losses += found.losses
                drawn = self._primitive(found, material.number)
                # Which of its sets of coordinates is that of the lightmap.
                drawn |= {"extras": {"lightmap": len(material.sets)}} if lit else {}
                primitives.append(drawn)
            said = {"name": mesh.prim.GetName(), "primitives": primitives}
            self._meshes[key] = self.document.add("meshes", said), tuple(losses)
        return self._meshes[key]

    def _material(
        self, mesh: PlacedMesh, look: ReadMaterial, radiance: _Radiance, losses: list[str]
    ) -> Material:
        if not look.path:
            losses += look.losses
        shown = look.key, mesh.double_sided, radiance
        if shown not in self._materials:
            self._materials[shown] = made = add_material(
                self.document,
                self._pictures,
                look.preview,
                name=look.name,
                double_sided=mesh.double_sided,
                radiance=radiance,
                brighter=self._factor,
            )
            self._tell(look, made.losses)
        return self._materials[shown]

    def _tell(self, look: ReadMaterial, losses: tuple[str, ...]) -> None:
        """Say once what became of a material."""
        if look.path and look.path not in self._told:
            self._told.add(look.path)
            self._say(look.path, [*look.losses, *losses])

    # The rest.

    def add_cameras(self) -> None:
        for prim in list_cameras(self.stage):
            path = str(prim.GetPath())
            found = add_camera(self.document, prim)
            if isinstance(found, str):
                self.report.add(path, "skipped", found)
                continue
            number, world, known, lost = found
            node = self._nodes.place(path, world)
            self.document.objects["nodes"][node]["camera"] = number
            self.document.objects["nodes"][node]["extras"] |= known
            self._say(path, [lost] if lost else [])

    def name_the_rest(self) -> None:
        report_unseen(self.stage, self.report)
        for prim in self.stage.Traverse():
            if prim.IsA(UsdPhysics.Joint):
                self.report.add(prim.GetPath(), "skipped", "glTF has no joints of bodies")

    def _say(self, path: str, losses: list[str]) -> None:
        told = "; ".join(dict.fromkeys(losses))
        self.report.add(path, "approximated" if told else "translated", told)


def _is_too_far(mesh: PlacedMesh) -> bool:
    """Whether a mesh is larger than single precision can tell."""
    local = float(np.abs(mesh.mesh.points).max(initial=0.0))
    if not local <= _FARTHEST_LOCAL:
        return True
    with np.errstate(over="ignore", invalid="ignore"):
        return not float(np.abs(mesh.world_points()).max(initial=0.0)) <= _FARTHEST_M


def _parent(path: str) -> str:
    return path.rpartition("/")[0]


def _without_shaping(light: Light) -> Light:
    """The light without its profile, which glTF has no word for."""
    if light.shaping is None:
        return light
    lost = "the light does not follow its IES profile"
    return replace(light, shaping=None, losses=(*light.losses, lost))
