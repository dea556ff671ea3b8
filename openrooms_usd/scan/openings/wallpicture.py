"""Evidence grids of walls: returns from the plane, returns from behind it, and voids.

Every wall has its own frame: x to the right along its inner face, y outwards, z up. A cell is solid
(the wall returned), a recess (a return from behind), a void (sensors looked through without a
return), or unknown (occluded by furniture).

A wall's upper part may lack returns because no sensor was tilted up. So a void counts up to the
height to which the wall was scanned on both its sides.

Behind furniture a wall shows nothing, whatever its picture looks like: a shelf is full of dark
recesses. Through a doorway or a clear pane, in contrast, the scan has returns farther out.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import ndimage

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.scan.openings.cellcounts import (
    CELL_M,
    WallFace,
    cell_means,
    cells_of,
    counted,
    faces_of,
    label_counts,
    layers_of,
    nearest_walls,
    window_of,
)
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.sightlines import Sight

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
# Number of sensors that look through a cell from which on it is a certain void.
_SURE_SENSORS: Final = 3.0
# Narrower voids are gaps between things; cells of 2.5 cm.
_SLIT_CELLS: Final = 5
# Holes have wall on both sides within this distance, up to their full height; voids to the top that
# are wider than a door were not scanned. Cells.
_WALL_BESIDE_CELLS: Final = 60
_UNSEEN_CELLS: Final = 52
# Things before a wall: their distance from it, metres. Nearer are its own casings and sills.
_BEFORE_M: Final = (0.08, 0.75)
# Returns beyond a wall: behind its thickness, and within a scanner's reach, metres.
_BEYOND_M: Final = (0.6, 6.0)
# Blocks in which things before a wall (by the window of the grid), and views beyond it are marked,
# cells.
_BLOCKS_CELLS: Final = {3: 2, 5: 4, 7: 6, 9: 6}
_VIEW_CELLS: Final = 6
# Sensors nearer to the wall than this see it too flatly, metres.
_MIN_STAND_OFF_M: Final = 0.2
_MAX_POINTS: Final = 20_000


@dataclass(frozen=True, eq=False)
class WallViews:
    """The surroundings of a wall.

    Attributes:
        before: (Z, X) something stands before the wall.
        beyond: (Z, X) a line of sight to a return far behind the wall passes here.
    """

    before: Mask
    beyond: Mask


def wall_views(
    points: Array, face: WallFace, shape: tuple[int, int], cell: float, window: int, sight: Sight
) -> WallViews:
    """Look at what is before and beyond a wall.

    Args:
        points: (N, 3) of the whole scan, in the level frame, metres.
        face: The wall.
        shape: Rows and columns of its grid.
        cell: Their edge, metres.
        window: Cells that usually hold some returns.
        sight: Sensors.
    """
    x, y, z = face.from_level(points).T
    level = (z > cell) & (z < shape[0] * cell)
    near = level & (y < -_BEFORE_M[0]) & (y > -_BEFORE_M[1])
    before = _marked(x[near] / cell, z[near] / cell, shape, _BLOCKS_CELLS[window])
    far = np.flatnonzero(level & (y > _BEYOND_M[0]) & (y < _BEYOND_M[1]))
    far = far[:: max(1, len(far) // _MAX_POINTS)]
    beyond = np.zeros(shape, dtype=np.bool_)
    for ox, oy, oz in face.from_level(sight.sensor_origins):
        if oy < -_MIN_STAND_OFF_M:
            part = -oy / (y[far] - oy)
            at = ox + part * (x[far] - ox), oz + part * (z[far] - oz)
            beyond |= _marked(at[0] / cell, at[1] / cell, shape, _VIEW_CELLS)
    return WallViews(before, beyond)


def _marked(column: Array, row: Array, shape: tuple[int, int], block: int) -> Mask:
    """(Z, X) the blocks of cells that hold any of the places."""
    size = -(-shape[0] // block), -(-shape[1] // block)
    i, j = np.floor(row / block).astype(np.int64), np.floor(column / block).astype(np.int64)
    inside = (i >= 0) & (i < size[0]) & (j >= 0) & (j < size[1])
    marked = np.zeros(size, dtype=np.bool_)
    marked[i[inside], j[inside]] = True
    whole = np.repeat(np.repeat(marked, block, axis=0), block, axis=1)
    return whole[: shape[0], : shape[1]]


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


def wall_grids(cloud: Cloud, corners: Array, height: float, sight: Sight) -> Iterator[WallGrid]:
    """The evidence grids of a room's walls, one after the other.

    Args:
        cloud: In the level frame.
        corners: (N, 2) counter-clockwise.
        height: Of the walls, metres.
        sight: Sensors and occlusion.
    """
    faces = faces_of(corners)
    nearest = nearest_walls(cloud.points, corners, faces)
    order = np.argsort(nearest, kind="stable")
    ends = np.searchsorted(nearest[order], np.arange(len(faces) + 1))
    for face, first, last in zip(faces, ends, ends[1:], strict=False):
        if face.length > 4 * CELL_M:
            own = cloud.take(order[first:last])
            yield _grid(own, cloud.points, face, height, sight)


def _grid(cloud: Cloud, points: Array, face: WallFace, height: float, sight: Sight) -> WallGrid:
    shape = (max(round(height / CELL_M), 8), max(round(face.length / CELL_M), 4))
    x, y, z = face.from_level(cloud.points).T
    inside = (x > 0) & (x < face.length) & (z > -0.1) & (z < height)
    cloud, x, y, z = cloud.take(inside), x[inside], y[inside], z[inside]
    plane, deviation = _plane(x, y, z)
    y = y - plane[0] - plane[1] * x - plane[2] * z
    cell = cells_of(x, z, shape)
    above = z > 0
    inner = above & ~_other_side(cloud, face, y)
    near = float(np.clip(_RETURN_SIGMAS * deviation, *_ON_WALL_LIMITS_M))
    on, behind, before = above & (np.abs(y) < near), inner & (y >= near), above & (y <= -near)
    layers = [counted(cell[kind], shape) for kind in (on, behind, before)]
    window = window_of(layers[0])
    solid, recess, covered = layers_of(layers, window)
    face_like = inner & (y > -_RELIEF_LIMITS_M[0]) & (y < _RELIEF_LIMITS_M[1])
    relief = cell_means(cell[face_like], -y[face_like], shape, window - 2)
    tint = cell_means(cell[face_like], _tints(cloud, face_like), shape, window - 2)
    labels, labelled = label_counts(
        cloud.take(above), y[above], near, deviation, cell[above], face, shape
    )
    floor = (np.abs(z) < 2 * CELL_M) & (y > 0.1)
    threshold = counted(cell[floor], shape).sum(axis=0) > 0
    standing = solid | recess
    seen = _seen_through(~(standing | covered), face, plane, sight)
    void = np.where(enclosed(seen > 0, standing), seen, 0.0)
    views = wall_views(points, face, shape, CELL_M, window, sight)
    beyond = views.beyond & (void > 0)
    return WallGrid(
        face,
        solid,
        recess,
        void,
        relief,
        tint,
        labels,
        labelled,
        threshold,
        deviation,
        window,
        views.before,
        beyond,
    )


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


def enclosed(void: Mask, standing: Mask) -> Mask:
    """(Z, X) voids without slits, and without unscanned areas above the wall's returns.

    Args:
        void: (Z, X) cells with unoccluded lines of sight and no return.
        standing: (Z, X) cells where the wall returned.
    """
    broad = ndimage.binary_opening(void, np.ones((_SLIT_CELLS, _SLIT_CELLS), dtype=bool))
    pieces, count = ndimage.label(broad)
    over = np.isin(np.arange(count + 1), pieces[-_SLIT_CELLS:])[pieces] & broad
    unseen = ndimage.binary_opening(over, np.ones((1, _UNSEEN_CELLS), dtype=bool))
    rows = np.arange(len(void))[:, None]
    return np.asarray(broad & ~unseen & (~over | (rows < _horizon(standing))))


def _horizon(standing: Mask) -> Ints:
    """(X,) the row up to which the wall was scanned on both sides of a column."""
    highest = np.where(standing.any(axis=0), len(standing) - standing[::-1].argmax(axis=0), 0)
    near = np.lib.stride_tricks.sliding_window_view(
        np.pad(highest, _WALL_BESIDE_CELLS), _WALL_BESIDE_CELLS + 1
    ).max(axis=1)
    return np.asarray(np.minimum(near[: len(highest)], near[_WALL_BESIDE_CELLS:]))
