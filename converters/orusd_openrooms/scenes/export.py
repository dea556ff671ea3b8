"""How a room becomes a scene: its shell, its models, its lights, its cameras, and the file."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final, NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from pxr import Usd

from openrooms_usd import atomic, claims, names
from openrooms_usd.errors import StageError
from openrooms_usd.exporters import Report
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.light_records import light_records
from openrooms_usd.rendering.scene.models import without_shaping
from openrooms_usd.rendering.scene.sources import sources_of
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.usd.cameras import PINHOLE, PinholeCamera, list_cameras, read_camera
from openrooms_usd.usd.rendersettings import stage_resolution
from orusd_openrooms.cameras import layout_transforms, pose, write_cameras, write_intrinsics
from orusd_openrooms.images import write_rgbe
from orusd_openrooms.lights import ELSEWHERE, Light, light_of
from orusd_openrooms.pickles import write_pickled
from orusd_openrooms.scenes.layoutfiles import floor_of, layout_losses, write_layout
from orusd_openrooms.scenes.lightboxes import FORM, light_files, panorama
from orusd_openrooms.scenes.materials import Materials, losses
from orusd_openrooms.scenes.modelfiles import ModelFiles, plain_steps
from orusd_openrooms.scenes.objects import Object, Objects, objects_of
from orusd_openrooms.scenes.records import Bsdf, SceneFile, ShapeRecord, Step

_DECIMALS: Final = 6
# A turn's axis needs more: an error counts as often as a point is away from it.
_TURN_DECIMALS: Final = 9
_SAMPLES: Final = 1024
_MAPS: Final = ("albedo", "normal", "roughness", "metallic")
_UP: Final = "../../../"
_OFF: Final = 1e-8
_SAME_FOV_DEG: Final = 0.01
_USUAL_FOV_DEG: Final = 60.0
_MIDDLE_PX: Final = 0.5
# How far a window's middle may be from that of its opening.
_NEAR_M: Final = 0.5


class Film(NamedTuple):
    """What the pictures of a dataset were taken with.

    Attributes:
        fov_deg: The horizontal field of view.
        resolution: Width and height.
    """

    fov_deg: float
    resolution: tuple[int, int]


def export_scene(stage: Usd.Stage, destination: Path, name: str) -> Report:
    """Write a room below the folder of a dataset, with the cameras of the stage.

    Raises:
        StageError: The stage has no room.
        OutputError: A file cannot be written.
    """
    floor_of(stage)
    with (
        claims.claimed(destination, f".orusd.{name}.sha256"),
        atomic.replacing_files(destination) as root,
    ):
        export = _Export(stage, without_shaping(translate(stage, outside=False)), root, name)
        export.write()
    return export.report


def add_scene(stage: Usd.Stage, root: Path, name: str, split: str, film: Film) -> None:
    """Write a room beside pictures of it; the writer of the pictures writes their cameras.

    Args:
        stage: The composed stage.
        root: The dataset's folder.
        name: Of the scene.
        split: What the pictures are, such as ``mainDiffMat_xml``.
        film: What the pictures were taken with.

    Raises:
        StageError: The stage has no room.
        OutputError: A file cannot be written.
    """
    floor_of(stage)
    scene = without_shaping(translate(stage, outside=False))
    _Export(stage, scene, root, name, split).write(film)


class _Export:
    """One scene on its way into a folder."""

    def __init__(
        self, stage: Usd.Stage, scene: Scene, root: Path, name: str, split: str = "main_xml"
    ) -> None:
        self.stage, self.scene, self.root, self.name = stage, scene, root, name
        self.split, (self.variant, _, self.suffix) = split, split.partition("_")
        # What rooms and their variants do not share has a name of its own.
        different = f"{self.variant}{self.suffix.removeprefix('xml')}"
        self.own = name if different == "main" else f"{name}_{different}"
        self.report = scene.report
        self.objects: Objects = objects_of(stage, scene)

    def write(self, film: Film | None = None) -> None:
        """Everything; the cameras if no other writer does."""
        folder = self.root / "scenes" / self.suffix / self.name
        bsdfs, shapes = self._write_surfaces()
        film = film or Film(self._write_cameras(folder), stage_resolution(self.stage))
        environment, scale = self._write_environment()
        self._write_lights(scale, environment)
        steps = [list(plain_steps(item)) for item in self.objects.members]
        write_pickled(folder / "transform.dat", [*layout_transforms(), *steps])
        file = SceneFile(bsdfs, tuple(shapes), *film, environment, scale)
        atomic.write_text(folder / f"{self.variant}.xml", scene_text(file))
        self._report_losses()

    def _write_surfaces(self) -> tuple[dict[str, Bsdf], list[ShapeRecord]]:
        """The meshes and materials of the shell, and of what stands in it."""
        materials = Materials(self.root, _UP)
        bsdfs, shapes = write_layout(
            self.stage, self.scene, self.objects, self.root, self.own, materials, _UP
        )
        models = ModelFiles(self.root, _UP, self.own, materials, bsdfs)
        for item in self.objects.members:
            shapes.extend(models.shapes(item, len(shapes)))
            lost = [f"{item.baked}: its place is in its mesh"] if item.baked else []
            if (label := models.label(item)) != item.category:
                lost.append(f"as a light it is filed as {label}")
            if lost:
                self.report.add(item.path, "approximated", "; ".join(lost))
        return bsdfs, shapes

    def _write_cameras(self, folder: Path) -> float:
        """The cameras; returns the field of view that they have to share, degrees."""
        width, height = stage_resolution(self.stage)
        cameras: dict[str, PinholeCamera] = {}
        for prim in list_cameras(self.stage):
            try:
                camera = read_camera(prim, width, height)
                if camera.projection != PINHOLE:
                    raise StageError(f"cam.txt has no {camera.projection} cameras")
                cameras[str(prim.GetPath())] = camera
            except StageError as error:
                self.report.add(prim.GetPath(), "skipped", error.message)
        fovs = {
            path: float(2.0 * np.degrees(np.arctan(0.5 * width / camera.K[0, 0])))
            for path, camera in cameras.items()
        }
        fov = next(iter(fovs.values()), _USUAL_FOV_DEG)
        middle = np.array([0.5 * width, 0.5 * height])
        for path, camera in cameras.items():
            lost = []
            if abs(fovs[path] - fov) > _SAME_FOV_DEG:
                lost.append(f"the scene has one field of view, {fov:.2f} degrees")
            if np.abs(camera.K[:2, 2] - middle).max() > _MIDDLE_PX:
                lost.append("its principal point is in the centre there")
            self.report.add(path, "approximated" if lost else "translated", "; ".join(lost))
        write_cameras(folder / "cam.txt", [pose(c.world_from_camera) for c in cameras.values()])
        focal = 0.5 * width / np.tan(np.radians(fov) / 2.0)
        K = np.array([[focal, 0.0, middle[0]], [0.0, focal, middle[1]], [0.0, 0.0, 1.0]])
        write_intrinsics(self.root / "scenes/intrinsic.txt", K)
        return fov

    def _write_environment(self) -> tuple[str, float]:
        """The surroundings in nits; their path and factor. Loaders want a picture of darkness."""
        pixels = panorama(self.scene)
        on = bool(pixels.any())
        path = f"EnvDataset/{self.own}.hdr"
        write_rgbe(self.root / path, pixels if on else np.ones_like(pixels))
        return f"{_UP}{path}", 1.0 if on else _OFF

    def _write_lights(self, scale: float, environment: str) -> None:
        """The boxes of windows and lamps, counted in the order of their shapes."""
        records = light_records(self.stage, self.scene, sources_of(self.scene))
        known = {one.path: light_of(one) for one in records if one.kind != ELSEWHERE}
        openings = [light for light in known.values() if light.is_window]
        lights: list[Light] = []
        for item in self.objects.members:
            if item.category == "window" and scale > _OFF:
                lights.append(_window(item, openings))
            elif item.radiance is not None:
                # Loaders refuse a scene whose two files say different things of a lamp.
                lights.append(replace(known[item.path], radiance=np.array(item.radiance)))
        folder = self.root / self.split / self.name
        # Loaders sort the files by their names.
        digits = len(str(max(len(lights) - 1, 0)))
        for number, (box, shines) in enumerate(light_files(lights, scale, environment)):
            write_pickled(folder / f"box{number:0{digits}}.dat", box)
            write_pickled(folder / f"light_{FORM}_{number:0{digits}}.dat", shines)

    def _report_losses(self) -> None:
        """What of surfaces such a file cannot say, and what moves."""
        lost = {path: reason for path, reason in layout_losses(self.objects) if reason}
        for item in self.objects.members:
            for part in item.parts.values():
                shines = part.patch.radiance is not None
                reason = "light sources have no material there" if shines else ""
                for triangles in part.triangles:
                    piece = self.scene.pieces[int(triangles.pieces[0])]
                    path = self.scene.legend.part[piece.part]
                    lost[path] = reason or losses(part.patch.surface)
        self.report.lose(lost)
        for prim in self.stage.Traverse():
            if prim.GetAttribute(names.JOINT_TYPE):
                self.report.add(prim.GetPath(), "skipped", "nothing moves in a scene")


def _window(item: Object, openings: Sequence[Light]) -> Light:
    """The opening that a window fills; a dark one where nothing shines in by it."""
    low, high = item.bounds
    center = 0.5 * (low + high)
    nearest = min(
        openings, key=lambda one: float(np.linalg.norm(one.center - center)), default=None
    )
    if nearest is not None and np.linalg.norm(nearest.center - center) < _NEAR_M:
        return nearest
    return Light(0, True, False, center, np.eye(3), high - low, np.zeros(3), {})


def scene_text(file: SceneFile) -> str:
    """The text of a scene file."""
    # Misspelt in the release; loaders look for this spelling to mend it.
    root = Element("scene", verion="0.5.0")
    SubElement(root, "integrator", type="path")
    for bsdf in file.bsdfs.values():
        root.append(_bsdf(bsdf))
    for shape in file.shapes:
        root.append(_shape(shape))
    root.append(_sensor(file))
    emitter = SubElement(root, "emitter", type="envmap")
    SubElement(emitter, "string", name="filename", value=file.environment or "")
    SubElement(emitter, "float", name="scale", value=f"{file.environment_scale:.8f}")
    ElementTree.indent(root, " " * 4)
    return f'<?xml version="1.0" ?>\n{ElementTree.tostring(root, encoding="unicode")}\n'


def _bsdf(bsdf: Bsdf) -> Element:
    """A material; the renderer refuses names that it does not know, so usual values are left out.

    Maps and constants exclude each other.
    """
    element = Element("bsdf", id=bsdf.id, type="microfacet")
    if bsdf.maps:
        _float(element, "uvScale", bsdf.uv_scale)
    for kind in _MAPS:
        if kind in bsdf.maps:
            texture = SubElement(element, "texture", name=kind, type="bitmap")
            SubElement(texture, "string", name="filename", value=bsdf.maps[kind])
    if "albedo" not in bsdf.maps:
        SubElement(element, "rgb", name="albedo", value=_numbers(bsdf.albedo))
    SubElement(element, "rgb", name="albedoScale", value=_numbers(bsdf.albedo_scale))
    if "roughness" not in bsdf.maps:
        _float(element, "roughness", bsdf.roughness)
    _float(element, "roughnessScale", bsdf.roughness_scale)
    if "metallic" not in bsdf.maps and bsdf.metallic:
        _float(element, "metallic", bsdf.metallic)
    if bsdf.f0 != Bsdf("").f0:
        _float(element, "fresnel", bsdf.f0)
    return element


def _shape(shape: ShapeRecord) -> Element:
    element = Element("shape", id=shape.id, type="obj")
    SubElement(element, "string", name="filename", value=shape.file)
    if shape.radiance is not None:
        emitter = SubElement(element, "emitter", type="area")
        SubElement(emitter, "rgb", value=_numbers(shape.radiance))
    transform = SubElement(element, "transform", name="toWorld")
    transform.extend(_step(step) for step in shape.steps)
    for ref in shape.refs:
        SubElement(element, "ref", id=ref, name="bsdf")
    return element


def _step(step: Step) -> Element:
    element: Element = Element(str(step.kind))
    values = step.values
    decimals = _DECIMALS
    if step.kind == "rotate":
        element.set("angle", f"{values[0]:.{_TURN_DECIMALS}f}")
        values, decimals = values[1:], _TURN_DECIMALS
    for axis, value in zip("xyz", values, strict=True):
        element.set(axis, f"{value + 0.0:.{decimals}f}")
    return element


def _sensor(file: SceneFile) -> Element:
    sensor = Element("sensor", type="perspective")
    _float(sensor, "fov", file.fov or 0.0)
    SubElement(sensor, "string", name="fovAxis", value="x")
    film = SubElement(sensor, "film", type="hdrfilm")
    for name, value in zip(("width", "height"), file.resolution, strict=True):
        SubElement(film, "integer", name=name, value=str(value))
    sampler = SubElement(sensor, "sampler", type="adaptive")
    SubElement(sampler, "integer", name="sampleCount", value=str(_SAMPLES))
    return sensor


def _float(element: Element, name: str, value: float) -> None:
    SubElement(element, "float", name=name, value=f"{value:.{_DECIMALS}f}")


def _numbers(values: Iterable[float]) -> str:
    return " ".join(f"{value:.{_DECIMALS}f}" for value in values)
