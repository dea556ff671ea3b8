"""Worktops of kitchens: one slab over a whole row, with holes for sink and hob."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, row, solid
from openrooms_usd.furniture.joinery.pieces import (
    NOTHING_ORDERED,
    Cutout,
    FitOptions,
    Parts,
    Size,
    Style,
)
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.normals import with_normals
from openrooms_usd.geometry.uv import cube_projection

# Of its upper edges, metres.
_BEVEL_M: Final = 0.002


def plate(size: Size, cutouts: Sequence[Cutout]) -> Mesh:
    """A slab on the origin with rectangular holes, its upper edges bevelled.

    It is cut into a grid along all edges of the holes: the upper and lower sides of the cells that
    are left, and a wall wherever a cell has no neighbour.

    Args:
        size: Metres.
        cutouts: Holes, within the slab and apart from each other.

    Returns:
        The closed mesh.
    """
    half = 0.5 * np.array(size[:2])
    edge = min(_BEVEL_M, 0.2 * size[2])
    holes = np.array(cutouts, dtype=np.float64).reshape(-1, 4)
    low, high = holes[:, :2] - 0.5 * holes[:, 2:], holes[:, :2] + 0.5 * holes[:, 2:]
    xs, ys = (
        np.unique([-h, edge - h, h - edge, h, *low[:, axis], *high[:, axis]])
        for axis, h in enumerate(half)
    )
    middles = np.meshgrid(0.5 * (xs[1:] + xs[:-1]), 0.5 * (ys[1:] + ys[:-1]), indexing="ij")
    full = np.ones(middles[0].shape, dtype=bool)
    for a, b in zip(low, high, strict=True):
        x, y = middles
        full &= ~((x > a[0]) & (x < b[0]) & (y > a[1]) & (y < b[1]))
    grid = np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=-1).reshape(-1, 2)
    rim = (np.abs(grid) > half - 1e-9).any(axis=1)
    top = np.where(rim, size[2] - edge, size[2])
    points = np.concatenate(
        [np.column_stack([grid, np.zeros(len(grid))]), np.column_stack([grid, top])]
    )
    mesh = Mesh(points, *_faces(full, len(ys), len(grid)))
    return with_normals(cube_projection(mesh), crease=30.0)


def _faces(full: np.ndarray, rows: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Counts and corners of the quads around the cells of a grid that are full."""
    i, j = np.nonzero(full)
    a, b, c, d = i * rows + j, (i + 1) * rows + j, (i + 1) * rows + j + 1, i * rows + j + 1
    quads = [np.stack([a, b, c, d], axis=1) + count, np.stack([d, c, b, a], axis=1)]
    around = np.pad(full, 1)
    for near, (p, q) in (
        (around[i + 1, j], (a, b)),
        (around[i + 2, j + 1], (b, c)),
        (around[i + 1, j + 2], (c, d)),
        (around[i, j + 1], (d, a)),
    ):
        p, q = p[~near], q[~near]
        quads.append(np.stack([p, q, q + count, p + count], axis=1))
    corners = np.concatenate(quads).astype(np.int32)
    used = np.full(len(corners), 4, dtype=np.int32)
    return used, corners.reshape(-1)


def slab(size: Size, rng: np.random.Generator, order: FitOptions = NOTHING_ORDERED) -> Parts:
    """A plain slab with the holes that are ordered."""
    return {"countertop": plate(size, order.cutouts)}


CATEGORY: Final = BuiltCategory(
    description="the worktop of a row of kitchen units",
    size=(2.4, 0.63, 0.038),
    min_size=(0.2, 0.2, 0.012),
    max_size=(8.0, 1.6, 0.1),
    styles={"slab": Style(slab, takes=("cutouts",))},
    size_variation=STANDARD,
    support="surface",
    fixed=True,
    words="kitchen_worktop",
    classes=Classes("counter", "counter", "countertop"),
    schemes=(scheme("stone", weight=2.0), scheme("wood")),
    construction=(row(ANY, solid(), "common"),),
    offers_surfaces=("worktop",),
)
