"""A stage as a Mitsuba XML scene: one shape for each prim, meshes and textures beside it."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any, Final
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray
from pxr import Usd

from openrooms_usd import atomic, claims, imagefile, ledger
from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError, StageError
from openrooms_usd.exporters import Report
from openrooms_usd.portable import RESERVED
from openrooms_usd.progress import Progress, each, nested, silent
from openrooms_usd.rendering.contract import DEFAULT_BOUNCES, DEFAULT_SAMPLES
from openrooms_usd.rendering.scene.arrays import Environment, Patch, Scene
from openrooms_usd.rendering.scene.cameras import camera_losses
from openrooms_usd.rendering.scene.instances import Instances
from openrooms_usd.rendering.scene.models import (
    report_plain,
    report_principled,
    report_simplified,
    with_model,
    without_shaping,
)
from openrooms_usd.rendering.scene.pictures import Picture
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.rendering.scene.triangles import Triangles
from openrooms_usd.usd.cameras import PinholeCamera, framing_camera, list_cameras, read_camera
from openrooms_usd.usd.rendersettings import stage_resolution
from orusd_mitsuba.plugins.descriptions import (
    Description,
    describe_area,
    describe_bsdf,
    describe_sun,
)
from orusd_mitsuba.plugins.light_weights import light_weights
from orusd_mitsuba.plugins.sensors import describe_sensor

_TAGS: Final = {
    "path": "integrator",
    "perspective": "sensor",
    "thinlens": "sensor",
    "orthographic": "sensor",
    "independent": "sampler",
    "hdrfilm": "film",
    "box": "rfilter",
    "ply": "shape",
    "shapegroup": "shape",
    "instance": "shape",
    "area": "emitter",
    "constant": "emitter",
    "envmap": "emitter",
    "directional": "emitter",
    "diffuse": "bsdf",
    "principled": "bsdf",
    "normalmap": "bsdf",
    "twosided": "bsdf",
    "mask": "bsdf",
    "blendbsdf": "bsdf",
    "principledthin": "bsdf",
    "thindielectric": "bsdf",
    "bitmap": "texture",
}
# The share of reading the stage in all of the time.
_TRANSLATED: Final = 0.3
_VERSION: Final = "3.0.0"
_HEADER = """ply
format binary_little_endian 1.0
element vertex {vertices}
property float x
property float y
property float z
property float nx
property float ny
property float nz
property float u
property float v
element face {faces}
property list uchar int vertex_index
end_header
"""
# Nearer to the origin than this, single precision still resolves a twentieth of a millimetre.
_NEAR_ORIGIN_METRES: Final = 1000.0


def export_scene(
    stage: Usd.Stage, destination: Path, options: Mapping[str, Any], progress: Progress = silent
) -> Report:
    """Write a stage as a Mitsuba scene.

    Args:
        stage: The composed stage.
        destination: The ``.xml`` file, or a folder that receives ``scene.xml``. Meshes and
            textures go into ``NAME.meshes`` and ``NAME.textures`` beside ``NAME.xml``.
        options: None is known.
        progress: Called with each surface.

    Returns:
        What became of every prim.

    Raises:
        InputError: An option is given.
        OutputError: A file cannot be written, or one that is not ours would give way.
    """
    if options:
        known = ", ".join(options)
        raise InputError(f"the Mitsuba exporter has no option {known}", remedy="omit it")
    is_file = destination.suffix.lower() == ".xml"
    file = destination if is_file else destination / "scene.xml"
    # A folder may hold several scenes: each has a ledger of its own.
    known = ledger.name_of(file.name)
    claims.check_refill(file.parent, known, [file.name])
    progress("translating", 0.0)
    # What loads the file knows Mitsuba's own plugins alone.
    scene = without_shaping(with_model(translate(stage, default_light=True), "preview"))
    report_simplified(scene)
    report_plain(scene)
    report_principled(scene)
    with claims.refilling(file.parent, known) as refill:
        inner = nested(progress, "", _TRANSLATED, 1.0)
        _write_scene(stage, scene, refill.folder / file.name, inner)
    return scene.report


def _write_scene(stage: Usd.Stage, scene: Scene, file: Path, progress: Progress) -> None:
    export = _Export(scene, file.parent, file.stem)
    # 1. What a scene is rendered with.
    export.add("integrator", {"type": "path", "max_depth": DEFAULT_BOUNCES + 1})
    for name, camera in _cameras(stage, scene).items():
        export.add_camera(name, camera, stage_resolution(stage))
    # 2. Light from far away.
    if scene.environment is not None:
        export.add_environment(scene.environment)
    for sun, weight in zip(scene.suns, export.weights.suns, strict=True):
        export.add("sun", describe_sun(sun, weight))
    # 3. Surfaces.
    patches = (*scene.patches, *(pane.sheet() for pane in scene.panes))
    for patch in each(progress, "surface", patches, len(patches)):
        export.add_patch(patch)
    atomic.write_text(file, scene_text(export.objects))


def _cameras(stage: Usd.Stage, scene: Scene) -> dict[str, PinholeCamera]:
    width, height = stage_resolution(stage)
    cameras = {}
    for prim in list_cameras(stage):
        try:
            cameras[str(prim.GetPath())] = read_camera(prim, width, height)
            scene.report.say(prim.GetPath(), camera_losses(prim, scene))
        except StageError as error:
            scene.report.add(prim.GetPath(), "skipped", error.message)
    return cameras or {"/framing": framing_camera(stage, width, height)}


@dataclass
class _Export:
    """The objects of the scene file, and the files that are written beside it."""

    scene: Scene
    folder: Path
    name: str
    objects: dict[str, Description] = field(default_factory=dict)
    _files: dict[int, tuple[PurePosixPath, object]] = field(default_factory=dict)
    _bsdfs: dict[int, str] = field(default_factory=dict)
    _taken: set[str] = field(default_factory=lambda: set(RESERVED))

    def __post_init__(self) -> None:
        self.weights = light_weights(self.scene)
        self._origin = np.zeros(3)
        if np.abs(self.scene.origin).max() > _NEAR_ORIGIN_METRES:
            self._origin = self.scene.origin
            moved = f"everything is moved by {(-self._origin).tolist()} m, near the origin"
            self.scene.report.add("/", "approximated", moved)

    def add(self, path: str, description: Description) -> str:
        """Add an object and return its identifier."""
        identifier = self._identifier(path)
        self.objects[identifier] = description
        return identifier

    def add_camera(self, path: str, camera: PinholeCamera, size: tuple[int, int]) -> None:
        sensor = describe_sensor(camera, *size, self._origin)
        sensor["sampler"] = {"type": "independent", "sample_count": DEFAULT_SAMPLES}
        self.add(path, sensor)

    def add_environment(self, environment: Environment) -> None:
        weight = {"sampling_weight": self.weights.sky}
        if environment.pixels.shape[:2] == (1, 1):
            color = {"type": "rgb", "value": environment.pixels[0, 0].tolist()}
            self.add("environment", {"type": "constant", "radiance": color, **weight})
            return
        turn = np.eye(4)
        turn[:3, :3] = environment.world_from_light
        file = self._picture(environment.pixels, "environment")
        sky = {"type": "envmap", "filename": file, "to_world": turn, **weight}
        self.add("environment", sky)

    def add_patch(self, patch: Patch) -> None:
        for part in patch.triangles.parts:
            if isinstance(part, Instances):
                self._add_instances(patch, part)
            else:
                self._add_pieces(patch, part)

    def _add_pieces(self, patch: Patch, triangles: Triangles) -> None:
        """A shape of each piece of surface."""
        order = np.argsort(triangles.pieces, kind="stable")
        pieces, starts = np.unique(triangles.pieces[order], return_index=True)
        for piece, rows in zip(pieces.tolist(), np.split(order, starts[1:]), strict=True):
            bsdf = self._bsdf(patch)
            identifier = self._identifier(self._prim(piece))
            file = self._mesh(identifier, triangles.rows(rows), self._origin)
            shape: Description = {"type": "ply", "filename": file, "bsdf": bsdf}
            if patch.radiance is not None:
                weight = self.weights.patches[patch.name]
                shape["emitter"] = self._resolved(describe_area(patch.radiance, weight))
            self.objects[identifier] = shape

    def _add_instances(self, patch: Patch, instances: Instances) -> None:
        """What they share as one mesh, and where each stands."""
        bsdf = self._bsdf(patch)
        group = self._identifier(f"{self._prim(int(instances.owners[0]))}/shared")
        centred = instances.centred()
        file = self._mesh(group, centred.prototype, np.zeros(3))
        shared: Description = {"type": "ply", "filename": file, "bsdf": bsdf}
        self.objects[group] = {"type": "shapegroup", "mesh": shared}
        matrices = centred.seen_from(self._origin)
        for piece, matrix in zip(centred.owners.tolist(), matrices, strict=True):
            instance = {"type": "instance", "group": {"ref": group}, "to_world": matrix}
            self.add(self._prim(piece), instance)

    def _prim(self, piece: int) -> str:
        return self.scene.legend.part[self.scene.pieces[piece].part]

    def _mesh(self, name: str, triangles: Triangles, origin: Array) -> PurePosixPath:
        file = PurePosixPath(f"{self.name}.meshes", f"{name}.ply")
        atomic.write_bytes(self.folder / file, ply_bytes(triangles, origin))
        return file

    def _bsdf(self, patch: Patch) -> Description:
        key = id(patch.surface)
        if key not in self._bsdfs:
            self._bsdfs[key] = self.add("bsdf", self._resolved(describe_bsdf(patch.surface)))
        return {"ref": self._bsdfs[key]}

    def _identifier(self, path: str) -> str:
        """A name for an object: the prim's path, made of plain characters, unlike every other."""
        plain = re.sub(r"[^A-Za-z0-9]+", "_", path).strip("_") or "object"
        name, number = plain, 1
        # Files are named so too, and some file systems take capitals for small letters.
        while name.lower() in self._taken:
            number += 1
            name = f"{plain}_{number}"
        self._taken.add(name.lower())
        return name

    def _resolved(self, value: Any) -> Any:
        """A description with its pictures written to files."""
        if isinstance(value, dict):
            return {name: self._resolved(item) for name, item in value.items()}
        if not isinstance(value, Picture):
            return value
        texture: Description = {
            "type": "bitmap",
            "filename": self._picture(value.pixels, f"texture_{len(self._files) + 1}"),
            "raw": True,
            "wrap_mode": value.ways[0],
        }
        return texture if value.is_plain else texture | {"to_uv": value.uv}

    def _picture(self, pixels: NDArray[np.floating[Any]], name: str) -> PurePosixPath:
        """Write pixels as they are, linear; Mitsuba's v grows from the first row, as here."""
        key = id(pixels)
        if key not in self._files:
            file = PurePosixPath(f"{self.name}.textures", f"{name}.exr")
            _write_exr(self.folder / file, pixels)
            # The pixels are kept with it, so that their identity is not given to others.
            self._files[key] = file, pixels
        return self._files[key][0]


def _write_exr(target: Path, pixels: NDArray[np.floating[Any]]) -> None:
    kind = "half" if pixels.dtype == np.float16 else "float"
    with atomic.replacing(target) as beside:
        # The library would write the time of day.
        imagefile.write(beside, pixels, kind, {"DateTime": ""})


def ply_bytes(triangles: Triangles, origin: Array) -> bytes:
    """A PLY file of triangles; corners that agree in everything become one vertex.

    Args:
        triangles: What to write.
        origin: (3,) the point of the world that is the file's origin.
    """
    points = (triangles.corners - origin).astype(np.float32)
    corners = np.concatenate([points, triangles.normals, triangles.st], axis=2).reshape(-1, 8)
    # Adding zero makes -0 and 0 one number.
    vertices, index = np.unique(corners + np.float32(0), axis=0, return_inverse=True)
    faces = np.empty(len(triangles), dtype=[("count", "u1"), ("index", "<i4", 3)])
    faces["count"], faces["index"] = 3, index.reshape(-1, 3)
    header = _HEADER.format(vertices=len(vertices), faces=len(faces))
    return header.encode("ascii") + vertices.astype("<f4").tobytes() + faces.tobytes()


def scene_text(objects: dict[str, Any]) -> str:
    """A whole scene file.

    Args:
        objects: Plugin descriptions by identifier. ``{"ref": identifier}`` refers to another.
    """
    root = ElementTree.Element("scene", version=_VERSION)
    for identifier, description in objects.items():
        element = _plugin(description)
        element.set("id", identifier)
        root.append(element)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def _plugin(description: dict[str, Any]) -> ElementTree.Element:
    kind = description["type"]
    element = ElementTree.Element(_TAGS[kind], type=kind)
    for name, value in description.items():
        if name != "type":
            element.append(_property(name, value))
    return element


def _property(name: str, value: Any) -> ElementTree.Element:
    if isinstance(value, dict):
        return _nested(name, value)
    if isinstance(value, np.ndarray):
        transform = ElementTree.Element("transform", name=name)
        ElementTree.SubElement(transform, "matrix", value=_numbers(value))
        return transform
    if isinstance(value, list):
        return ElementTree.Element("vector", name=name, value=_numbers(value))
    tag, text = _scalar(value)
    return ElementTree.Element(tag, name=name, value=text)


def _nested(name: str, value: dict[str, Any]) -> ElementTree.Element:
    if "ref" in value:
        return ElementTree.Element("ref", name=name, id=value["ref"])
    if value["type"] == "rgb":
        return ElementTree.Element("rgb", name=name, value=_numbers(value["value"]))
    element = _plugin(value)
    element.set("name", name)
    return element


def _scalar(value: Any) -> tuple[str, str]:
    if isinstance(value, bool):
        return "boolean", "true" if value else "false"
    if isinstance(value, int):
        return "integer", str(value)
    if isinstance(value, PurePosixPath | str):
        return "string", str(value)
    return "float", repr(float(value))


def _numbers(values: Any) -> str:
    return " ".join(repr(float(value)) for value in np.asarray(values).ravel())
