"""What kitchen and laundry appliances share: bodies, liners, racks, dials, pierced plates."""

from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.boards import FRONT, board
from openrooms_usd.furniture.joinery.cells import Cell
from openrooms_usd.furniture.joinery.pieces import Size
from openrooms_usd.geometry.lofts import loft, ring, superellipse, vessel
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.sweeps import tube

SHEET: Final = 0.012


def body(made: Assembly, low: Size, high: Size, *, top: bool = True) -> None:
    """Sides, back, bottom and top of a case that is open to the front.

    Args:
        made: Gets the ``frame``.
        low: Its least corner, metres.
        high: Its greatest corner, metres.
        top: Whether it has a top.
    """
    (x0, y0, z0), (x1, y1, z1), t = low, high, SHEET
    made.add(
        "frame",
        board((x0, y0, z0), (x0 + t, y1, z1), 0.004),
        board((x1 - t, y0, z0), (x1, y1, z1), 0.004),
        board((x0 + t, y1 - t, z0), (x1 - t, y1, z1)),
        board((x0 + t, y0, z0), (x1 - t, y1 - t, z0 + t)),
    )
    if top:
        made.board("frame", (x0 + t, y0, z1 - t), (x1 - t, y1 - t, z1))


def liner(made: Assembly, cell: Cell, front: float, back: float, wall: float) -> Cell:
    """A hollow block behind an opening in the front.

    Args:
        made: Gets the ``container``.
        cell: What the block takes up in the front, metres.
        front: Y of its front, metres.
        back: Y of its back, metres.
        wall: Metres, on all sides.

    Returns:
        The opening of its hollow.
    """
    left, right, low, high = cell
    mesh = vessel(
        (left, low, -back, right, high, -front),
        (left + wall, low + wall, wall - back, right - wall, high - wall),
        inner_corner=min(0.02, 0.1 * (high - low)),
    )
    made.add("container", mesh.transformed(FRONT))
    return left + wall, right - wall, low + wall, high - wall


def rack(width: float, depth: float, pitch: float = 0.05) -> Mesh:
    """A grid of wires about the origin, as in ovens."""
    x, y, r = 0.5 * width, 0.5 * depth, 0.003
    count = max(3, round(width / pitch))
    wires = [
        tube([(a, -y, 0.0), (a, y, 0.0)], 0.6 * r, segments=5)
        for a in np.linspace(-x, x, count + 2)[1:-1]
    ]
    edge = tube(
        [(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)], r, segments=6, closed=True
    )
    return joined([edge, *wires])


def basket(width: float, depth: float, height: float, pitch: float = 0.06) -> Mesh:
    """A wire basket about the origin, its floor at 0, as in dishwashers."""
    floor = rack(width, depth, pitch)
    x, y, r = 0.5 * width, 0.5 * depth, 0.003
    loop = [(-x, -y, height), (x, -y, height), (x, y, height), (-x, y, height)]
    posts = [
        tube([(a, b, 0.0), (a, b, height)], 0.6 * r, segments=5)
        for b in (-y, y)
        for a in np.linspace(-x, x, max(3, round(width / 0.1)))
    ]
    sides = [
        tube([(a, b, 0.0), (a, b, height)], 0.6 * r, segments=5)
        for a in (-x, x)
        for b in np.linspace(-y, y, 5)[1:-1]
    ]
    return joined([floor, tube(loop, r, segments=6, closed=True), *posts, *sides])


def dial(radius: float, reach: float) -> Mesh:
    """A knob to turn, standing out by ``reach`` metres from the front at y = 0."""
    profile = [
        (0.0, 0.0),
        (1.15 * radius, 0.0),
        (1.15 * radius, 0.12 * reach),
        (radius, 0.16 * reach),
        (0.88 * radius, 0.92 * reach),
        (0.8 * radius, reach),
        (0.0, reach),
    ]
    turned = lathe(profile, segments=20, crease=50.0)
    grip = board(
        (-0.13 * radius, -0.85 * radius, 0.9 * reach),
        (0.13 * radius, 0.85 * radius, 1.15 * reach),
        0.001,
    )
    return joined([turned, grip]).transformed(FRONT)


def knob(made: Assembly, at: tuple[float, float, float], radius: float, reach: float) -> None:
    """A dial on the front at a point, which turns."""
    names = made.add("knob", dial(radius, reach).moved(at))
    made.turn("knob", names, at, (0.0, -1.0, 0.0), (0.0, 270.0))


def pierced(outline: Array, hole: Array, low: float, high: float) -> Mesh:
    """A plate with a hole between two heights; outline and hole are (N, 2), point by point."""
    e = min(0.003, 0.3 * (high - low))
    return loft(
        [
            ring(outline, low),
            ring(outline, high - e),
            ring(outline * (1.0 - e), high),
            ring(hole * 1.02, high),
            ring(hole, high - e),
            ring(hole, low),
        ],
        closed=True,
    )


def square(width: float, depth: float, segments: int = 64) -> Array:
    """(N, 2) points of a rectangle in even directions from its middle, its corners among them."""
    flat = superellipse(2.0, 2.0, 2.0, segments)
    reach = np.max(np.abs(flat) / [0.5 * width, 0.5 * depth], axis=1)
    points = flat / reach[:, None]
    # The direction nearest to each corner is moved into it.
    for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
        corner = np.array([0.5 * sx * width, 0.5 * sy * depth])
        points[np.argmin(np.linalg.norm(points - corner, axis=1))] = corner
    return np.asarray(points)


def display(made: Assembly, x: float, y: float, z: float, size: tuple[float, float]) -> str:
    """A small dark screen on the front at ``y``, its middle at (x, z).

    Returns:
        Its name.
    """
    a, b = 0.5 * size[0], 0.5 * size[1]
    (name,) = made.board("screen", (x - a, y - 0.0015, z - b), (x + a, y + 0.004, z + b), 0.001)
    return name
