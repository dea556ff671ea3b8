"""What a stage asks of pictures: their size, and what its cameras cut away."""

from typing import Final

from pxr import Usd, UsdGeom, UsdRender

from openrooms_usd import names
from openrooms_usd.usd.frames import TIME

DEFAULT_RESOLUTION: Final = (640, 480)


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
    """What is lost because a camera's own clipping planes are left out; empty without any.

    Args:
        prim: A ``UsdGeom.Camera``.
    """
    planes = UsdGeom.Camera(prim).GetClippingPlanesAttr().Get(TIME)
    return "clippingPlanes are left out: what they cut away is seen too" if planes else ""
