"""A client of lightmaps that knows nothing of this package: plain pxr, numpy and OpenImageIO."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
from pxr import Usd, UsdGeom

from openrooms_usd.arrays import Array, Ints


@dataclass(frozen=True)
class Client:
    """All triangles of a baked stage, with where they are in which picture.

    Attributes:
        corners: (M, 3, 3) in the stage's frame.
        places: (M, 3, 2) texture coordinates in the picture.
        pictures: (M,) number of the picture, -1 where there is none.
        files: The pictures.
    """

    corners: Array
    places: Array
    pictures: Ints
    files: tuple[str, ...]

    def irradiance(self, rows: Ints, points: Array) -> Array:
        """(P, 3) lux at points on triangles, bilinear; NaN where there is no lightmap."""
        a, b, c = np.moveaxis(self.corners[rows], 1, 0)
        sides = np.stack([b - a, c - a], axis=2)
        inner = (np.linalg.pinv(sides) @ (points - a)[..., None])[..., 0]
        weights = np.column_stack([1.0 - inner.sum(axis=1), inner])
        st = np.einsum("pk,pkc->pc", weights, self.places[rows])
        found = np.full((len(rows), 3), np.nan)
        for number, file in enumerate(self.files):
            chosen = self.pictures[rows] == number
            found[chosen] = bilinear(read(file), st[chosen])
        return found


def read(file: str | Path) -> Array:
    """(height, width, 3), top row first."""
    source: Any = OpenImageIO.ImageInput.open(str(file))
    pixels = np.asarray(source.read_image(OpenImageIO.FLOAT), dtype=np.float64)
    source.close()
    return pixels


def bilinear(pixels: Array, st: Array) -> Array:
    """(P, 3) as a graphics card looks them up: t = 0 is the lower edge."""
    height, width = pixels.shape[:2]
    x, y = st[:, 0] * width - 0.5, (1.0 - st[:, 1]) * height - 0.5
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    across, down = (x - left)[:, None], (y - top)[:, None]

    def at(column: Any, row: Any) -> Any:
        return pixels[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)]

    upper = at(left, top) * (1 - across) + at(left + 1, top) * across
    lower = at(left, top + 1) * (1 - across) + at(left + 1, top + 1) * across
    return np.asarray(upper * (1 - down) + lower * down)


def load(file: Path) -> Client:
    """Read a baked stage as its documentation says."""
    stage = Usd.Stage.Open(str(file))
    cache, files = UsdGeom.XformCache(), dict[str, int]()
    corners, places, pictures = [], [], []
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()):
        if not prim.IsA(UsdGeom.Mesh):
            continue
        mesh = UsdGeom.Mesh(prim)
        world = np.array(cache.GetLocalToWorldTransform(prim))
        points = np.array(mesh.GetPointsAttr().Get()) @ world[:3, :3] + world[3, :3]
        counts = np.array(mesh.GetFaceVertexCountsAttr().Get())
        indices = np.array(mesh.GetFaceVertexIndicesAttr().Get())
        st, picture = np.zeros((len(indices), 2)), -1
        coordinates = UsdGeom.PrimvarsAPI(prim).GetPrimvar("st1")
        if coordinates and coordinates.HasValue():
            found = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(
                "openrooms:lightmap:scaleOffset"
            )
            scale_s, scale_t, offset_s, offset_t = found.Get()
            st = np.array(coordinates.Get()) * (scale_s, scale_t) + (offset_s, offset_t)
            (atlas,) = (
                found.GetAttr().GetPrim().GetRelationship("openrooms:lightmap:atlas").GetTargets()
            )
            texture = stage.GetAttributeAtPath(
                atlas.AppendProperty("openrooms:lightmap:irradiance")
            )
            picture = files.setdefault(texture.Get().resolvedPath, len(files))
        first = np.cumsum(counts) - counts
        for step in range(1, counts.max() - 1):
            begin = first[counts > step + 1]
            fan = np.stack([begin, begin + step, begin + step + 1], axis=1)
            corners.append(points[indices[fan]])
            places.append(st[fan])
            pictures.append(np.full(len(fan), picture))
    return Client(
        np.concatenate(corners), np.concatenate(places), np.concatenate(pictures), tuple(files)
    )
