"""The cells of a line arrangement, labelled inside or outside by a minimum cut.

Cells are nodes; the line segment between two cells is an edge whose capacity is its length without
a wall. The minimum cut is then a closed outline along the walls that bridges gaps in the scan at
least cost. The cuts are Boykov and Kolmogorov's. The graph of cells is that of Oesau et al.,
"Indoor scene reconstruction using feature sensitive primitive extraction and graph-cut", 2014.
"""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.scan.rooms.directions import unseen_wall_cost
from openrooms_usd.scan.rooms.walls import Line

# Capacities are integers: tenths of a millimetre of wall.
_CAPACITY_PER_M: Final = 1e4
_SEALED_CAPACITY: Final = 10**8


@dataclass(frozen=True, eq=False)
class FloorCells:
    """C cells between lines.

    Attributes:
        shapes: Polygons (shapely) that tile a box.
        pairs: (E, 2) cells on the two sides of a segment.
        missing: (E,) its cost in an outline: metres without a wall, more off the prevailing
            directions.
        rim: (C,) whether a cell touches the box's border.
    """

    shapes: NDArray[Any]
    pairs: Ints
    missing: Array
    rim: Mask

    def __len__(self) -> int:
        return len(self.shapes)

    def owners(self, points: Array) -> Ints:
        """(N,) the cell of each point (N, 2); -1 outside the box."""
        import shapely

        tree = shapely.STRtree(self.shapes)
        point, cell = tree.query(shapely.points(points), predicate="intersects")
        owner = np.full(len(points), -1)
        owner[point] = cell
        return owner


def cut_plan(
    lines: list[Line], low: Array, high: Array, directions: tuple[float, ...] = ()
) -> FloorCells:
    """Cut a box into cells by lines.

    Args:
        lines: Each with its cover by walls.
        low: (2,) the box's least corner.
        high: (2,) its greatest.
        directions: Of walls, degrees modulo 90.
    """
    import shapely

    box = shapely.box(*low, *high)
    reach = float(np.linalg.norm(high - low))
    middle = (low + high) / 2.0
    strings = [_string(line, middle, reach) for line in lines]
    noded = shapely.node(shapely.union_all([*shapely.intersection(strings, box), box.boundary]))
    parts = shapely.get_parts(noded)
    shapes = shapely.get_parts(shapely.polygonize(parts))
    ends = _segments(parts)
    sides, rim = _sides(ends, shapes)
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    missing = length - _covered(lines, ends, length)
    missing *= unseen_wall_cost(_normals(ends), directions)
    inner = (sides >= 0).all(axis=1) & (sides[:, 0] != sides[:, 1])
    return FloorCells(shapes, sides[inner], missing[inner], rim)


def _string(line: Line, middle: Array, reach: float) -> Any:
    import shapely

    foot = middle + (line.offset - middle @ line.normal) * line.normal
    return shapely.LineString([foot - reach * line.along, foot + reach * line.along])


def _segments(parts: NDArray[Any]) -> Array:
    """(E, 2, 2) the segments of line strings."""
    import shapely

    points, owner = shapely.get_coordinates(parts, return_index=True)
    joined = owner[1:] == owner[:-1]
    return np.stack([points[:-1][joined], points[1:][joined]], axis=1)


def _sides(ends: Array, shapes: NDArray[Any]) -> tuple[Ints, Mask]:
    """(E, 2) cells left and right of each segment, -1 for none, and (C,) which touch the border."""
    import shapely

    middle = ends.mean(axis=1)
    across = _normals(ends)
    tree = shapely.STRtree(shapes)
    sides = np.full((len(ends), 2), -1)
    for side, sign in enumerate((1.0, -1.0)):
        piece, cell = tree.query(shapely.points(middle + sign * 1e-5 * across), "within")
        sides[piece, side] = cell
    rim = np.zeros(len(shapes), bool)
    single = (sides >= 0).sum(axis=1) == 1
    rim[sides[single].max(axis=1)] = True
    return sides, rim


def _normals(ends: Array) -> Array:
    """(E, 2) unit normals to the left of each segment."""
    onward = ends[:, 1] - ends[:, 0]
    across = np.column_stack([-onward[:, 1], onward[:, 0]])
    return unit(across)


def _covered(lines: list[Line], ends: Array, length: Array) -> Array:
    middle = ends.mean(axis=1)
    best = np.zeros(len(ends))
    for line in lines:
        on = np.abs(middle @ line.normal - line.offset) < 1e-5
        on &= np.abs((ends[:, 1] - ends[:, 0]) @ line.normal) < 1e-5 + 1e-4 * length
        a, b = ends[on, 0] @ line.along, ends[on, 1] @ line.along
        best[on] = np.maximum(best[on], line.covered(a, b))
    return np.minimum(best, length)


def inside_by_cut(cells: FloorCells, gain: Array, inner: Mask, outer: Mask) -> Mask:
    """Label cells inside or outside by a minimum cut.

    Args:
        cells: All of them.
        gain: (C,) by how much an inside label lowers the cost, metres of missing wall; may be
            negative.
        inner: (C,) cells that are inside for certain.
        outer: (C,) cells that are outside for certain.

    Returns:
        (C,) whether inside, at the least cost: missing wall along the outline, less gains.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import breadth_first_order, maximum_flow

    count = len(cells)
    source, sink = count, count + 1
    toward = np.where(inner, _SEALED_CAPACITY, np.rint(np.maximum(gain, 0.0) * _CAPACITY_PER_M))
    away = np.where(outer, _SEALED_CAPACITY, np.rint(np.maximum(-gain, 0.0) * _CAPACITY_PER_M))
    cost = np.rint(cells.missing * _CAPACITY_PER_M) + 1
    a, b = cells.pairs.T
    nodes = np.arange(count)
    rows = np.concatenate([a, b, np.full(count, source), nodes])
    columns = np.concatenate([b, a, nodes, np.full(count, sink)])
    values = np.concatenate([cost, cost, toward, away]).astype(np.int32)
    graph = csr_array((values, (rows, columns)), shape=(count + 2, count + 2))
    graph.sum_duplicates()
    flow = maximum_flow(graph, source, sink).flow
    left = csr_array(graph - flow)
    left.data = np.maximum(left.data, 0)
    left.eliminate_zeros()
    reached = breadth_first_order(left, source, return_predecessors=False)
    inside = np.zeros(count + 2, bool)
    inside[reached] = True
    return inside[:count]
