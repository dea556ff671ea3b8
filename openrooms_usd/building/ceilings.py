"""What stands out below a ceiling: beams, coffers, and the bars of a suspended grid."""

from collections.abc import Iterator
from typing import Final, Literal

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.building.faces import Face, level, polyhedron, upright
from openrooms_usd.building.mouldings import EMBED_M
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.polygons import counter_clockwise, triangulated

Axis = Literal["x", "y"]

# Pieces of bars with less area are left out, square metres.
_LEAST_M2: Final = 1e-4


def across(corners: Array) -> Axis:
    """The way that beams span a room: that of its shorter side."""
    width, depth = np.ptp(corners, axis=0)
    return "x" if width < depth else "y"


def strips(corners: Array, axis: Axis, spacing: float, width: float) -> list[tuple[float, float]]:
    """Where bars along an axis run: from where to where across it, evenly, none at a wall.

    Args:
        corners: (N, 2) the room, metres.
        axis: The way that the bars run.
        spacing: From bar to bar at most, metres.
        width: Of a bar, metres.
    """
    low, high = np.sort(corners[:, 1 if axis == "x" else 0])[[0, -1]].tolist()
    count = max(1, int(np.ceil((high - low) / spacing - 1e-9)))
    middles = np.linspace(low, high, count + 1)[1:-1].tolist()
    return [(m - 0.5 * width, m + 0.5 * width) for m in middles]


def bars(
    corners: Array,
    ceiling: float,
    *,
    spacing: float,
    width: float,
    depth: float,
    along: Axis,
    crossed: bool,
) -> Mesh | None:
    """Bars below a ceiling, cut off at the walls.

    Args:
        corners: (N, 2) the room, counter-clockwise, metres.
        ceiling: Height of the ceiling, metres.
        spacing: From bar to bar at most, metres.
        width: Of a bar, metres.
        depth: How far they hang down, metres.
        along: The way that they run.
        crossed: Whether others cross them at right angles.

    Returns:
        Closed solids; None where the room has no place for any.
    """
    found = [
        _bar(ring, holes, axis, ceiling - depth, ceiling + EMBED_M)
        for axis, ring, holes in _pieces(corners, spacing, width, along, crossed)
    ]
    return joined(found) if found else None


def _pieces(
    corners: Array, spacing: float, width: float, along: Axis, crossed: bool
) -> Iterator[tuple[Axis, Array, tuple[Array, ...]]]:
    import shapely

    room = shapely.Polygon(corners)
    x0, y0, x1, y1 = room.bounds
    across: Axis = "y" if along == "x" else "x"
    taken = shapely.union_all([])
    for axis in (along, across) if crossed else (along,):
        rows = strips(corners, axis, spacing, width)
        boxes = [
            shapely.box(x0, a, x1, b) if axis == "x" else shapely.box(a, y0, b, y1) for a, b in rows
        ]
        for box in boxes:
            for part in shapely.get_parts(box.intersection(room).difference(taken)):
                if part.geom_type == "Polygon" and part.area > _LEAST_M2:
                    rings = [shapely.get_coordinates(r)[:-1] for r in shapely.get_rings(part)]
                    yield axis, counter_clockwise(rings[0])[0], tuple(rings[1:])
        taken = shapely.union_all(boxes)


def _bar(outline: Array, holes: tuple[Array, ...], axis: Axis, bottom: float, top: float) -> Mesh:
    """A solid over an outline; its grain runs along it: t is the axis."""
    faces: list[Face] = []
    for ring in triangulated(outline, holes):
        faces += [level(ring, top, up=True), level(ring, bottom, up=False)]
    for ring in (outline, *(hole[::-1] for hole in map(_turned, holes))):
        faces += [
            upright(a, b, bottom, top) for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True)
        ]
    return polyhedron([(corners, _along(corners, st, axis)) for corners, st in faces])


def _turned(ring: Array) -> Array:
    return counter_clockwise(ring)[0]


def _along(corners: Array, st: Array, axis: Axis) -> Array:
    """Texture coordinates whose t runs along the axis where the face has an extent along it."""
    t = corners[:, 0 if axis == "x" else 1]
    if np.ptp(t) < 1e-6:
        return st
    other = corners[:, [1, 2] if axis == "x" else [0, 2]]
    wide = np.ptp(other, axis=0)
    return np.stack([other[:, int(wide[1] > wide[0])], t], axis=1)
