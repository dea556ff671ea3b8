"""The size of the pictures that a stage asks for."""

from pxr import Usd, UsdRender

from openrooms_usd import names
from openrooms_usd.render.contract import DEFAULT_RESOLUTION


def stage_resolution(stage: Usd.Stage) -> tuple[int, int]:
    """Width and height of the stage's render settings, or `DEFAULT_RESOLUTION`."""
    settings = UsdRender.Settings.GetStageRenderSettings(stage)
    if not settings:
        settings = UsdRender.Settings(stage.GetPrimAtPath(names.RENDER_SETTINGS))
    if not settings:
        return DEFAULT_RESOLUTION
    width, height = settings.GetResolutionAttr().Get() or DEFAULT_RESOLUTION
    return (int(width), int(height)) if width > 0 and height > 0 else DEFAULT_RESOLUTION
