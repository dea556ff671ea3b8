"""What is lost or doubtful of a stage's cameras."""

from collections.abc import Iterator
from typing import Final

import numpy as np
from pxr import Usd, UsdGeom

from openrooms_usd.errors import StageError
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.usd.cameras import UNCLIPPED, read_camera
from openrooms_usd.usd.doubts import DOUBT, camera_doubts
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.rendersettings import stage_resolution

_MOST_HIDDEN: Final = 0.9


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
        camera = read_camera(prim, *stage_resolution(prim.GetStage()))
    except StageError:
        # Who asks for its picture reads why there is none.
        return
    if camera.clipping == UNCLIPPED:
        return
    eye, forward = camera.world_from_camera[:3, 3], camera.world_from_camera[:3, 2]
    (near, far), before, hidden = camera.clipping, 0, 0
    for part in (part for patch in scene.patches for part in patch.triangles.parts):
        depths = part.landmarks @ forward - eye @ forward
        before += int(np.count_nonzero(depths > 0.0))
        hidden += int(np.count_nonzero((depths > 0.0) & ((depths < near) | (depths > far))))
    if hidden > _MOST_HIDDEN * before:
        share = f"{100.0 * hidden / before:.0f} % of what is before it"
        yield f"a clippingRange of {near:g} to {far:g} m{DOUBT}it cuts away {share}"
