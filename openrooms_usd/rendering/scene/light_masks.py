"""Which pixels see each light."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.first_hits import Hits
from openrooms_usd.rendering.scene.pictures import Array
from openrooms_usd.rendering.scene.sources import GRAZING_COS, Source
from openrooms_usd.usd.cameras import PinholeCamera
from openrooms_usd.usd.light.lights import Portal

# What stands this near behind a rectangle belongs to the opening: its frame, its sill. Metres.
_REVEAL_DEPTH: Final = 0.5


def light_masks(
    scene: Scene, sources: Sequence[Source], camera: PinholeCamera, hits: Hits
) -> NDArray[np.float32]:
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
