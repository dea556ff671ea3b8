"""What a stage asks of pictures: their size, and what its cameras cut away."""

from typing import Final

from pxr import Usd, UsdGeom

from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.rendersettings import asked_resolution

DEFAULT_RESOLUTION: Final = (640, 480)


def stage_resolution(stage: Usd.Stage) -> tuple[int, int]:
    """Width and height of the stage's render settings, or `DEFAULT_RESOLUTION`."""
    return asked_resolution(stage) or DEFAULT_RESOLUTION


def clipping_loss(prim: Usd.Prim) -> str:
    """What is lost because a camera's own clipping planes are left out; empty without any.

    Args:
        prim: A ``UsdGeom.Camera``.
    """
    planes = UsdGeom.Camera(prim).GetClippingPlanesAttr().Get(TIME)
    return "clippingPlanes are left out: what they cut away is seen too" if planes else ""
