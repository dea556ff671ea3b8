"""Writes a finished render for radiance fields and photogrammetry."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from openrooms_usd import atomic, claims
from openrooms_usd.arrays import Array, Bytes, Ints
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.pinhole import pixel_directions
from openrooms_usd.progress import Progress, silent
from openrooms_usd.rendering.datasets import DatasetOptions, DatasetSummary
from openrooms_usd.rendering.exr import Pixels
from openrooms_usd.rendering.manifest import write_json
from openrooms_usd.rendering.reading import RenderedScene
from orusd_nerf.cameras import Camera, Lens, camera_of, write_matrices
from orusd_nerf.pictures import (
    DEPTH_STEP_M,
    DEPTHS,
    IMAGES,
    image_name,
    survey,
    write_depth,
    write_image,
)

# Of one view, and of all.
_POINTS_A_VIEW: Final = 2048
_MOST_POINTS: Final = 100_000
# Depths that differ by less, relatively, are of the same surface: the pixel's centre lies beside.
_SAME_SURFACE_SHARE: Final = 0.01
# Without a picture.
_GREY: Final = 128
# Where COLMAP, nerfstudio and 3D Gaussian splatting look for it.
MODEL: Final = "sparse/0"
_PIXEL_DECIMALS: Final = 6
_METRE_DECIMALS: Final = 9
TRANSFORMS: Final = "transforms.json"
CLOUD: Final = "points3D.ply"
_NO_DISTORTION: Final = {"k1": 0.0, "k2": 0.0, "p1": 0.0, "p2": 0.0}
# Around all surfaces and cameras.
_MARGIN_M: Final = 0.1
_LEDGER: Final = ".orusd.nerf.sha256"
# Kinds of files that are made of depth.
_OF_DEPTH: Final = ("depths", "points")


# They are the exact first hits of pixels on a regular grid of every view. A view sees a point
# that it has in front of it and within its picture, where its own depth is that of the point.
@dataclass(frozen=True, eq=False)
class Points:
    """Points of surfaces.

    Attributes:
        positions: (N, 3) metres, in the world.
        colors: (N, 3) as the view that they are taken from shows them.
    """

    positions: Array
    colors: Bytes

    def __len__(self) -> int:
        return len(self.positions)


@dataclass(frozen=True, eq=False)
class Sightings:
    """What one view sees of the points.

    Attributes:
        points: (M,) their indices, ascending.
        pixels: (M, 2) where they lie in the picture.
    """

    points: Ints
    pixels: Array


NOTHING: Final = Sightings(np.empty(0, np.int64), np.empty((0, 2)))


def sample(camera: Camera, depth: Pixels, image: Bytes | None, views: int) -> Points:
    """Points on a regular grid of a view's pixels.

    Args:
        camera: The view's.
        depth: (height, width, 1) planar, metres; 0 where nothing is.
        image: (height, width, 3) its colours, if it has any.
        views: How many views there are: together they have no more than a scene may have.
    """
    lens = camera.lens
    most = max(1, min(_POINTS_A_VIEW, _MOST_POINTS // views))
    step = max(1, math.ceil(math.sqrt(lens.width * lens.height / most)))
    rows, columns = np.meshgrid(
        np.arange(step // 2, lens.height, step),
        np.arange(step // 2, lens.width, step),
        indexing="ij",
    )
    far = depth[rows, columns, 0].astype(np.float64)
    there = np.isfinite(far) & (far > 0.0)
    rows, columns, far = rows[there], columns[there], far[there]
    seen = pixel_directions(camera.K, lens.width, lens.height)[rows, columns] * far[:, None]
    M = camera.world_from_camera
    colors = np.full((len(far), 3), _GREY, np.uint8) if image is None else image[rows, columns]
    return Points(seen @ M[:3, :3].T + M[:3, 3], colors)


def joined(parts: Sequence[Points]) -> Points:
    """All points of several views."""
    return Points(
        np.concatenate([np.empty((0, 3)), *(part.positions for part in parts)]),
        np.concatenate([np.empty((0, 3), np.uint8), *(part.colors for part in parts)]),
    )


def sightings(camera: Camera, depth: Pixels, points: Points) -> Sightings:
    """Which of the points a view sees, and where.

    Args:
        camera: The view's.
        depth: (height, width, 1) planar, metres; 0 where nothing is.
        points: Those of all views.
    """
    pixels, far = camera.project(points.positions)
    size = np.array([camera.lens.width, camera.lens.height])
    inside = np.flatnonzero((far > 0.0) & ((pixels >= 0.0) & (pixels < size)).all(axis=1))
    columns, rows = np.floor(pixels[inside]).astype(np.int64).T
    surface = depth[rows, columns, 0].astype(np.float64)
    same = np.abs(surface - far[inside]) <= _SAME_SURFACE_SHARE * far[inside]
    return Sightings(inside[same], pixels[inside[same]])


class NerfDataset:
    """``transforms.json``, a COLMAP model and plain matrices of one render (docs/howto/nerf.md)."""

    takes: Final = "render"
    needs: Mapping[str, str] = MappingProxyType({})
    called: Mapping[str, str] = MappingProxyType({})

    def write(
        self,
        renders: Sequence[RenderedScene],
        root: Path,
        options: DatasetOptions,
        progress: Progress = silent,
    ) -> DatasetSummary:
        """Write one render; nothing appears before all is written.

        Args:
            renders: The render.
            root: The dataset's folder.
            options: What it was given: those of OpenRooms' dataset mean nothing here.
            progress: Called with each finished view and the finished fraction.

        Raises:
            InputError: There are several renders, or an option has no meaning here, or a camera
                cannot be said in these files.
            OutputError: A file cannot be written, or another's would be replaced.
        """
        render = _check(renders, options)
        with claims.refilling(root, _LEDGER) as refill:
            missing, far = _write(refill.folder, render, progress)
        frames, count = {"all": list(range(1, len(render.views) + 1))}, len(refill.written)
        return DatasetSummary(root, frames, count, missing, tuple(_notes(far, refill.stay)))


def _write(folder: Path, render: RenderedScene, progress: Progress) -> tuple[dict[str, str], int]:
    """Write everything; what there is none of and why, and how many pixels are too far away."""
    cameras = [camera_of(view) for view in render.views.values()]
    found, count = survey(render), len(cameras)
    parts: list[Points] = []
    far = 0
    for number, (camera, view) in enumerate(zip(cameras, render.each(), strict=True), start=1):
        image = None if found.exposure is None else write_image(folder, view, found.exposure)
        if found.depths:
            far += write_depth(folder, view)
            parts.append(sample(camera, view.pixels["depth"], image, count))
        progress(view.name, 0.5 * number / count)
    points = joined(parts)
    seen: list[Sightings] = []
    for number, (camera, view) in enumerate(zip(cameras, render.each(), strict=True), start=1):
        seen.append(sightings(camera, view.pixels["depth"], points) if parts else NOTHING)
        progress(view.name, 0.5 + 0.5 * number / count)
    write_model(folder, cameras, points, seen)
    write_transforms(folder, cameras, points, depths=found.depths)
    write_matrices(folder, cameras)
    missing = {} if found.exposure else {"images": "a view has no radiance"}
    return missing | ({} if found.depths else dict.fromkeys(_OF_DEPTH, "a view has no depth")), far


def _check(renders: Sequence[RenderedScene], options: DatasetOptions) -> RenderedScene:
    if len(renders) != 1:
        raise InputError(
            f"{len(renders)} renders, and this dataset is of one",
            place="dataset",
            remedy="write each into its own folder",
        )
    if options != DatasetOptions():
        raise InputError(
            "--scene, --split, --subset, --dataset-layout, --imenv-order and --first belong to "
            "OpenRooms",
            place="dataset",
            remedy="omit them",
        )
    return renders[0]


def _notes(far: int, stay: Sequence[Path]) -> Iterator[str]:
    if far:
        yield f"{far} pixels lie farther away than 16 bits of millimetres say: they have no depth"
    for path in stay:
        yield f"{path.name} stays, which was changed after it was written"


def write_transforms(
    folder: Path, cameras: Sequence[Camera], points: Points, *, depths: bool
) -> None:
    """Write ``transforms.json``, and ``points3D.ply`` where there are points.

    Args:
        folder: The dataset.
        cameras: One for each view.
        points: Points of surfaces.
        depths: Whether there are depth maps.

    Raises:
        OutputError: A file cannot be written.
    """
    lenses = {camera.lens for camera in cameras}
    common = _lens(next(iter(lenses))) if len(lenses) == 1 else {}
    found: dict[str, Any] = {"camera_model": "OPENCV", **_NO_DISTORTION, **common}
    if depths:
        found["integer_depth_scale"] = DEPTH_STEP_M
    if len(points):
        found["ply_file_path"] = CLOUD
        # instant-ngp scales this box to its unit cube.
        found["aabb"], found["aabb_scale"] = _box(cameras, points).tolist(), 1
        _write_cloud(folder / CLOUD, points)
    found["frames"] = [
        _frame(camera, number, depths=depths) | ({} if common else _lens(camera.lens))
        for number, camera in enumerate(cameras, start=1)
    ]
    write_json(folder / TRANSFORMS, found)


def _lens(lens: Lens) -> dict[str, float]:
    found = asdict(lens)
    angles = {
        "camera_angle_x": 2.0 * math.atan2(lens.width, 2.0 * lens.fl_x),
        "camera_angle_y": 2.0 * math.atan2(lens.height, 2.0 * lens.fl_y),
    }
    return {"w": found.pop("width"), "h": found.pop("height"), **found, **angles}


def _frame(camera: Camera, number: int, *, depths: bool) -> dict[str, Any]:
    found: dict[str, Any] = {
        "file_path": f"{IMAGES}/{image_name(camera.name)}",
        "transform_matrix": camera.transform_matrix.tolist(),
        "colmap_im_id": number,
    }
    if depths:
        depth = f"{DEPTHS}/{image_name(camera.name)}"
        found |= {"depth_file_path": depth, "depth_path": depth}
    return found


def _box(cameras: Sequence[Camera], points: Points) -> Array:
    eyes = np.stack([camera.world_from_camera[:3, 3] for camera in cameras])
    everything = np.concatenate([eyes, points.positions])
    return np.stack([everything.min(axis=0) - _MARGIN_M, everything.max(axis=0) + _MARGIN_M])


def _write_cloud(path: Path, points: Points) -> None:
    """Write a binary PLY of positions and colours."""
    kinds = [(axis, "<f4") for axis in "xyz"] + [(c, "u1") for c in ("red", "green", "blue")]
    rows = np.empty(len(points), np.dtype(kinds))
    for values, names in ((points.positions, kinds[:3]), (points.colors, kinds[3:])):
        for column, (name, _) in enumerate(names):
            rows[name] = values[:, column]
    words = {"<f4": "float", "u1": "uchar"}
    properties = [f"property {words[kind]} {name}" for name, kind in kinds]
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}", *properties]
    atomic.write_bytes(path, ("\n".join([*head, "end_header"]) + "\n").encode() + rows.tobytes())


def write_model(
    folder: Path, cameras: Sequence[Camera], points: Points, seen: Sequence[Sightings]
) -> None:
    """Write ``cameras.txt``, ``images.txt`` and ``points3D.txt``.

    Args:
        folder: The dataset.
        cameras: One for each view.
        points: Points of surfaces.
        seen: Which of them each view sees.

    Raises:
        OutputError: A file cannot be written.
    """
    lenses = sorted({camera.lens for camera in cameras})
    numbers = {lens: number for number, lens in enumerate(lenses, start=1)}
    model = folder / MODEL
    _write_model(
        model / "cameras.txt",
        ["CAMERA_ID, MODEL, WIDTH, HEIGHT, fx, fy, cx, cy"],
        (
            f"{numbers[lens]} PINHOLE {lens.width} {lens.height} "
            + _numbers((lens.fl_x, lens.fl_y, lens.cx, lens.cy))
            for lens in lenses
        ),
    )
    _write_model(
        model / "images.txt",
        ["IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME", "(X, Y, POINT3D_ID)*"],
        _images(cameras, [numbers[camera.lens] for camera in cameras], seen),
    )
    _write_model(
        model / "points3D.txt",
        ["POINT3D_ID, X, Y, Z, R, G, B, ERROR, (IMAGE_ID, POINT2D_IDX)*"],
        _points(points, seen),
    )


def _images(
    cameras: Sequence[Camera], lenses: Sequence[int], seen: Sequence[Sightings]
) -> Iterator[str]:
    rows = zip(cameras, lenses, seen, strict=True)
    for number, (camera, lens, sighted) in enumerate(rows, start=1):
        place = (*camera.rotation, *camera.camera_from_world[:3, 3])
        yield f"{number} {_numbers(place)} {lens} {image_name(camera.name)}"
        pixels = np.round(sighted.pixels, _PIXEL_DECIMALS).tolist()
        marks = zip(pixels, sighted.points.tolist(), strict=True)
        yield " ".join(f"{x!r} {y!r} {point + 1}" for (x, y), point in marks)


def _points(points: Points, seen: Sequence[Sightings]) -> Iterator[str]:
    tracks: list[list[str]] = [[] for _ in range(len(points))]
    for number, sighted in enumerate(seen, start=1):
        for place, point in enumerate(sighted.points.tolist()):
            tracks[point].append(f"{number} {place}")
    positions = np.round(points.positions, _METRE_DECIMALS).tolist()
    rows = zip(positions, points.colors.tolist(), tracks, strict=True)
    for number, (position, color, track) in enumerate(rows, start=1):
        colored = " ".join(map(str, color))
        yield f"{number} {_numbers(position)} {colored} 0 {' '.join(track)}"


def _numbers(values: Sequence[float]) -> str:
    return " ".join(repr(float(value) + 0.0) for value in values)


def _write_model(path: Path, comments: Sequence[str], lines: Iterator[str]) -> None:
    everything = [*(f"# {comment}" for comment in comments), *lines]
    atomic.write_text(path, "\n".join(everything) + "\n")
