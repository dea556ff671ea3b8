"""The size of the pictures that a stage asks for."""

from typing import Final

from pxr import Usd, UsdRender

from openrooms_usd import names

DEFAULT: Final = (640, 480)


def stage_resolution(stage: Usd.Stage) -> tuple[int, int]:
    """Width and height of the stage's render settings, or 640 by 480."""
    settings = UsdRender.Settings.GetStageRenderSettings(stage)
    if not settings:
        settings = UsdRender.Settings(stage.GetPrimAtPath(names.RENDER_SETTINGS))
    if not settings:
        return DEFAULT
    width, height = settings.GetResolutionAttr().Get() or DEFAULT
    return (int(width), int(height)) if width > 0 and height > 0 else DEFAULT
