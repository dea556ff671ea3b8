"""A polygon mesh as plain arrays: what every generator makes and every reader gives."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.geometry.vectors import unit


@dataclass(frozen=True)
class Mesh:
    """Polygons with face-varying normals and texture coordinates.

    Attributes:
        points: (N, 3) metres.
        counts: (F,) corners of each face.
        indices: (K,) point of each corner, K = sum of counts; counter-clockwise seen from outside.
        normals: (K, 3) unit normal of each corner, or None.
        st: (K, 2) texture coordinates of each corner in metres, or None.
    """

    points: Array
    counts: NDArray[np.int32]
    indices: NDArray[np.int32]
    normals: Floats | None = None
    st: Floats | None = None

    @property
    def extent(self) -> Array:
        """(2, 3) least and greatest coordinates."""
        return np.stack([self.points.min(axis=0), self.points.max(axis=0)])

    def triangles(self) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Fan triangulation, exact for convex faces.

        Returns:
            (M, 3) corners (into ``indices``) of each triangle, and (M,) the face it is from.
        """
        fans = np.maximum(self.counts - 2, 0)
        faces = np.repeat(np.arange(len(self.counts), dtype=np.int32), fans)
        first = np.repeat(np.cumsum(self.counts) - self.counts, fans)
        step = np.arange(len(faces)) - np.repeat(np.cumsum(fans) - fans, fans)
        corners = np.stack([first, first + step + 1, first + step + 2], axis=1)
        return corners.astype(np.int32), faces

    def areas(self) -> Array:
        """(F,) area of each face, square metres."""
        corners, faces = self.triangles()
        a, b, c = np.moveaxis(self.points[self.indices[corners]], 1, 0)
        totals = np.zeros(len(self.counts))
        np.add.at(totals, faces, 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))
        return totals

    def volume(self) -> float:
        """Enclosed volume by the divergence theorem, cubic metres; right for closed meshes."""
        corners, _ = self.triangles()
        a, b, c = np.moveaxis(self.points[self.indices[corners]], 1, 0)
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)

    def moved(self, offset: ArrayLike) -> "Mesh":
        """The mesh moved by ``offset``, metres."""
        return replace(self, points=self.points + np.asarray(offset, dtype=np.float64))

    def transformed(self, matrix: ArrayLike) -> "Mesh":
        """The mesh under a (4, 4) or (3, 3) matrix for column vectors; mirrors flip the winding.

        Texture coordinates stay as they are.
        """
        M = np.asarray(matrix, dtype=np.float64)
        linear, offset = M[:3, :3], M[:3, 3] if M.shape[1] == 4 else np.zeros(3)
        moved = replace(self, points=self.points @ linear.T + offset)
        if self.normals is not None:
            normals = unit(self.normals @ np.linalg.inv(linear))
            moved = replace(moved, normals=normals.astype(np.float32))
        return moved.flipped() if np.linalg.det(linear) < 0 else moved

    def flipped(self) -> "Mesh":
        """The mesh with every face turned round; its normals are kept."""
        ends = np.repeat(np.cumsum(self.counts), self.counts)
        starts = np.repeat(np.cumsum(self.counts) - self.counts, self.counts)
        order = starts + ends - 1 - np.arange(len(self.indices))
        return replace(
            self,
            indices=self.indices[order],
            normals=None if self.normals is None else self.normals[order],
            st=None if self.st is None else self.st[order],
        )


def joined(meshes: Sequence[Mesh]) -> Mesh:
    """One mesh of several; normals and st are kept when all of them have some."""
    offsets = np.cumsum([0, *(len(mesh.points) for mesh in meshes[:-1])])
    normals = [mesh.normals for mesh in meshes if mesh.normals is not None]
    st = [mesh.st for mesh in meshes if mesh.st is not None]
    return Mesh(
        points=np.concatenate([mesh.points for mesh in meshes]),
        counts=np.concatenate([mesh.counts for mesh in meshes]),
        indices=np.concatenate(
            [mesh.indices + np.int32(offset) for mesh, offset in zip(meshes, offsets, strict=True)]
        ),
        normals=np.concatenate(normals) if len(normals) == len(meshes) else None,
        st=np.concatenate(st) if len(st) == len(meshes) else None,
    )
