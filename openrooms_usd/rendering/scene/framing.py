"""A camera for a large scene whose stage has none, by the tracer that the renderer has built."""

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.geometry.framing import FOV_DEG, framing_view
from openrooms_usd.geometry.pinhole import intrinsics
from openrooms_usd.geometry.raycast import Hits
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.instances import joined
from openrooms_usd.rendering.scene.rays import RayTracer
from openrooms_usd.usd.cameras import PinholeCamera

_MANY_TRIANGLES: Final = 500_000


def is_framed_here(scene: Scene) -> bool:
    """Whether a scene is so large that a ray caster of its own would take long to make.

    Renderers see what stands outside before windows; where there is any of that, the stage's own
    meshes tell what a room is.
    """
    return len(scene.triangles) > _MANY_TRIANGLES and not scene.has_outside


def framed(scene: Scene, tracer: RayTracer, width: int, height: int) -> PinholeCamera:
    """A camera that sees everything but lamps, or a closed room from inside.

    Args:
        scene: What is seen.
        tracer: Finds its triangles.
        width: Pixels.
        height: Pixels.
    """
    dark = joined([patch.triangles for patch in scene.patches if patch.radiance is None])
    shown = dark if len(dark) else scene.triangles
    # Rays go through panes, which are to be seen all the same.
    points = np.concatenate([shown.hull, *(pane.triangles.hull for pane in scene.panes)])
    view = framing_view(points, _SceneCaster(scene, tracer), width / height)
    return PinholeCamera(intrinsics(FOV_DEG, width, height), view.poses()[0])


class _SceneCaster:
    """Rays cast by a renderer's tracer, met in double precision."""

    def __init__(self, scene: Scene, tracer: RayTracer) -> None:
        self._triangles = scene.triangles
        self._tracer = tracer

    def first_hit(self, origins: ArrayLike, directions: ArrayLike) -> Hits:
        """See `openrooms_usd.geometry.raycast.Caster`."""
        rays = unit(np.asarray(directions, dtype=np.float64).reshape(-1, 3))
        starts = np.broadcast_to(np.asarray(origins, dtype=np.float64), rays.shape)
        rows = self._tracer.rays(starts, rays)
        distance = np.full(len(rays), np.inf)
        hit = np.flatnonzero(rows >= 0)
        heights, normals = self._planes(rows[hit], starts[hit])
        slopes = np.einsum("ij,ij->i", normals, rays[hit])
        distance[hit] = np.maximum(heights / np.where(slopes == 0.0, 1.0, slopes), 0.0)
        return Hits(distance, rows.astype(np.int32))

    def normals_of(self, triangles: NDArray[np.int32]) -> Array:
        """See `openrooms_usd.geometry.raycast.Caster`."""
        return self._planes(np.maximum(triangles, 0), np.zeros((len(triangles), 3)))[1]

    def _planes(self, rows: Ints, points: Array) -> tuple[Array, Array]:
        """Signed distances of points to the planes of triangles, and these planes' normals."""
        a, b, c = np.moveaxis(self._triangles.rows(rows).corners, 1, 0)
        normals = unit(np.cross(b - a, c - a))
        return np.einsum("ij,ij->i", a - points, normals), normals
