"""Plain layouts to compare with: a Manhattan histogram, and planes by RANSAC of Open3D."""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.rotations import in_plan
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.results import FoundOpening, FoundRoom

Array = NDArray[np.float64]

# Bins of heights and of walls' places; cells of the plan, metres.
BIN: Final = 0.02
CELL: Final = 0.05
# A wall is a peak of at least this part of the highest one, and this far from a higher one.
PEAK: Final = 0.15
APART: Final = 0.3
# Points so near to the floor or ceiling are of it, metres; a cell between walls is inside where
# this part of it shows either.
LEVEL: Final = 0.1
FILLED: Final = 0.3
DOOR, WINDOW = 8, 9
# Labelled points belong to a wall within this distance; smaller rectangles are noise, metres.
NEAR: Final = 0.25
SMALLEST: Final = 0.4


def manhattan(cloud: Cloud) -> FoundRoom | None:
    """A room of right angles from histograms; Z is up, normals are known.

    Heights give the floor and the ceiling, the normals' angles modulo 90 degrees the walls'
    direction, places along both axes the walls; between them, cells that show floor are inside.
    """
    normals = np.asarray(cloud.normals, float)
    flat = np.abs(normals[:, 2]) > 0.9
    floor, ceiling = _levels(cloud.points[flat, 2], normals[flat, 2])
    walls = np.abs(normals[:, 2]) < 0.3
    angle = _heading(normals[walls, :2])
    turn = in_plan(angle)
    plan, facing = cloud.points[:, :2] @ turn, normals[:, :2] @ turn
    lines = [_peaks(plan[walls, axis][np.abs(facing[walls, axis]) > 0.9]) for axis in (0, 1)]
    levels = np.abs(cloud.points[:, 2, None] - (floor, ceiling)).min(axis=1) < LEVEL
    ring = _outline(lines, plan[flat & levels])
    if ring is None:
        return None
    corners = np.column_stack([ring @ turn.T, np.full(len(ring), floor)])
    holes = openings_of(cloud, corners) if cloud.label is not None else ()
    up = np.array([0.0, 0.0, 1.0])
    return FoundRoom(up, corners[0], corners, (), ceiling - floor, holes)


def _levels(heights: Array, facing: Array) -> tuple[float, float]:
    """Modes of what faces up in the lower half and of what faces down."""
    edges = np.arange(heights.min(), heights.max() + 2 * BIN, BIN)
    middle = (heights.min() + heights.max()) / 2
    low = np.histogram(heights[(facing > 0) & (heights < middle)], edges)[0]
    high = np.histogram(heights[(facing < 0) & (heights > middle)], edges)[0]
    return float(edges[low.argmax()] + BIN / 2), float(edges[high.argmax()] + BIN / 2)


def _heading(normals: Array) -> float:
    """Radians: the mode of directions modulo 90 degrees."""
    degrees = np.degrees(np.arctan2(normals[:, 1], normals[:, 0])) % 90.0
    counts = np.histogram(degrees, np.arange(0.0, 90.5, 0.5))[0]
    mode = (counts + np.roll(counts, 1) + np.roll(counts, -1)).argmax() * 0.5 + 0.25
    away = (degrees - mode + 45.0) % 90.0 - 45.0
    return float(np.radians(mode + np.median(away[np.abs(away) < 2.0])))


def _peaks(places: Array) -> Array:
    """Where walls may be along an axis."""
    edges = np.arange(places.min() - BIN, places.max() + 2 * BIN, BIN)
    counts = np.convolve(np.histogram(places, edges)[0], np.ones(3), "same")
    chosen: list[int] = []
    for row in np.argsort(-counts, kind="stable"):
        if counts[row] < PEAK * counts.max():
            break
        if all(abs(row - other) * BIN > APART for other in chosen):
            chosen.append(int(row))
    return np.sort(edges[chosen] + BIN / 2)


def _outline(lines: list[Array], ground: Array) -> Array | None:
    """(N, 2) counter-clockwise outline of the cells between lines that show floor."""
    import shapely

    if min(len(axis) for axis in lines) < 2:
        return None
    seen = np.unique(np.floor(ground / CELL).astype(int), axis=0) * CELL + CELL / 2
    counts = np.histogram2d(seen[:, 0], seen[:, 1], bins=lines)[0] * CELL**2
    areas = np.diff(lines[0])[:, None] * np.diff(lines[1])[None]
    cells = [
        shapely.box(lines[0][i], lines[1][j], lines[0][i + 1], lines[1][j + 1])
        for i, j in np.argwhere(counts > FILLED * areas)
    ]
    if not cells:
        return None
    whole: Any = shapely.union_all(cells)
    largest = max(getattr(whole, "geoms", [whole]), key=lambda piece: piece.area)
    ring = shapely.get_coordinates(shapely.orient_polygons(largest.simplify(1e-6)).exterior)[:-1]
    return np.asarray(ring)


def openings_of(cloud: Cloud, corners: Array) -> tuple[FoundOpening, ...]:
    """The box of each labelled door or window on the wall that is nearest to it."""
    assert cloud.label is not None and cloud.instance is not None
    found = []
    for label, kind in ((DOOR, "door"), (WINDOW, "window")):
        for number in np.unique(cloud.instance[cloud.label == label]):
            rows = (cloud.label == label) & (cloud.instance == number)
            hole = _rectangle(cloud.points[rows], corners, kind)
            if hole is not None:
                found.append(hole)
    return tuple(found)


def _rectangle(points: Array, corners: Array, kind: Any) -> FoundOpening | None:
    middle = np.median(points, axis=0)
    starts, ends = corners, np.roll(corners, -1, axis=0)
    along = (ends - starts) / np.linalg.norm(ends - starts, axis=1, keepdims=True)
    outward = np.column_stack([along[:, 1], -along[:, 0]])
    away = np.abs(np.einsum("ij,ij->i", middle[:2] - starts[:, :2], outward))
    run = np.einsum("ij,ij->i", middle[:2] - starts[:, :2], along[:, :2])
    within = (run > 0) & (run < np.linalg.norm(ends - starts, axis=1))
    wall = int(np.where(within, away, np.inf).argmin())
    near = np.abs((points[:, :2] - starts[wall, :2]) @ outward[wall]) < NEAR
    if near.sum() < 20:
        return None
    u = np.quantile((points[near, :2] - starts[wall, :2]) @ along[wall, :2], [0.98, 0.02])
    v = np.quantile(points[near, 2], [0.02, 0.98])
    if u[0] - u[1] < SMALLEST or v[1] - v[0] < SMALLEST:
        return None
    ring = [(u[0], v[0]), (u[1], v[0]), (u[1], v[1]), (u[0], v[1])]
    up = np.array([0.0, 0.0, 1.0])
    base = starts[wall] * (1, 1, 0)
    return FoundOpening(kind, np.array([base + a * along[wall] + b * up for a, b in ring]), 1, wall)


def ransac_planes(cloud: Cloud, planes: int = 12) -> FoundRoom | None:
    """The usual tool: planes one by one by Open3D's RANSAC; the box of the upright ones.

    Raises:
        ImportError: Open3D is not installed.
    """
    import open3d  # type: ignore[import-not-found, unused-ignore]

    open3d.utility.random.seed(0)
    left = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(cloud.points))
    left = left.voxel_down_sample(0.03)
    levels, sides = [], []
    for _ in range(planes):
        if len(left.points) < 1000:
            break
        model, rows = left.segment_plane(0.03, 3, 500)
        points = np.asarray(left.points)[rows]
        normal = np.array(model[:3])
        if abs(normal[2]) > 0.95:
            levels.append(float(np.median(points[:, 2])))
        elif abs(normal[2]) < 0.1:
            sides.append((normal, points))
        left = left.select_by_index(rows, invert=True)
    if len(levels) < 1 or len(sides) < 2:
        return None
    angle = np.arctan2(sides[0][0][1], sides[0][0][0])
    turn = in_plan(angle)
    plan = np.concatenate([np.median(points[:, :2] @ turn, axis=0)[None] for _, points in sides])
    low, high = plan.min(axis=0), plan.max(axis=0)
    ring = np.array([low, (high[0], low[1]), high, (low[0], high[1])]) @ turn.T
    corners = np.column_stack([ring, np.full(4, min(levels))])
    up = np.array([0.0, 0.0, 1.0])
    height = max(levels) - min(levels) if len(levels) > 1 else None
    return FoundRoom(up, corners[0], corners, (), height)
