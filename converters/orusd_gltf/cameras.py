"""Cameras: perspective, with their field of view."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from openrooms_usd.errors import StageError
from openrooms_usd.render.scene.cameras import stage_resolution
from openrooms_usd.usd.cameras import FLIP, list_cameras, read_camera
from openrooms_usd.usd.frames import TIME
from orusd_gltf.document import Document, Object, number

Array = NDArray[np.float64]

# Pixels by which an optical axis may miss the middle before it is told.
_CENTRED_PX: Final = 1e-3
# What is nearer is not seen, where the stage says nothing that can be.
_NEAREST_M: Final = 0.01


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
    near, far = camera.clipping
    perspective = {
        "aspectRatio": number(width / height * K[1, 1] / K[0, 0]),
        "yfov": number(2.0 * math.atan(height / (2.0 * K[1, 1]))),
        "znear": number(near if 0.0 < near < math.inf else _NEAREST_M),
    }
    if perspective["znear"] < far < math.inf:
        # Without it nothing is too far.
        perspective["zfar"] = number(far)
    name = prim.GetName()
    found = document.add(
        "cameras", {"name": name, "type": "perspective", "perspective": perspective}
    )
    off = np.abs(K[:2, 2] - [width / 2.0, height / 2.0]).max()
    lost = "its picture is off the optical axis; glTF centres it" if off > _CENTRED_PX else ""
    stops = UsdGeom.Camera(prim).GetExposureAttr()
    said = stops.Get(TIME) if stops.HasAuthoredValue() else math.nan
    known: Object = {"exposure": number(said)} if math.isfinite(said) else {}
    return found, camera.world_from_camera @ FLIP, known, lost
