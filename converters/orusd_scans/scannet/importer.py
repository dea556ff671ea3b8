"""A scene of ScanNet becomes a Capture: mesh, segments, aggregation, axis alignment and frames.

The world is the scan after the scene's ``axisAlignment`` (Dai et al., "ScanNet: Richly-annotated 3D
Reconstructions of Indoor Scenes", CVPR 2017, and the notes of its repository). Instances are the
aggregation's ``objectId`` plus one, because 0 means none.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd import untrusted
from openrooms_usd.capture import NO_OPTIONS, Capture, CapturedFrame, CapturedModel, Packed
from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.fusion import DepthFrame, Fused, fuse
from orusd_scans.formats.ply import read_ply
from orusd_scans.frames import as_text, in_world, packed_folder
from orusd_scans.plainscan import UNDETERMINED, cloud_in, with_sensor_origins
from orusd_scans.records import Node
from orusd_scans.scanned import Scanned, one_in, opened
from orusd_scans.scannet.frames import Sens, centred, read_scannet_frames, settings
from orusd_scans.scannet.labels import read_annotation
from orusd_scans.scannet.scan2cad import Scan2CadImporter, official, read_aligned
from orusd_scans.worldframe import WorldFrame, rigid

# The meshes of a scene, the usual one first.
_MESHES: Final = ("_vh_clean_2.ply", "_vh_clean.ply")
_EVERY_FRAMES: Final = 10
# Where a scene's axis alignment stands: among its settings, or in a file of its own.
_ALIGNMENTS: Final = (
    ".txt",
    ".axisAlignment.txt",
    "_axisAlignment.txt",
    ".axis_alignment.txt",
    "_axis_alignment.txt",
    "_axis_align_matrix.txt",
)
# The tables of labels of new and old releases, which lie beside a scene or above all scenes.
_TABLES: Final = ("scannetv2-labels.combined.tsv", "scannet-labels.combined.tsv")
_FOLDERS_ABOVE: Final = 2


@dataclass(frozen=True)
class _Scene:
    """The files of a scene by its name."""

    folder: Path
    name: str
    mesh: Path | None

    def file(self, *endings: str) -> Path | None:
        """The first of its files that is there."""
        paths = (self.folder / f"{self.name}{ending}" for ending in endings)
        return next((path for path in paths if path.is_file()), None)

    @property
    def stem(self) -> str:
        """How the mesh's name goes on after the scene's."""
        assert self.mesh is not None
        return self.mesh.name.removesuffix(".ply").removeprefix(self.name)

    @property
    def segments(self) -> Path | None:
        """The segment of each vertex."""
        return self.file(f"{self.stem}.0.010000.segs.json", f"{self.stem}.segs.json")

    @property
    def aggregation(self) -> Path | None:
        """The segments of each object."""
        usual = (".aggregation.json",) if self.stem == "_vh_clean_2" else ()
        return self.file(*usual, f"{self.stem}.aggregation.json")

    @property
    def labelled(self) -> Path | None:
        """The mesh with a class at each vertex."""
        return self.file(f"{self.stem}.labels.ply")

    @property
    def alignments(self) -> list[Path]:
        """What may hold its axis alignment."""
        paths = (self.folder / f"{self.name}{ending}" for ending in _ALIGNMENTS)
        return [path for path in paths if path.is_file()]

    def table(self, options: Mapping[str, str]) -> Path | None:
        """The table of labels: the given one, or that of its release."""
        if "labels" in options:
            return Path(options["labels"])
        folder = self.folder.resolve()
        above = (folder, *folder.parents[:_FOLDERS_ABOVE])
        paths = (place / name for place in above for name in _TABLES)
        return next((path for path in paths if path.is_file()), None)

    def annotated(self) -> tuple[Path | None, ...]:
        """The mesh and its annotation."""
        return self.mesh, self.segments, self.aggregation, self.labelled


class ScanNetImporter:
    """Reads a scene of ScanNet: its folder, or its mesh with what lies beside it."""

    options: Mapping[str, str] = {
        "labels": "scannetv2-labels.combined.tsv, if it is neither here nor two folders above.",
        "frames": "Poses of the photographs: an exported folder, a .sens file or JSON.",
        "fuse": "Fuse one in this many depth pictures of the .sens file, in place of the mesh.",
        "annotation": "full_annotations.json of Scan2CAD.",
        "models": "The folder of ShapeNetCore.v2.",
        "official_centre": "yes: subtract the CADs' centres, as the official scorer does "
        "(default no).",
    }
    paths = frozenset({"labels", "frames", "annotation", "models"})

    def read(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Capture:
        """Read a scene.

        Args:
            source: Its folder, or its mesh ``<scene>_vh_clean_2.ply``.
            options: See `options`.

        Raises:
            InputError: The mesh or what an option names is missing, or holds nonsense.
        """
        scene, notes = _scene(source), list[str]()
        frame = _aligned_frame(scene, notes)
        frames = in_world(_frames(scene, options, notes), frame, notes)
        scanned = _scanned(scene, options, notes)
        return Capture(
            source=source.name,
            source_from_world=frame.source_from_world(),
            models=_models(scene, options, frame, notes),
            frames=frames,
            cloud=with_sensor_origins(cloud_in(frame, scanned, source, notes), frames),
            notes=tuple(notes),
            remedy=UNDETERMINED,
        )

    def pack(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Packed:
        """The mesh with what is said of it, or the depth that is fused; poses without pictures."""
        scene = _scene(source)
        fused = "fuse" in options or scene.mesh is None
        kept = {name: options[name] for name in ("fuse", "official_centre") if name in options}
        more: dict[str, bytes | Path] = {}
        if fused:
            more[f"{scene.name}/{scene.name}.sens"] = _needed_sens(scene, options)
        elif frames := _frames(scene, options, []):
            kept["frames"], more["frames.json"] = "frames.json", as_text(frames)
        if (table := scene.table(options)) is not None and not fused:
            kept["labels"], more["labels.tsv"] = "labels.tsv", table
        if "annotation" in options:
            models = {"scan": scene.name} | {n: options[n] for n in ("models",) if n in options}
            aligned = Scan2CadImporter().pack(Path(options["annotation"]), models)
            more |= aligned.contents
            kept |= {"annotation": aligned.file} | dict(aligned.options)
        files = [*scene.alignments, *([] if fused else scene.annotated())]
        return packed_folder(scene.folder, files, kept, scene.name, more)


def _scene(source: Path) -> _Scene:
    if source.is_file() and source.name.endswith(_MESHES):
        ending = next(ending for ending in _MESHES if source.name.endswith(ending))
        return _Scene(source.parent, source.name.removesuffix(ending), source)
    if not source.is_dir():
        raise InputError(
            "this is not a scene of ScanNet",
            place=source,
            remedy=f"give its folder, or its mesh <scene>{_MESHES[0]}",
        )
    for ending in _MESHES:
        meshes = sorted(source.glob(f"*{ending}"))
        if len(meshes) > 1:
            raise InputError("several scenes are here", place=source, remedy="give one mesh")
        if meshes:
            return _Scene(source, meshes[0].name.removesuffix(ending), meshes[0])
    return _Scene(source, source.resolve().name, None)


def _aligned_frame(scene: _Scene, notes: list[str]) -> WorldFrame:
    """World from scan: the scene's ``axisAlignment``, or a matrix in a file of its own."""
    for path in scene.alignments:
        found = settings(path)
        own = path.name != f"{scene.name}.txt" and "axisAlignment" not in found
        words = (untrusted.read_text(path) if own else found.get("axisAlignment", "")).split()
        if words:
            matrix = rigid(Node(_numbers(words, path), path, "axisAlignment"))
            return WorldFrame(matrix[:3, :3], -matrix[:3, :3].T @ matrix[:3, 3])
    notes.append("the scene has no axisAlignment: its own axes are used")
    return WorldFrame(np.eye(3), np.zeros(3))


def _numbers(words: list[str], path: Path) -> list[float]:
    try:
        return [float(word) for word in words]
    except ValueError as error:
        raise InputError("axisAlignment is not of numbers", place=path) from error


def _frames(
    scene: _Scene, options: Mapping[str, str], notes: list[str]
) -> tuple[CapturedFrame, ...]:
    if "frames" in options:
        return read_scannet_frames(Path(options["frames"]), notes)
    sens = scene.file(".sens")
    if sens is not None:
        return read_scannet_frames(sens, notes)
    posed = (scene.folder / "pose").is_dir()
    return read_scannet_frames(scene.folder, notes) if posed else ()


def _scanned(scene: _Scene, options: Mapping[str, str], notes: list[str]) -> Scanned:
    """The points in the frame of the scan: the labelled mesh, or fused depth."""
    if "fuse" in options or (scene.mesh is None and _sens(scene, options) is not None):
        sens = _needed_sens(scene, options)
        fused = fuse_sens(sens, one_in(options, _EVERY_FRAMES, sens, "frames"))
        notes.extend(fused.notes)
        return Scanned(fused.cloud)
    if scene.mesh is None:
        raise InputError(
            f"no mesh *{_MESHES[0]} and no .sens file are here",
            place=scene.folder,
            remedy="give the folder of one scene of ScanNet",
        )
    scanned = read_ply(scene.mesh)
    found = read_annotation(
        count=len(scanned.cloud),
        segments=scene.segments,
        aggregation=scene.aggregation,
        labelled=scene.labelled,
        table=scene.table(options),
        notes=notes,
    )
    return replace(
        scanned,
        cloud=replace(scanned.cloud, label=found.label, instance=found.instance, words=found.words),
    )


def _sens(scene: _Scene, options: Mapping[str, str]) -> Path | None:
    given = Path(options.get("frames", ""))
    return given if given.suffix.lower() == ".sens" else scene.file(".sens")


def _needed_sens(scene: _Scene, options: Mapping[str, str]) -> Path:
    sens = _sens(scene, options)
    if sens is None:
        raise InputError(
            "no .sens file is here, whose depth could be fused",
            place=scene.folder,
            remedy="give it by --frames, or omit --fuse",
        )
    return sens


def fuse_sens(path: Path, every: int = _EVERY_FRAMES) -> Fused:
    """Fuse the depth pictures of a ``.sens`` file, in the frame of the scan.

    Args:
        path: The file; one depth picture is in memory at a time.
        every: One in this many frames.

    Raises:
        InputError: It cannot be read, is cut off, or holds nonsense.
    """
    with opened(path, "frames") as stream:
        return fuse(_depth_frames(Sens(stream, path), every))


def _depth_frames(sens: Sens, every: int) -> Iterator[DepthFrame]:
    K = centred(sens.depth_intrinsics())
    for _, node, depth in sens.depths(every):
        pose = np.array(node.value)
        yield DepthFrame(depth, K, rigid(node) if np.isfinite(pose).all() else pose)


def _models(
    scene: _Scene, options: Mapping[str, str], frame: WorldFrame, notes: list[str]
) -> tuple[CapturedModel, ...]:
    if "annotation" not in options:
        return ()
    source = Path(options["annotation"])
    folder = Path(options["models"]) if "models" in options else None
    return read_aligned(source, scene.name, frame, folder, official(options, source), notes)
