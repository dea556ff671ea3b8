"""Points of surfaces that nobody sees, because they are inside of something.

The floor below the leg of a table, a board where another one stands on it: a texel that is partly
hidden so would mix the dark in there with the light beside it, and the look-up of its neighbours
takes it too. From inside of a solid, nearly all that rays meet is turned away from them.
"""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.vectors import unit
from openrooms_usd.rendering.bake.request import LIFT_M, TexelPoints
from openrooms_usd.rendering.bake.texels import Texels
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.pictures import Array
from openrooms_usd.rendering.scene.rays import RayTracer

# Rays from each point: one along the normal, the others around it.
_AROUND: Final = 5
_TILT_DEG: Final = 55.0
# So many of a buried point's rays must meet a back.
_BACKS: Final = 5
_POINTS_AT_ONCE: Final = 1 << 19


def without_buried(texels: Texels, scene: Scene, tracer: RayTracer) -> Texels:
    """The texels that somebody sees, by the points of them that are not inside of something.

    Args:
        texels: All that show a surface.
        scene: What may be over it.
        tracer: Of that scene.
    """
    points = texels.points
    corners = scene.triangles.corners
    a, b, c = np.moveaxis(corners, 1, 0)
    fronts = unit(np.cross(b - a, c - a))
    chunks = range(0, len(points.triangles), _POINTS_AT_ONCE)
    buried = np.concatenate(
        [_buried(points, slice(at, at + _POINTS_AT_ONCE), fronts, tracer) for at in chunks]
    )
    texel_of = np.repeat(np.arange(len(points)), np.diff(points.first))
    left = np.bincount(texel_of[~buried], minlength=len(points))
    seen = left > 0
    if not seen.any():
        return texels
    chosen = replace(
        points,
        first=np.concatenate([[0], np.cumsum(left[seen])]),
        triangles=points.triangles[~buried],
        weights=points.weights[~buried],
    )
    return Texels(texels.atlas[seen], texels.column[seen], texels.row[seen], chosen)


def _buried(
    points: TexelPoints, some: slice, fronts: Array, tracer: RayTracer
) -> NDArray[np.bool_]:
    """(P,) whether nearly all rays of each point meet the back of what they meet first."""
    chosen = replace(points, triangles=points.triangles[some], weights=points.weights[some])
    normals = points.normals[chosen.triangles]
    begins = chosen.positions() + LIFT_M * normals
    backs = np.zeros(len(begins), dtype=np.int64)
    for ahead in _directions(normals):
        rows = tracer.rays(begins, ahead)
        backs += (rows >= 0) & (np.einsum("ij,ij->i", fronts[rows], ahead) > 0.0)
    return np.asarray(backs >= _BACKS)


def _directions(normals: Array) -> list[Array]:
    """Unit directions about normals."""
    least = np.eye(3)[np.abs(normals).argmin(axis=1)]
    across = unit(np.cross(normals, least))
    along = np.cross(normals, across)
    tilt = np.radians(_TILT_DEG)
    turns = 2.0 * np.pi * np.arange(_AROUND) / _AROUND
    tilted = [
        np.cos(tilt) * normals + np.sin(tilt) * (np.cos(turn) * across + np.sin(turn) * along)
        for turn in turns.tolist()
    ]
    return [normals, *tilted]
