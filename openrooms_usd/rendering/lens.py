"""The lens that a picture is asked for, before a camera of the stage."""

import math

from openrooms_usd.errors import RenderError
from openrooms_usd.geometry.composition import focus_distance
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.usd.cameras import PINHOLE, PinholeCamera, with_lens


def lens_of(
    camera: PinholeCamera, f_stop: float, caster: RayCaster, width: int, place: str | None
) -> PinholeCamera:
    """The camera with a lens, focused as it says or on what is in the middle of the picture.

    Args:
        camera: A pinhole.
        f_stop: F-number of the lens, before film 36 mm wide.
        caster: Casts rays against what is rendered.
        width: Of the picture, pixels.
        place: The camera's name, for messages.

    Raises:
        RenderError: It is not a camera that has a lens.
    """
    if camera.projection != PINHOLE:
        raise RenderError(
            f"an {camera.projection} camera has no lens",
            place=place,
            remedy="omit --f-stop, or choose another --camera",
        )
    fov = 2.0 * math.degrees(math.atan(0.5 * width / camera.K[0, 0]))
    pose = camera.world_from_camera
    focus = camera.focus_distance or focus_distance(caster, pose[:3, 3], pose[:3, 2], fov)
    return with_lens(camera, f_stop, focus, width)
