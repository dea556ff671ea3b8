"""Triangles as glTF wants them: vertices that hold all that is known there, and their numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Floats
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.geometry.vectors import unit

# From the numbers of vertices beyond this two bytes are too few: the last one has a meaning.
_SHORT_MOST: Final = 65535
# Tangents shorter than this, in square metres and relative to their sum, have no direction.
_NO_TANGENT: Final = 1e-12


@dataclass(frozen=True)
class Coordinates:
    """One set of texture coordinates: a primvar, and what a material makes of it.

    Attributes:
        primvar: Its name.
        matrix: (3, 3) the material's transform, row by row; for columns (s, t, 1).
    """

    primvar: str
    matrix: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Vertices:
    """Arrays of a primitive.

    Attributes:
        attributes: ``POSITION``, ``NORMAL``, ``TANGENT``, ``TEXCOORD_0`` ...: (V, 2 to 4) float32.
        indices: (3 M,) rows of these, uint16 or uint32.
        losses: What could not be kept, in words.
    """

    attributes: dict[str, Floats]
    indices: NDArray[Any]
    losses: tuple[str, ...]


def vertices(
    mesh: TriangleMesh,
    rows: NDArray[np.int32],
    sets: Sequence[Coordinates],
    normal_set: int | None = None,
) -> Vertices:
    """The vertices of some triangles; corners where everything agrees are one.

    Args:
        mesh: The triangles, in their local frame.
        rows: Which of them.
        sets: The sets of texture coordinates that are wanted, in their order.
        normal_set: Which of these a normal map is looked up by; its tangents come with it.
    """
    losses: list[str] = []
    columns = {
        "POSITION": mesh.points[mesh.triangles[rows]].astype(np.float32),
        "NORMAL": _normals(mesh, rows),
    }
    for number, wanted in enumerate(sets):
        columns[f"TEXCOORD_{number}"] = _coordinates(mesh, rows, wanted, losses)
    if normal_set is not None:
        tangents = _tangents(columns["POSITION"], columns[f"TEXCOORD_{normal_set}"])
        columns["hand"] = tangents[..., 3:]
    corners = {name: values.reshape(len(rows) * 3, -1) for name, values in columns.items()}
    firsts, indices = _welded(np.concatenate(list(corners.values()), axis=1))
    short = np.uint16 if len(firsts) < _SHORT_MOST else np.uint32
    kept = {name: np.ascontiguousarray(values[firsts]) for name, values in corners.items()}
    if normal_set is not None:
        kept["TANGENT"] = _smoothed(tangents.reshape(-1, 4), indices, kept)
        del kept["hand"]
    return Vertices(kept, indices.astype(short), tuple(losses))


def _welded(rows: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The first of each of the different rows, in their order, and which of these each row is."""
    # Zero has two signs.
    packed = np.ascontiguousarray(rows + np.float32(0))
    whole = packed.view(np.dtype((np.void, packed.dtype.itemsize * packed.shape[1]))).ravel()
    _, firsts, inverse = np.unique(whole, return_index=True, return_inverse=True)
    order = np.argsort(firsts)
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return firsts[order], place[inverse.ravel()]


def _normals(mesh: TriangleMesh, rows: NDArray[np.int32]) -> Floats:
    if mesh.normals is not None:
        return mesh.normals[rows].astype(np.float32)
    a, b, c = np.moveaxis(mesh.points[mesh.triangles[rows]], 1, 0)
    flat = unit(np.cross(b - a, c - a))
    return np.repeat(flat[:, None], 3, axis=1).astype(np.float32)


def _coordinates(
    mesh: TriangleMesh, rows: NDArray[np.int32], wanted: Coordinates, losses: list[str]
) -> Floats:
    """(M, 3, 2) in glTF's way: v grows downwards from the upper edge of the picture."""
    st = mesh.uvs.get(wanted.primvar)
    if st is None:
        st = mesh.st
        instead = "others are" if st is not None else "none are there; 0 is"
        losses.append(f"texture coordinates {wanted.primvar} are missing, {instead} used")
    if st is None:
        return np.zeros((len(rows), 3, 2), np.float32)
    matrix = np.array(wanted.matrix).reshape(3, 3)
    uv = st[rows].astype(np.float64) @ matrix[:2, :2].T + matrix[:2, 2]
    return np.stack([uv[..., 0], 1.0 - uv[..., 1]], axis=-1).astype(np.float32)


def _tangents(corners: Floats, uv: Floats) -> Floats:
    """(M, 3, 4) of each triangle: where u grows, times its area, and the hand of the frame.

    The hand is +1 where u, the upward way in the picture (v grows downwards) and the front make a
    right-handed frame.
    """
    a, b, c = np.moveaxis(corners.astype(np.float64), 1, 0)
    first, second = np.moveaxis(uv.astype(np.float64)[:, 1:] - uv[:, :1], 1, 0)
    turn = first[:, 0] * second[:, 1] - second[:, 0] * first[:, 1]
    along = (b - a) * second[:, 1:] - (c - a) * first[:, 1:]
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    hand = np.where(turn > 0, -1.0, 1.0)
    along = unit(along) * (areas * np.sign(turn))[:, None]
    found = np.concatenate([along, hand[:, None]], axis=1).astype(np.float32)
    return np.repeat(found[:, None], 3, axis=1)


def _smoothed(corners: Floats, indices: NDArray[np.intp], kept: dict[str, Floats]) -> Floats:
    """(V, 4) the mean tangent at each vertex, square to the normal, with its hand."""
    normals = kept["NORMAL"].astype(np.float64)
    summed = np.stack(
        [np.bincount(indices, corners[:, axis], len(normals)) for axis in range(3)], axis=1
    )
    flat = summed - (summed * normals).sum(axis=1, keepdims=True) * normals
    # Where coordinates say nothing any direction will do.
    lost = np.linalg.norm(flat, axis=1) <= _NO_TANGENT * (1.0 + np.linalg.norm(summed, axis=1))
    side = np.eye(3)[np.abs(normals[lost]).argmin(axis=1)]
    flat[lost] = np.cross(normals[lost], side)
    return np.concatenate([unit(flat), kept["hand"]], axis=1).astype(np.float32)
