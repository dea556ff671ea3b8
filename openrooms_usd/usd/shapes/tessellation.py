"""USD's intrinsic shapes as polygons: Cube, Sphere, Cylinder, Cone, Capsule and Plane."""

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final

import numpy as np
from pxr import Usd

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.usd.arrays import number_of
from openrooms_usd.usd.places.frames import TIME


@dataclass(frozen=True, eq=False)
class Drawn:
    """Polygons in place of curves, points and the like.

    Attributes:
        mesh: None where there is nothing to draw.
        losses: What was approximated; without a mesh the reason.
        along: Maps a primvar's values (N, C) and its interpolation to values at the places that the
            points of the mesh surround, with equally many points around each place, one place after
            the other. It raises ``ValueError`` if they do not fit.
    """

    mesh: Mesh | None
    losses: list[str] = field(default_factory=list)
    along: Callable[[Array, str], Array] | None = None

    def at_points(self, values: Array, interpolation: str) -> Array | None:
        """(P, C) a primvar's values at the points of the mesh; None where they do not fit."""
        if self.mesh is None or self.along is None or not len(values):
            return None
        try:
            placed = self.along(values, interpolation)
        except ValueError:
            return None
        return np.repeat(placed, len(self.mesh.points) // len(placed), axis=0)


# Sides of a round shape: the outline is then within 0.2 % of the radius.
SECTORS: Final = 48

# Rows are the shape's own X, Y and Z in the prim's frame: a cyclic turn of the axes, as USD wants.
_AXES: Final = {
    "X": np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]),
    "Y": np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
    "Z": np.eye(3),
}


def tessellate(prim: Usd.Prim) -> Mesh | None:
    """The polygons of an intrinsic shape, in its local frame.

    Round shapes have smooth normals and points that lie on the true surface.

    Returns:
        None if the prim is not an intrinsic shape, or has no size.
    """
    make = _MAKERS.get(prim.GetTypeName())
    return None if make is None else make(prim)


def _number(prim: Usd.Prim, name: str) -> float:
    value = number_of(prim.GetAttribute(name).Get(TIME))
    return 0.0 if value is None or not np.isfinite(value) else value


def _cube(prim: Usd.Prim) -> Mesh | None:
    half = _number(prim, "size") / 2.0
    if half <= 0:
        return None
    corners = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)])
    quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
    normals = np.repeat(np.kron(np.eye(3), [[-1.0], [1.0]]), 4, axis=0)
    return _polygons(half * corners, np.array(quads), normals)


def _plane(prim: Usd.Prim) -> Mesh | None:
    width, length = _number(prim, "width") / 2.0, _number(prim, "length") / 2.0
    if width <= 0 or length <= 0:
        return None
    # In the schema's words: X axis: width along Z, length along Y; Y: X and Z; Z: X and Y.
    sides = {
        "X": ((0, 0, width), (0, length, 0)),
        "Y": ((width, 0, 0), (0, 0, length)),
        "Z": ((width, 0, 0), (0, length, 0)),
    }
    axis = _axis(prim)
    u, v = np.array(sides[axis], dtype=np.float64)
    normal = _AXES[axis][2]
    ring = np.array([-u - v, u - v, u + v, v - u])
    order = [0, 1, 2, 3] if np.cross(u, v) @ normal > 0 else [3, 2, 1, 0]
    return _polygons(ring, np.array([order]), np.tile(normal, (4, 1)))


def _sphere(prim: Usd.Prim) -> Mesh | None:
    radius = _number(prim, "radius")
    return _revolved(_arc(radius, 0.0, -90.0, 90.0), "Z") if radius > 0 else None


def _cylinder(prim: Usd.Prim) -> Mesh | None:
    bottom, top, half = *_radii(prim), _number(prim, "height") / 2.0
    if half <= 0 or max(bottom, top) <= 0 or min(bottom, top) < 0:
        return None
    lower = _flat(0.0, bottom, -half, -1.0)
    upper = _flat(top, 0.0, half, 1.0)
    return _revolved([*lower, *_side(bottom, -half, top, half), *upper], _axis(prim))


def _cone(prim: Usd.Prim) -> Mesh | None:
    radius, half = _number(prim, "radius"), _number(prim, "height") / 2.0
    if half <= 0 or radius <= 0:
        return None
    base = _flat(0.0, radius, -half, -1.0)
    return _revolved([*base, *_side(radius, -half, 0.0, half)], _axis(prim))


def _capsule(prim: Usd.Prim) -> Mesh | None:
    bottom, top, half = *_radii(prim), _number(prim, "height") / 2.0
    if half < 0 or min(bottom, top) <= 0:
        return None
    lower = _arc(bottom, -half, -90.0, 0.0)
    upper = _arc(top, half, 0.0, 90.0)
    side = _side(bottom, -half, top, half) if half > 0 else []
    return _revolved([*lower, *side, *upper], _axis(prim))


def _axis(prim: Usd.Prim) -> str:
    axis = prim.GetAttribute("axis").Get(TIME)
    return axis if axis in _AXES else "Z"


def _radii(prim: Usd.Prim) -> tuple[float, float]:
    """Bottom and top: one number in the first version of the schema, two in the second."""
    if prim.GetTypeName().endswith("_1"):
        return _number(prim, "radiusBottom"), _number(prim, "radiusTop")
    return _number(prim, "radius"), _number(prim, "radius")


# A profile is a list of strips, each (radius, z, normal's radial part, normal's z) at both ends.
_End = tuple[float, float, float, float]
_Strip = tuple[_End, _End]


def _arc(radius: float, z: float, start: float, stop: float) -> list[_Strip]:
    steps = max(2, round(SECTORS / 2 * (stop - start) / 180.0))
    angles = np.radians(np.linspace(start, stop, steps + 1))
    # Exactly on the axis at the poles, so that the triangles there are left out.
    cosines = np.where(np.isclose(np.cos(angles), 0.0), 0.0, np.cos(angles))
    ends = [
        (radius * float(c), z + radius * float(s), float(c), float(s))
        for c, s in zip(cosines, np.sin(angles), strict=True)
    ]
    return list(pairwise(ends))


def _flat(inner: float, outer: float, z: float, up: float) -> list[_Strip]:
    return [((inner, z, 0.0, up), (outer, z, 0.0, up))] if max(inner, outer) > 0 else []


def _side(bottom: float, low: float, top: float, high: float) -> list[_Strip]:
    slope = np.hypot(high - low, bottom - top)
    radial, up = float((high - low) / slope), float((bottom - top) / slope)
    return [((bottom, low, radial, up), (top, high, radial, up))]


def _revolved(strips: list[_Strip], axis: str) -> Mesh:
    """Turn a profile about an axis; strips run upwards along the outside."""
    places = np.concatenate([_quads(*(_ring(r, z) for r, z, _, _ in strip)) for strip in strips])
    normals = np.concatenate([_quads(*(_ring(r, z) for _, _, r, z in strip)) for strip in strips])
    points, which = np.unique(places + 0.0, axis=0, return_inverse=True)
    return _polygons(points @ _AXES[axis], which.reshape(-1, 4), normals @ _AXES[axis])


def _ring(radius: float, z: float) -> Array:
    turn = 2.0 * np.pi * np.arange(SECTORS) / SECTORS
    ring = [radius * np.cos(turn), radius * np.sin(turn), np.full(SECTORS, z)]
    return np.stack(ring, axis=1)


def _quads(lower: Array, upper: Array) -> Array:
    """(4 SECTORS, 3) the corners of the faces between two rings."""
    corners = [lower, np.roll(lower, -1, axis=0), np.roll(upper, -1, axis=0), upper]
    return np.stack(corners, axis=1).reshape(-1, 3)


def _polygons(points: Array, quads: Ints, normals: Array) -> Mesh:
    return Mesh(
        points=np.asarray(points, dtype=np.float64),
        counts=np.full(len(quads), 4, dtype=np.int32),
        indices=quads.astype(np.int32).reshape(-1),
        normals=normals.astype(np.float32),
    )


_MAKERS: Final[dict[str, Callable[[Usd.Prim], Mesh | None]]] = {
    "Cube": _cube,
    "Plane": _plane,
    "Sphere": _sphere,
    "Cylinder": _cylinder,
    "Cylinder_1": _cylinder,
    "Cone": _cone,
    "Capsule": _capsule,
    "Capsule_1": _capsule,
}
