"""How sharp a mesh prim says that its edges and points are."""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pxr import UsdGeom

from openrooms_usd.geometry.cages import Cage
from openrooms_usd.usd.arrays import array_of, integers
from openrooms_usd.usd.frames import TIME

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

# What is sharper stays so, however often it is refined.
_ENDLESS: Final = UsdGeom.Mesh.SHARPNESS_INFINITE


def _sharp(values: Any, count: int) -> Array | None:
    """One sharpness for each of so many; what is beyond USD's greatest is endless."""
    found = array_of(values, np.float64)
    if len(found) != count or not np.isfinite(found).all():
        return None
    return np.where(found >= _ENDLESS, np.inf, np.maximum(found, 0.0))


def read_corners(geometry: UsdGeom.Mesh, count: int) -> Array:
    """(N,) sharpness of each point."""
    found = np.zeros(count)
    rows = integers(geometry.GetCornerIndicesAttr())
    sharp = _sharp(geometry.GetCornerSharpnessesAttr().Get(TIME), len(rows))
    if sharp is not None and len(rows) and rows.min() >= 0 and rows.max() < count:
        np.maximum.at(found, rows, sharp)
    return found


def read_creases(geometry: UsdGeom.Mesh, cage: Cage) -> Array:
    """(K,) sharpness of each edge, at the corners that begin it."""
    edges = np.zeros(len(cage.ends))
    points = integers(geometry.GetCreaseIndicesAttr())
    lengths = integers(geometry.GetCreaseLengthsAttr())
    if not len(lengths) or lengths.min() < 2 or lengths.sum() != len(points):
        return edges[cage.edges]
    # Edges of one crease follow each other; between creases there is none.
    inner = np.ones(len(points), dtype=np.bool_)
    inner[np.cumsum(lengths) - 1] = False
    starts = np.flatnonzero(inner)
    pairs = np.sort(np.stack([points[starts], points[starts + 1]], axis=1), axis=1)
    said = geometry.GetCreaseSharpnessesAttr().Get(TIME)
    sharp = _sharp(said, len(lengths))
    sharp = _sharp(said, len(pairs)) if sharp is None else np.repeat(sharp, lengths - 1)
    if sharp is None:
        return edges[cage.edges]
    size = len(cage.corners) + 1
    keys = cage.ends[:, 0] * size + cage.ends[:, 1]
    wanted = pairs[:, 0] * size + pairs[:, 1]
    at = np.searchsorted(keys, wanted)
    there = (at < len(keys)) & (keys[np.minimum(at, len(keys) - 1)] == wanted)
    np.maximum.at(edges, at[there], sharp[there])
    return edges[cage.edges]
