"""Which triangle a ray meets first."""

from abc import ABC, abstractmethod
from functools import cached_property

import numpy as np

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.usd.cameras import PinholeCamera

Rows = Ints


class RayTracer(ABC):
    """Finds triangles of a `Scene`; a renderer may bring one of its own, which is faster.

    Only the choice of the triangle is its own. Where the ray meets it is computed from the triangle
    in double precision (`openrooms_usd.rendering.scene.first_hits`), the same for all.
    """

    @abstractmethod
    def rays(self, origins: Array, directions: Array) -> Rows:
        """The first triangle along each ray.

        Args:
            origins: (R, 3) world, metres.
            directions: (R, 3) of any length.

        Returns:
            (R,) rows of ``scene.triangles``; -1 where there is nothing.
        """

    def pixels(self, camera: PinholeCamera, width: int, height: int) -> Rows:
        """The triangle in the centre of each pixel, in front of depth 0.

        Returns:
            (height, width) rows of ``scene.triangles``; -1 where there is nothing.
        """
        return self.rays(*camera.rays(width, height)).reshape(height, width)


class CastingTracer(RayTracer):
    """Finds triangles by the core's ray caster.

    Args:
        scene: The arrays.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene

    @cached_property
    def caster(self) -> RayCaster:
        """The triangles of the scene, made when the first ray is cast."""
        corners = self._scene.triangles.corners
        return RayCaster(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))

    def rays(self, origins: Array, directions: Array) -> Rows:
        """See `RayTracer.rays`."""
        return self.caster.first_hit(origins, directions).triangle.astype(np.int64)
