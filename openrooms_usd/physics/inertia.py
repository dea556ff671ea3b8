"""Mass properties of meshes: solid bodies, and walls of a given thickness.

Moments of simplices are exact. Over a simplex of k corners v and measure m,
integral x x^T = m / (k (k + 1)) (sum v v^T + s s^T), with s = sum v, and integral x = m s / k.
Bodies are sums over the signed tetrahedra between the triangles and a local origin. Sources:
F. Tonon, "Explicit Exact Formulas for the 3-D Tetrahedron Inertia Tensor in Terms of its Vertex
Coordinates", J. Math. Stat. 1 (2004); B. Mirtich, "Fast and Accurate Computation of Polyhedral Mass
Properties", JGT 1 (1996); D. Eberly, "Polyhedral Mass Properties (Revisited)" (2002).
"""

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.errors import InputError
from openrooms_usd.physics.borders import sums, vector_areas
from openrooms_usd.physics.enclosure import Enclosure, examined
from openrooms_usd.physics.mass import MassProperties, combined, from_moments

# The length of the mean normal of a corner below which it is too sharp to be moved by its share.
_MIN_MEAN_NORMAL: Final = 0.5
# A wall that leaves less than this share of its body hollow fills it.
_MIN_HOLLOW_SHARE: Final = 1e-3
# Where in a wall its two sheets lie, in thicknesses: the nodes of Gauss and Legendre.
_NODES: Final = (0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0))


def solid(
    points: ArrayLike, triangles: ArrayLike, density: float, sheet: float | None = None
) -> MassProperties:
    """A body that is full of one material.

    Components that overlap count twice where they do. A component inside another that faces the
    other way is a cavity. Holes of up to a quarter of a component's area are closed flat.

    Args:
        points: (N, 3) metres.
        triangles: (M, 3) rows of ``points``, wound either way, but alike.
        density: kg/m3.
        sheet: What enclosing nothing weighs: a sheet of this thickness, metres. None: it must not.

    Raises:
        InputError: The mesh is broken or has no surface, a number is not positive, or a part
            encloses no volume and ``sheet`` is missing.
    """
    _positive(density, "density", "kg/m3")
    if sheet is not None:
        _positive(sheet, "thickness of a sheet", "metres")
    surface = examined(points, triangles)
    full = surface.volumes > 0
    if sheet is None and not full[surface.labels].all():
        raise InputError(
            "a surface with holes has no volume", remedy="give its walls a thickness, or close it"
        )
    return _weighed(surface, full, full, density, sheet or 0.0, [])


def shell(
    points: ArrayLike, triangles: ArrayLike, density: float, thickness: float
) -> MassProperties:
    """A wall of one thickness along a surface.

    The wall of a closed component lies inside its surface. It is weighed as two parallel sheets, at
    the nodes of the Gauss-Legendre rule. The area of a parallel surface is a polynomial of second
    degree of its depth (Steiner's formula), so the mass of a hollow box, ball or cylinder is exact,
    and its inertia errs in the fifth order of the thickness. Around edges that are rounded more
    narrowly than the wall is thick, up to 0.21 t2 a metre is missing; where a part of a component
    is thinner than two walls, it counts for more than it has. A component that the wall fills is
    solid. The wall along an open surface lies half on each side of it.

    Args:
        points: (N, 3) metres.
        triangles: (M, 3) rows of ``points``, wound either way, but alike.
        density: Of the wall, kg/m3.
        thickness: Of the wall, metres.

    Raises:
        InputError: The mesh is broken or has no surface, or a number is not positive.
    """
    _positive(density, "density", "kg/m3")
    _positive(thickness, "thickness of a wall", "metres")
    surface = examined(points, triangles)
    closed = surface.volumes > 0
    sheets = [_sunk(surface, node * thickness) for node in _NODES]
    full = closed & _filled(surface, sheets, thickness)
    wall = (closed & ~full)[surface.labels]
    halves = [
        from_moments(*_moments(corners[wall], 0.5 * density * thickness * areas[wall]))
        for corners, areas in sheets
        if wall.any()
    ]
    return _weighed(surface, full, closed, density, thickness, halves)


def _positive(value: float, what: str, unit: str) -> None:
    if not (np.isfinite(value) and value > 0):
        raise InputError(
            f"{what} must be positive, got {value:g} {unit}", remedy=f"give {unit} above zero"
        )


def _weighed(
    surface: Enclosure,
    full: Mask,
    closed: Mask,
    density: float,
    thickness: float,
    walls: list[MassProperties],
) -> MassProperties:
    """Full components, open ones as sheets, and the walls of the others."""
    pieces = [
        *_bodies(surface, full, density),
        *_sheets(surface, ~closed, density, thickness),
        *walls,
    ]
    whole = combined(pieces)
    return MassProperties(whole.mass, whole.centre + surface.origin, whole.inertia, surface.notes)


def _bodies(surface: Enclosure, full: Mask, density: float) -> list[MassProperties]:
    corners = np.concatenate(
        [surface.corners[full[surface.labels]], surface.lids[full[surface.lid_labels]]]
    )
    return [enclosed(corners, density)] if len(corners) else []


def enclosed(corners: Array, density: float = 1.0) -> MassProperties:
    """What closed surfaces enclose, by the signed tetrahedra to the origin.

    Args:
        corners: (M, 3, 3) of triangles that face outwards, metres.
        density: kg/m3.
    """
    apex = np.zeros((len(corners), 1, 3))
    masses = density * np.linalg.det(corners) / 6.0
    return from_moments(*_moments(np.concatenate([corners, apex], axis=1), masses))


def _sheets(
    surface: Enclosure, chosen: Mask, density: float, thickness: float
) -> list[MassProperties]:
    """Plates along triangles, half on each side; sheets that show both sides count once."""
    rows = chosen[surface.labels]
    if not rows.any():
        return []
    corners, vectors = surface.corners[rows], vector_areas(surface.corners[rows])
    areas = np.linalg.norm(vectors, axis=1)
    normals = vectors / np.where(areas > 0, areas, 1.0)[:, None]
    share = np.where(surface.two_sided[surface.labels[rows]], 0.5, 1.0)
    masses = density * thickness * areas * share
    mass, first, second = _moments(corners, masses)
    across = np.einsum("m,mi,mj->ij", masses, normals, normals) * thickness**2 / 12.0
    return [from_moments(mass, first, second + across)]


def _moments(corners: Array, masses: Array) -> tuple[float, Array, Array]:
    """The integrals of 1, x and x x^T over simplices: (M, k, 3) corners and (M,) masses."""
    k = corners.shape[1]
    totals = corners.sum(axis=1)
    squares = np.einsum("m,mki,mkj->ij", masses, corners, corners)
    squares += np.einsum("m,mi,mj->ij", masses, totals, totals)
    return float(masses.sum()), masses @ totals / k, squares / (k * (k + 1))


def _sunk(surface: Enclosure, depth: float) -> tuple[Array, Array]:
    """A parallel surface inside: (M, 3, 3) corners and (M,) areas.

    Corners are moved so that flat faces that meet there all move by the depth, as far as one point
    can: by the mean normal over its squared length, which is exact in the corners of boxes and
    along the rims of cylinders. An area that is turned over by it is negative.
    """
    vectors = vector_areas(surface.corners)
    areas = np.linalg.norm(vectors, axis=1, keepdims=True)
    units = vectors / np.where(areas > 0, areas, 1.0)
    moved = surface.corners - depth * _mean_normals(surface, units)
    return moved, np.einsum("ij,ij->i", vector_areas(moved), units)


def _filled(surface: Enclosure, sheets: list[tuple[Array, Array]], thickness: float) -> Mask:
    """(K,) whether a wall leaves nothing hollow.

    That is so at the depth where the parallel surface has no area, or where the layers above it
    have all the volume.
    """
    near, far = (sums(surface.labels, areas, len(surface.areas)) for _, areas in sheets)
    # area(u) = a + b u + c u2 at a depth of u thicknesses.
    a, (u, v) = surface.areas, _NODES
    c = ((far - a) / v - (near - a) / u) / (v - u)
    b = (near - a) / u - c * u
    lowest = np.clip(np.divide(-b, 2 * c, out=np.ones_like(c), where=c > 0), 0.0, 1.0)
    least = np.minimum(a + b + c, a + b * lowest + c * lowest**2)
    layers = thickness * 0.5 * (near + far)
    return np.asarray((least <= 0) | (layers >= (1.0 - _MIN_HOLLOW_SHARE) * surface.volumes))


def _mean_normals(surface: Enclosure, units: Array) -> Array:
    """(M, 3, 3) means of a component's normals about each corner, over their squared lengths."""
    corners = surface.corners
    out, back = (np.roll(corners, -turn, axis=1) - corners for turn in (1, 2))
    sines = np.linalg.norm(np.cross(out, back), axis=2)
    angles = np.arctan2(sines, np.einsum("mki,mki->mk", out, back)).ravel()
    own = surface.labels[:, None] * len(surface.points) + surface.triangles
    places = np.unique(own, return_inverse=True)[1].ravel()
    count, normals = int(places.max()) + 1, np.repeat(units, 3, axis=0)
    total = sums(places, angles, count)
    turned = [sums(places, angles * normals[:, axis], count) for axis in range(3)]
    means = np.stack(turned, axis=1) / np.where(total > 0, total, 1.0)[:, None]
    lengths = np.linalg.norm(means, axis=1, keepdims=True)
    return np.asarray(
        (means / np.maximum(lengths, _MIN_MEAN_NORMAL) ** 2)[places].reshape(-1, 3, 3)
    )
