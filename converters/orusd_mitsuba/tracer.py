"""Which triangle a ray meets first, by Mitsuba's own ray tracer."""

from functools import cached_property
from typing import Any, Final

import mitsuba as mi
import numpy as np

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.rays import RayTracer, Rows
from openrooms_usd.usd.cameras import PINHOLE, PinholeCamera
from orusd_mitsuba.plugins.build import load_sensor
from orusd_mitsuba.plugins.sensors import describe_sensor
from orusd_mitsuba.transport.light_index import registered

# Films that tell shapes compare each pixel's with all that there are.
_FEW_SHAPES: Final = 1000
# Rays in flight at once: some 100 bytes each.
_RAYS_IN_FLIGHT: Final = 1 << 22


class MitsubaTracer(RayTracer):
    """Finds triangles of a `Scene` by the ray tracer of the active variant, now and later.

    Args:
        scene: The arrays.
        built: The same as a Mitsuba scene, its shapes in the order of the patches.
        starts: (shapes,) the first row of ``scene.triangles`` of each of its shapes; None where
            there is one for each patch.
    """

    def __init__(self, scene: Scene, built: Any, starts: Rows | None = None) -> None:
        self._scene = scene
        self._built = built
        self._starts = scene.offsets[:-1] if starts is None else starts
        self._variant = str(mi.variant())

    def pixels(self, camera: PinholeCamera, width: int, height: int) -> Rows:
        """See `openrooms_usd.rendering.scene.rays.RayTracer.pixels`."""
        mi.set_variant(self._variant)
        if not self._scene.offsets[-1]:
            return np.full((height, width), -1)
        few = len(self._starts) <= _FEW_SHAPES
        if not _is_vectorized() and camera.projection == PINHOLE and few:
            return self._by_film(camera, width, height)
        return super().pixels(camera, width, height)

    def rays(self, origins: Array, directions: Array) -> Rows:
        """See `RayTracer.rays`; best for few rays where nothing is vectorized."""
        mi.set_variant(self._variant)
        if not self._scene.offsets[-1]:
            return np.full(len(directions), -1)
        local = (origins - self._scene.origin).astype(np.float32)
        ahead = directions.astype(np.float32)
        if not _is_vectorized():
            return np.array([self._one(*ray) for ray in zip(local, ahead, strict=True)], np.int64)
        parts = [
            self._batch(
                local[start : start + _RAYS_IN_FLIGHT], ahead[start : start + _RAYS_IN_FLIGHT]
            )
            for start in range(0, len(local), _RAYS_IN_FLIGHT)
        ]
        return np.concatenate([np.zeros(0, np.int64), *parts])

    def _batch(self, origins: Floats, directions: Floats) -> Rows:
        numbers = [registered(mi.ShapePtr(shape)) for shape in self._built.shapes()]
        shape_of = np.zeros(np.max(numbers) + 1, dtype=np.int64)
        shape_of[np.concatenate(numbers)] = np.arange(len(numbers))
        ray = mi.Ray3f(mi.Point3f(origins.T), mi.Vector3f(directions.T))
        hit = self._built.ray_intersect_preliminary(ray, coherent=True)
        rows = self._starts[shape_of[registered(hit.shape)]] + hit.prim_index.numpy()
        return np.where(hit.is_valid().numpy(), rows, -1)

    def _one(self, origin: Floats, direction: Floats) -> int:
        ray = mi.Ray3f(mi.Point3f(origin), mi.Vector3f(direction))
        hit = self._built.ray_intersect_preliminary(ray)
        if not hit.is_valid():
            return -1
        return self._start_of[(hit.shape or hit.instance).id()] + int(hit.prim_index)

    @cached_property
    def _start_of(self) -> dict[str, int]:
        """The first row of each shape by its identifier; what is an instance has no other shape."""
        shapes = [shape.id() for shape in self._built.shapes()]
        return dict(zip(shapes, self._starts.tolist(), strict=True))

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
        return np.where(shapes > 0, self._starts[shapes - 1] + prims, -1)


def _is_vectorized() -> bool:
    return not str(mi.variant()).startswith("scalar")
