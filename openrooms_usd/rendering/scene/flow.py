"""Optical flow: where what a pixel sees is in the next frame of a path, and whether it is seen.

Nothing in a room moves but the camera, so the flow of a pixel's centre follows from the exact point
that it sees and from the next camera. Whether that camera sees the point is asked by a ray of its
own, not by the depth of its pixels: at the edges of things those tell of their neighbours.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.channels import FLOWS
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.first_hits import first_hits, hits_along
from openrooms_usd.rendering.scene.rays import RayTracer
from openrooms_usd.usd.cameras import PinholeCamera

# What a ray to a point meets so little before it is the point; metres, and relative.
_BEFORE_M: Final = 1e-3
_BEFORE_SHARE: Final = 1e-4
# Nearer to the next camera's plane, nothing is projected; metres.
_NEAR_M: Final = 1e-6


def optical_flow(
    scene: Scene,
    tracer: RayTracer,
    camera: PinholeCamera,
    after: PinholeCamera,
    size: tuple[int, int],
) -> dict[str, NDArray[np.float32]]:
    """The flow from one frame to the next.

    Args:
        scene: What is seen.
        tracer: Finds its triangles.
        camera: Of the frame; a pinhole.
        after: Of the next frame; a pinhole.
        size: Width and height of both, pixels.

    Returns:
        Those of `openrooms_usd.channels.FLOWS`. ``flow``: (height, width, 2) pixels to the right
        and down; of the surroundings that of points infinitely far away; 0 where the point is
        behind the next camera. ``flow_visible``: (height, width, 1) 1 where the next frame shows
        the point, else 0.
    """
    width, height = size
    hits = first_hits(scene, tracer, camera, width, height)
    eye, R = after.world_from_camera[:3, 3], after.world_from_camera[:3, :3]
    world = camera.world_from_camera[:3, :3]
    toward = (camera.directions(width, height) @ world.T).reshape(-1, 3)
    far = np.full(len(toward), np.inf)
    toward[hits.pixels] = hits.position - eye
    far[hits.pixels] = np.linalg.norm(toward[hits.pixels], axis=1)
    local = toward @ R
    ahead = local[:, 2] > _NEAR_M
    image = local @ after.K.T / np.where(ahead, local[:, 2], 1.0)[:, None]
    place = image[:, :2]
    column, row = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    here = np.column_stack([column.ravel(), row.ravel()])
    flow = np.where(ahead[:, None], place - here, 0.0)
    inside = ahead & ((place >= 0.0) & (place <= (width, height))).all(axis=1)
    met = np.full(len(toward), np.inf)
    # Rays to points outside of the picture need not be cast.
    asked = np.where(inside[:, None], toward, 0.0)
    found = hits_along(scene, tracer, eye, asked, (height, width))
    met[found.pixels] = found.depth * np.linalg.norm(asked[found.pixels], axis=1)
    with np.errstate(invalid="ignore"):
        nothing_before = met >= far - _BEFORE_M - _BEFORE_SHARE * far
    seen = inside & np.where(np.isinf(far), np.isinf(met), nothing_before)
    planes = (flow.reshape(height, width, 2), seen.reshape(height, width, 1))
    return dict(zip(FLOWS, (plane.astype(np.float32) for plane in planes), strict=True))
