"""Draws ``docs/scan.png``: a room, its simulated scan, the plan of what was found, the room again.

A room is generated and scanned by the simulator of the benchmarks; the scan alone goes through
``orusd import`` and ``orusd compose``, and the room that was found is rendered by the camera of
the first one.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
from numpy.typing import NDArray
from pxr import Usd

from benchmarks.scan.rooms import generated
from benchmarks.scan.scanner import Scan, Scanner, simulate
from benchmarks.scenes import orusd
from openrooms_usd.usd.cameras import PinholeCamera, read_camera

Bytes = NDArray[np.uint8]

CAMERA = "view_0"
CAPTIONS = ("as it was described", "its scan", "as it was found")


def scanned(
    folder: Path, kind: str, seed: int, size: tuple[int, int], quality: Sequence[str]
) -> list[tuple[str, Bytes]]:
    """The pictures with their captions.

    Args:
        folder: For what is made on the way.
        kind: The type of the room.
        seed: Of the room.
        size: Width and height of the pictures.
        quality: Options of ``orusd render``.
    """
    stage = generated(kind, seed, folder)
    opened = Usd.Stage.Open(str(stage))
    camera = read_camera(opened.GetPrimAtPath(f"/World/Cameras/{CAMERA}"), *size)
    scan = simulate(stage, seed, Scanner())
    home = folder / f"{kind}_{seed}" / "scanned"
    _write(home, scan, camera, size)
    if not (home / "room/room.yaml").is_file():
        orusd(
            "import",
            "scan",
            home / "scan.npz",
            "--frames",
            home / "frames.json",
            "-o",
            home / "room",
        )
    orusd("compose", home / "room/room.yaml", "-o", home / "out")
    orusd("validate", home / "out/scene.usda", "--strict")
    views = []
    for scene, name in ((stage, CAMERA), (home / "out/scene.usda", f"frame_{CAMERA}")):
        target = home / f"render_{name}"
        orusd(
            "render",
            scene,
            "-o",
            target,
            "--camera",
            name,
            "--resolution",
            "x".join(map(str, size)),
            *quality,
        )
        views.append(_read(target / name / "denoised.png"))
    plan = _fitted(home / "out/overlay.png", size)
    tiles = zip(CAPTIONS, (views[0], seen(scan, camera, size), views[1]), strict=True)
    return [*tiles, ("the plan of what was found", plan)]


def _write(home: Path, scan: Scan, camera: PinholeCamera, size: tuple[int, int]) -> None:
    home.mkdir(parents=True, exist_ok=True)
    cloud = scan.cloud
    arrays = {
        name: getattr(cloud, name) for name in ("points", "label", "instance", "sensor_origins")
    }
    np.savez(home / "scan.npz", **arrays)
    frame = {
        "id": CAMERA,
        "resolution": size,
        "K": camera.K.tolist(),
        "world_from_camera": camera.world_from_camera.tolist(),
    }
    (home / "frames.json").write_text(json.dumps([frame]))


def seen(scan: Scan, camera: PinholeCamera, size: tuple[int, int]) -> Bytes:
    """(H, W, 3) the points as a camera sees them, each object in a colour of its own."""
    width, height = size
    cloud = scan.cloud
    camera_from_world = np.linalg.inv(camera.world_from_camera)
    points = cloud.points @ camera_from_world[:3, :3].T + camera_from_world[:3, 3]
    pixels = np.full((len(points), 2), -1.0)
    ahead = points[:, 2] > 0.1
    pixels[ahead] = (points[ahead] @ camera.K.T)[:, :2] / points[ahead, 2:]
    inside = ((pixels >= 0.0) & (pixels < size)).all(axis=1)
    columns, rows = pixels[inside].astype(int).T
    depth = points[inside, 2]
    shades = _shades(cloud.label, cloud.instance)[inside]
    picture = np.full((height, width, 3), 20, np.uint8)
    # The farthest first: what is near covers it, with a square of its size.
    for row in np.argsort(-depth):
        half = max(int(0.009 * camera.K[0, 0] / depth[row]), 0)
        top, left = max(rows[row] - half, 0), max(columns[row] - half, 0)
        picture[top : rows[row] + half + 1, left : columns[row] + half + 1] = shades[row]
    return picture


def _shades(label: Any, instance: Any) -> NDArray[np.uint8]:
    random = np.random.default_rng(7)
    objects = random.integers(70, 250, (int(instance.max()) + 1, 3))
    structure = random.integers(110, 200, (64, 1)).repeat(3, axis=1)
    return np.where(instance[:, None] > 0, objects[instance], structure[label]).astype(np.uint8)


def _read(path: Path) -> Bytes:
    return np.asarray(OpenImageIO.ImageBuf(str(path)).get_pixels(OpenImageIO.UINT8))[..., :3]


def _fitted(path: Path, size: tuple[int, int]) -> Bytes:
    """A picture in the size of the others, on white."""
    given = OpenImageIO.ImageBuf(str(path))
    scale = min(size[0] / given.spec().width, size[1] / given.spec().height)
    width, height = (round(scale * side) for side in (given.spec().width, given.spec().height))
    roi = OpenImageIO.ROI(0, width, 0, height, 0, 1, 0, 3)
    small = OpenImageIO.ImageBufAlgo.resize(given, "lanczos3", roi=roi)
    whole: Bytes = np.full((size[1], size[0], 3), 255, np.uint8)
    whole[:height, :width] = small.get_pixels(OpenImageIO.UINT8)[..., :3]
    return whole
