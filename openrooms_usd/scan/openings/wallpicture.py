"""Evidence grids of walls: returns from the plane, returns from behind it, and voids.

Every wall has its own frame: x to the right along its inner face, y outwards, z up. A cell is solid
(the wall returned), a recess (a return from behind), a void (sensors looked through without a
return), or unknown (occluded by furniture).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from openrooms_usd.scan.openings.wallfaces import WallFace, faces_of, nearest_walls
from openrooms_usd.scan.openings.wallviews import wall_views
from openrooms_usd.scan.openings.wallvoids import enclosed
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.sightlines import Sight

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Rows = NDArray[np.int64]

CELL_M: Final = 0.025  # metres
# Inlier distance of the plane: so many standard deviations, clipped to these limits.
_RETURN_SIGMAS: Final = 4.0
_ON_WALL_LIMITS_M: Final = (0.02, 0.045)
# Largest protrusion, and largest recess, that relief measures.
_RELIEF_LIMITS_M: Final = (0.045, 0.12)
# A colour difference of 15 in 255 counts as a step of three millimetres.
_TINT_STEP_M: Final = 0.003 / 15.0
# Returns up to this far from the initial plane take part in its refit.
_PLANE_REFIT_M: Final = 0.12
_PLANE_REFIT_ROUNDS: Final = 6
# Cells with less than this part of the wall's usual number of returns are empty.
_EMPTY_CELL_SHARE: Final = 0.2
# Windows in which returns are counted, cells: the smallest that usually holds so many of them. A
# scan with returns every six centimetres shows nothing in cells of half of that.
_WINDOWS_CELLS: Final = (3, 5, 7, 9)
_RETURNS_IN_WINDOW: Final = 4.0
_BLOCK_CELLS: Final = 10
# Radius of the local mean of returns, because density varies, metres.
_DENSITY_RADIUS_M: Final = 0.25
# Where the usual number of returns of a cell is less than this, the scan is sparse.
_MIN_USUAL_COUNT: Final = 0.5
# Number of sensors that look through a cell from which on it is a certain void.
_SURE_SENSORS: Final = 3.0
# Labels count of returns with normals within 25 degrees of the wall's.
_LABEL_FACING_COS: Final = float(np.cos(np.radians(25.0)))


@dataclass(frozen=True, eq=False)
class WallGrid:
    """The evidence grid of a wall: rows from the floor upwards, columns to the right.

    Attributes:
        face: The wall.
        solid: (Z, X) where the wall's face returned.
        recess: (Z, X) where only surfaces a few centimetres behind it returned.
        void: (Z, X) confidence from 0 to 1 that sensors looked through without a return.
        relief: (Z, X) mean protrusion of returns into the room from the wall's plane, metres;
            negative where they are recessed, NaN without returns near the plane.
        tint: (Z, X) colour of the face along its principal axis, scaled to metres of relief; NaN
            without returns or colours.
        labels: For each requested class, (Z, X) the number of returns near the wall with it.
        labelled: (Z, X) the number of returns near the wall with any label.
        threshold: (X,) whether floor was seen just behind the wall's plane.
        deviation: Root mean squared residual of the wall's plane, metres.
        window: Edge of the windows in which returns are counted, cells; larger in sparse scans.
        before: (Z, X) where something stands before the wall.
        beyond: (Z, X) where sensors looked through it at something far behind.
    """

    face: WallFace
    solid: Mask
    recess: Mask
    void: Array
    relief: Array
    tint: Array
    labels: dict[int, Array]
    labelled: Array
    threshold: Mask
    deviation: float
    window: int
    before: Mask
    beyond: Mask

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.solid.shape[0], self.solid.shape[1]


def wall_grids(
    cloud: Cloud, corners: Array, height: float, classes: Sequence[int], sight: Sight
) -> Iterator[WallGrid]:
    """The evidence grids of a room's walls, one after the other.

    Args:
        cloud: In the level frame.
        corners: (N, 2) counter-clockwise.
        height: Of the walls, metres.
        classes: Labels that are counted.
        sight: Sensors and occlusion.
    """
    faces = faces_of(corners)
    nearest = nearest_walls(cloud.points, corners, faces)
    order = np.argsort(nearest, kind="stable")
    ends = np.searchsorted(nearest[order], np.arange(len(faces) + 1))
    for face, first, last in zip(faces, ends, ends[1:], strict=False):
        if face.length > 4 * CELL_M:
            own = cloud.take(order[first:last])
            yield _grid(own, cloud.points, face, height, classes, sight)


def _grid(
    cloud: Cloud, points: Array, face: WallFace, height: float, classes: Sequence[int], sight: Sight
) -> WallGrid:
    shape = (max(round(height / CELL_M), 8), max(round(face.length / CELL_M), 4))
    x, y, z = face.from_level(cloud.points).T
    inside = (x > 0) & (x < face.length) & (z > -0.1) & (z < height)
    cloud, x, y, z = cloud.take(inside), x[inside], y[inside], z[inside]
    plane, deviation = _plane(x, y, z)
    y = y - plane[0] - plane[1] * x - plane[2] * z
    cell = _cells(x, z, shape)
    above = z > 0
    inner = above & ~_other_side(cloud, face, y)
    near = float(np.clip(_RETURN_SIGMAS * deviation, *_ON_WALL_LIMITS_M))
    on, behind, before = above & (np.abs(y) < near), inner & (y >= near), above & (y <= -near)
    layers = [_counted(cell[kind], shape) for kind in (on, behind, before)]
    window = _window(layers[0])
    solid, recess, covered = _layers(layers, window)
    face_like = inner & (y > -_RELIEF_LIMITS_M[0]) & (y < _RELIEF_LIMITS_M[1])
    relief = _mean_depth(cell[face_like], -y[face_like], shape, window - 2)
    tint = _mean_depth(cell[face_like], _tints(cloud, face_like), shape, window - 2)
    labels, labelled = _label_counts(cloud, cell, above, y >= near, face, classes, shape)
    floor = (np.abs(z) < 2 * CELL_M) & (y > 0.1)
    threshold = _counted(cell[floor], shape).sum(axis=0) > 0
    standing = solid | recess
    seen = _seen_through(~(standing | covered), face, plane, sight)
    void = np.where(enclosed(seen > 0, standing), seen, 0.0)
    views = wall_views(points, face, shape, CELL_M, window, sight)
    beyond = views.beyond & (void > 0)
    return WallGrid(
        face, solid, recess, void, relief, tint, labels, labelled, threshold, deviation, window,
        views.before, beyond,
    )  # fmt: skip


def _window(counts: Array) -> int:
    """The least window that usually holds some returns, where there are any."""
    rows, columns = (size // _BLOCK_CELLS * _BLOCK_CELLS for size in counts.shape)
    blocks = counts[:rows, :columns].reshape(
        rows // _BLOCK_CELLS, _BLOCK_CELLS, columns // _BLOCK_CELLS, _BLOCK_CELLS
    )
    returns = blocks.mean(axis=(1, 3))
    usual = float(np.median(returns[returns > 0])) if (returns > 0).any() else 1.0
    enough = (edge for edge in _WINDOWS_CELLS if edge**2 * usual >= _RETURNS_IN_WINDOW)
    return next(enough, _WINDOWS_CELLS[-1])


def _mean_depth(cells: Rows, values: Array, shape: tuple[int, int], window: int) -> Array:
    counts = _counted(cells, shape)
    total = np.bincount(cells, values, shape[0] * shape[1]).reshape(shape).astype(np.float64)
    counts, total = (
        ndimage.uniform_filter(part, window, mode="constant") for part in (counts, total)
    )
    known = counts > 0.5 / window**2
    return np.where(known, total / np.where(known, counts, 1.0), np.nan)


def _tints(cloud: Cloud, on: Mask) -> Array:
    """Colours of a wall's returns projected on their principal axis."""
    if cloud.colors is None or not on.any():
        return np.full(int(on.sum()), np.nan)
    colors = cloud.colors[on].astype(np.float64)
    colors -= colors.mean(axis=0)
    axis = np.linalg.eigh(colors.T @ colors)[1][:, -1]
    return np.asarray(_TINT_STEP_M * (colors @ (axis if axis.sum() >= 0 else -axis)))


def _other_side(cloud: Cloud, face: WallFace, y: Array) -> Mask:
    """Returns of a wall's other face, scanned from another room."""
    if cloud.normals is None:
        return np.zeros(len(y), dtype=np.bool_)
    return np.asarray((y > _ON_WALL_LIMITS_M[1]) & (cloud.normals[:, :2] @ face.outward > 0.7))


def _layers(layers: Sequence[Array], window: int) -> tuple[Mask, Mask, Mask]:
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


def _plane(x: Array, y: Array, z: Array) -> tuple[Array, float]:
    """(3,) robust fit y = p0 + p1 x + p2 z to a wall's returns, and their standard deviation."""
    near = np.flatnonzero(np.abs(y) < _PLANE_REFIT_M)[:: max(1, len(y) // 20_000)]
    columns = np.column_stack([np.ones(len(near)), x[near], z[near]])
    plane, scale = np.zeros(3), _PLANE_REFIT_M
    if len(near) < 50:
        return plane, 0.0
    for _ in range(_PLANE_REFIT_ROUNDS):
        away = y[near] - columns @ plane
        weight = np.maximum(1.0 - (away / (3.0 * scale)) ** 2, 0.0) ** 2
        normal = columns.T @ (columns * weight[:, None]) + 1e-6 * np.eye(3)
        plane = np.linalg.solve(normal, columns.T @ (weight * y[near]))
        rest = np.abs(y[near] - columns @ plane)
        scale = max(1.4826 * float(np.median(rest)), 0.004)
    return plane, scale


def _cells(x: Array, z: Array, shape: tuple[int, int]) -> Rows:
    row = np.clip((z / CELL_M).astype(np.int64), 0, shape[0] - 1)
    return row * shape[1] + np.clip((x / CELL_M).astype(np.int64), 0, shape[1] - 1)


def _counted(cells: Rows, shape: tuple[int, int]) -> Array:
    return np.bincount(cells, minlength=shape[0] * shape[1]).reshape(shape).astype(np.float64)


def _label_counts(
    cloud: Cloud, cell: Rows, above: Mask, behind: Mask, face: WallFace,
    classes: Sequence[int], shape: tuple[int, int],
) -> tuple[dict[int, Array], Array]:  # fmt: skip
    """Label counts of returns with the wall's normal, and of the sides of holes in it."""
    if cloud.label is None:
        return {}, np.zeros(shape)
    if cloud.normals is not None:
        above = above & (behind | (np.abs(cloud.normals[:, :2] @ face.outward) > _LABEL_FACING_COS))
    cell, label = cell[above], cloud.label[above]
    counts = {number: _counted(cell[label == number], shape) for number in classes}
    return counts, _counted(cell[label > 0], shape)


def _seen_through(open_cells: Mask, face: WallFace, plane: Array, sight: Sight) -> Array:
    """(Z, X) confidence that sensors looked through a cell; computed for every second one."""
    rows, columns = np.nonzero(open_cells[::2, ::2])
    x, z = (2 * columns + 1.0) * CELL_M, (2 * rows + 1.0) * CELL_M
    places = face.to_level(np.column_stack([x, plane[0] + plane[1] * x + plane[2] * z, z]))
    seen = np.zeros(open_cells[::2, ::2].shape)
    sensor_origins = sight.sensors_looking_at(places, np.append(face.outward, 0.0))
    seen[rows, columns] = np.minimum(sensor_origins / _SURE_SENSORS, 1.0)
    whole = np.repeat(np.repeat(seen, 2, axis=0), 2, axis=1)[: len(open_cells)]
    return np.where(open_cells, whole[:, : open_cells.shape[1]], 0.0)
