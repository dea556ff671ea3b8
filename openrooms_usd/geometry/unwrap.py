"""A second set of texture coordinates in which no two places share one: for what is baked.

The charts are xatlas' (MIT; after Sander et al. 2002 and Levy et al. 2002); the extra ``bake``.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.errors import MissingPackageError

if TYPE_CHECKING:
    from types import ModuleType


# Two places of a corner that are nearer than this are the same.
_SAME_PLACE_TEXELS: Final = 1e-2


@dataclass(frozen=True, eq=False)
class Layout:
    """Triangles in a rectangle of texels, none over another.

    Attributes:
        size: Width and height, texels.
        places: (M, 3, 2) of their corners, texels from the lower left.
    """

    size: tuple[int, int]
    places: Array


def laid_out(
    points: Array,
    triangles: NDArray[np.int32],
    faces: NDArray[np.int32],
    *,
    texels_per_metre: float,
    padding: int = 2,
) -> Layout:
    """Lay out polygons without overlaps, as large as they are; no polygon is cut.

    The same polygons always give the same layout.

    Args:
        points: (N, 3) metres.
        triangles: (M, 3) rows of ``points``, each with an area.
        faces: (M,) the polygon that each is part of.
        texels_per_metre: How finely.
        padding: Texels that are kept free between charts, and around all.

    Raises:
        MissingPackageError: xatlas is not installed.
    """
    joined, inverse = np.unique(points, axis=0, return_inverse=True)
    rows = inverse.reshape(-1)[triangles]
    size, places = _packed(joined, rows, texels_per_metre, padding)
    # Charts end at edges of triangles. A polygon has one place for each of its corners, so those
    # that were cut are charts of their own, below the others.
    loose = np.isin(faces, _cut(faces, rows, places))
    if not loose.any():
        return Layout(size, places)
    below, places[loose] = _flat(points[triangles[loose]], faces[loose], texels_per_metre, padding)
    places[~loose] += (0.0, below[1])
    return Layout((max(size[0], below[0]), size[1] + below[1]), places)


def _packed(
    points: Array, triangles: Ints, density: float, padding: int
) -> tuple[tuple[int, int], Array]:
    """Size and (M, 3, 2) places of the charts of xatlas; NaN for what it cannot place."""
    xatlas = _xatlas()
    low, high = points.min(axis=0), points.max(axis=0)
    extent = float((high - low).max())
    options = xatlas.PackOptions()
    options.padding, options.bilinear = padding, True
    # Tolerances of the package are absolute.
    options.resolution, options.texels_per_unit = 0, density * extent
    atlas = xatlas.Atlas()
    small = ((points - low) / extent).astype(np.float32)
    atlas.add_mesh(small, triangles.astype(np.uint32))
    atlas.generate(xatlas.ChartOptions(), options)
    _, corners, found = atlas.get_mesh(0)
    size = int(atlas.width), int(atlas.height)
    places = np.asarray(found, dtype=np.float64)[np.asarray(corners).reshape(-1, 3)] * size
    return (size[0] + padding, size[1] + padding), places + 0.5 * padding


def _cut(faces: NDArray[np.int32], rows: Ints, places: Array) -> NDArray[np.int32]:
    """The polygons of which a corner has several places, or none."""
    pairs = np.stack([np.repeat(faces, 3), rows.reshape(-1)], axis=1)
    corners, which = np.unique(pairs, axis=0, return_inverse=True)
    flat = places.reshape(-1, 2)
    spread = np.full((2, len(corners), 2), [[[np.inf]], [[-np.inf]]])
    np.minimum.at(spread[0], which.reshape(-1), flat)
    np.maximum.at(spread[1], which.reshape(-1), flat)
    with np.errstate(invalid="ignore"):
        whole = (spread[1] - spread[0]).max(axis=1) <= _SAME_PLACE_TEXELS
    return np.asarray(np.unique(corners[~whole, 0]), dtype=np.int32)


def _flat(
    corners: Array, faces: NDArray[np.int32], density: float, padding: int
) -> tuple[tuple[int, int], Array]:
    """Size and (M, 3, 2) places of polygons that are each seen along their own normal."""
    places = np.zeros((*corners.shape[:2], 2))
    polygons = [faces == face for face in np.unique(faces)]
    for rows in polygons:
        a, b, c = np.moveaxis(corners[rows], 1, 0)
        normal = np.cross(b - a, c - a).sum(axis=0)
        normal /= max(float(np.linalg.norm(normal)), np.finfo(float).tiny)
        along = b[0] - a[0] - ((b[0] - a[0]) @ normal) * normal
        along /= max(float(np.linalg.norm(along)), np.finfo(float).tiny)
        flat = corners[rows] @ np.stack([along, np.cross(normal, along)], axis=1) * density
        places[rows] = flat - flat.min(axis=(0, 1)) + 0.5 * padding
    sizes = np.array([np.ceil(places[rows].max(axis=(0, 1))) for rows in polygons]).astype(int)
    at, size = shelved(sizes + padding)
    for rows, corner in zip(polygons, at, strict=True):
        places[rows] += corner
    return size, places


def _xatlas() -> "ModuleType":
    try:
        import xatlas
    except ImportError as error:
        raise MissingPackageError(
            f"unwrapping needs the package 'xatlas', which cannot be imported ({error})",
            remedy="pip install openrooms-usd[bake]",
        ) from error
    package: ModuleType = xatlas
    return package


def shelved(sizes: Ints, width: int | None = None) -> tuple[Ints, tuple[int, int]]:
    """Pack rectangles, upright as they are: the highest first, each on the first shelf with room.

    (First fit by decreasing height: Coffman et al. 1980.)

    Args:
        sizes: (N, 2) width and height of each.
        width: Of the larger one; None: about as wide as high, and as the widest at least.

    Returns:
        (N, 2) lower left corner of each, and the width and height that all of them need.
    """
    if not len(sizes):
        return np.zeros((0, 2), np.int64), (0, 0)
    if width is None:
        width = max(int(np.ceil(np.sqrt(sizes.prod(axis=1).sum()))), int(sizes[:, 0].max()))
    corners = np.zeros((len(sizes), 2), dtype=np.int64)
    shelves: list[list[int]] = []  # where each begins, and how far it is full
    top = 0
    for row in np.lexsort((-sizes[:, 0], -sizes[:, 1])).tolist():
        across, high = sizes[row].tolist()
        shelf = next((one for one in shelves if one[1] + across <= width), None)
        if shelf is None:
            shelf = [top, 0]
            shelves.append(shelf)
            top += high
        corners[row] = shelf[1], shelf[0]
        shelf[1] += across
    return corners, (max(full for _, full in shelves), top)
