"""Turning meshes, and sides that taper: what is drawn upright and stands otherwise."""

from dataclasses import replace
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.furniture.joinery.pieces import Parts, Size
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.normals import with_normals
from openrooms_usd.geometry.rotations import about_point, about_x, about_y, about_z
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.sweeps import tube

_ABOUT: Final = {"x": about_x, "y": about_y, "z": about_z}
# Smaller sines count as no rotation.
_LEVEL: Final = 1e-6
_AXES: Final = {"x": 0, "y": 1, "z": 2}


def turned(
    mesh: Mesh, axis: Literal["x", "y", "z"], degrees: float, pivot: ArrayLike = (0.0, 0.0, 0.0)
) -> Mesh:
    """The mesh turned about an axis through ``pivot`` (metres), counter-clockwise."""
    turn = _ABOUT[axis](np.radians(degrees))
    return mesh.transformed(about_point(turn, np.asarray(pivot, dtype=np.float64)))


def facing(mesh: Mesh, at: ArrayLike) -> Mesh:
    """What is drawn along Z, turned to look to the front and moved to ``at``, metres."""
    return turned(mesh, "x", 90.0).moved(at)


def tapered(
    mesh: Mesh, axis: Literal["x", "y", "z"], end: tuple[float, float], crease: float = 60.0
) -> Mesh:
    """Scale the two other sides linearly along an axis: 1 at its start, ``end`` at its end.

    The scale is about the middle of the mesh.
    """
    i = _AXES[axis]
    low, high = mesh.extent
    along = (mesh.points[:, i] - low[i]) / (high[i] - low[i])
    points = mesh.points.copy()
    for j, scale in zip(((i + 1) % 3, (i + 2) % 3), end, strict=True):
        middle = 0.5 * (low[j] + high[j])
        points[:, j] = middle + (points[:, j] - middle) * (1.0 + (scale - 1.0) * along)
    return with_normals(replace(mesh, points=points), crease=crease)


def seated(mesh: Mesh, crease: float = 60.0) -> Mesh:
    """What is soft lies flat on the ground where it would reach below it: z = 0."""
    points = mesh.points.copy()
    points[:, 2] = np.maximum(points[:, 2], 0.0)
    return with_normals(replace(mesh, points=points), crease=crease)


def at_rest(parts: Parts, size: Size) -> Parts:
    """What lies, turned by the least angle after which it would not tip over.

    A face of the hull carries it if the line from the centre along the face's normal leaves the
    hull there. All parts count as equally dense. It is stretched to its box again, which leaves
    that so.
    """
    from scipy.spatial import ConvexHull

    from openrooms_usd.physics.inertia import enclosed

    points = np.concatenate([mesh.points for mesh in parts.values()])
    solids = [enclosed(mesh.points[mesh.indices[mesh.triangles()[0]]]) for mesh in parts.values()]
    weights = [abs(solid.mass) for solid in solids]
    centre = np.average([solid.centre for solid in solids], axis=0, weights=weights)
    planes = np.unique(np.round(ConvexHull(points).equations, 9), axis=0)
    normals, depths = planes[:, :3], -(planes[:, :3] @ centre + planes[:, 3])
    with np.errstate(divide="ignore"):
        along = normals @ normals.T
        ways = np.where(along > 0.0, depths / along, np.inf)
    carries = depths <= ways.min(axis=1) * (1.0 + 1e-6)
    down = normals[carries][np.argmin(normals[carries, 2])]
    axis = np.cross(down, (0.0, 0.0, -1.0))
    sine = float(np.linalg.norm(axis))
    if sine < _LEVEL:
        return parts
    x, y, z = axis / sine
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    R = np.eye(3) + sine * K + (1.0 + float(down[2])) * K @ K
    fit = np.diag(size / np.ptp(points @ R.T, axis=0)) @ R
    return {name: mesh.transformed(fit) for name, mesh in parts.items()}


def oval(mesh: Mesh, size: Size) -> Mesh:
    """What was turned with the smaller half side as radius, stretched to the box."""
    least = min(size[0], size[1])
    return mesh.transformed(np.diag([size[0] / least, size[1] / least, 1.0]))


def hoop(radius: float, z: float, thick: float, segments: int = 36, sides: int = 6) -> Mesh:
    """A round bar of radius ``thick`` in a level circle, metres."""
    angle = 2.0 * np.pi * np.arange(segments) / segments
    path = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(segments, z)], axis=1)
    return tube(path, thick, segments=sides, closed=True)


def band(inner: float, outer: float, low: float, high: float, segments: int = 32) -> Mesh:
    """A ring about Z between two radii and two heights, metres."""
    return lathe([(inner, low), (outer, low), (outer, high), (inner, high)], segments=segments)
