"""What furniture is made of: boards, legs, posts, outlines; in the frame of `pieces`."""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.joinery.pieces import Size
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.normals import with_normals
from openrooms_usd.geometry.solids import frustum, rounded_box
from openrooms_usd.geometry.sweeps import extrude
from openrooms_usd.geometry.vectors import unit

# Drawn in (a, b) and extruded along c: where these axes point in the object frame.
SIDE: Final = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # a: Y, b: Z, c: X
FRONT: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # a: X, b: Z, c: -Y


def board(low: ArrayLike, high: ArrayLike, edge: float = 0.002) -> Mesh:
    """A board between two opposite corners, its edges rounded by ``edge`` metres."""
    a, b = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    return rounded_box(b - a, edge, center=0.5 * (a + b))


def wall_plate(size: Size, thick: float) -> Mesh:
    """A cover with eased edges, ``thick`` metres, flat on the wall behind the box."""
    x, y, height = 0.5 * size[0], 0.5 * size[1], size[2]
    return board((-x, y - thick, 0.0), (x, y, height))


def profiled(polygon: ArrayLike, width: float, frame: Array, bevel: float) -> Mesh:
    """A board of a given outline, drawn in `SIDE` or `FRONT` view, centred in its width."""
    return extrude(polygon, width, bevel=bevel, base=-0.5 * width).transformed(frame)


def strip(line: ArrayLike, thickness: float, end: float | None = None) -> Array:
    """The outline of a band along a 2D polyline, tapering from ``thickness`` to ``end``."""
    axis = np.asarray(line, dtype=np.float64)
    along = np.gradient(axis, axis=0)
    side = unit(np.stack([-along[:, 1], along[:, 0]], axis=1))
    half = 0.5 * np.linspace(thickness, thickness if end is None else end, len(axis))[:, None]
    return np.concatenate([axis + half * side, (axis - half * side)[::-1]])


def bent_post(
    corners: ArrayLike,
    thickness: float,
    width: float,
    *,
    bend: float = 0.5,
    end: float | None = None,
) -> Mesh:
    """A post bent in the side view (Y, Z), cut level with the floor at its foot."""
    axis = filleted(corners, bend, segments=6)
    post = profiled(strip(axis, thickness, end), width, SIDE, 0.004)
    return cut_level(post, float(axis[0, 1]), float(axis[-1, 1]))


def cut_level(mesh: Mesh, low: float = 0.0, high: float = np.inf) -> Mesh:
    """What is below or above two heights is ground off, metres: feet stand on a face."""
    points = mesh.points.copy()
    points[:, 2] = np.clip(points[:, 2], low, high)
    return replace(mesh, points=points)


def square_leg(top: float, bottom: float, height: float, edge: float = 0.004) -> Mesh:
    """A square leg that tapers downwards, its foot in the origin."""
    plain = rounded_box((top, top, height), edge, center=(0.0, 0.0, 0.5 * height))
    scale = bottom / top + (1.0 - bottom / top) * plain.points[:, 2:] / height
    points = np.concatenate([plain.points[:, :2] * scale, plain.points[:, 2:]], axis=1)
    return with_normals(replace(plain, points=points), crease=60.0)


def round_leg(top: float, bottom: float, height: float, segments: int = 20) -> Mesh:
    """A turned leg that tapers from radius ``top`` to ``bottom``, its foot in the origin."""
    return frustum(bottom, top, height, bevel=0.002, segments=segments)


def splayed(leg: Mesh, foot: ArrayLike, head: ArrayLike) -> Mesh:
    """Stand a leg so that its foot and its head come to two points (x, y), metres."""
    low, high = np.asarray(foot, dtype=np.float64), np.asarray(head, dtype=np.float64)
    height = float(leg.extent[1, 2])
    shear = np.eye(4)
    shear[:2, 2] = (high - low) / height
    shear[:2, 3] = low
    return leg.transformed(shear)


def corners(x: float, y: float) -> tuple[tuple[float, float], ...]:
    """The four points (+-x, +-y), front left first, counter-clockwise."""
    return (-x, -y), (x, -y), (x, y), (-x, y)
