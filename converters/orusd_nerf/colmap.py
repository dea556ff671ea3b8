"""COLMAP's sparse model as text (https://colmap.github.io/format.html).

Cameras are OpenCV's, poses camera_from_world, quaternions w x y z; the centre of the top-left pixel
is (0.5, 0.5); identifiers count from 1. Points lie exactly where they are seen: their error is 0.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd import atomic
from orusd_nerf.cameras import Camera
from orusd_nerf.pictures import image_name
from orusd_nerf.points import Points, Sightings

# Where COLMAP, nerfstudio and 3D Gaussian splatting look for it.
MODEL: Final = "sparse/0"

_PIXEL_DECIMALS: Final = 6
_METRE_DECIMALS: Final = 9


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
    _write(
        model / "cameras.txt",
        ["CAMERA_ID, MODEL, WIDTH, HEIGHT, fx, fy, cx, cy"],
        (
            f"{numbers[lens]} PINHOLE {lens.width} {lens.height} "
            + _numbers((lens.fl_x, lens.fl_y, lens.cx, lens.cy))
            for lens in lenses
        ),
    )
    _write(
        model / "images.txt",
        ["IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME", "(X, Y, POINT3D_ID)*"],
        _images(cameras, [numbers[camera.lens] for camera in cameras], seen),
    )
    _write(
        model / "points3D.txt",
        ["POINT3D_ID, X, Y, Z, R, G, B, ERROR, (IMAGE_ID, POINT2D_IDX)*"],
        _points(points, seen),
    )


def _images(
    cameras: Sequence[Camera], lenses: Sequence[int], seen: Sequence[Sightings]
) -> Iterator[str]:
    rows = zip(cameras, lenses, seen, strict=True)
    for number, (camera, lens, sightings) in enumerate(rows, start=1):
        place = (*camera.rotation, *camera.camera_from_world[:3, 3])
        yield f"{number} {_numbers(place)} {lens} {image_name(camera.name)}"
        pixels = np.round(sightings.pixels, _PIXEL_DECIMALS).tolist()
        marks = zip(pixels, sightings.points.tolist(), strict=True)
        yield " ".join(f"{x!r} {y!r} {point + 1}" for (x, y), point in marks)


def _points(points: Points, seen: Sequence[Sightings]) -> Iterator[str]:
    tracks: list[list[str]] = [[] for _ in range(len(points))]
    for number, sightings in enumerate(seen, start=1):
        for place, point in enumerate(sightings.points.tolist()):
            tracks[point].append(f"{number} {place}")
    positions = np.round(points.positions, _METRE_DECIMALS).tolist()
    rows = zip(positions, points.colors.tolist(), tracks, strict=True)
    for number, (position, color, track) in enumerate(rows, start=1):
        colored = " ".join(map(str, color))
        yield f"{number} {_numbers(position)} {colored} 0 {' '.join(track)}"


def _numbers(values: Sequence[float]) -> str:
    return " ".join(repr(float(value) + 0.0) for value in values)


def _write(path: Path, comments: Sequence[str], lines: Iterator[str]) -> None:
    everything = [*(f"# {comment}" for comment in comments), *lines]
    atomic.write_text(path, "\n".join(everything) + "\n")
