"""How far what was scanned is from a camera, and how far a render is from that."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# A point covers that many times the usual distance to its neighbours, so that none shines through.
_COVER: Final = 2.0
# Points are thinned to this before, metres: finer than any scan's noise.
_VOXEL_M: Final = 0.02
# Distances to neighbours are measured at so many points.
_PROBES: Final = 2000
# The largest blocks that a point covers are 2 to this power, pixels.
_MAX_LEVEL: Final = 6
_NEAREST_M: Final = 0.1
# Depth that differs more among neighbouring pixels is an edge, which is not compared, relative.
_EDGE_SHARE: Final = 0.05
# Depth nearer to the scan than this counts as right, metres.
_RIGHT_M: Final = 0.1


@dataclass(frozen=True)
class DepthError:
    """How a render's depth differs from the scan's.

    Attributes:
        median: Of the absolute difference, metres.
        bias: Median of render minus scan, metres.
        right: Share of pixels that differ by less than 10 cm.
        seen: Share of the picture in which both are known.
    """

    median: float
    bias: float
    right: float
    seen: float

    def as_dict(self) -> dict[str, float]:
        """With four digits."""
        return {
            "median_m": round(self.median, 4),
            "bias_m": round(self.bias, 4),
            "within_10_cm": round(self.right, 4),
            "share_of_picture": round(self.seen, 4),
        }


def spacing(points: Array) -> tuple[Array, float]:
    """Thin points out, and say how far neighbours usually are from each other.

    Args:
        points: (N, 3) metres.

    Returns:
        (M, 3) the points that stay, and the distance, metres.
    """
    from scipy.spatial import KDTree

    _, first = np.unique(np.floor(points / _VOXEL_M).astype(np.int64), axis=0, return_index=True)
    kept = points[np.sort(first)]
    probes = kept[:: max(1, len(kept) // _PROBES)]
    near = KDTree(kept).query(probes, k=min(4, len(kept)))[0]
    return kept, float(np.median(np.atleast_2d(near)[:, -1]))


def scan_depth(
    points: Array, apart: float, K: Array, world_from_camera: Array, size: tuple[int, int]
) -> Array:
    """The depth of points along the optical axis, each as a square that meets its neighbours.

    Args:
        points: (N, 3) world, metres.
        apart: The usual distance between neighbours, metres.
        K: (3, 3) intrinsics, pixels.
        world_from_camera: (4, 4), OpenCV.
        size: Width and height, pixels.

    Returns:
        (H, W) metres; 0 where no point is, and at edges of depth.
    """
    width, height = size
    camera_from_world = np.linalg.inv(world_from_camera)
    seen = points @ camera_from_world[:3, :3].T + camera_from_world[:3, 3]
    seen = seen[seen[:, 2] > _NEAREST_M]
    x, y, z = (seen @ K.T).T
    column, row = x / z, y / z
    level = np.clip(np.ceil(np.log2(_COVER * apart * K[0, 0] / z)), 0, _MAX_LEVEL).astype(int)
    depth = np.full((height, width), np.inf)
    for power in range(_MAX_LEVEL + 1):
        side = 2**power
        shape = -(-height // side), -(-width // side)
        i, j = np.floor(row / side).astype(int), np.floor(column / side).astype(int)
        of = (level == power) & (i >= 0) & (j >= 0) & (i < shape[0]) & (j < shape[1])
        block = _nearest(i[of] * shape[1] + j[of], z[of], shape[0] * shape[1]).reshape(shape)
        block = _closed(block)
        large = block.repeat(side, axis=0).repeat(side, axis=1)[:height, :width]
        depth = np.minimum(depth, large)
    depth[~np.isfinite(depth)] = 0.0
    return np.where(_is_smooth(depth), depth, 0.0)


def _nearest(cell: NDArray[np.int64], z: Array, count: int) -> Array:
    """(count,) mean depth of the nearest surface in each cell; infinite where there is none."""
    first = np.full(count, np.inf)
    np.minimum.at(first, cell, z)
    front = z <= (1.0 + _EDGE_SHARE) * first[cell]
    total = np.bincount(cell[front], z[front], count)
    number = np.bincount(cell[front], minlength=count)
    return np.asarray(np.where(number > 0, total / np.maximum(number, 1), np.inf))


def _closed(block: Array) -> Array:
    """Cells that chance left empty among others have the mean depth of those around them."""
    from scipy.ndimage import uniform_filter

    known = np.isfinite(block)
    around = uniform_filter(known.astype(np.float64), 3, mode="constant")
    total = uniform_filter(np.where(known, block, 0.0), 3, mode="constant")
    filled = ~known & (around > 0.5)
    return np.asarray(np.where(filled, total / np.maximum(around, 1e-9), block))


def _is_smooth(depth: Array) -> Mask:
    from scipy.ndimage import maximum_filter, minimum_filter

    low, high = minimum_filter(depth, 3), maximum_filter(depth, 3)
    return np.asarray((low > 0.0) & (high - low < _EDGE_SHARE * high))


def depth_error(rendered: Array, scanned: Array) -> DepthError | None:
    """How a render's depth differs from the scan's.

    Args:
        rendered: (H, W) metres; 0 where there is nothing.
        scanned: The same of the scan.

    Returns:
        None where they have no pixel in common.
    """
    both = (rendered > 0.0) & (scanned > 0.0)
    if not both.any():
        return None
    off = rendered[both] - scanned[both]
    return DepthError(
        median=float(np.median(np.abs(off))),
        bias=float(np.median(off)),
        right=float((np.abs(off) < _RIGHT_M).mean()),
        seen=float(both.mean()),
    )
