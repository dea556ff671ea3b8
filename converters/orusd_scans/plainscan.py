"""A plain point cloud or mesh becomes a Capture: PLY, PCD, OBJ, GLB, LAS, E57, text and NPZ."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.capture import NO_OPTIONS, Capture, CapturedFrame, Packed
from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.thinning import clean
from orusd_scans.formats.laser import read_e57, read_las
from orusd_scans.formats.meshfile import read_mesh
from orusd_scans.formats.pcd import read_pcd
from orusd_scans.formats.ply import read_ply
from orusd_scans.formats.pointtext import read_npz, read_text
from orusd_scans.frames import in_world, read_frames
from orusd_scans.scanned import OTHER_CLASSES, Scanned
from orusd_scans.scanunits import AUTO, Asked, unit_named
from orusd_scans.segments import with_segments
from orusd_scans.standing import Standing, find_standing
from orusd_scans.surfaces import as_cloud
from orusd_scans.words import classified, read_words
from orusd_scans.worldframe import WorldFrame

Array = NDArray[np.float64]

READERS: Final[Mapping[str, Callable[[Path], Scanned]]] = {
    ".ply": read_ply,
    ".pcd": read_pcd,
    ".obj": read_mesh,
    ".glb": read_mesh,
    ".stl": read_mesh,
    ".off": read_mesh,
    ".las": read_las,
    ".laz": read_las,
    ".e57": read_e57,
    ".xyz": read_text,
    ".txt": read_text,
    ".pts": read_text,
    ".asc": read_text,
    ".csv": read_text,
    ".npz": read_npz,
}
UNDETERMINED: Final = (
    "a scan says nothing of its floor: let it be found, by `layout: {from: scan, scan: FILE}`"
)
# Samples of a mesh by which it is seen how it stands.
_SAMPLES: Final = 200_000
# Percentiles that bound the extent, without outliers.
_EXTENT_PERCENTILES: Final = (1.0, 99.0)
_MAX_SAMPLE_POINTS: Final = 100_000
# Scans farther than this from the source's origin get an origin of their own, metres.
_FAR_FROM_ORIGIN_M: Final = 1000.0


class ScanImporter:
    """Reads point clouds and meshes by the ending of their names."""

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

    def read(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Capture:
        """Read a point cloud or a mesh.

        Args:
            source: The file.
            options: See `options`.

        Raises:
            InputError: It is missing, of an unknown kind, or holds nonsense; names the place.
            MissingPackageError: Its kind needs a package that is not installed.
        """
        scanned = read_scanned(source)
        if "segments" in options:
            cloud = with_segments(scanned.cloud, Path(options["segments"]))
            scanned = replace(scanned, cloud=cloud)
        notes = list(scanned.notes)
        if "classes" in options:
            scanned = replace(scanned, cloud=classified(scanned.cloud, Path(options["classes"])))
            notes = [note for note in notes if not note.endswith(OTHER_CLASSES)]
        stands = _standing(scanned, options, source)
        notes += stands.notes
        frame = _frame(scanned, stands, source)
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
            f"files that end in {source.suffix!r} are no scans that can be read",
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


def _standing(scanned: Scanned, options: Mapping[str, str], source: Path) -> Standing:
    """How the scan stands, by what is said of it and what it shows."""
    said = options.get("up")
    asked = Asked(
        direction(said or scanned.up, source), bool(said),
        unit_named(options.get("unit", AUTO), source),
    )  # fmt: skip
    cloud = scanned.cloud
    if scanned.faces is not None:
        cloud, _ = as_cloud(cloud, scanned.faces, _spacing(cloud.points, scanned.faces))
    whole = cloud.take(np.asarray(np.isfinite(cloud.points).all(axis=1)))
    if not len(whole):
        raise InputError("no point has finite coordinates", place=source)
    return find_standing(whole, asked, source)


def _spacing(points: Array, faces: NDArray[np.int64]) -> float:
    """Of samples of a mesh, in its unit, for a certain number of them."""
    corners = points[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * float(np.nansum(np.linalg.norm(normals, axis=1)))
    return max(float(np.sqrt(area / _SAMPLES)), 1e-9)


def _frame(scanned: Scanned, stands: Standing, source: Path) -> WorldFrame:
    """The source's own axes, upright; its own origin unless that is far away."""
    low, high = _range(scanned.cloud.points)
    middle = 0.5 * (low + high)
    far = stands.unit * float(np.abs(middle).max()) > _FAR_FROM_ORIGIN_M
    origin = np.floor(middle) if far else np.zeros(3)
    return WorldFrame(upright(stands.up), origin, stands.unit)


def _range(points: Array) -> tuple[Array, Array]:
    """(3,) each, robust least and greatest coordinates."""
    some = points[:: max(len(points) // _MAX_SAMPLE_POINTS, 1)]
    some = some[np.isfinite(some).all(axis=1)]
    if len(some) == 0:
        return np.zeros(3), np.zeros(3)
    low, high = np.percentile(some, _EXTENT_PERCENTILES, axis=0)
    return low, high


def direction(up: str, source: Path) -> Array:
    """(3,) unit, of a direction in words.

    Args:
        up: Three numbers with commas between them, or x, y or z.
        source: The file, for messages.

    Raises:
        InputError: It is no direction.
    """
    axes = {"x": "1,0,0", "y": "0,1,0", "z": "0,0,1"}
    try:
        vector = np.array([float(word) for word in axes.get(up.lower(), up).split(",")])
    except ValueError:
        vector = np.zeros(0)
    length = float(np.linalg.norm(vector)) if vector.shape == (3,) else 0.0
    if not 0.0 < length < np.inf:
        raise InputError(
            f"the direction {up[:40]!r} is none", place=source, remedy="give up as 0,0,1 or as z"
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
