"""Where the surfaces of a frame were seen in an earlier one, by exact positions.

A point of a surface is projected into the earlier camera. The four pixels around it count, by
their bilinear weights, as far as they see the same surface: the same object, at the same place of
its plane, facing the same way. What was hidden then, or outside the picture, has no weight.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Floats, Ints, Mask
from openrooms_usd.geometry.pinhole import pixel_directions
from openrooms_usd.rendering.contract import View

CHANNELS: Final = ("position", "normal_geometric", "instance", "valid")

_LEAST_NORMAL_COS: Final = 0.9
# Off the surface's plane, relative to the distance from the camera.
_MOST_OFF_PLANE_SHARE: Final = 0.01
# History with a smaller weight is dropped.
_LEAST_WEIGHT: Final = 0.05
# Where there is no surface, the surroundings: as good as infinitely far.
_SKY_M: Final = 1e5


@dataclass(frozen=True, eq=False)
class VisibleSurfaces:
    """What the pixels' centres of a frame see, row by row.

    Attributes:
        K: (3, 3) intrinsics.
        world_from_camera: (4, 4) pose.
        shape: Height and width.
        position: (P, 3) world, metres.
        normal: (P, 3) of the faces; 0 for the surroundings.
        instance: (P,) numbers of objects; 0 for the surroundings.
        distance: (P,) from the camera, metres.
    """

    K: Array
    world_from_camera: Array
    shape: tuple[int, int]
    position: Array
    normal: Array
    instance: Ints
    distance: Array

    @staticmethod
    def of(view: View) -> "VisibleSurfaces":
        """Those of a view that has `CHANNELS`."""
        position, normal, instance, valid = (view.images[name].pixels for name in CHANNELS)
        seen = valid[..., 0].ravel() > 0
        R, eye = view.world_from_camera[:3, :3], view.world_from_camera[:3, 3]
        rays = pixel_directions(view.K, view.width, view.height).reshape(-1, 3) @ R.T
        far = eye + _SKY_M * rays
        place = np.where(seen[:, None], position.reshape(-1, 3).astype(np.float64), far)
        return VisibleSurfaces(
            view.K,
            view.world_from_camera,
            (view.height, view.width),
            place,
            np.where(seen[:, None], normal.reshape(-1, 3), 0.0).astype(np.float64),
            np.where(seen, instance[..., 0].ravel(), 0).astype(np.int64),
            np.linalg.norm(place - eye, axis=1),
        )


@dataclass(frozen=True, eq=False)
class Taps:
    """The pixels of an earlier frame that saw what those of a frame see.

    Attributes:
        rows: (P, 4) numbers of pixels.
        weights: (P, 4) that add up to 1; all 0 where nothing of it was seen.
    """

    rows: Ints
    weights: Floats

    @property
    def found(self) -> Mask:
        """(P,) where the earlier frame saw it."""
        return np.asarray(self.weights.any(axis=1))

    def __call__(self, values: Floats) -> Floats:
        """(P, ...) the weighted means of the earlier frame's (P, ...) values."""
        gathered = values[self.rows]
        weights = self.weights.reshape(*self.weights.shape, *[1] * (values.ndim - 1))
        return np.asarray((gathered * weights).sum(axis=1), dtype=np.float32)


def reproject(now: VisibleSurfaces, before: VisibleSurfaces) -> Taps:
    """Find what a frame sees in an earlier one of the same size."""
    height, width = before.shape
    R, eye = before.world_from_camera[:3, :3], before.world_from_camera[:3, 3]
    local = (now.position - eye) @ R
    ahead = local[:, 2] > 1e-6
    depth = np.where(ahead, local[:, 2], 1.0)
    x = before.K[0, 0] * local[:, 0] / depth + before.K[0, 2] - 0.5
    y = before.K[1, 1] * local[:, 1] / depth + before.K[1, 2] - 0.5
    # A camera that stands still meets the pixels' centres: no neighbour by rounding.
    x, y = (np.where(np.abs(c - np.rint(c)) < 1e-4, np.rint(c), c) for c in (x, y))
    ahead &= (x > -1) & (y > -1) & (x < width) & (y < height)
    column, row = (np.where(ahead, np.floor(c), 0).astype(np.int64) for c in (x, y))
    right, down = np.where(ahead, x - column, 0.0), np.where(ahead, y - row, 0.0)
    rows, weights = [], []
    for i, across in ((0, 1 - right), (1, right)):
        for j, along in ((0, 1 - down), (1, down)):
            inside = (column + i >= 0) & (row + j >= 0) & (column + i < width) & (row + j < height)
            place = np.clip(row + j, 0, height - 1) * width + np.clip(column + i, 0, width - 1)
            same = ahead & inside & _same(now, before, place)
            rows.append(place)
            weights.append(np.where(same, across * along, 0.0))
    found = np.stack(weights, axis=1)
    total = found.sum(axis=1, keepdims=True)
    known = total > _LEAST_WEIGHT
    shares = np.divide(found, total, out=np.zeros_like(found), where=known)
    return Taps(np.stack(rows, axis=1), shares.astype(np.float32))


def _same(now: VisibleSurfaces, before: VisibleSurfaces, place: Ints) -> Mask:
    """Whether each pixel of a frame sees the surface that a pixel of an earlier one saw."""
    instance = now.instance == before.instance[place]
    sky = now.instance == 0
    facing = np.einsum("ij,ij->i", now.normal, before.normal[place]) > _LEAST_NORMAL_COS
    off = np.abs(np.einsum("ij,ij->i", now.normal, before.position[place] - now.position))
    return np.asarray(instance & (sky | facing & (off < _MOST_OFF_PLANE_SHARE * now.distance)))
