"""From a composed USD stage to a `Scene`: arrays, surfaces, lights, labels and a report."""

from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from pxr import Usd

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.exporters import Report
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.rendering.scene import lamps
from openrooms_usd.rendering.scene.arrays import Environment, Scene, Sun
from openrooms_usd.rendering.scene.gathering import Gathered, shapes
from openrooms_usd.rendering.scene.labels import Labels, material_path
from openrooms_usd.rendering.scene.mesh_surfaces import MeshSurfaces, Parts
from openrooms_usd.rendering.scene.painted import passed_on
from openrooms_usd.rendering.scene.pictures import Picture, Value
from openrooms_usd.rendering.scene.surfaces import Surface, SurfaceReader
from openrooms_usd.rendering.scene.surroundings import summed
from openrooms_usd.rendering.scene.unseen import report_unseen
from openrooms_usd.usd.doubts import dark_doubt, light_doubts
from openrooms_usd.usd.light.lightreader import LightLinks
from openrooms_usd.usd.light.lights import (
    CylinderLight,
    DiskLight,
    DistantLight,
    DomeLight,
    Light,
    MeshLight,
    Portal,
    RectLight,
    SphereLight,
    read_lights,
    read_portals,
)
from openrooms_usd.usd.light.lightsearch import is_light
from openrooms_usd.usd.places.frames import odd_frame
from openrooms_usd.usd.rendersettings import asked_purposes
from openrooms_usd.usd.shapes.meshes import PlacedMesh, read_meshes

BRIGHTEST_FROM: Final[Array] = unit(np.array([-0.35, -0.5, 0.8]))
"""(3,) where the default light comes from, in the world: above, from the front left."""
EXPOSURE: Final = 0.5
"""What pictures in the default light are multiplied by: white that faces it is nearly white."""
TOLD: Final = (
    "the stage has no light: a default one lights it, 1 nit on average and brighter from above "
    "(--no-default-light leaves it dark)"
)

_ROWS: Final = 65
_MOST_OF_A_GLOW_NITS: Final = 1.0
_BLACK: Final = Surface(base_color=(0.0, 0.0, 0.0), roughness=1.0, ior=1.0)
# A lamp by itself; one that stands for the pixels of a screen has a body behind it.
_LAMP: Final = replace(_BLACK, one_sided=True)
_UNSEEN: Final = replace(_BLACK, opacity=0.0)


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
    report = Report()
    surfaces = MeshSurfaces(SurfaceReader(texture_side), passed_on(stage), report)
    work = _Translation(stage, LightLinks(stage, lights), surfaces, report)
    # 1. Light, first: a mesh has to know whether it emits.
    for light in lights:
        work.add_light(light)
    work.add_portals()
    if dark := dark_doubt(lights):
        report.add("/", "approximated", dark)
    # 2. Surfaces, instances expanded.
    reading = read_meshes(stage, purposes=asked_purposes(stage), outside=outside)
    for path, outcome, reason in reading.losses:
        report.add(path, outcome, reason)
    lossy = {path for path, _, _ in reading.losses}
    for mesh, parts in surfaces.bind(reading):
        work.add_mesh(mesh, parts, whole=mesh.path not in lossy)
    if default_light and work.is_dim and is_unlit(stage):
        work.add_default_light()
    # 3. Everything else is named too.
    for reason in odd_frame(stage):
        report.add("/", "approximated", reason)
    report_unseen(stage, report)
    report.gather()
    return work.scene(_folder(stage))


class _Translation:
    """Gathers what will be the scene."""

    def __init__(
        self, stage: Usd.Stage, links: LightLinks, surfaces: MeshSurfaces, report: Report
    ) -> None:
        self._stage = stage
        self._links = links
        self._surfaces = surfaces
        self._report = report
        self._labels = Labels(stage)
        self._responses: dict[str, tuple[float, float]] = {}
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
            tuple(self._surfaces.owners),
            self._report,
            folder,
            panes,
            self._exposure,
        )

    # Light.

    def add_portals(self) -> None:
        self._portals = read_portals(self._stage)
        for portal in self._portals:
            self._report.add(portal.path, "translated")

    @property
    def is_dim(self) -> bool:
        """Whether there is matter, none of which sends more light than what merely glows."""
        return bool(self._groups) and all(
            group.radiance is None or is_negligible_emitter(group.radiance)
            for group in self._groups.values()
        )

    def add_default_light(self) -> None:
        self._environment = default_light()
        self._exposure = EXPOSURE
        self._report.add("/", "approximated", TOLD)

    def add_light(self, light: Light) -> None:
        losses = [*light.losses, *light_doubts(light)]
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
                self._report.add(light.path, "skipped", reason)
                return
            radiance, lost = lamps.radiance(light)
            source = self._stage.GetPrimAtPath(light.prim)
            surface = _surface_of(source)
            is_body = surface != source
            stands = str(surface.GetPath()) if is_body else light.path
            row = self._labels.row(stands, None)
            dark = _UNSEEN if light.unseen else _BLACK if is_body else _LAMP
            made = Gathered(
                dark, radiance, False, light.shaping, light.path, (), unseen=light.unseen
            )
            self._group(made).add(lamps.shape(light, row))
            losses += lost
        else:
            self._report.add(light.path, "skipped", "; ".join(losses))
            return
        self._report.say(light.path, losses)

    # Surfaces.

    def add_mesh(self, mesh: PlacedMesh, parts: Parts, *, whole: bool) -> None:
        losses: list[str] = []
        emitted = self._emitting.get(str(mesh.prim.GetPath()))
        shaping = None if emitted is None else emitted.shaping
        for rows, material in parts:
            surface, st = self._surfaces.read(mesh, material, losses)
            radiance = lamps.emission(surface, emitted)
            if surface.pane is not None and radiance is not None:
                radiance = None
                losses.append("a clear pane emits nothing")
            if radiance is not None and mesh.double_sided:
                losses.append("it emits from its front side only")
            piece = self._labels.row(mesh.path, material_path(material))
            sheet = surface.pane is not None and mesh.double_sided
            # What emits is a shape of its own, so that it is sampled as one light.
            bent, lamp = (None, "") if radiance is None else (shaping, mesh.path)
            unlit = self._links.unlit_by(mesh.path)
            group = self._group(Gathered(surface, radiance, sheet, bent, lamp, unlit))
            group.place(self._surfaces.moved(mesh, rows, material, losses), rows, st, piece)
        if losses or whole:
            self._report.say(mesh.path, losses)

    def _group(self, made: Gathered) -> Gathered:
        """The group of this kind: an earlier one, or else this."""
        key = id(made.surface), made.lamp, made.is_sheet, made.unlit_by
        return self._groups.setdefault(key, made)


def _folder(stage: Usd.Stage) -> Path | None:
    """Where the file of a stage lies; None of one in memory."""
    file = stage.GetRootLayer().realPath
    return Path(file).parent if file else None


def is_unlit(stage: Usd.Stage) -> bool:
    """Whether a stage has no light at all.

    A light that is off or invisible says it, and so does our own step that writes lights, which may
    write none. What is bright by its material does, too (`is_negligible_emitter`).
    """
    if stage.GetPrimAtPath(names.LIGHTS):
        return False
    return not any(
        is_light(prim)
        for root in (stage.GetPseudoRoot(), *stage.GetPrototypes())
        for prim in Usd.PrimRange(root)
    )


def is_negligible_emitter(radiance: Value) -> bool:
    """Whether an emission is too weak to light the rest.

    Screens and signs of models that are shown in any light have colours up to 1; what shall light a
    scene is brighter.
    """
    most = radiance.pixels.max() if isinstance(radiance, Picture) else np.max(radiance)
    return bool(most <= _MOST_OF_A_GLOW_NITS)


def default_light() -> Environment:
    """The surroundings of a stage that has none: 1 nit in the mean, dark where one looks.

    The radiance in the direction d is 1/4 + 9/16 (1 + c)^2 nits with c = d . BRIGHTEST_FROM. A
    surface with the normal n and nothing around it receives pi (1 + 3/4 c + 3/64 (3 c^2 - 1)) lux
    with c = n . BRIGHTEST_FROM, so that the three sides of a box that one sees at once differ.
    """
    theta = np.linspace(0.0, np.pi, _ROWS)[:, None]
    phi = 2.0 * np.pi * (np.arange(2 * (_ROWS - 1)) + 0.5) / (2 * (_ROWS - 1))
    ways = np.stack(
        [np.sin(theta) * np.sin(phi), np.cos(theta) + 0.0 * phi, -np.sin(theta) * np.cos(phi)], -1
    )
    # The picture's upper edge is the world's +Z.
    upright = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    nits = 0.25 + 0.5625 * (1.0 + ways @ upright.T @ BRIGHTEST_FROM) ** 2
    pixels = np.repeat(nits[..., None], 3, axis=2).astype(np.float32)
    return Environment(pixels, upright)
