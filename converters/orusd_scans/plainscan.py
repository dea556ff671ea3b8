"""A plain point cloud or mesh becomes a Capture: PLY, PCD, OBJ, GLB, LAS, E57, text and NPZ.

What the file or the user says is compared with the evidence of all axes and all units. Where that
is clear it is followed, with a note; where it is not, or contradicts what was asked, the scan is
refused with the option that settles it. The options are those of the importer: ``--up``,
``--unit``, or ``up:`` and ``unit:`` in a description.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.capture import NO_OPTIONS, Capture, CapturedFrame, Packed
from openrooms_usd.errors import InputError
from openrooms_usd.progress import Progress, silent
from openrooms_usd.scan.models.meshscene import ShownMesh, shown_meshes
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.mainpart import FEW, MOST, main_part
from openrooms_usd.scan.points.thinning import clean, evened
from openrooms_usd.scan.rooms.verticals import Vertical, verticals
from openrooms_usd.scan.segmentation.naming import with_labels
from orusd_scans.formats.arrays import read_npz
from orusd_scans.formats.laser import read_e57, read_las
from orusd_scans.formats.obj import read_obj
from orusd_scans.formats.pcd import read_pcd
from orusd_scans.formats.ply import read_ply
from orusd_scans.formats.pointtext import read_text
from orusd_scans.frames import in_world, read_frames
from orusd_scans.plan import Up
from orusd_scans.records import read_json, text
from orusd_scans.scanaxes import AUTO, Asked, find_unit, find_up, unit_named, written
from orusd_scans.scanned import OTHER_CLASSES, Scanned, broken, opened
from orusd_scans.segments import with_segments
from orusd_scans.surfaces import as_cloud
from orusd_scans.worldframe import WorldFrame

# Meshes (GLB, STL, OFF) through trimesh, as points with triangles.

# glTF fixes its vertical axis; the others do not.
_Y_UP: Final = (".glb",)


def read_mesh(path: Path) -> Scanned:
    """Read all meshes of a file in its common frame.

    Raises:
        InputError: It cannot be read, or has no triangles.
        MissingPackageError: It is compressed with Draco, which is not installed.
    """
    with opened(path, "model") as stream:
        content = stream.read()
    meshes = shown_meshes(path, content)
    if not meshes:
        raise broken(path, "it has no triangles")
    starts = np.cumsum([0, *(len(one.vertices) for one in meshes)])
    faces = [one.faces + start for one, start in zip(meshes, starts, strict=False)]
    cloud = Cloud(points=np.concatenate([one.vertices for one in meshes]), colors=_colors(meshes))
    up: Up = "Y" if path.suffix.lower() in _Y_UP else "Z"
    return Scanned(cloud, np.concatenate(faces).astype(np.int64), up)


def _colors(meshes: list[ShownMesh]) -> Any:
    """Colours of the points, where all meshes have them."""
    visuals = [one.mesh.visual for one in meshes]
    if not all(visual.kind == "vertex" for visual in visuals):
        return None
    colors = [np.asarray(visual.vertex_colors)[:, :3] for visual in visuals]
    sound = all(len(c) == len(m.vertices) for c, m in zip(colors, meshes, strict=True))
    return np.concatenate(colors).astype("u1") if sound else None


READERS: Final[Mapping[str, Callable[[Path], Scanned]]] = {
    ".ply": read_ply,
    ".pcd": read_pcd,
    ".obj": read_obj,
    **dict.fromkeys((".glb", ".stl", ".off"), read_mesh),
    **dict.fromkeys((".las", ".laz"), read_las),
    ".e57": read_e57,
    **dict.fromkeys((".xyz", ".txt", ".pts", ".ptx", ".asc", ".csv"), read_text),
    ".npz": read_npz,
}
UNDETERMINED: Final = (
    "a scan does not record its floor: reconstruct it by `layout: {from: scan, scan: FILE}`"
)
# Samples of a mesh by which it is seen how it stands.
_SAMPLES: Final = 200_000
# Percentiles that bound the extent, without outliers.
_EXTENT_PERCENTILES: Final = (1.0, 99.0)
# Scans farther than this from the source's origin get an origin of their own, metres.
_FAR_FROM_ORIGIN_M: Final = 1000.0


@dataclass(frozen=True, eq=False)
class Standing:
    """How a scan stands.

    Attributes:
        up: (3,) unit, in the scan's frame.
        unit: Metres for one unit of it.
        settled: Options that say what was found where it is not what the file says.
        notes: What people should know.
    """

    up: Array
    unit: float
    settled: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def find_standing(cloud: Cloud, asked: Asked, source: Path) -> Standing:
    """Find how a scan stands.

    Args:
        cloud: Finite points in the file's frame and unit.
        asked: What is said of it.
        source: The file, for messages.

    Raises:
        InputError: What is said is absurd, or the evidence is not clear.
    """
    notes = list[str]()
    found = _room_like(cloud)
    if not found:
        found = (_as_said(cloud, asked.up),)
        if not asked.up_said:
            notes.append(
                f"{written(asked.up)} is taken for up: the scan shows too little surface to tell"
                " (`--up` says otherwise)"
            )
    unit, name = find_unit(found, asked, source, notes)
    up = find_up(found, asked, unit, source, notes)
    settled = {} if np.allclose(up, asked.up, atol=1e-3) else {"up": written(up)}
    if asked.unit is None and name != "m":
        settled["unit"] = name
    return Standing(up, unit, settled, tuple(notes))


def _room_like(cloud: Cloud) -> tuple[Vertical, ...]:
    """The verticals of the part of a scan that has a floor and a ceiling, without what is outside.

    Where none has both, those of the part with most of the points.
    """
    usual = verticals(main_part(cloud, FEW))
    if any(one.height is not None for one in usual[:1]):
        return usual
    dense = verticals(main_part(cloud, MOST))
    return dense if any(one.height is not None for one in dense) else usual


def _as_said(cloud: Cloud, up: Array) -> Vertical:
    """The direction that is said, of a scan that shows hardly any surface."""
    points = cloud.points[evened(cloud)[0]]
    heights = points @ up
    across = points - heights[:, None] * up
    along = float(np.ptp(np.percentile(heights, (1.0, 99.0))))
    sizes = np.ptp(np.percentile(across, (1.0, 99.0), axis=0), axis=0)
    return Vertical(up, 0.0, np.inf, None, (along, float(np.linalg.norm(sizes))))


class ScanImporter:
    """Reads a point cloud or a mesh: PLY, PCD, LAS, E57, OBJ, GLB, text and others."""

    options: Mapping[str, str] = {
        "unit": "The unit of the coordinates: m, dm, cm, mm, in, ft, metres for one unit, or auto"
        " (default): metres, unless the scan shows otherwise.",
        "up": "The direction that is up, as x,y,z or an axis (default z, y for GLB, unless the scan"
        " shows otherwise).",
        "frames": "A JSON file with the cameras of photographs.",
        "classes": 'A JSON file with a word for each number of label: {"0": "ceiling"}.',
        "words": 'A JSON file with a word for each instance by its number: {"13": "trash can"}.',
        "segments": "An .npz or .npy file with a label, a number of a thing, or both, per point.",
    }
    paths = frozenset({"frames", "classes", "words", "segments"})

    def read(
        self, source: Path, options: Mapping[str, str] = NO_OPTIONS, progress: Progress = silent
    ) -> Capture:
        """Read a point cloud or a mesh.

        Args:
            source: The file.
            options: See `options`.
            progress: Called with each step.

        Raises:
            InputError: It is missing, of an unknown kind, or holds nonsense; names the place.
            MissingPackageError: Its kind needs a package that is not installed.
        """
        progress("reading", 0.0)
        scanned = read_scanned(source)
        if "segments" in options:
            cloud = with_segments(scanned.cloud, Path(options["segments"]))
            scanned = replace(scanned, cloud=cloud)
        notes = list(scanned.notes)
        if "classes" in options:
            scanned = replace(scanned, cloud=classified(scanned.cloud, Path(options["classes"])))
            notes = [note for note in notes if not note.endswith(OTHER_CLASSES)]
        progress("finding unit and axes", 0.1)
        placed = _placed(scanned.cloud, source)
        stands = _standing(scanned, placed, options, source)
        notes += stands.notes
        progress("placing points", 0.6)
        frame = _frame(placed, stands)
        frames: tuple[CapturedFrame, ...] = ()
        if "frames" in options:
            frames = in_world(read_frames(Path(options["frames"])), frame, notes)
        if "words" in options:
            words = read_words(Path(options["words"]))
            scanned = replace(scanned, cloud=replace(scanned.cloud, words=words))
        return Capture(
            source=source.name,
            source_from_world=frame.source_from_world(),
            frames=frames,
            cloud=with_sensor_origins(cloud_in(frame, scanned, source, notes), frames),
            notes=tuple(notes),
            remedy=UNDETERMINED,
            settled=stands.settled,
        )

    def pack(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Packed:
        """The scan, and the files beside it that the options name."""
        kept, contents = dict(options), {source.name: source}
        for name in sorted(self.paths & options.keys()):
            beside = f"{name}{Path(options[name]).suffix}"
            kept[name] = beside if beside not in contents else f"{name}_{beside}"
            contents[kept[name]] = Path(options[name])
        return Packed(source.name, contents, kept)


def read_scanned(source: Path) -> Scanned:
    """Read a point cloud or a mesh in its own frame and unit.

    Raises:
        InputError: It is missing, of an unknown kind, or holds nonsense.
    """
    reader = READERS.get(source.suffix.lower())
    if source.is_dir():
        raise InputError(
            "this is a folder, not a file", place=source, remedy="give the file of the scan in it"
        )
    if reader is None:
        raise InputError(
            f"files that end in {source.suffix!r} are not supported scans",
            place=source,
            remedy=f"known are: {', '.join(READERS)}",
        )
    return reader(source)


def cloud_in(frame: WorldFrame, scanned: Scanned, source: Path, notes: list[str]) -> Cloud:
    """The points in the world, metres: surfaces are sampled, invalid points dropped.

    Args:
        frame: Transform to the world.
        scanned: What was read.
        source: The file, for messages.
        notes: Receives a sentence for what was dropped.

    Raises:
        InputError: No point is left.
    """
    given = scanned.cloud
    cloud = replace(
        given,
        points=frame.points(given.points),
        normals=None if given.normals is None else (given.normals @ frame.rotation.T).astype("f4"),
        sensor_origins=None if given.sensor_origins is None else frame.points(given.sensor_origins),
    )
    if scanned.faces is not None:
        cloud, told = as_cloud(cloud, scanned.faces)
        notes.extend(told)
    cloud, dropped = clean(cloud)
    notes.extend(dropped.notes())
    if len(cloud) == 0:
        raise InputError("no point has finite coordinates", place=source)
    return cloud


def with_sensor_origins(cloud: Cloud, frames: tuple[CapturedFrame, ...]) -> Cloud:
    """A cloud with the photographs' positions as sensor origins, where it has none."""
    if cloud.sensor_origins is not None or not frames:
        return cloud
    return replace(
        cloud, sensor_origins=np.array([frame.world_from_camera[:3, 3] for frame in frames])
    )


def _placed(cloud: Cloud, source: Path) -> Cloud:
    """The points with finite coordinates."""
    finite = np.asarray(np.isfinite(cloud.points).all(axis=1))
    if not finite.any():
        raise InputError("no point has finite coordinates", place=source)
    return cloud if finite.all() else cloud.take(finite)


def _standing(
    scanned: Scanned, placed: Cloud, options: Mapping[str, str], source: Path
) -> Standing:
    """How the scan stands, by what is said of it and what it shows."""
    said = options.get("up")
    asked = Asked(
        direction(said or scanned.up, source),
        bool(said),
        unit_named(options.get("unit", scanned.unit or AUTO), source),
    )
    if scanned.faces is not None:
        cloud = scanned.cloud
        cloud, _ = as_cloud(cloud, scanned.faces, _spacing(cloud.points, scanned.faces))
        placed = _placed(cloud, source)
    return find_standing(placed, asked, source)


def _spacing(points: Array, faces: Ints) -> float:
    """Of samples of a mesh, in its unit, for a certain number of them."""
    corners = points[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * float(np.nansum(np.linalg.norm(normals, axis=1)))
    return max(float(np.sqrt(area / _SAMPLES)), 1e-9)


def _frame(cloud: Cloud, stands: Standing) -> WorldFrame:
    """The source's own axes, upright; its own origin unless that is far away."""
    low, high = np.percentile(cloud.points[evened(cloud)[0]], _EXTENT_PERCENTILES, axis=0)
    middle = 0.5 * (low + high)
    far = stands.unit * float(np.abs(middle).max()) > _FAR_FROM_ORIGIN_M
    origin = np.floor(middle) if far else np.zeros(3)
    return WorldFrame(upright(stands.up), origin, stands.unit)


def direction(up: str, source: Path) -> Array:
    """(3,) unit, of a direction in words.

    Args:
        up: Three numbers with commas between them, or x, y or z.
        source: The file, for messages.

    Raises:
        InputError: It is not a direction.
    """
    axes = {"x": "1,0,0", "y": "0,1,0", "z": "0,0,1"}
    try:
        vector = np.array([float(word) for word in axes.get(up.lower(), up).split(",")])
    except ValueError:
        vector = np.zeros(0)
    length = float(np.linalg.norm(vector)) if vector.shape == (3,) else 0.0
    if not 0.0 < length < np.inf:
        raise InputError(
            f"the direction {up[:40]!r} is not valid",
            place=source,
            remedy="give up as 0,0,1 or as z",
        )
    return np.asarray(vector / length)


def upright(up: Array) -> Array:
    """(3, 3) the least rotation that turns a unit vector up."""
    x, y, z = up
    if z < -1.0 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    # Rodrigues' formula for the rotation about up x z.
    cross = np.array([[0.0, 0.0, -x], [0.0, 0.0, -y], [x, y, 0.0]])
    return np.asarray(np.eye(3) + cross + cross @ cross / (1.0 + z))


def classified(cloud: Cloud, path: Path) -> Cloud:
    """A cloud whose labels are the numbers of another list of classes than NYU40's.

    Raises:
        InputError: The cloud has no labels, or the file is not a table of words.
    """
    if cloud.label is None:
        raise InputError("the scan has no labels that could have classes", place=path)
    table = {number: words[0] for number, words in read_words(path).items()}
    numbers, of_point = np.unique(cloud.label, return_inverse=True)
    names = np.array([table.get(number, "") for number in numbers.tolist()])
    return with_labels(cloud, names[of_point].tolist())


def read_words(path: Path) -> dict[int, tuple[str, ...]]:
    """Words by numbers, of instances or of classes.

    Raises:
        InputError: It is not such a file.
    """
    node = read_json(path)
    words = node.value if isinstance(node.value, dict) else {}
    if not words or not all(key.isdecimal() and len(key) < 9 for key in words):
        raise node.error("this is not a table of words by numbers", 'write {"13": "trash can"}')
    return {int(key): (text(node.need(key)),) for key in words}
