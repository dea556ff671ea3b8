"""Which triangle a ray meets first."""

from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.pinhole import pixel_directions
from openrooms_usd.usd.cameras import PinholeCamera
from orusd_mitsuba.build import load_sensor
from orusd_mitsuba.pictures import Array
from orusd_mitsuba.scene import Scene
from orusd_mitsuba.sensors import describe_sensor

Rows = NDArray[np.int64]

# Rays in flight at once: some 100 bytes each.
_BATCH: Final = 1 << 22


class RayTracer:
    """Finds triangles of a `Scene` by the ray tracer of the active variant.

    Args:
        scene: The arrays.
        built: The same as a Mitsuba scene, its shapes in the order of the patches.
    """

    def __init__(self, scene: Scene, built: Any) -> None:
        self._scene = scene
        self._built = built

    def pixels(self, camera: PinholeCamera, width: int, height: int) -> Rows:
        """The triangle in the centre of each pixel.

        Returns:
            (height, width) rows of ``scene.triangles``; -1 where there is nothing.
        """
        if not len(self._scene.triangles):
            return np.full((height, width), -1)
        if not _is_vectorized():
            return self._by_film(camera, width, height)
        R, eye = camera.world_from_camera[:3, :3], camera.world_from_camera[:3, 3]
        directions = (pixel_directions(camera.K, width, height) @ R.T).reshape(-1, 3)
        origins = np.broadcast_to(eye, directions.shape)
        return self.rays(origins, directions).reshape(height, width)

    def rays(self, origins: Array, directions: Array) -> Rows:
        """The first triangle along each ray; best for few rays where nothing is vectorized.

        Args:
            origins: (R, 3) world, metres.
            directions: (R, 3) of any length.

        Returns:
            (R,) rows of ``scene.triangles``; -1 where there is nothing.
        """
        local = (origins - self._scene.origin).astype(np.float32)
        ahead = directions.astype(np.float32)
        if not _is_vectorized():
            return np.array([self._one(*ray) for ray in zip(local, ahead, strict=True)], np.int64)
        parts = [
            self._batch(local[start : start + _BATCH], ahead[start : start + _BATCH])
            for start in range(0, len(local), _BATCH)
        ]
        return np.concatenate([np.zeros(0, np.int64), *parts])

    def _batch(self, origins: NDArray[np.float32], directions: NDArray[np.float32]) -> Rows:
        registered = [_number(mi.ShapePtr(shape)) for shape in self._built.shapes()]
        patch_of = np.zeros(np.max(registered) + 1, dtype=np.int64)
        patch_of[np.concatenate(registered)] = np.arange(len(registered))
        ray = mi.Ray3f(mi.Point3f(origins.T), mi.Vector3f(directions.T))
        hit = self._built.ray_intersect_preliminary(ray, coherent=True)
        rows = self._scene.offsets[patch_of[_number(hit.shape)]] + hit.prim_index.numpy()
        return np.where(hit.is_valid().numpy(), rows, -1)

    def _one(self, origin: NDArray[np.float32], direction: NDArray[np.float32]) -> int:
        ray = mi.Ray3f(mi.Point3f(origin), mi.Vector3f(direction))
        hit = self._built.ray_intersect_preliminary(ray)
        if not hit.is_valid():
            return -1
        patch = self._built.shapes().index(hit.shape)
        return int(self._scene.offsets[patch] + hit.prim_index)

    def _by_film(self, camera: PinholeCamera, width: int, height: int) -> Rows:
        """By a film of one sample in each pixel's centre: compiled code, where Python is slow."""
        pinhole = PinholeCamera(camera.K, camera.world_from_camera)
        description = describe_sensor(pinhole, width, height, self._scene.origin)
        centre = {"type": "stratified", "sample_count": 1, "jitter": False}
        integrator = mi.load_dict({"type": "aov", "aovs": "shape:shape_index,prim:prim_index"})
        film = mi.render(
            self._built, sensor=load_sensor(description, centre), integrator=integrator, spp=1
        )
        # Shapes are numbered from 1 here; 0 is nothing.
        shapes, prims = np.moveaxis(np.asarray(film).astype(np.int64), 2, 0)
        return np.where(shapes > 0, self._scene.offsets[shapes - 1] + prims, -1)


def _number(shapes: Any) -> NDArray[np.uint32]:
    """The numbers under which Dr.Jit knows shapes."""
    numbers: Any = dr.reinterpret_array(mi.UInt32, shapes)
    return np.asarray(numbers.numpy())


def _is_vectorized() -> bool:
    return not str(mi.variant()).startswith("scalar")
