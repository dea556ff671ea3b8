"""What a stage asks of pictures: their size, and what is lost or doubtful of its cameras."""

from collections.abc import Iterator
from typing import Final

import numpy as np
from pxr import Usd, UsdGeom

from openrooms_usd.errors import StageError
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.usd.cameras import UNCLIPPED, read_camera
from openrooms_usd.usd.doubts import DOUBT, camera_doubts
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.rendersettings import asked_resolution

DEFAULT_RESOLUTION: Final = (640, 480)
_MOST_HIDDEN: Final = 0.9


def stage_resolution(stage: Usd.Stage) -> tuple[int, int]:
    """Width and height of the stage's render settings, or `DEFAULT_RESOLUTION`."""
    return asked_resolution(stage) or DEFAULT_RESOLUTION


def camera_losses(prim: Usd.Prim, scene: Scene) -> Iterator[str]:
    """What is lost of a camera, and what of it is hardly meant, one sentence each.

    Args:
        prim: A ``UsdGeom.Camera``.
        scene: What it sees.
    """
    if UsdGeom.Camera(prim).GetClippingPlanesAttr().Get(TIME):
        yield "clippingPlanes are left out: what they cut away is seen too"
    yield from camera_doubts(prim)
    try:
        camera = read_camera(prim, *DEFAULT_RESOLUTION)
    except StageError:
        # Who asks for its picture reads why there is none.
        return
    if camera.clipping == UNCLIPPED:
        return
    points = np.concatenate([np.zeros((0, 3)), *(p.triangles.landmarks for p in scene.patches)])
    eye, forward = camera.world_from_camera[:3, 3], camera.world_from_camera[:3, 2]
    depths = (points - eye) @ forward
    (near, far), before = camera.clipping, depths > 0.0
    hidden = before & ((depths < near) | (depths > far))
    if hidden.sum() > _MOST_HIDDEN * before.sum():
        share = f"{100.0 * hidden.sum() / before.sum():.0f} % of what is before it"
        yield f"a clippingRange of {near:g} to {far:g} m{DOUBT}it cuts away {share}"
