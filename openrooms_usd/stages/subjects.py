"""What a room is photographed for: its main furniture, by category and else by size."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import names
from openrooms_usd.furniture.registry import record
from openrooms_usd.geometry.composition import BARE, NO_SUBJECT, Subjects
from openrooms_usd.usd.meshes import PlacedMesh
from openrooms_usd.usd.semantics import read_label

Array = NDArray[np.float64]
Ints = NDArray[np.int32]

# Of a thing whose record says nothing, for each metre of its longest side, and at most.
_WORTH_PER_M: Final = 0.4
_MOST_WORTH_BY_SIZE: Final = 0.8
# Things that are shorter than this, metres, are nobody's subject.
_SMALL_M: Final = 0.4
# Classes of NYU40 in the shell on which there is nothing to look at, tiles and panels among them.
_BARE: Final = ("wall", "ceiling", "door")
# How many subjects a room has at most, and points on each.
_MAX_SUBJECTS: Final = 16
_POINTS: Final = 20


def room_subjects(meshes: list[PlacedMesh], corners: Array, owners: Ints) -> Subjects:
    """The main things of a room.

    Args:
        meshes: All that is drawn.
        corners: (M, 3, 3) corners of their triangles in the world, metres.
        owners: (M,) the mesh of each triangle.
    """
    roots = [_root(mesh.path) for mesh in meshes]
    labels = {
        root: read_label(mesh.prim, names.CATEGORY) or ""
        for root, mesh in zip(roots, meshes, strict=True)
        if root
    }
    number = {root: row for row, root in enumerate(labels)}
    thing_of_mesh = np.array([number.get(root, NO_SUBJECT) for root in roots], dtype=np.int32)
    bare = np.array(
        [
            not root and read_label(mesh.prim, names.NYU40) in _BARE
            for root, mesh in zip(roots, meshes, strict=True)
        ],
        dtype=np.bool_,
    )
    thing = thing_of_mesh[owners] if len(roots) else np.zeros(0, dtype=np.int32)
    rows = [np.flatnonzero(thing == row) for row in range(len(labels))]
    worth = np.array(
        [_worth(label, corners[at]) for label, at in zip(labels.values(), rows, strict=True)]
    )
    main = np.argsort(-worth, kind="stable")[:_MAX_SUBJECTS]
    main = main[worth[main] > 0.0] if len(main) else main
    renamed = np.full(len(labels) + 1, NO_SUBJECT, dtype=np.int32)
    renamed[main] = np.arange(len(main))
    points = [_surface_points(corners[rows[row]]) for row in main]
    of_triangle = np.where(bare[owners], BARE, renamed[thing]) if len(bare) else renamed[thing]
    return Subjects(np.array(points).reshape(-1, _POINTS, 3), worth[main], of_triangle)


def _root(path: str) -> str:
    """The object that a mesh belongs to; nothing for those of the shell."""
    inside = path.startswith(f"{names.FURNITURE}/")
    return path[len(names.FURNITURE) + 1 :].split("/")[0] if inside else ""


def _worth(category: str, corners: Array) -> float:
    known = record(category)
    if known and known.view_importance is not None:
        return known.view_importance
    longest = float(np.ptp(corners.reshape(-1, 3), axis=0).max()) if len(corners) else 0.0
    return min(_WORTH_PER_M * longest, _MOST_WORTH_BY_SIZE) if longest > _SMALL_M else 0.0


def _surface_points(corners: Array) -> Array:
    """(P, 3) middles of triangles, spread evenly by area over the order of the mesh."""
    a, b, c = np.moveaxis(corners, 1, 0)
    areas = np.cumsum(np.linalg.norm(np.cross(b - a, c - a), axis=1))
    at = (np.arange(_POINTS) + 0.5) / _POINTS * areas[-1]
    return np.asarray(corners.mean(axis=1)[np.minimum(np.searchsorted(areas, at), len(areas) - 1)])
