"""What a stage asks of pictures: their size, and what its cameras cut away."""

from typing import Final

import numpy as np
from pxr import Usd, UsdGeom, UsdRender

from openrooms_usd import names
from openrooms_usd.usd.frames import TIME

DEFAULT_RESOLUTION: Final = (640, 480)
# Where a camera's own near plane begins to matter, metres: nearer things are hardly ever there.
_NEAR_PLANE_MATTERS: Final = np.float32(0.1)


def stage_resolution(stage: Usd.Stage) -> tuple[int, int]:
    """Width and height of the stage's render settings, or `DEFAULT_RESOLUTION`."""
    settings = UsdRender.Settings.GetStageRenderSettings(stage)
    if not settings:
        settings = UsdRender.Settings(stage.GetPrimAtPath(names.RENDER_SETTINGS))
    if not settings:
        return DEFAULT_RESOLUTION
    width, height = settings.GetResolutionAttr().Get() or DEFAULT_RESOLUTION
    return (int(width), int(height)) if width > 0 and height > 0 else DEFAULT_RESOLUTION


def clipping_loss(prim: Usd.Prim) -> str:
    """What is lost because a camera's clipping range is left out; empty where that is nothing.

    Args:
        prim: A ``UsdGeom.Camera``.
    """
    clipping = UsdGeom.Camera(prim).GetClippingRangeAttr()
    if not clipping.HasAuthoredValue():
        return ""
    near = clipping.Get(TIME)[0] * UsdGeom.GetStageMetersPerUnit(prim.GetStage())
    if np.float32(near) <= _NEAR_PLANE_MATTERS:
        return ""
    return f"clipping is left out: what is nearer than {near:.3g} m is seen too"
