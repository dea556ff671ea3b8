"""Ray casting against triangles: Embree where it is installed, else a slower pure-Python tree."""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.errors import InputError, MissingPackageError
from openrooms_usd.geometry.vectors import doubled_areas

# |cos| between a ray and a triangle's plane below which the plane cannot tell the distance.
GRAZING = 1e-6


@dataclass(frozen=True)
class Hits:
    """What rays meet first.

    Attributes:
        distance: (R,) metres along the ray; inf where it meets nothing.
        triangle: (R,) row of the triangle; -1 where it meets nothing.
    """

    distance: Array
    triangle: NDArray[np.int32]

    @property
    def hit(self) -> Mask:
        """(R,) whether the ray meets anything."""
        return self.triangle >= 0


class Caster(Protocol):
    """What finds the surfaces that rays meet: a `RayCaster`, or what a renderer has of its own."""

    def first_hit(self, origins: ArrayLike, directions: ArrayLike) -> Hits:
        """See `RayCaster.first_hit`."""
        ...

    def normals_of(self, triangles: NDArray[np.int32]) -> Array:
        """See `RayCaster.normals_of`."""
        ...


class _Tracer(Protocol):
    """Finds triangles in a frame centred on them; directions are unit vectors."""

    def first(self, origins: Array, directions: Array) -> tuple[NDArray[np.int32], Array]: ...

    def any(self, origins: Array, directions: Array, reach: Array) -> Mask: ...


class RayCaster:
    """Triangles that rays can be cast against; both sides of each count.

    The tracer works on single precision numbers around the triangles' centre; the distance is then
    computed in double precision from the plane of the triangle that it found. So a scene may lie
    far from the origin, and a ray may start far from the scene.

    Args:
        points: (N, 3) corners, metres.
        triangles: (M, 3) rows of ``points``.

    Raises:
        InputError: A coordinate is not finite, or an index is out of range.
    """

    def __init__(self, points: ArrayLike, triangles: ArrayLike) -> None:
        corners = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        rows = np.asarray(triangles).reshape(-1, 3).astype(np.int32)
        if not np.isfinite(corners).all():
            raise InputError("ray casting needs finite coordinates")
        if rows.size and not (rows.min() >= 0 and rows.max() < len(corners)):
            raise InputError("a triangle refers to a point that does not exist")
        used = corners[np.unique(rows)] if rows.size else np.zeros((1, 3))
        self._centre: Array = (used.min(axis=0) + used.max(axis=0)) / 2.0
        self._radius = float(np.linalg.norm(used - self._centre, axis=1).max())
        local = corners - self._centre
        self.normals: Array = _unit(doubled_areas(local[rows]))
        self._offsets: Array = np.einsum("ij,ij->i", local[rows[:, 0]], self.normals)
        self._tracer = _tracer(local, rows)

    def first_hit(self, origins: ArrayLike, directions: ArrayLike) -> Hits:
        """What each ray meets first.

        Args:
            origins: (R, 3) where the rays start, metres, or (3,) for all.
            directions: (R, 3) of any length; a ray without a finite direction meets nothing.
        """
        starts, units, skipped, usable = self._rays(origins, directions)
        triangle, coarse = self._tracer.first(starts + skipped[:, None] * units, units)
        triangle = np.where(usable, triangle, -1).astype(np.int32)
        distance = self._distance(starts, units, triangle, coarse + skipped)
        return Hits(distance, triangle)

    def normals_of(self, triangles: NDArray[np.int32]) -> Array:
        """(R, 3) unit normals of triangles by (R,) their rows; anything where that is -1."""
        return self.normals[triangles] if len(self.normals) else np.zeros((len(triangles), 3))

    def occluded(
        self, origins: ArrayLike, directions: ArrayLike, reach: ArrayLike = np.inf
    ) -> Mask:
        """(R,) whether each ray meets anything within its reach.

        Args:
            origins: (R, 3) where the rays start, metres, or (3,) for all.
            directions: (R, 3) of any length.
            reach: Metres, a number or (R,).
        """
        starts, units, skipped, usable = self._rays(origins, directions)
        left = np.broadcast_to(np.asarray(reach, dtype=np.float64), skipped.shape) - skipped
        blocked = self._tracer.any(starts + skipped[:, None] * units, units, left)
        return np.asarray(blocked & usable & (left > 0))

    def _rays(self, origins: ArrayLike, directions: ArrayLike) -> tuple[Array, Array, Array, Mask]:
        """Rays in the tracer's frame, and what lies between their start and the scene's sphere."""
        given = np.asarray(directions, dtype=np.float64).reshape(-1, 3)
        starts = np.broadcast_to(np.asarray(origins, dtype=np.float64), given.shape) - self._centre
        # Columns are added up one by one: reducing rows of three is slow.
        finite = np.isfinite(given[:, 0] + given[:, 1] + given[:, 2])
        finite &= np.isfinite(starts[:, 0] + starts[:, 1] + starts[:, 2])
        usable = finite & ((given[:, 0] != 0) | (given[:, 1] != 0) | (given[:, 2] != 0))
        units = _unit(np.where(usable[:, None], given, (0.0, 0.0, 1.0)))
        starts = np.where(usable[:, None], starts, 0.0)
        nearest = -np.einsum("ij,ij->i", starts, units)
        skipped = np.maximum(nearest - 1.01 * self._radius, 0.0)
        return starts, units, skipped, usable

    def _distance(
        self, starts: Array, units: Array, triangle: NDArray[np.int32], coarse: Array
    ) -> Array:
        distance = np.full(len(starts), np.inf)
        hit = np.flatnonzero(triangle >= 0)
        normals = self.normals[triangle[hit]]
        slope = np.einsum("ij,ij->i", units[hit], normals)
        height = self._offsets[triangle[hit]] - np.einsum("ij,ij->i", starts[hit], normals)
        steep = np.abs(slope) > GRAZING
        exact = height / np.where(steep, slope, 1.0)
        distance[hit] = np.maximum(np.where(steep, exact, coarse[hit]), 0.0)
        return distance


def _unit(vectors: Array) -> Array:
    # Scaled first: the squares of very long or short vectors would overflow or vanish.
    x, y, z = np.abs(vectors).T
    longest = np.maximum(np.maximum(x, y), z)
    scaled = vectors / np.where(longest > 0, longest, 1.0)[:, None]
    lengths = np.sqrt(np.einsum("ij,ij->i", scaled, scaled))
    return np.asarray(scaled / np.where(lengths > 0, lengths, 1.0)[:, None])


def _tracer(points: Array, triangles: NDArray[np.int32]) -> _Tracer:
    if not len(triangles):
        return _Nothing()
    try:
        return _Embree(points, triangles)
    except ImportError:
        return _Tree(points, triangles)


class _Nothing:
    """An empty scene."""

    def first(self, origins: Array, directions: Array) -> tuple[NDArray[np.int32], Array]:
        return np.full(len(origins), -1, dtype=np.int32), np.full(len(origins), np.inf)

    def any(self, origins: Array, directions: Array, reach: Array) -> Mask:
        return np.zeros(len(origins), dtype=np.bool_)


class _Embree:
    """Embree, directly: through trimesh it would cost most of a second to import."""

    def __init__(self, points: Array, triangles: NDArray[np.int32]) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        # Robust: no ray slips through between two triangles that share an edge.
        self._scene: Any = EmbreeScene(robust=True)
        TriangleMesh(self._scene, points.astype(np.float32), triangles)

    def first(self, origins: Array, directions: Array) -> tuple[NDArray[np.int32], Array]:
        found = self._scene.run(
            origins.astype(np.float32), directions.astype(np.float32), output=True
        )
        return found["primID"], found["tfar"].astype(np.float64)

    def any(self, origins: Array, directions: Array, reach: Array) -> Mask:
        limits = np.clip(reach, 0.0, 1e30).astype(np.float32)
        found = self._scene.run(
            origins.astype(np.float32), directions.astype(np.float32), limits, query="OCCLUDED"
        )
        return np.asarray(found >= 0)


class _Tree:
    """trimesh with rtree, where Embree has no wheel."""

    def __init__(self, points: Array, triangles: NDArray[np.int32]) -> None:
        try:
            import rtree  # type: ignore[import-not-found, unused-ignore]  # noqa: F401
            import trimesh
            from trimesh.ray.ray_triangle import RayMeshIntersector
        except ImportError as error:
            raise MissingPackageError(
                "ray casting needs embreex, or rtree and trimesh",
                remedy="pip install embreex, or where it has no wheel: pip install rtree trimesh",
            ) from error
        mesh = trimesh.Trimesh(points, triangles, process=False)
        self._intersector: Any = RayMeshIntersector(mesh)

    def first(self, origins: Array, directions: Array) -> tuple[NDArray[np.int32], Array]:
        found, rays, places = self._intersector.intersects_id(
            origins, directions, multiple_hits=False, return_locations=True
        )
        triangle = np.full(len(origins), -1, dtype=np.int32)
        distance = np.full(len(origins), np.inf)
        if len(rays) == 0:
            return triangle, distance
        triangle[rays] = found
        distance[rays] = np.einsum("ij,ij->i", places - origins[rays], directions[rays])
        return triangle, distance

    def any(self, origins: Array, directions: Array, reach: Array) -> Mask:
        triangle, distance = self.first(origins, directions)
        return np.asarray((triangle >= 0) & (distance <= reach))
