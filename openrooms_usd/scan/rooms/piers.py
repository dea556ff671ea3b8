"""Piers: walls that protrude into a room, with a side that a scan may miss.

The minimum cut charges for the missed side and may leave a pier out; full-height wall inside the
outline then shows where it is.
"""

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.rooms.occupancy import PIXEL_M
from openrooms_usd.scan.rooms.outline import Outline
from openrooms_usd.scan.rooms.spaces import Spaces

Array = NDArray[np.float64]

_MAX_DEPTH_M: Final = 2.0
# A freestanding wall has surfels, of its back or the floor, in more than this part of its pier.
_MAX_SCANNED_SHARE: Final = 0.3
_MIN_WALL_M: Final = 0.1
_MIN_EVIDENCE_PIXELS: Final = 0.25  # of a pixel's width


def with_piers(
    outline: Outline, spaces: Spaces, away: float, cost: Callable[[Outline], float]
) -> Outline:
    """Add rectangular piers around full-height wall inside, where that lowers the cost.

    Args:
        outline: The room so far.
        spaces: The map of the plan.
        away: Wall nearer to the outline than this is the outline's own, metres.
        cost: Of an outline.
    """
    for places in _standing_inside(outline, spaces, away):
        tries = [_pier(outline, wall, places) for wall in range(len(outline))]
        valid = [other for other in tries if other is not None and other.valid()]
        valid = [other for other in valid if _is_solid(outline, other, spaces, away)]
        if valid:
            best = min(valid, key=cost)
            outline = best if cost(best) < cost(outline) else outline
    return outline


def _standing_inside(outline: Outline, spaces: Spaces, away: float) -> list[Array]:
    """(P, 2) the pixels of each connected component of wall inside an outline."""
    import shapely
    from scipy import ndimage

    inner = shapely.Polygon(outline.corners()).buffer(-away, join_style="mitre")
    shapely.prepare(inner)
    inside = shapely.contains_xy(inner, spaces.centres()).reshape(spaces.standing.shape)
    strong = inside & (spaces.standing > _MIN_EVIDENCE_PIXELS * PIXEL_M)
    groups, count = ndimage.label(strong, np.ones((3, 3)))
    centres = spaces.centres()
    found = [groups.ravel() == number for number in range(1, count + 1)]
    weights = spaces.standing.ravel()
    return [centres[rows] for rows in found if weights[rows].sum() > _MIN_WALL_M]


def _is_solid(outline: Outline, other: Outline, spaces: Spaces, away: float) -> bool:
    """Whether the area that an outline cuts off has few surfels: else the wall is freestanding."""
    import shapely

    whole, rest = (shapely.Polygon(shape.corners()) for shape in (outline, other))
    within = shapely.contains_xy(whole.difference(rest).buffer(-away), spaces.centres())
    return not within.any() or float(spaces.scanned.ravel()[within].mean()) < _MAX_SCANNED_SHARE


def _pier(outline: Outline, wall: int, places: Array) -> Outline | None:
    """The outline with a rectangle around some places cut off at one of its walls."""
    corners = outline.corners()
    start, end = corners[wall], corners[(wall + 1) % len(outline)]
    normal = outline.normals[wall]
    along = np.array([-normal[1], normal[0]])
    depth = outline.offsets[wall] - places @ normal
    place = places @ along
    a, b, deep = place.min(), place.max(), float(depth.max())
    if deep > _MAX_DEPTH_M or a < start @ along - PIXEL_M or b > end @ along + PIXEL_M:
        return None
    normals = np.array([normal, along, normal, -along, normal])
    offset = outline.offsets[wall]
    offsets = np.array([offset, a, offset - deep, -b, offset])
    order = np.arange(len(outline))
    before, after = order < wall, order > wall
    return Outline(
        np.concatenate([outline.normals[before], normals, outline.normals[after]]),
        np.concatenate([outline.offsets[before], offsets, outline.offsets[after]]),
    )
