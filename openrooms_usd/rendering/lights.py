"""The lights of a scene as one camera has them."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.rendering.rle import tight_box
from openrooms_usd.rendering.scene.lights import LightRecord, plain

Array = NDArray[np.float64]

# Nearer to the camera's plane nothing is projected, metres.
_NEAR_PLANE_M: Final = 1e-3
# OpenCV axes (right, down, forward) in OpenGL's (right, up, backward).
_OPENGL: Final = np.diag([1.0, -1.0, -1.0, 1.0])
# The corners of a box about 0, and the pairs of them that are edges.
_CORNERS: Final = np.array(
    [[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
)
_EDGES: Final = np.array([[i, i | bit] for i in range(8) for bit in (1, 2, 4) if not i & bit])


def view_lights(
    records: Sequence[LightRecord],
    K: NDArray[np.float64],
    world_from_camera: NDArray[np.float64],
    size: tuple[int, int],
    masks: Mapping[int, NDArray[Any]],
) -> list[dict[str, Any]]:
    """The lights as one camera has them, for its entry of the manifest.

    Args:
        records: All lights.
        K: (3, 3) intrinsics, pixels.
        world_from_camera: (4, 4) from the OpenCV camera frame.
        size: Width and height of the picture.
        masks: By number, (height, width, 1) images of ``mask_i``, where they were asked for.

    Returns:
        For each light its ``number``; its box as ``camera_from_box`` in the OpenCV frame and
        ``opengl_from_box`` in OpenGL's; ``box2d_projected``: left, top, right, bottom of the box as
        if nothing hid it, cut off at the edges of the picture, empty where it is not in it; and
        where there is a mask ``box2d`` of its pixels, right and bottom exclusive, empty where
        there are none. ``elsewhere`` has no boxes.
    """
    camera_from_world: Array = np.linalg.inv(world_from_camera).astype(np.float64)
    return [_in_view(record, K, camera_from_world, size, masks) for record in records]


def _in_view(
    record: LightRecord,
    K: Array,
    camera_from_world: Array,
    size: tuple[int, int],
    masks: Mapping[int, NDArray[Any]],
) -> dict[str, Any]:
    entry: dict[str, Any] = {"number": record.number}
    if record.kind != "elsewhere":
        pose = camera_from_world @ record.world_from_box
        entry["camera_from_box"] = plain(pose)
        entry["opengl_from_box"] = plain(_OPENGL @ pose)
        corners = (_CORNERS * record.size) @ pose[:3, :3].T + pose[:3, 3]
        entry["box2d_projected"] = _projected(corners[_EDGES], K, size)
    if record.number in masks:
        mask = masks[record.number][..., 0] > 0.5
        entry["box2d"] = list(tight_box(mask)) if mask.any() else []
    return entry


def _projected(edges: Array, K: Array, size: tuple[int, int]) -> list[float]:
    """Left, top, right, bottom of edges (E, 2, 3) in the picture; empty where none are."""
    deep = edges[..., 2] >= _NEAR_PLANE_M
    crossing = edges[deep[:, 0] != deep[:, 1]]
    share = (_NEAR_PLANE_M - crossing[:, 0, 2]) / (crossing[:, 1, 2] - crossing[:, 0, 2])
    cut = crossing[:, 0] + share[:, None] * (crossing[:, 1] - crossing[:, 0])
    points = np.concatenate([edges[deep], cut]) @ K.T
    if not len(points):
        return []
    places = points[:, :2] / points[:, 2:]
    low, high = (np.clip(edge, 0.0, size) for edge in (places.min(axis=0), places.max(axis=0)))
    inside = bool((places.max(axis=0) > 0.0).all() and (places.min(axis=0) < size).all())
    box: list[float] = np.round([*low, *high], 3).tolist()
    return box if inside else []
