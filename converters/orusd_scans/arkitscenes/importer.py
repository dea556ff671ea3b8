"""A scan of ARKitScenes becomes a Capture: mesh, 3D boxes, and low-resolution depth with its path.

Both layouts of the download are read: ``<id>/`` with its files side by side (raw), and with
``<id>_frames/`` below it (3dod). (Baruch et al., "ARKitScenes: A Diverse Real-World Dataset for 3D
Indoor Scene Understanding Using Mobile RGB-D Data", NeurIPS 2021 datasets.) The world is the
scan's: metres, Z up.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.capture import NO_OPTIONS, Capture, CapturedBox, Packed
from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.fusion import fuse
from orusd_scans.arkitscenes.path import captured_frames, depth_frames, read_path
from orusd_scans.formats.ply import read_ply
from orusd_scans.packing import packed_folder
from orusd_scans.plainscan import UNDETERMINED, cloud_in, with_sensor_origins
from orusd_scans.records.fields import text
from orusd_scans.records.jsonfile import Node, read_json
from orusd_scans.scanned import Scanned
from orusd_scans.worldframe import MAX_COORDINATE_M, WorldFrame

Array = NDArray[np.float64]

_MESH: Final = "*_3dod_mesh.ply"
_BOXES: Final = "*_3dod_annotation.json"
_TRAJECTORY: Final = "lowres_wide.traj"
_POSED: Final = (_TRAJECTORY, "lowres_wide_intrinsics/*.pincam")
_DEPTH: Final = ("lowres_depth/*.png", "confidence/*.png")
_MAX_SIZE_M: Final = 1e3  # metres
_RIGHT_ANGLE_TOLERANCE: Final = 1e-2
_EVERY_FRAMES: Final = 10


class ARKitScenesImporter:
    """Reads the folder of one scan."""

    options: Mapping[str, str] = {
        "fuse": "Fuse one in this many low-resolution depth pictures, in place of the mesh.",
    }

    def read(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Capture:
        """Read a scan.

        Args:
            source: Its folder.
            options: See `options`.

        Raises:
            InputError: It holds neither mesh nor depth, several scans, or nonsense.
        """
        notes: list[str] = []
        mesh, annotation = _one(source, _MESH), _one(source, _BOXES)
        folder = _frames_folder(source)
        poses = read_path(folder / _TRAJECTORY) if folder is not None else None
        frames = captured_frames(folder, poses, notes) if folder is not None and poses else ()
        if "fuse" in options or mesh is None:
            if folder is None or poses is None:
                raise InputError(
                    f"neither a mesh {_MESH} nor {_TRAJECTORY} with lowres_depth is here",
                    place=source,
                    remedy="give the folder of one scan of ARKitScenes",
                )
            every = _whole(options.get("fuse", str(_EVERY_FRAMES)), source)
            fused = fuse(depth_frames(folder, poses, every))
            notes.extend(fused.notes)
            scanned = Scanned(fused.cloud)
        else:
            scanned = read_ply(mesh)
        same = WorldFrame(np.eye(3), np.zeros(3))
        cloud = with_sensor_origins(cloud_in(same, scanned, source, notes), frames)
        return Capture(
            source=source.name,
            source_from_world=np.eye(4),
            boxes=read_boxes(annotation) if annotation is not None else (),
            frames=frames,
            cloud=cloud,
            notes=tuple(notes),
            remedy=UNDETERMINED,
        )

    def pack(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Packed:
        """The mesh or the depth that is fused, the boxes, and the camera's path."""
        mesh, folder = _one(source, _MESH), _frames_folder(source)
        fused = "fuse" in options or mesh is None
        files = [None if fused else mesh, _one(source, _BOXES)]
        if folder is not None:
            kinds = (*_POSED, *(_DEPTH if fused else ()))
            files += [path for kind in kinds for path in sorted(folder.glob(kind))]
        return packed_folder(source, files, options)


def _one(source: Path, pattern: str) -> Path | None:
    found = sorted(source.glob(pattern)) if source.is_dir() else []
    if len(found) > 1:
        raise InputError(
            f"several scans are here: {len(found)} of {pattern}", place=source, remedy="give one"
        )
    return found[0] if found else None


def _frames_folder(source: Path) -> Path | None:
    """The folder of the camera's trajectory."""
    folders = [source, *sorted(source.glob("*_frames"))] if source.is_dir() else []
    return next((folder for folder in folders if (folder / _TRAJECTORY).is_file()), None)


def _whole(text_: str, place: Path) -> int:
    if not text_.isdecimal() or not 0 < int(text_) < 1_000_000:
        raise InputError(
            f"{text_[:20]!r} is no number of pictures", place=place, remedy="give --fuse 10"
        )
    return int(text_)


def read_boxes(path: Path) -> tuple[CapturedBox, ...]:
    """The boxes of ``<id>_3dod_annotation.json``: which side is their front is not known.

    Raises:
        InputError: A box holds nonsense, or an identifier repeats.
    """
    found: dict[str, CapturedBox] = {}
    for node in read_json(path).items("data"):
        box = _box(node)
        if box.id in found:
            raise node.error(f"the uid {box.id!r} is there already", "mend the annotation")
        found[box.id] = box
    return tuple(found.values())


def _box(node: Node) -> CapturedBox:
    drawn = node.need("segments").need("obbAligned")
    lengths = drawn.need("axesLengths").numbers(3, _MAX_SIZE_M)
    axes = drawn.need("normalizedAxes").numbers(9, 1.0 + _RIGHT_ANGLE_TOLERANCE).reshape(3, 3)
    if not (lengths > 0.0).all():
        raise drawn.error("a side of the box is not above zero", "mend the annotation")
    if np.abs(axes @ axes.T - np.eye(3)).max() > _RIGHT_ANGLE_TOLERANCE:
        raise drawn.error("the axes of the box are not at right angles", "mend the annotation")
    rotation, size = _upright(axes, lengths)
    return CapturedBox(
        id=text(node.need("uid")),
        label=text(node.need("label")),
        center=drawn.need("centroid").numbers(3, MAX_COORDINATE_M),
        rotation=rotation,
        size=size,
    )


def _upright(axes: Array, lengths: Array) -> tuple[Array, Array]:
    """Axes (rows) as columns width, depth, height: the steepest is up, the longer other is wide."""
    up = int(np.argmax(np.abs(axes[:, 2])))
    others = [i for i in range(3) if i != up]
    wide = max(others, key=lambda i: float(lengths[i]))
    deep = next(i for i in others if i != wide)
    height = axes[up] * np.sign(axes[up, 2])
    rotation = np.column_stack([axes[wide], np.cross(height, axes[wide]), height])
    return rotation, lengths[[wide, deep, up]]
