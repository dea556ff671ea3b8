"""Fields of view that somebody asks for, in place of those that cameras have."""

import math
from typing import Final

from pxr import Usd, UsdGeom, UsdRender

from openrooms_usd.errors import InputError
from openrooms_usd.usd.arrays import number_of
from openrooms_usd.usd.cameras import list_cameras
from openrooms_usd.usd.frames import TIME
from openrooms_usd.usd.rendersettings import render_settings

_LEAST_FIELD_DEG: Final = 1.0
_MOST_FIELD_DEG: Final = 170.0


def set_field_of_view(stage: Usd.Stage, degrees: float) -> None:
    """Give all cameras of an opened stage a horizontal field of view; its files stay as they are.

    Args:
        stage: An opened stage.
        degrees: The angle between the picture's left and right edge.

    Raises:
        InputError: No picture has such an angle.
    """
    if not _LEAST_FIELD_DEG <= degrees <= _MOST_FIELD_DEG:
        raise InputError(
            f"a field of view of {degrees:g} degrees makes no picture",
            remedy=f"give {_LEAST_FIELD_DEG:g} to {_MOST_FIELD_DEG:g}",
        )
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        if (settings := render_settings(stage)) is not None:
            # Else the horizontal field of view may follow from the vertical one.
            policy = settings.GetAspectRatioConformPolicyAttr()
            policy.Set(UsdRender.Tokens.adjustApertureHeight)
        for prim in list_cameras(stage):
            camera = UsdGeom.Camera(prim)
            aperture = number_of(camera.GetHorizontalApertureAttr().Get(TIME)) or 0.0
            camera.GetFocalLengthAttr().Set(0.5 * aperture / math.tan(math.radians(degrees) / 2.0))
