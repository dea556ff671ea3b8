"""What one exact ray through each pixel's centre tells: geometry, materials, labels, and flow."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.channels import FLOWS, numbered
from openrooms_usd.rendering.contract import GUIDES, Image, RenderRequest, View
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.first_hits import Hits, first_hits, hits_along
from openrooms_usd.rendering.scene.ground_truth import GroundTruth
from openrooms_usd.rendering.scene.rays import RayTracer
from openrooms_usd.rendering.scene.sources import GRAZING_COS, Source
from openrooms_usd.usd.cameras import PinholeCamera
from openrooms_usd.usd.light.lights import Portal

# What stands this near behind a rectangle belongs to the opening: its frame, its sill. Metres.
_REVEAL_DEPTH: Final = 0.5
# What a ray to a point meets so little before it is the point; metres, and relative.
_BEFORE_M: Final = 1e-3
_BEFORE_SHARE: Final = 1e-4
# Nearer to the next camera's plane, nothing is projected; metres.
_NEAR_M: Final = 1e-6
# Guides are looked up at so many by so many places of a pixel.
_GUIDED_PLACES: Final = 2


def exact_images(
    scene: Scene,
    tracer: RayTracer,
    sources: Sequence[Source],
    camera: PinholeCamera,
    size: tuple[int, int],
    channels: Sequence[str],
) -> dict[str, Image]:
    """Exact channels of a camera; the ray that all share is in the time of each.

    Args:
        scene: What is seen.
        tracer: Finds the triangles.
        sources: The lights, by their numbers.
        camera: For the size.
        size: Width and height, pixels.
        channels: Names from `openrooms_usd.rendering.given.EXACT`.

    Returns:
        By channel; of ``mask_i`` one for each light.
    """
    if not channels:
        return {}
    start = time.perf_counter()
    hits = first_hits(scene, tracer, camera, *size)
    truth = GroundTruth(scene, camera, hits)
    shared = time.perf_counter() - start
    images: dict[str, Image] = {}
    for name in channels:
        start = time.perf_counter()
        if name == "mask_i":
            masks = light_masks(scene, sources, camera, hits)
            made = {numbered(name, light): mask for light, mask in enumerate(masks)}
        else:
            made = {name: truth.channel(name)}
        seconds = shared + time.perf_counter() - start
        for single, pixels in made.items():
            images[single] = Image(pixels, 1, seconds, 0.0, robust_error=0.0)
    return images


def flow_images(
    scene: Scene,
    tracer: RayTracer,
    camera: PinholeCamera,
    after: PinholeCamera,
    size: tuple[int, int],
) -> dict[str, Image]:
    """Where what a frame of a path sees is in the next frame (`openrooms_usd.channels.FLOWS`).

    Args:
        scene: What is seen.
        tracer: Finds the triangles.
        camera: Of the frame, for the size.
        after: Of the next frame, likewise.
        size: Width and height, pixels.
    """
    start = time.perf_counter()
    made = optical_flow(scene, tracer, camera, after, size)
    seconds = time.perf_counter() - start
    return {name: Image(pixels, 1, seconds, 0.0, robust_error=0.0) for name, pixels in made.items()}


def fine_guides(
    picture: Callable[[PinholeCamera, RenderRequest], View],
    camera: PinholeCamera,
    request: RenderRequest,
) -> dict[str, Floats]:
    """What a denoiser is guided by, where the renderer does not give it: means over whole pixels.

    Args:
        picture: Renders channels of a camera.
        camera: For the request's size.
        request: Its size.

    Returns:
        (height, width, 3) by channel of `openrooms_usd.rendering.contract.GUIDES`.
    """
    n, height, width = _GUIDED_PLACES, request.height, request.width
    fine = replace(camera, K=np.diag([n, n, 1.0]) @ camera.K)
    asked = replace(request, channels=GUIDES, width=n * width, height=n * height, guides=False)
    images = picture(fine, asked).images
    return {
        name: images[name].pixels.reshape(height, n, width, n, -1).mean(axis=(1, 3))
        for name in GUIDES
    }


# Nothing in a room moves but the camera, so the flow of a pixel's centre follows from the exact
# point that it sees and from the next camera. Whether that camera sees the point is asked by a
# ray of its own, not by the depth of its pixels: at the edges of things those tell of their
# neighbours.
def optical_flow(
    scene: Scene,
    tracer: RayTracer,
    camera: PinholeCamera,
    after: PinholeCamera,
    size: tuple[int, int],
) -> dict[str, Floats]:
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


def light_masks(
    scene: Scene, sources: Sequence[Source], camera: PinholeCamera, hits: Hits
) -> Floats:
    """Where the pixels' centres see each light.

    A lamp is seen where its object is. An opening is seen where the ray leaves through its
    rectangle, of several the last, and meets nothing but what is well outside.

    Args:
        scene: The arrays.
        sources: Its lights.
        camera: What sees them.
        hits: What its pixels' centres meet.

    Returns:
        (L, height, width, 1) 1 where it is seen, else 0; of ``elsewhere`` where the surroundings
        are seen past all openings.
    """
    height, width = hits.shape
    origins, directions = camera.rays(width, height)
    end = np.full(len(directions), np.inf)
    end[hits.pixels] = hits.depth
    instance = np.zeros(len(directions), dtype=np.int64)
    numbers = np.array([piece.instance for piece in scene.pieces] or [0])
    instance[hits.pixels] = numbers[scene.triangles.rows(hits.rows).pieces]
    left = _left_through(sources, origins, directions, end)
    masks = [
        instance == scene.pieces[int(scene.patches[source.patches[0]].triangles.pieces[0])].instance
        if source.kind == "lamp"
        else left == number
        for number, source in enumerate(sources)
    ]
    return np.stack(masks).reshape(len(sources), height, width, 1).astype(np.float32)


def _left_through(sources: Sequence[Source], origins: Array, directions: Array, end: Array) -> Any:
    """(R,) the light that is the outside in each pixel; -1 where the room is seen."""
    found = np.where(np.isinf(end), len(sources) - 1, -1)
    farthest = np.full(len(directions), -1.0)
    for number, source in enumerate(sources):
        if source.portal is not None:
            t, through = _meet(source.portal, origins, directions, end)
            last = through & (t > farthest)
            found, farthest = np.where(last, number, found), np.where(last, t, farthest)
    return found


def _meet(portal: Portal, origins: Array, directions: Array, end: Array) -> tuple[Array, Any]:
    """Where rays meet a portal's plane, and whether they leave the room through it."""
    world = portal.world_from_portal
    slope = directions @ world[:3, 2]
    outwards = slope > GRAZING_COS
    t = (world[:3, 3] - origins) @ world[:3, 2] / np.where(outwards, slope, 1.0)
    at = (origins + t[:, None] * directions - world[:3, 3]) @ world[:3, :2]
    within = (np.abs(at) <= 0.5 * np.array([portal.width, portal.height])).all(axis=1)
    outside = end > t + _REVEAL_DEPTH / np.where(outwards, slope, 1.0)
    return t, outwards & within & (t >= 0.0) & outside
