"""Returns counted over the cells of a wall, in windows as wide as the scan is sparse."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.scan.points.cloud import Cloud

CELL_M: Final = 0.025  # metres
# Cells with less than this part of the wall's usual number of returns are empty.
_EMPTY_CELL_SHARE: Final = 0.2
# Windows in which returns are counted, cells: the smallest that usually holds so many of them. A
# scan with returns every six centimetres shows nothing in cells of half of that.
WINDOWS_CELLS: Final = (3, 5, 7, 9)
_RETURNS_IN_WINDOW: Final = 4.0
_BLOCK_CELLS: Final = 10
# Radius of the local mean of returns, because density varies, metres.
_DENSITY_RADIUS_M: Final = 0.25
# Where the usual number of returns of a cell is less than this, the scan is sparse.
_MIN_USUAL_COUNT: Final = 0.5
# NYU40.
DOOR, WINDOW, BLINDS, CURTAIN = 8, 9, 13, 16
OPENING_LABELS: Final = (DOOR, WINDOW, BLINDS, CURTAIN)
# Returns labelled door this far before the wall belong to a leaf that was opened against it, not to
# a door in this wall. The distance grows by this many standard deviations of the wall's returns
# (drift doubles walls).
_LEAF_ASIDE_M: Final = 0.12
_DRIFT_SIGMAS: Final = 2.0
# Labels count of returns with normals within 25 degrees of the wall's.
_LABEL_FACING_COS: Final = float(np.cos(np.radians(25.0)))
# Largest distance of a wall's own returns, in the room and behind it, metres.
REACH_M: Final = 0.35
# Resolution of the map of nearest walls, metres.
_PLAN_CELL_M: Final = 0.02


@dataclass(frozen=True, eq=False)
class WallFace:
    """The inner face of a wall in the plan.

    Attributes:
        number: From corner ``number`` of the room to the next.
        left: (2,) its left end, seen from inside.
        along: (2,) unit vector to the right.
        length: Metres.
    """

    number: int
    left: Array
    along: Array
    length: float

    @property
    def outward(self) -> Array:
        """(2,) unit vector away from the room."""
        return np.array([-self.along[1], self.along[0]])

    def from_level(self, points: Array) -> Array:
        """Transform (N, 3) points from the level frame to the wall's."""
        offset = points[:, :2] - self.left
        return np.column_stack([offset @ self.along, offset @ self.outward, points[:, 2]])

    def to_level(self, points: Array) -> Array:
        """Transform (N, 3) points from the wall's frame to the level frame."""
        plan = self.left + points[:, :1] * self.along + points[:, 1:2] * self.outward
        return np.column_stack([plan, points[:, 2]])


def faces_of(corners: Array) -> tuple[WallFace, ...]:
    """The inner faces of a room's walls.

    Args:
        corners: (N, 2) counter-clockwise, metres.
    """
    # Counter-clockwise edges run from right to left, seen from inside.
    lefts = np.roll(corners, -1, axis=0)
    lengths = np.linalg.norm(corners - lefts, axis=1)
    return tuple(
        WallFace(i, lefts[i], (corners[i] - lefts[i]) / max(lengths[i], 1e-9), float(lengths[i]))
        for i in range(len(corners))
    )


def nearest_walls(points: Array, corners: Array, faces: Sequence[WallFace]) -> NDArray[np.int16]:
    """The wall that each point is closest to in the plan.

    Args:
        points: (N, 3) in the level frame.
        corners: (M, 2) of the room.
        faces: Its walls.

    Returns:
        (N,) their numbers, to two centimetres; -1 where none is within reach.
    """
    low = corners.min(axis=0) - REACH_M - _PLAN_CELL_M
    shape = np.ceil((corners.max(axis=0) + REACH_M - low) / _PLAN_CELL_M).astype(np.int64) + 1
    x, y = (
        start + _PLAN_CELL_M * (np.arange(n) + 0.5) for start, n in zip(low, shape, strict=True)
    )
    places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    best = np.full(shape, REACH_M)
    nearest = np.full(shape, -1, dtype=np.int16)
    for face in faces:
        along, out = (places - face.left) @ face.along, (places - face.left) @ face.outward
        away = np.hypot(np.maximum(np.maximum(-along, along - face.length), 0.0), out)
        closer = away < best
        best[closer], nearest[closer] = away[closer], face.number
    # Points beyond the map are clamped to its outermost cells, which are out of reach.
    cells = [
        np.clip((points[:, i] - low[i]) / _PLAN_CELL_M, 0, shape[i] - 1).astype(np.int64)
        for i in (0, 1)
    ]
    return np.asarray(nearest[cells[0], cells[1]])


def window_of(counts: Array) -> int:
    """The least window that usually holds some returns, where there are any."""
    rows, columns = (size // _BLOCK_CELLS * _BLOCK_CELLS for size in counts.shape)
    blocks = counts[:rows, :columns].reshape(
        rows // _BLOCK_CELLS, _BLOCK_CELLS, columns // _BLOCK_CELLS, _BLOCK_CELLS
    )
    returns = blocks.mean(axis=(1, 3))
    usual = float(np.median(returns[returns > 0])) if (returns > 0).any() else 1.0
    enough = (edge for edge in WINDOWS_CELLS if edge**2 * usual >= _RETURNS_IN_WINDOW)
    return next(enough, WINDOWS_CELLS[-1])


def layers_of(layers: Sequence[Array], window: int) -> tuple[Mask, Mask, Mask]:
    """Masks: the face returned; only surfaces behind it; only surfaces before it.

    Args:
        layers: (Z, X) returns on the face, behind it and before it.
        window: Edge of the windows in which they are counted, cells.
    """
    on, behind, before = (
        ndimage.uniform_filter(counts, window, mode="nearest") for counts in layers
    )
    usual = usual_counts(layers[0], on)
    present = on + behind > _EMPTY_CELL_SHARE * usual
    solid = present & ((on > behind) | (on > 0.5 * usual))
    return solid, present & ~solid, ~present & (before > _EMPTY_CELL_SHARE * usual)


def usual_counts(counts: Array, smooth: Array) -> Array:
    """Local mean of returns over the cells that have any.

    Args:
        counts: (Z, X) returns of each cell.
        smooth: (Z, X) their means over neighbours.
    """
    some = counts > 0
    if not some.any():
        return np.ones(counts.shape)
    total, cells = (
        ndimage.gaussian_filter(part, _DENSITY_RADIUS_M / CELL_M, mode="nearest")
        for part in (counts, some.astype(np.float64))
    )
    here = total / np.maximum(cells, 1e-3)
    middle = float(np.median(smooth[some]))
    least = min(_MIN_USUAL_COUNT, middle)
    return np.asarray(np.clip(here, least, max(least, middle)))


def cell_means(cells: Ints, values: Array, shape: tuple[int, int], window: int) -> Array:
    """(Z, X) means of values over windows around each cell; NaN without returns."""
    counts = counted(cells, shape)
    total = np.bincount(cells, values, shape[0] * shape[1]).reshape(shape).astype(np.float64)
    counts, total = (
        ndimage.uniform_filter(part, window, mode="constant") for part in (counts, total)
    )
    known = counts > 0.5 / window**2
    return np.where(known, total / np.where(known, counts, 1.0), np.nan)


def cells_of(x: Array, z: Array, shape: tuple[int, int]) -> Ints:
    """(N,) the cell of each place on a wall, in rows from the floor."""
    row = np.clip((z / CELL_M).astype(np.int64), 0, shape[0] - 1)
    return row * shape[1] + np.clip((x / CELL_M).astype(np.int64), 0, shape[1] - 1)


def counted(cells: Ints, shape: tuple[int, int]) -> Array:
    """(Z, X) the returns of each cell."""
    return np.bincount(cells, minlength=shape[0] * shape[1]).reshape(shape).astype(np.float64)


def label_counts(
    cloud: Cloud,
    out: Array,
    near: float,
    deviation: float,
    cells: Ints,
    face: WallFace,
    shape: tuple[int, int],
) -> tuple[dict[int, Array], Array]:
    """The labels of openings over the cells of a wall.

    Only returns with the wall's normal count, and those of the sides of holes in it; of a leaf
    that was opened against the wall none does.

    Args:
        cloud: N returns near the wall.
        out: (N,) their distances behind its face, metres.
        near: Least distance of what is behind it, metres.
        deviation: Root mean squared residual of the wall's plane, metres.
        cells: (N,) their cells.
        face: The wall.
        shape: Rows and columns of its grid.

    Returns:
        (Z, X) counts for each label of openings, and for all labels.
    """
    if cloud.label is None:
        return {}, np.zeros(shape)
    own = (cloud.label != DOOR) | (out > -_LEAF_ASIDE_M - _DRIFT_SIGMAS * deviation)
    if cloud.normals is not None:
        facing = np.abs(cloud.normals[:, :2] @ face.outward) > _LABEL_FACING_COS
        own &= (out >= near) | facing
    cells, label = cells[own], cloud.label[own]
    counts = {number: counted(cells[label == number], shape) for number in OPENING_LABELS}
    return counts, counted(cells[label > 0], shape)
