"""The points of surfaces that the texels of atlases stand for.

A texel is looked at in a few places, evenly spread. Of those that are on a triangle each is a point
of the surface; a triangle that none of them meets counts by its middle.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.rendering.bake.atlases import Atlases
from openrooms_usd.rendering.bake.request import TexelPoints

# Places in a texel to a side.
_PLACES_A_SIDE: Final = 4
# Candidates that are tested at once.
_CANDIDATES: Final = 1 << 22
# What counts as inside a triangle, of its barycentric coordinates.
_EDGE: Final = -1e-9


@dataclass(frozen=True, eq=False)
class Texels:
    """The texels of atlases that show a surface.

    Attributes:
        atlas: (T,) the picture that each is in.
        column: (T,) from the left.
        row: (T,) from the bottom.
        points: What each stands for.
    """

    atlas: Ints
    column: Ints
    row: Ints
    points: TexelPoints

    def __len__(self) -> int:
        """How many there are."""
        return len(self.points)


def find_texels(atlases: Atlases) -> Texels:
    """The texels that show a surface, in the order of atlas, row and column."""
    places, pages, corners, normals = _triangles(atlases)
    found = [*_texels_of(places)]
    triangle = np.concatenate([np.zeros(0, np.int64), *(rows for rows, _, _ in found)])
    cell = np.concatenate([np.zeros((0, 2), np.int64), *(cells for _, cells, _ in found)])
    weights = np.concatenate([np.zeros((0, 2)), *(inner for _, _, inner in found)])
    missed = np.setdiff1d(np.arange(len(places)), triangle)
    triangle = np.concatenate([triangle, missed])
    cell = np.concatenate([cell, np.floor(places[missed].mean(axis=1)).astype(np.int64)])
    weights = np.concatenate([weights, np.full((len(missed), 2), 1.0 / 3.0)])
    # Points by their texels, and within these by triangle: the same whatever the chunks.
    order = np.lexsort((triangle, cell[:, 0], cell[:, 1], pages[triangle]))
    triangle, cell, weights = triangle[order], cell[order], weights[order]
    keys = np.column_stack([pages[triangle], cell[:, 1], cell[:, 0]])
    begins = np.flatnonzero(np.any(np.diff(keys, axis=0, prepend=-1), axis=1))
    atlas, row, column = keys[begins].T
    points = TexelPoints(
        corners,
        normals,
        np.append(begins, len(triangle)),
        triangle.astype(np.int32),
        weights.astype(np.float32),
    )
    return Texels(atlas, column, row, points)


def _triangles(atlases: Atlases) -> tuple[Array, Ints, Array, Array]:
    """Places in the pictures, numbers of the pictures, corners and front normals of all."""
    places, pages, corners, normals = [], [], [], []
    for placement in atlases.placements:
        places.append(placement.layout.places + placement.corner)
        pages.append(np.full(len(placement.layout.places), placement.atlas))
        for member in placement.unit.members:
            own = member.mesh.world_points()[member.mesh.mesh.triangles[member.lit]]
            a, b, c = np.moveaxis(own, 1, 0)
            front = np.cross(b - a, c - a) * (-1.0 if member.mesh.mirrored else 1.0)
            corners.append(own)
            normals.append(unit(front))
    return (
        np.concatenate([np.zeros((0, 3, 2)), *places]),
        np.concatenate([np.zeros(0, np.int64), *pages]),
        np.concatenate([np.zeros((0, 3, 3)), *corners]),
        np.concatenate([np.zeros((0, 3)), *normals]),
    )


def _texels_of(places: Array) -> Iterator[tuple[Ints, Ints, Array]]:
    """(triangles, (P, 2) texels, (P, 2) barycentric coordinates) of places on triangles."""
    fine = places * _PLACES_A_SIDE
    low = np.ceil(fine.min(axis=1) - 0.5).astype(np.int64)
    high = np.floor(fine.max(axis=1) - 0.5).astype(np.int64)
    spans = np.maximum(high - low + 1, 0)
    counts = spans.prod(axis=1)
    chunks = np.cumsum(counts) // _CANDIDATES
    for rows in np.split(np.arange(len(places)), np.flatnonzero(np.diff(chunks)) + 1):
        triangle = np.repeat(rows, counts[rows])
        step = np.arange(len(triangle)) - np.repeat(
            np.cumsum(counts[rows]) - counts[rows], counts[rows]
        )
        wide = spans[triangle, 0]
        at = low[triangle] + np.column_stack([step % wide, step // wide])
        weights = _barycentric(fine[triangle], at + 0.5)
        inside = (weights >= _EDGE).all(axis=1) & (weights.sum(axis=1) <= 1.0 - _EDGE)
        yield triangle[inside], at[inside] // _PLACES_A_SIDE, weights[inside]


def _barycentric(corners: Array, at: Array) -> Array:
    """(P, 2) how much the second and the third corner count; negative where there is no area."""
    a, b, c = np.moveaxis(corners, 1, 0)
    u, v, w = b - a, c - a, at - a
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    second = w[:, 0] * v[:, 1] - w[:, 1] * v[:, 0]
    third = u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0]
    flat = area == 0.0
    found = np.column_stack([second, third]) / np.where(flat, 1.0, area)[:, None]
    return np.where(flat[:, None], -1.0, found)
