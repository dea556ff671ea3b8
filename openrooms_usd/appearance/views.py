"""What a camera sees of a room's geometry, and photographs, as arrays."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from openrooms_usd.arrays import Array, Bytes
from openrooms_usd.geometry.pinhole import pixel_directions
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.first_hits import first_hits
from openrooms_usd.rendering.scene.rays import RayTracer
from openrooms_usd.usd.cameras import PinholeCamera

Size = tuple[int, int]


class Seen(NamedTuple):
    """A view of geometry.

    Attributes:
        depth: (H, W) along the optical axis, metres; 0 where there is nothing.
        normal: (H, W, 3) unit, world, towards the camera.
        part: (H, W) numbers of parts, whose borders are edges.
    """

    depth: Array
    normal: Array
    part: NDArray[np.int64]


Geometry = Callable[[Array, Array, Size], Seen]
"""(3, 3) K in pixels, (4, 4) world_from_camera (OpenCV), width and height: what is seen."""


@dataclass(frozen=True, eq=False)
class Photograph:
    """A photograph, and where it is said to be taken.

    Attributes:
        pixels: (H, W, 3) sRGB.
        K: (3, 3) intrinsics in pixels; the centre of the top-left pixel is (0.5, 0.5).
        world_from_camera: (4, 4) rigid, OpenCV camera to world, Z up, metres.
        depth: (H', W') metres along the optical axis, 0 unknown, of the same field of view; None
            where there is no depth map.
    """

    pixels: Bytes
    K: Array
    world_from_camera: Array
    depth: Array | None = None

    def reduced(self, width: int) -> tuple[Bytes, Array]:
        """The pixels averaged in blocks to at most about that width, and their K."""
        block = max(1, round(self.pixels.shape[1] / width))
        rows, columns = (side // block for side in self.pixels.shape[:2])
        cut = self.pixels[: rows * block, : columns * block].astype(np.float64)
        small = cut.reshape(rows, block, columns, block, 3).mean(axis=(1, 3))
        return small.round().astype(np.uint8), scaled(self.K, 1.0 / block)


def scaled(K: Array, factor: float) -> Array:
    """(3, 3) intrinsics of the same picture at another size."""
    return np.asarray(np.diag([factor, factor, 1.0]) @ K)


def geometry_of(
    points: ArrayLike, triangles: ArrayLike, parts: ArrayLike | None = None
) -> Geometry:
    """Triangles as a `Geometry`, by ray casting.

    Args:
        points: (N, 3) world, metres.
        triangles: (M, 3) rows of ``points``.
        parts: (M,) number of each triangle's part; one part if None.

    Raises:
        InputError: A coordinate is not finite, or an index is out of range.
    """
    caster = RayCaster(points, triangles)
    numbers = None if parts is None else np.asarray(parts, dtype=np.int64)

    def seen(K: Array, world_from_camera: Array, size: Size) -> Seen:
        directions = pixel_directions(K, *size).reshape(-1, 3)
        ahead = directions @ world_from_camera[:3, :3].T
        hits = caster.first_hit(world_from_camera[:3, 3], ahead)
        lengths = np.sqrt(np.einsum("ij,ij->i", directions, directions))
        depth = np.where(hits.hit, hits.distance / lengths, 0.0)
        normal = caster.normals_of(hits.triangle)
        facing = -np.sign(np.einsum("ij,ij->i", normal, ahead)) * hits.hit
        part = hits.hit.astype(np.int64) if numbers is None else numbers[hits.triangle] + 1
        part = np.where(hits.hit, part, 0)
        shape = size[1], size[0]
        toward = (normal * facing[:, None]).reshape(*shape, 3)
        return Seen(depth.reshape(shape), toward, part.reshape(shape))

    return seen


def geometry_in(scene: Scene, tracer: RayTracer) -> Geometry:
    """An opened scene as a `Geometry`, by its renderer's own ray tracer."""
    parts = np.array([piece.part for piece in scene.pieces] or [0], dtype=np.int64)

    def seen(K: Array, world_from_camera: Array, size: Size) -> Seen:
        hits = first_hits(scene, tracer, PinholeCamera(K, world_from_camera), *size)
        facing = np.where(hits.front, 1.0, -1.0)[:, None]
        part = parts[scene.triangles.pieces[hits.rows]].astype(np.float64) + 1.0
        return Seen(
            hits.image(hits.depth)[..., 0].astype(np.float64),
            hits.image(facing * hits.geometric).astype(np.float64),
            hits.image(part)[..., 0].astype(np.int64),
        )

    return seen
