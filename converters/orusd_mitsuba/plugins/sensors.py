"""Cameras as Mitsuba sensors, described without Mitsuba."""

import math
from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.usd.cameras import ORTHOGRAPHIC, PinholeCamera
from orusd_mitsuba.plugins.descriptions import Description

# OpenCV axes (right, down, forward) in Mitsuba's camera axes (left, up, forward), and back.
_MITSUBA_FROM_OPENCV: Final = np.diag([-1.0, -1.0, 1.0, 1.0])
# Where a camera has no clipping planes.
_NEAR_CLIP_METRES: Final = 1e-3
FAR_CLIP_METRES: Final = 1e6
# Of the picture's size, by which the principal point may be off the middle.
_CENTRED_SHARE: Final = 1e-6


def describe_sensor(
    camera: PinholeCamera,
    width: int,
    height: int,
    origin: Array,
    rows: tuple[int, int] | None = None,
) -> Description:
    """The sensor of a camera, without its sampler.

    Args:
        camera: Of any projection but panoramas. With a lens it is a ``thinlens``, which has its
            axis in the picture's middle: where the camera's is elsewhere, all is sharp.
        width: Pixels.
        height: Pixels.
        origin: (3,) the point of the world that is Mitsuba's origin.
        rows: The first row and the number of rows of a band; all of them when None.
    """
    K, pose = camera.K, camera.world_from_camera @ _MITSUBA_FROM_OPENCV
    pose[:3, 3] -= origin
    near, far = camera.clipping
    shared: Description = {
        "near_clip": max(near, _NEAR_CLIP_METRES),
        "far_clip": min(far, FAR_CLIP_METRES),
        "to_world": pose,
        "film": {
            "type": "hdrfilm",
            "width": width,
            "height": height,
            **_band(width, rows),
            "pixel_format": "rgb",
            "component_format": "float32",
            "rfilter": {"type": "box"},
        },
    }
    if camera.projection == ORTHOGRAPHIC:
        return shared | _parallel(camera, width, height, pose)
    offsets = 0.5 - K[0, 2] / width, 0.5 - K[1, 2] / height
    lens: Description = {
        "type": "perspective",
        "principal_point_offset_x": offsets[0],
        "principal_point_offset_y": offsets[1],
    }
    if has_lens(camera) and max(map(abs, offsets)) < _CENTRED_SHARE:
        lens = {
            "type": "thinlens",
            "aperture_radius": camera.lens_radius,
            "focus_distance": camera.focus_distance,
        }
    fov = math.degrees(2.0 * math.atan(width / 2.0 / K[0, 0]))
    return lens | {"fov": fov, "fov_axis": "x"} | shared


def _parallel(camera: PinholeCamera, width: int, height: int, pose: Array) -> Description:
    """What is other by parallel rays: Mitsuba's window is 2 wide, and begins where it stands."""
    K, (near, far) = camera.K, camera.clipping
    # What is seen may begin behind the camera; there it stands.
    back = near - _NEAR_CLIP_METRES
    right, down = ((side / 2.0 - K[i, 2]) / K[i, i] for i, side in enumerate((width, height)))
    window = np.diag([width / (2.0 * K[0, 0])] * 2 + [1.0, 1.0])
    # Mitsuba's axes are to the left and up.
    window[:3, 3] = -right, -down, back
    return {
        "type": "orthographic",
        "near_clip": _NEAR_CLIP_METRES,
        "far_clip": min(far - back, FAR_CLIP_METRES),
        "to_world": pose @ window,
    }


def has_lens(camera: PinholeCamera) -> bool:
    """Whether anything is out of focus."""
    return camera.lens_radius > 0.0 and camera.focus_distance > 0.0


def pinhole(camera: PinholeCamera) -> PinholeCamera:
    """The camera with all in focus."""
    return replace(camera, f_stop=0.0, lens_radius=0.0)


def _band(width: int, rows: tuple[int, int] | None) -> dict[str, int]:
    if rows is None:
        return {}
    top, count = rows
    return {"crop_offset_x": 0, "crop_offset_y": top, "crop_width": width, "crop_height": count}
