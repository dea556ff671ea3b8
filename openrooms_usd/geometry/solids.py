"""Closed solids with rounded edges: boxes, cushions and bodies of revolution.

All are watertight, wound counter-clockwise seen from outside, with unit normals and texture
coordinates in metres.
"""

from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.geometry.curves import filleted, lengths, signed_area
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.normals import with_normals
from openrooms_usd.geometry.topology import weld
from openrooms_usd.geometry.vectors import UP, unit

Vector = Sequence[float] | Array
_ORIGIN = (0.0, 0.0, 0.0)
# Corners that are as near are one point, metres.
_SAME_M = 1e-9

# Outward axis, then the two axes of each side of a box, so that u x v points outwards.
_SIDES = ((0, 1, 1, 2), (0, -1, 2, 1), (1, 1, 2, 0), (1, -1, 0, 2), (2, 1, 0, 1), (2, -1, 1, 0))


def box(size: Vector, center: Vector = _ORIGIN) -> Mesh:
    """A sharp-edged box of six quads.

    Args:
        size: Width, depth and height, metres.
        center: Its middle, metres.

    Returns:
        The closed mesh.
    """
    half = 0.5 * np.asarray(size, dtype=np.float64)
    if half.min() <= _SAME_M:
        return _sharp(half).moved(center)
    # All others are one box, stretched.
    cube, across = _cube()
    assert cube.normals is not None and cube.st is not None
    return Mesh(
        points=cube.points * half + np.asarray(center, dtype=np.float64),
        counts=cube.counts.copy(),
        indices=cube.indices.copy(),
        normals=cube.normals.copy(),
        st=(cube.st * half[across]).astype(np.float32),
    )


def _sharp(half: Array) -> Mesh:
    return _from_sides([np.array([-h, h]) for h in half], [np.zeros(2)] * 3, 0.0)


@cache
def _cube() -> tuple[Mesh, Ints]:
    """A box of half sizes 1, and (24, 2) the axes along which each corner's texture runs."""
    across = [sorted((u, v)) for _, _, u, v in _SIDES]
    return _sharp(np.ones(3)), np.repeat(np.array(across), 4, axis=0)


def rounded_box(
    size: Vector, radius: float = 0.003, *, segments: int = 1, center: Vector = _ORIGIN
) -> Mesh:
    """A box whose edges and corners are rounded.

    Args:
        size: Width, depth and height, metres.
        radius: Radius of the edges, metres; less where the box is too thin for it.
        segments: Straight pieces of each half of an edge's quarter circle.
        center: Its middle, metres.

    Returns:
        The closed mesh: 6 (2 segments + 1)^2 quads.
    """
    half = 0.5 * np.asarray(size, dtype=np.float64)
    radius = min(radius, 0.98 * float(half.min()))
    turn = np.radians(45.0) * np.linspace(1.0, 0.0, segments + 1)
    core = [np.repeat([radius - h, h - radius], segments + 1) for h in half]
    angles = [np.concatenate([-turn, turn[::-1]])] * 3
    return _from_sides(core, angles, radius).moved(center)


def cushion(
    size: Vector,
    *,
    radius: float = 0.05,
    crown: Vector = (0.01, 0.01, 0.025),
    divisions: int = 4,
    center: Vector = _ORIGIN,
) -> Mesh:
    """A soft box: rounded edges and sides that bulge.

    Args:
        size: Width, depth and height over the bulges, metres.
        radius: Radius of the edges, metres.
        crown: How far the sides of each axis bulge in their middle, metres.
        divisions: Quads along each flat part.
        center: Its middle, metres.

    Returns:
        The closed mesh.
    """
    swell = np.minimum(np.asarray(crown, dtype=np.float64), 0.2 * np.asarray(size))
    half = 0.5 * np.asarray(size, dtype=np.float64) - swell
    radius = min(radius, 0.98 * float(half.min()))
    turn = np.radians(45.0) * np.linspace(1.0, 0.0, 3)
    core, angles = [], []
    for h in half:
        inner = np.linspace(radius - h, h - radius, divisions + 1)
        core.append(np.concatenate([[inner[0]] * 2, inner, [inner[-1]] * 2]))
        angles.append(np.concatenate([-turn[:-1], np.zeros(divisions + 1), turn[-2::-1]]))
    plain = _from_sides(core, angles, radius)
    t = plain.points / half
    falloff = 1.0 - t**2
    bulge = np.roll(falloff, -1, axis=1) * np.roll(falloff, -2, axis=1)
    swollen = Mesh(
        plain.points + swell * t * bulge, plain.counts, plain.indices, plain.normals, plain.st
    )
    return with_normals(swollen, crease=80.0).moved(center)


def cylinder(
    radius: float, height: float, *, bevel: float = 0.0, segments: int = 32, base: Vector = _ORIGIN
) -> Mesh:
    """A capped cylinder along Z.

    Args:
        radius: Metres.
        height: Metres.
        bevel: Radius of its rounded rims, metres.
        segments: Sides.
        base: The middle of its lower cap, metres.

    Returns:
        The closed mesh.
    """
    return frustum(radius, radius, height, bevel=bevel, segments=segments, base=base)


def frustum(
    bottom: float,
    top: float,
    height: float,
    *,
    bevel: float = 0.0,
    segments: int = 32,
    base: Vector = _ORIGIN,
) -> Mesh:
    """A capped frustum of a cone along Z; a cone when one radius is zero.

    Args:
        bottom: Radius at its base, metres.
        top: Radius at its top, metres.
        height: Metres.
        bevel: Radius of its rounded rims, metres.
        segments: Sides.
        base: The middle of its lower cap, metres.

    Returns:
        The closed mesh.
    """
    corners = [(0.0, 0.0), (bottom, 0.0), (top, height), (0.0, height)]
    profile = [p for i, p in enumerate(corners) if i in (0, 3) or p[0] > 0.0]
    rounded = filleted(profile, bevel, segments=3) if bevel > 0.0 else np.array(profile)
    return lathe(rounded, segments=segments).moved(base)


def sphere(
    radius: float, *, segments: int = 32, center: Vector = _ORIGIN, squash: float = 1.0
) -> Mesh:
    """A sphere, or an ellipsoid of revolution about Z.

    Args:
        radius: Horizontal radius, metres.
        segments: Sides around the axis; half as many along it.
        center: Its middle, metres.
        squash: Vertical over horizontal radius.

    Returns:
        The closed mesh.
    """
    t = np.linspace(-0.5 * np.pi, 0.5 * np.pi, segments // 2 + 1)
    profile = np.stack([radius * np.cos(t), radius * squash * np.sin(t)], axis=1)
    profile[[0, -1], 0] = 0.0
    return lathe(profile, segments=segments).moved(center)


def lathe(profile: ArrayLike, *, segments: int = 32, crease: float = 40.0) -> Mesh:
    """The solid that a profile sweeps when it turns about Z.

    Args:
        profile: (P, 2) radius and height of its corners, metres. When both ends lie on the axis
            they are the poles; otherwise the last corner joins the first and the solid is a ring.
        segments: Sides around the axis.
        crease: Degrees from which a corner of the profile stays sharp.

    Returns:
        The closed mesh.
    """
    corners = np.asarray(profile, dtype=np.float64)
    if signed_area(corners) < 0.0:
        corners = corners[::-1]
    if corners[0, 0] > 0.0 or corners[-1, 0] > 0.0:
        corners = np.concatenate([corners, corners[:1]])
    low, high = _profile_normals(corners, np.cos(np.radians(crease)))
    angle = np.linspace(0.0, 2.0 * np.pi, segments + 1)
    turn = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    turn[-1] = turn[0]
    row, column = (a.ravel() for a in np.indices((len(corners) - 1, segments)))
    rows = np.stack([row, row, row + 1, row + 1], axis=1)
    columns = np.stack([column, column + 1, column + 1, column], axis=1)
    points = _turned(corners[rows], turn[columns])
    slopes = np.stack([low[row], low[row], high[row], high[row]], axis=1)
    st = _lathe_st(corners, rows, angle[columns], points)
    return _welded(points, _turned(slopes, turn[columns]), st)


def _turned(radial: Array, turn: Array) -> Array:
    """Radius and height (..., 2) turned into (..., 3)."""
    return np.concatenate([radial[..., :1] * turn, radial[..., 1:]], axis=-1)


def _profile_normals(corners: Array, crease: float) -> tuple[Array, Array]:
    """The normal of each piece of a profile at its start and at its end."""
    along = np.diff(corners, axis=0)
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    units = unit(normal)
    ring = bool(np.array_equal(corners[0], corners[-1]))
    following, before = np.roll(normal, -1, axis=0), np.roll(normal, 1, axis=0)
    if not ring:
        following[-1], before[0] = normal[-1], normal[0]

    return _blend(normal, units, before, crease), _blend(normal, units, following, crease)


def _blend(normal: Array, units: Array, neighbour: Array, crease: float) -> Array:
    """Mean with the neighbouring piece, weighted by length: long flats stay flat."""
    facing = np.einsum("ij,ij->i", units, neighbour) / np.linalg.norm(neighbour, axis=1)
    mean = np.where((facing > crease)[:, None], normal + neighbour, normal)
    return unit(mean)


def _lathe_st(corners: Array, rows: Ints, angle: Array, points: Array) -> Array:
    """Unrolled where the surface is steep, seen from above where it is flat."""
    along = np.diff(corners, axis=0)
    flat = np.abs(along[:, 0]) > np.abs(along[:, 1])
    mean = 0.5 * (corners[:-1, 0] + corners[1:, 0])
    piece = rows[:, 0]
    unrolled = np.stack([angle * mean[piece][:, None], lengths(corners)[rows]], axis=-1)
    return np.where(flat[piece][:, None, None], points[..., :2], unrolled)


def _from_sides(core: Sequence[Array], angles: Sequence[Array], radius: float) -> Mesh:
    """A box from a grid on each side, its edges rounded by spheres about the core points."""
    points, normals, st = [], [], []
    for axis, sign, u, v in _SIDES:
        i, j = (a.ravel() for a in np.indices((len(core[u]) - 1, len(core[v]) - 1)))
        i, j = np.stack([i, i + 1, i + 1, i], axis=1), np.stack([j, j, j + 1, j + 1], axis=1)
        direction = np.empty((*i.shape, 3))
        direction[..., axis] = sign
        direction[..., u], direction[..., v] = np.tan(angles[u][i]), np.tan(angles[v][j])
        direction = unit(direction, UP)
        center = np.empty_like(direction)
        center[..., axis] = sign * core[axis].max()
        center[..., u], center[..., v] = core[u][i], core[v][j]
        unrolled = [core[u][i] + radius * angles[u][i], core[v][j] + radius * angles[v][j]]
        points.append(center + radius * direction)
        normals.append(direction)
        st.append(np.stack(unrolled if u < v else unrolled[::-1], axis=-1))
    return _welded(np.concatenate(points), np.concatenate(normals), np.concatenate(st))


def _welded(points: Array, normals: Array, st: Array) -> Mesh:
    """A mesh from loose quads: equal points are shared, collapsed corners dropped.

    Args:
        points: (F, 4, 3).
        normals: (F, 4, 3).
        st: (F, 4, 2).
    """
    first, places = weld(points.reshape(-1, 3), _SAME_M)
    corners = places.reshape(-1, 4)
    kept = corners != np.roll(corners, -1, axis=1)
    counts = kept.sum(axis=1)
    kept &= (counts >= 3)[:, None]
    return Mesh(
        points=points.reshape(-1, 3)[first],
        counts=counts[counts >= 3].astype(np.int32),
        indices=corners[kept].astype(np.int32),
        normals=unit(normals[kept], UP).astype(np.float32),
        st=st[kept].astype(np.float32),
    )
