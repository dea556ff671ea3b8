"""How a room becomes a scene: its shell, its models, its lights, its cameras, and the file."""

import re
from collections.abc import Container, Iterator, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pxr import Usd
from scipy.spatial.transform import Rotation

from openrooms_usd import atomic, names
from openrooms_usd.categories.record import given
from openrooms_usd.categories.registry import record
from openrooms_usd.convert import Report
from openrooms_usd.errors import StageError
from openrooms_usd.render.scene.arrays import Scene, Triangles
from openrooms_usd.render.scene.cameras import stage_resolution
from openrooms_usd.render.scene.light_records import light_records
from openrooms_usd.render.scene.sources import sources_of
from openrooms_usd.render.scene.translate import translate
from openrooms_usd.usd.cameras import list_cameras, read_camera
from openrooms_usd.usd.photometry import world_from_prim
from orusd_openrooms.cameras import (
    THEIRS_FROM_OURS,
    layout_transforms,
    pose,
    write_cameras,
    write_intrinsics,
)
from orusd_openrooms.pickles import write_pickled
from orusd_openrooms.records import ELSEWHERE, Light, light_of
from orusd_openrooms.rgbe import write_rgbe
from orusd_openrooms.scenes.lightboxes import FORM, light_files, panorama
from orusd_openrooms.scenes.microfacet import Materials, losses, mapping
from orusd_openrooms.scenes.objects import Object, Objects, objects_of
from orusd_openrooms.scenes.objtext import Faces, obj_bytes
from orusd_openrooms.scenes.records import Bsdf, SceneFile, Shape, Step
from orusd_openrooms.scenes.things import label_of
from orusd_openrooms.scenes.thinshell import Opening, outside, shell_faces
from orusd_openrooms.scenes.writing import scene_text

Array = NDArray[np.float64]

_UP: Final = "../../../"
# Our objects look along -Y and theirs along -Z, with Y up.
_MODEL_FROM_OBJECT: Final = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
_LAMPS: Final = "03636649"
_OFF: Final = 1e-8
_STILL_DEG: Final = 1e-7
_SAME_FOV_DEG: Final = 0.01


def export_scene(stage: Usd.Stage, destination: Path, name: str) -> Report:
    """Write a room below the folder of a dataset.

    Args:
        stage: The composed stage.
        destination: The dataset's folder.
        name: Of the scene.

    Raises:
        StageError: The stage has no room.
        OutputError: A file cannot be written.
    """
    floor = _floor(stage)
    scene = translate(stage)
    with atomic.filling(destination) as root:
        _Export(stage, scene, root, name).write(floor)
    return scene.report


def _floor(stage: Usd.Stage) -> Array:
    prim = stage.GetPrimAtPath(names.ROOM)
    attribute = prim.GetAttribute(names.ROOM_FLOOR) if prim else None
    corners = np.array(attribute.Get() if attribute else [], dtype=np.float64)
    if corners.ndim != 2 or len(corners) < 3 or not np.isfinite(corners).all():
        raise StageError(
            "the stage has no room whose floor is known",
            place=names.ROOM,
            remedy="give a stage that orusd compose has made",
        )
    return corners


class _Export:
    """One scene on its way into a folder."""

    def __init__(self, stage: Usd.Stage, scene: Scene, root: Path, name: str) -> None:
        self.stage, self.scene, self.root, self.name = stage, scene, root, name
        self.report = scene.report
        self.objects: Objects = objects_of(stage, scene)
        self.materials = Materials(root, _UP)
        self.bsdfs: dict[str, Bsdf] = {}
        self.shapes: list[Shape] = []
        # Of each prototype: its folder, its files with what they emit, and its materials.
        self._models: dict[str, tuple[str, tuple[str, ...], tuple[str, ...]]] = {}
        self._folders: set[str] = set()
        self._lost: dict[str, str] = {}

    def write(self, floor: Array) -> None:
        """Everything."""
        self._write_layout(floor)
        for thing in self.objects.things:
            self._write_thing(thing)
        folder = self.root / "scenes/xml" / self.name
        fov, resolution = self._write_cameras(folder)
        environment, scale = self._write_environment()
        file = SceneFile(self.bsdfs, tuple(self.shapes), fov, resolution, environment, scale)
        self._write_lights(scale, environment)
        steps = [list(_plain(thing)) for thing in self.objects.things]
        write_pickled(folder / "transform.dat", [*layout_transforms(), *steps])
        atomic.write_text(folder / "main.xml", scene_text(file))
        self.report.lose(self._lost)
        for prim in self.stage.Traverse():
            if prim.GetAttribute(names.JOINT_TYPE):
                self.report.add(prim.GetPath(), "skipped", "nothing moves in a scene")

    # The shell.

    def _write_layout(self, floor: Array) -> None:
        height = float(
            self.stage.GetPrimAtPath(names.ROOM).GetAttribute("openrooms:room:height").Get()
        )
        openings = list(_openings(self.stage))
        worn = {}
        for part in ("wall", "ceiling", "floor"):
            identifier = f"{self.name}_{part}"
            material, patch = self.objects.shell.get(part, ("", None))
            uv = np.eye(3)
            self.bsdfs[identifier] = Bsdf(identifier)
            if patch is not None:
                self.bsdfs[identifier] = self.materials.bsdf(
                    identifier, patch.surface, _tail(material)
                )
                uv = mapping(patch.surface) @ patch.surface.uv
            worn[part] = identifier, uv
        for path, patch in self.objects.shells.items():
            part = next(p for p, own in self.objects.shell.items() if _is_of(path, p))
            lost = ["its faces are thin, without reveals"] if part == "wall" else []
            if patch.surface is not self.objects.shell[part][1].surface:
                lost.append(f"it wears the material of the other {part}s")
            self._lose(path, "; ".join([*lost, losses(patch.surface)]))
        thickness = self._thickness()
        around = outside(floor, thickness)
        inner = shell_faces(floor, 0.0, height, openings, worn)
        outer = shell_faces(around, -thickness, height + thickness, openings, worn)
        for file, faces in (("uv_mapped.obj", inner), ("container.obj", outer)):
            path = f"layoutMesh/{self.name}/{file}"
            atomic.write_bytes(self.root / path, obj_bytes(faces))
            steps = (
                Step.scale(1.0, 1.0, 1.0),
                Step.rotate(90.0, np.array([-1.0, 0.0, 0.0])),
                Step.translate(0.0, 0.0, 0.0),
            )
            refs = tuple(identifier for identifier, _ in worn.values())
            self.shapes.append(
                Shape(len(self.shapes), f"{self.name}_object", f"{_UP}{path}", steps, refs)
            )

    def _thickness(self) -> float:
        """Of the walls and slabs: how far the floor's mesh reaches down."""
        low = [
            float(patch.triangles.rows(patch.triangles.pieces == row).corners[..., 2].min())
            for patch in {id(p): p for p in self.objects.shells.values()}.values()
            for row in np.unique(patch.triangles.pieces)
            if _is_of(self.scene.legend.part[self.scene.pieces[row].part], "floor")
        ]
        return max(-min(low, default=0.0), 0.01)

    # What stands in the room.

    def _write_thing(self, thing: Object) -> None:
        if thing.prototype not in self._models:
            self._models[thing.prototype] = self._write_model(thing)
        folder, files, refs = self._models[thing.prototype]
        radiance = thing.radiance
        lost = ["its matrix shears or mirrors: it is in its mesh"] if thing.baked else []
        if (read := label_of(folder.partition("/")[0])) != thing.category:
            lost.append(f"as a light it is filed as {read}")
        if lost:
            self.report.add(thing.path, "approximated", "; ".join(lost))
        for file in files:
            emits = radiance is not None and (file == "aligned_light.obj" or len(files) == 1)
            self.shapes.append(
                Shape(
                    len(self.shapes),
                    f"{folder.replace('/', '_')}_object",
                    f"{_UP}uv_mapped/{folder}/{file}",
                    tuple(_steps(thing)),
                    () if emits else refs,
                    radiance if emits else None,
                )
            )

    def _write_model(self, thing: Object) -> tuple[str, tuple[str, ...], tuple[str, ...]]:
        folder = _unique(f"{_folder(thing)}/{_plain_name(thing.name)}", self._folders)
        self._folders.add(folder)
        prefix = folder.replace("/", "_")
        dark: list[Faces] = []
        lit: list[Faces] = []
        for part in thing.parts.values():
            emits = part.patch.radiance is not None
            identifier = _unique(f"{prefix}_{part.name}", self.bsdfs)
            faces = _faces(thing, part.triangles, identifier, mapping(part.patch.surface))
            (lit if emits else dark).append(faces)
            if not emits:
                bsdf = self.materials.bsdf(identifier, part.patch.surface, _tail(part.material))
                self.bsdfs[identifier] = bsdf
            lost = "what shines has no material there" if emits else losses(part.patch.surface)
            for path in sorted({self._path(one) for one in part.triangles}):
                self._lose(path, lost)
        refs = tuple(faces.material for faces in dark)
        files = {"alignedNew.obj": [*dark, *lit]}
        if dark and lit:
            files |= {"aligned_shape.obj": dark, "aligned_light.obj": lit}
        for file, faces_of in files.items():
            atomic.write_bytes(self.root / "uv_mapped" / folder / file, obj_bytes(faces_of))
        shown = ("aligned_shape.obj", "aligned_light.obj") if dark and lit else ("alignedNew.obj",)
        return folder, shown, refs

    def _path(self, triangles: Triangles) -> str:
        piece = self.scene.pieces[int(triangles.pieces[0])]
        return self.scene.legend.part[piece.part]

    def _lose(self, path: str, reason: str) -> None:
        reason = reason.strip("; ")
        if reason:
            self._lost[path] = "; ".join(filter(None, (self._lost.get(path, ""), reason)))

    # Cameras and light.

    def _write_cameras(self, folder: Path) -> tuple[float, tuple[int, int]]:
        width, height = stage_resolution(self.stage)
        poses, fovs = [], []
        for prim in list_cameras(self.stage):
            try:
                camera = read_camera(prim, width, height)
            except StageError as error:
                self.report.add(prim.GetPath(), "skipped", error.message)
                continue
            K = camera.K
            fovs.append(float(2.0 * np.degrees(np.arctan(0.5 * width / K[0, 0]))))
            poses.append(pose(camera.world_from_camera))
            lost = []
            if abs(fovs[-1] - fovs[0]) > _SAME_FOV_DEG:
                lost.append(f"the scene has one field of view, {fovs[0]:.2f} degrees")
            if np.abs(K[:2, 2] - [0.5 * width, 0.5 * height]).max() > 0.5:
                lost.append("its principal point is in the middle there")
            outcome = "approximated" if lost else "translated"
            self.report.add(prim.GetPath(), outcome, "; ".join(lost))  # type: ignore[arg-type]
        fov = fovs[0] if fovs else 60.0
        write_cameras(folder / "cam.txt", poses)
        focal = 0.5 * width / np.tan(np.radians(fov) / 2.0)
        K = np.array([[focal, 0.0, 0.5 * width], [0.0, focal, 0.5 * height], [0.0, 0.0, 1.0]])
        write_intrinsics(self.root / "scenes/intrinsic.txt", K)
        return fov, (width, height)

    def _write_environment(self) -> tuple[str, float]:
        pixels = panorama(self.scene)
        on = bool(pixels.any())
        path = f"EnvDataset/{self.name}.hdr"
        write_rgbe(self.root / path, pixels if on else np.ones_like(pixels))
        return f"{_UP}{path}", 1.0 if on else _OFF

    def _write_lights(self, scale: float, environment: str) -> None:
        """The boxes of windows and lamps, counted in the order of their shapes."""
        records = light_records(self.stage, self.scene, sources_of(self.scene))
        by_path = {one.path: light_of(one) for one in records if one.kind != ELSEWHERE}
        lights: list[Light] = []
        for thing in self.objects.things:
            windows = f"{names.LIGHTS}/Portals/{thing.name}"
            found = by_path.get(thing.path)
            if found is None and thing.category == "window" and scale > _OFF:
                found = by_path.get(windows)
            if found is not None:
                lights.append(found)
        folder = self.root / "main_xml" / self.name
        digits = len(str(max(len(lights) - 1, 0)))
        for number, (box, shines) in enumerate(light_files(lights, scale, environment)):
            write_pickled(folder / f"box{number:0{digits}}.dat", box)
            write_pickled(folder / f"light_{FORM}_{number:0{digits}}.dat", shines)


def _openings(stage: Usd.Stage) -> Iterator[Opening]:
    group = stage.GetPrimAtPath(names.OPENINGS)
    for prim in group.GetChildren() if group else ():
        width, height = (
            prim.GetAttribute(name).Get() for name in (names.OPENING_WIDTH, names.OPENING_HEIGHT)
        )
        if width and height:
            M = world_from_prim(prim)
            along = M[:3, 0] / np.linalg.norm(M[:3, 0])
            yield Opening(M[:3, 3], along, float(width), float(height))


def _is_of(path: str, part: str) -> bool:
    root = {"floor": names.FLOOR, "ceiling": names.CEILING, "wall": names.WALLS}[part]
    return path == root or path.startswith(f"{root}/")


def _folder(thing: Object) -> str:
    """The folder of a category: where lights are, loaders know them by it."""
    if thing.radiance is not None:
        return "ceiling_lamp" if thing.category == "ceiling_lamp" else _LAMPS
    found = record(thing.category)
    synsets = given(found.synsets, ()) if found is not None else ()
    # Several of our categories have one synset; the reader takes the first of them.
    return next((s for s in synsets if label_of(s) == thing.category), thing.category)


def _steps(thing: Object) -> Iterator[Step]:
    """Scale, rotation and translation of a model, then the shifts that come after them."""
    matrix = thing.world_from_object
    scale = np.linalg.norm(matrix[:3, :3], axis=0)
    turn = THEIRS_FROM_OURS @ (matrix[:3, :3] / scale) @ _MODEL_FROM_OBJECT.T
    x, y, z = (np.abs(_MODEL_FROM_OBJECT) @ scale).tolist()
    yield Step.scale(x, y, z)
    vector = Rotation.from_matrix(turn).as_rotvec(degrees=True)
    angle = float(np.linalg.norm(vector))
    if angle > _STILL_DEG:
        yield Step.rotate(angle, vector)
    moved = matrix[:3, 3] - sum(thing.shifts, np.zeros(3))
    for shift in (moved, *thing.shifts):
        u, v, w = (THEIRS_FROM_OURS @ shift).tolist()
        yield Step.translate(u, v, w)


def _plain(thing: Object) -> Iterator[tuple[str, Array]]:
    """The same steps as ``transform.dat`` has them."""
    for step in _steps(thing):
        if step.kind == "rotate":
            yield "rot", step.matrix[:3, :3]
        else:
            yield ("s" if step.kind == "scale" else "t"), np.array(step.values)


def _faces(thing: Object, triangles: Sequence[Triangles], material: str, uv: Array) -> Faces:
    corners = np.concatenate([one.corners for one in triangles])
    normals = np.concatenate([one.normals for one in triangles]).astype(np.float64)
    st = np.concatenate([one.st for one in triangles]).astype(np.float64)
    object_from_world = np.linalg.inv(thing.world_from_object)
    local = corners @ object_from_world[:3, :3].T + object_from_world[:3, 3]
    # Normals go with the inverse transpose of the way of points.
    turned = normals @ thing.world_from_object[:3, :3]
    turned = turned / np.maximum(np.linalg.norm(turned, axis=-1, keepdims=True), 1e-12)
    C = _MODEL_FROM_OBJECT
    return Faces(material, local @ C.T, turned @ C.T, st @ uv[:2, :2].T + uv[:2, 2])


def _plain_name(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9_]+", "_", name) or "object"


def _tail(path: str) -> str:
    return path.rpartition("/")[2] or "material"


def _unique(name: str, taken: Container[str]) -> str:
    number, found = 0, name
    while found in taken:
        number += 1
        found = f"{name}_{number}"
    return found
