"""A scene with its files: what was found of it, where everything stands, and the room around it."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.furniture import CATEGORIES, category
from openrooms_usd.geometry.rotations import inverse, is_rotation, nearest_rotation, pose
from openrooms_usd.geometry.triangulation import triangulate
from openrooms_usd.library.models.wavefront import read_obj
from orusd_openrooms.scenes.models import CadModel, extent_of_file, file_of
from orusd_openrooms.scenes.reading import read_scene
from orusd_openrooms.scenes.records import SceneFile, ShapeRecord, Step, whole
from orusd_openrooms.scenes.roots import Roots, named
from orusd_openrooms.scenes.sceneobjects import SceneObject, contents
from orusd_openrooms.scenes.shell import RELEASE_HEIGHT_M, Hole, Shell, shell_around, shell_of
from orusd_openrooms.scenes.standins import extent_of

OpeningKind = Literal["window", "door", "opening"]
MARK: Final = "imported.txt"
# From their world, Y up, to ours where no layout says it.
_UPRIGHT: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
# Files have six decimals; larger shears from a scale between two rotations are reported.
_SHEAR: Final = 1e-4
_TILT: Final = 1e-3


@dataclass(frozen=True, eq=False)
class Pose:
    """Where an object stands in our world.

    Attributes:
        measured: (4, 4) from the model's axes: scale, rotation, translation.
        fixes: (3,) each, the shifts that follow, metres.
        shear: By how much the file's matrix is more than these, relative; 0 as a rule.
    """

    measured: Array
    fixes: tuple[Array, ...]
    shear: float

    @property
    def final(self) -> Array:
        """(4, 4) after all shifts."""
        moved = self.measured.copy()
        moved[:3, 3] += sum(self.fixes, np.zeros(3))
        return moved


def scene_frame(layout: tuple[Step, ...] | None) -> Array:
    """(4, 4) from our world to the scene's: that of the layout where it stands upright."""
    if layout is not None:
        matrix = whole(layout)
        up = matrix[:3, 2]
        if is_rotation(matrix[:3, :3], _TILT) and np.abs(up - [0.0, 1.0, 0.0]).max() < _TILT:
            return pose(nearest_rotation(matrix[:3, :3]), matrix[:3, 3])
    return pose(_UPRIGHT.T)


def pose_of(steps: tuple[Step, ...], world_from_scene: Array) -> Pose:
    """Where steps take a model.

    Args:
        steps: Of its shape.
        world_from_scene: (4, 4) rigid.
    """
    first = next((i for i, step in enumerate(steps) if step.kind == "translate"), len(steps))
    own, later = steps[: first + 1], steps[first + 1 :]
    if any(step.kind != "translate" for step in later):
        own, later = steps, ()
    measured = world_from_scene @ whole(own)
    fixes = tuple(world_from_scene[:3, :3] @ step.matrix[:3, 3] for step in later)
    scale = np.linalg.norm(measured[:3, :3], axis=0)
    turn = nearest_rotation(measured[:3, :3] / scale)
    squared = measured.copy()
    squared[:3, :3] = turn * scale
    shear = float(np.abs(squared[:3, :3] - measured[:3, :3]).max() / scale.max())
    return Pose(squared, tuple(fix for fix in fixes if fix.any()), shear if shear > _SHEAR else 0.0)


"""Says of a folder that an import has made it, so that nothing in it stands for anything."""
# Holes that begin higher are windows, metres.
_THRESHOLD_M: Final = 0.15
# What is fitted to a hole is larger than it by this, metres.
_FRAME_M: Final = 0.1
_FITTED: Final = ("door", "window", "curtain")


@dataclass(frozen=True, eq=False)
class PlacedShape:
    """An object where it stands.

    Attributes:
        item: What it is.
        pose: Where, in our world.
        file: What shows it; None where nothing of it is there.
        extent: (2, 3) its box in its own axes.
        up: Its vertical axis.
        looks: What stands for those of its materials that are not there, by part.
    """

    item: SceneObject
    pose: Pose
    file: Path | None
    extent: Array
    up: Literal["Y", "Z"]
    looks: Mapping[str, Mapping[str, str]]

    @property
    def box(self) -> Array:
        """(8, 3) the corners of its box in the world."""
        picks = np.array(list(np.ndindex(2, 2, 2)))
        corners = np.take_along_axis(self.extent, picks, axis=0)
        final = self.pose.final
        return np.asarray(corners @ final[:3, :3].T + final[:3, 3])


@dataclass(frozen=True, eq=False)
class Scene:
    """A scene, read.

    Attributes:
        file: What the scene file says.
        roots: Where the dataset's files are.
        scene_from_world: (4, 4) rigid, from our world to the scene's.
        layout: The shape of the layout.
        layout_file: Its mesh, if that is there.
        shell: The room's plan in our world.
        openings: What its walls leave open, and what fills it.
        placed: All objects that are shown, or that the library stands for.
        cads: Models of the dataset by their paths there.
        environment_file: The panorama, if it is there.
        filled: (model, kind, number) of objects in holes that we fill.
        imported: Whether an import has made the files: then they hold what stands for others.
        notes: What was left out or guessed.
    """

    file: SceneFile
    roots: Roots
    scene_from_world: Array
    layout: ShapeRecord | None
    layout_file: Path | None
    shell: Shell
    openings: tuple[tuple[Hole, OpeningKind], ...]
    placed: tuple[PlacedShape, ...]
    cads: Mapping[str, CadModel]
    environment_file: Path | None
    filled: tuple[tuple[str, str, int], ...]
    imported: bool
    notes: tuple[str, ...]


def load_scene(source: Path, options: Mapping[str, str]) -> Scene:
    """Read a scene and find what it names.

    Raises:
        InputError: The scene or a file that it names is broken or hostile.
    """
    # 1. The file, and what its shapes are.
    file = read_scene(source)
    sorted_ = contents(file.shapes)
    roots, notes = Roots(source, options), list(file.notes)
    # 2. The layout's mesh, whose frame is our world.
    layout_file = _layout_file(sorted_.layout, roots, options)
    scene_from_world = scene_frame(sorted_.layout.steps if sorted_.layout else None)
    shell = None
    if layout_file is not None:
        shell = _read_shell(layout_file)
        scene_from_world = scene_from_world @ pose(np.eye(3), (0.0, 0.0, shell.level))
    # 3. Things with their models, or with boxes where these are not there.
    cads: dict[str, CadModel] = {}
    height = shell.height if shell else RELEASE_HEIGHT_M
    world_from_scene = inverse(scene_from_world)
    everything = [_placed(t, file, roots, world_from_scene, height, cads) for t in sorted_.members]
    placed = [one for one in everything if one.file or one.item.kind not in _FITTED]
    lacking = [one.item for one in everything if one not in placed]
    # 4. The room around them, and what fills its holes.
    if shell is None:
        shell = _rebuilt(placed, notes)
    missing: set[str] = {item.kind for item in lacking}
    openings = tuple((hole, _filling(hole, missing)) for hole in shell.holes)
    found = {kind for _, kind in openings}
    filled = Counter(("/".join(t.model.parts), t.kind) for t in lacking if t.kind in found)
    lost = Counter("/".join(t.model.parts) for t in lacking if t.kind not in found)
    notes += [
        f"the model {model} is missing, and its place is unknown: left out"
        for model in sorted(lost)
    ]
    notes += [
        f"{one.item.id}: its scale shears it by {one.pose.shear:.1%}: squared"
        for one in placed
        if one.pose.shear
    ]
    notes += [note for cad in cads.values() for note in cad.notes]
    if sorted_.container and not _imported(options):
        notes.append("container.obj is left out: walls are solid here, and let no light through")
    panorama = file.environment
    return Scene(
        file,
        roots,
        scene_from_world,
        sorted_.layout,
        layout_file,
        shell,
        openings,
        tuple(placed),
        cads,
        roots.find(named(panorama, "environment map")) if panorama else None,
        tuple((model, kind, count) for (model, kind), count in sorted(filled.items())),
        _imported(options),
        tuple(notes),
    )


def _imported(options: Mapping[str, str]) -> bool:
    return "root" in options and (Path(options["root"]) / MARK).is_file()


def _layout_file(
    layout: ShapeRecord | None, roots: Roots, options: Mapping[str, str]
) -> Path | None:
    if "layout" in options:
        return Path(options["layout"])
    return roots.find(named(layout.file, "layout")) if layout is not None else None


def _read_shell(file: Path) -> Shell:
    corners, coordinates = [], []
    for piece in read_obj(file).pieces:
        mesh = piece.mesh
        triangles, _ = triangulate(mesh.points, mesh.counts, mesh.indices)
        corners.append(mesh.points[mesh.indices[triangles]])
        if mesh.st is not None:
            coordinates.append(mesh.st[triangles].astype(np.float64))
    whole = bool(corners) and len(coordinates) == len(corners)
    st = np.concatenate(coordinates) if whole else None
    return shell_of(np.concatenate([*corners, np.empty((0, 3, 3))]), st, str(file))


def _placed(
    item: SceneObject,
    file: SceneFile,
    roots: Roots,
    world_from_scene: Array,
    height: float,
    cads: dict[str, CadModel],
) -> PlacedShape:
    """An object with what shows it: what an import wrote, the dataset's meshes, or nothing."""
    stands = pose_of(item.steps, world_from_scene)
    up: Literal["Y", "Z"] = "Z" if abs(stands.final[2, 2]) > abs(stands.final[2, 1]) else "Y"
    model = item.model.path
    written = roots.find(file_of(item.model))
    if written is not None:
        return PlacedShape(item, stands, written, extent_of_file(written), up, {})
    if model not in cads:
        files = [roots.find(name) for name, _ in item.files]
        there = [path for path in files if path is not None]
        if len(there) == len(files):
            cads[model] = CadModel(item, there, file.bsdfs)
    if model in cads:
        found = roots.find(item.files[0][0])
        cad = cads[model]
        return PlacedShape(item, stands, found, cad.extent, up, cad.looks(roots.find))
    scale = np.linalg.norm(stands.final[:3, :3], axis=0)
    ceiling = height if item.kind == "lamp" and _hangs(item.label) else None
    extent = extent_of(item.label, scale, float(stands.final[2, 3]), ceiling)
    return PlacedShape(item, stands, None, extent, "Y", {})


def _hangs(label: str) -> bool:
    return label in CATEGORIES and category(label).support == "ceiling"


def _filling(hole: Hole, missing: set[str]) -> OpeningKind:
    """What fills a hole: nothing of ours where the dataset's own door or window is there."""
    if hole.center[2] - 0.5 * hole.height < _THRESHOLD_M:
        return "door" if "door" in missing else "opening"
    return "window" if "window" in missing else "opening"


def _rebuilt(placed: Sequence[PlacedShape], notes: list[str]) -> Shell:
    """The room around its objects, where the layout is not there."""
    holes = [_hole(one) for one in placed if one.item.kind in ("door", "window") and one.file]
    inside = [one.box for one in placed if one.item.kind not in _FITTED]
    boxes = inside or [one.box for one in placed]
    if not boxes:
        raise InputError(
            "the size of the room is unknown: its layout and its models are missing",
            remedy="give the dataset: --root FOLDER, or the layout: --layout FILE",
        )
    notes.append(
        "the layout's mesh is missing: a rectangle around the objects replaces it, "
        f"{RELEASE_HEIGHT_M:g} m high as all rooms of the dataset"
    )
    return shell_around(np.concatenate(boxes), [hole.direction for hole in holes], holes)


def _hole(one: PlacedShape) -> Hole:
    """The hole that a door or a window was fitted to: smaller than its box by the frame."""
    box = one.box
    final = one.pose.final
    along = final[:3, 0] * [1.0, 1.0, 0.0]
    along = along / max(float(np.linalg.norm(along)), 1e-9)
    spread = np.ptp(box @ along)
    low, high = float(box[:, 2].min()) + 0.5 * _FRAME_M, float(box[:, 2].max()) - 0.5 * _FRAME_M
    low = 0.0 if low < _THRESHOLD_M else low
    center = np.array([*box[:, :2].mean(axis=0), 0.5 * (low + high)])
    width, height = float(spread) - _FRAME_M, float(high - low)
    return Hole(center, along, max(width, _FRAME_M), max(height, _FRAME_M))
