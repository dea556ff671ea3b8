"""Cameras: perspective with their field of view, orthographic with half their window."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from openrooms_usd.errors import StageError
from openrooms_usd.render.scene.cameras import stage_resolution
from openrooms_usd.usd.cameras import FLIP, ORTHOGRAPHIC, PinholeCamera, list_cameras, read_camera
from openrooms_usd.usd.frames import TIME
from orusd_gltf.document import Document, Object, number

Array = NDArray[np.float64]

# Pixels by which an optical axis may miss the middle before it is told.
_CENTRED_PX: Final = 1e-3
# What is nearer is not seen, where the stage says nothing that can be.
_NEAREST_M: Final = 0.01
# By parallel rays something has to be.
_FARTHEST_M: Final = 1000.0


def authored_stops(stage: Usd.Stage) -> float | None:
    """The exposure of the first camera that has one, stops."""
    for prim in list_cameras(stage):
        stops = UsdGeom.Camera(prim).GetExposureAttr()
        if stops.HasAuthoredValue() and math.isfinite(stops.Get(TIME)):
            return float(stops.Get(TIME))
    return None


def add_camera(document: Document, prim: Usd.Prim) -> tuple[int, Array, Object, str] | str:
    """Add a camera of a stage.

    Returns:
        Its number, (4, 4) its place in the world, what else is known of it (``exposure`` in stops,
        where it is authored), and what was lost in words; or why there is none.
    """
    width, height = stage_resolution(prim.GetStage())
    try:
        camera = read_camera(prim, width, height)
    except StageError as error:
        return error.message
    K = camera.K
    found = document.add("cameras", {"name": prim.GetName(), **_projection(camera, width, height)})
    off = np.abs(K[:2, 2] - [width / 2.0, height / 2.0]).max()
    lost = "its picture is off the optical axis; glTF centres it" if off > _CENTRED_PX else ""
    stops = UsdGeom.Camera(prim).GetExposureAttr()
    said = stops.Get(TIME) if stops.HasAuthoredValue() else math.nan
    known: Object = {"exposure": number(said)} if math.isfinite(said) else {}
    return found, camera.world_from_camera @ FLIP, known, lost


def _projection(camera: PinholeCamera, width: int, height: int) -> Object:
    (across, down), (near, far) = camera.K[[0, 1], [0, 1]], camera.clipping
    if camera.projection == ORTHOGRAPHIC:
        nearest = max(near, 0.0)
        seen = {
            "xmag": number(width / (2.0 * across)),
            "ymag": number(height / (2.0 * down)),
            "znear": number(nearest),
            "zfar": number(far if nearest < far < math.inf else _FARTHEST_M),
        }
        return {"type": "orthographic", "orthographic": seen}
    perspective = {
        "aspectRatio": number(width / height * down / across),
        "yfov": number(2.0 * math.atan(height / (2.0 * down))),
        "znear": number(near if 0.0 < near < math.inf else _NEAREST_M),
    }
    if perspective["znear"] < far < math.inf:
        # Without it nothing is too far.
        perspective["zfar"] = number(far)
    return {"type": "perspective", "perspective": perspective}
