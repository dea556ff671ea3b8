"""``transforms.json`` of instant-ngp and nerfstudio, and its cloud of points.

Matrices are world_from_camera with OpenGL's axes (x right, y up, z backward) in our world, metres,
Z up, which is theirs. What is the same for all views stands at the top, else in each frame: so both
parsers take it. Depth is planar: nerfstudio reads ``depth_file_path`` in millimetres unless told
otherwise, instant-ngp ``depth_path`` by ``integer_depth_scale``.
"""

import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd import atomic
from openrooms_usd.render.manifest import write_json
from orusd_nerf.cameras import Array, Camera, Lens
from orusd_nerf.pictures import DEPTH_STEP_M, DEPTHS, IMAGES, image_name
from orusd_nerf.points import Points

TRANSFORMS: Final = "transforms.json"
CLOUD: Final = "points3D.ply"

_NO_DISTORTION: Final = {"k1": 0.0, "k2": 0.0, "p1": 0.0, "p2": 0.0}
# Around all surfaces and cameras.
_MARGIN_M: Final = 0.1


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
