"""Fills the light cache: what every surfel receives of each light, with all scatterings.

From points of every surfel paths are followed that end where other surfels are met (`tracing`):
what lights send on such a path is summed by light, and the rest is a link: so much of what that
surfel receives arrives here. Links are the form factors of classical radiosity with the albedo of
the very point that was met (Goral et al. 1984; constant elements), so one set of rays serves all
bounces and all lights: the irradiance is S + T S + T T S + ..., a sparse product a bounce. Where a
path went by more than one surface, it counts as so many scatterings.
"""

from dataclasses import dataclass
from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from openrooms_usd.render.scene.arrays import Scene
from orusd_mitsuba.cache.population import Rays, reached
from orusd_mitsuba.cache.surfels import SurfelIndex, SurfelTable, tabulate
from orusd_mitsuba.cache.tracing import Surroundings, follow
from orusd_mitsuba.transport.lattice import FirstDimensions

Floats = NDArray[np.float32]

NEAREST_PER_SIZE: Final = 1.5
"""Rays shorter than this many edges of a surfel do not look it up."""

# About so many surfels share the surface that light reaches.
_SURFELS: Final = 20_000
# Of which at least this part is flat enough to count by area.
_PATHS_A_SURFEL: Final = 128
_PATHS_IN_FLIGHT: Final = 1 << 20
_MOST_SUMS: Final = 1 << 26
# Vertices of a path that may be links, and the sides of each.
_LINKED_VERTICES: Final = 3
_ORDERS: Final = 4
LIMITS: Final = 3
"""For so many numbers of scatterings at most the irradiance is kept."""

_SIDES: Final = 2
_NONE: Final = 0xFFFFFFFF


@dataclass(frozen=True, eq=False)
class CacheData:
    """The light cache of a room.

    Attributes:
        table: Where surfels are found.
        irradiance: (N, 3, L, 3) lux that each surfel receives of each light, with all scatterings
            that there may be before the second surface of a path, the third and all later ones.
    """

    table: SurfelTable
    irradiance: Floats


class Links:
    """Records what surfels are met, in place of their irradiance: see `tracing.Known`.

    No dataclass: Dr.Jit would carry its arrays through loops.
    """

    def __init__(self, index: SurfelIndex, paths: int, passing: bool) -> None:
        self._index, self._paths, self.passing = index, paths, passing
        slots = _LINKED_VERTICES * _SIDES * paths
        self._surfels = dr.full(mi.UInt32, _NONE, slots)
        self._weights = [dr.zeros(mi.Float, slots) for _ in range(3)]
        dr.make_opaque(self._surfels, self._weights)

    def find(self, si: Any, towards: Any, active: Any) -> tuple[Any, Any]:
        """See `tracing.Known`."""
        return self._index.find(si, towards, active)

    def trusted(self, distance: Any, scatterings: Any) -> Any:
        """See `tracing.Known`; what has no slot left is followed on."""
        far = distance > NEAREST_PER_SIZE * self._index.size
        return far & (scatterings <= _LINKED_VERTICES)

    def add(
        self, surfel: Any, weight: Any, scatterings: Any, sums: Any, active: Any, *, behind: bool
    ) -> None:
        """See `tracing.Known`."""
        vertex = (scatterings - 2) * _SIDES + int(behind)
        slot = vertex * self._paths + dr.arange(mi.UInt32, self._paths)
        dr.scatter(self._surfels, surfel, slot, active)
        for plane, value in zip(self._weights, weight, strict=True):
            dr.scatter(plane, value, slot, active)

    def arrays(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], Floats]:
        """Vertex of the path, path, surfel and weight of each link."""
        surfels = np.asarray(self._surfels.numpy())
        slots = np.flatnonzero(surfels != _NONE)
        weights = np.column_stack([np.asarray(plane.numpy())[slots] for plane in self._weights])
        vertices = slots // (self._paths * _SIDES)
        return vertices, slots % self._paths, surfels[slots].astype(np.int64), weights


class Straight:
    """Sums what lights send along paths, by number of scatterings and light.

    No dataclass: Dr.Jit would carry its arrays through loops.
    """

    def __init__(self, paths: int, lights: int) -> None:
        self._paths, self._lights = paths, lights
        self.entries = dr.zeros(mi.Float, _ORDERS * lights * 3 * paths)

    def add(self, value: Any, light: Any, scatterings: Any, active: Any) -> None:
        """See `orusd_mitsuba.transport.path_tracing.PathAccumulator`."""
        slot = dr.arange(mi.UInt32, self._paths)
        row = dr.minimum(scatterings - 1, _ORDERS - 1) * self._lights + light
        for channel in range(3):
            dr.scatter_reduce(
                dr.ReduceOp.Add, self.entries, value[channel],
                (row * 3 + channel) * self._paths + slot, active, mode=dr.ReduceMode.NoConflicts,
            )  # fmt: skip


def fill(
    scene: Scene, built: Any, around: Surroundings, white: Any, scatterings: int, seed: int
) -> CacheData:
    """Fill the cache of a room.

    Args:
        scene: The arrays.
        built: The same as a Mitsuba scene.
        around: What paths are followed in; its cache is not looked at.
        white: What makes surfaces white: `orusd_mitsuba.transport.white.white_first`.
        scatterings: At most this many between a light and a surfel.
        seed: Of random numbers.
    """
    rays = reached(scene, built, seed)
    size_m = _size(scene)
    bare = SurfelIndex(scene, built, size_m)
    points, table = _points(built, bare, rays, size_m)
    index = SurfelIndex(scene, built, size_m, table)
    straight, matrices = _gathered(around, index, white, points, seed)
    return CacheData(table, _bounced(straight, matrices, scatterings))


def _size(scene: Scene) -> float:
    """Metres; of the edge of a cube, such that there are about as many surfels as shall be."""
    corners = scene.triangles.corners
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.linalg.norm(crosses, axis=1).sum()
    return float(np.sqrt(area / _SURFELS))


@dataclass(frozen=True, eq=False)
class Points:
    """Rays onto surfels, those of a surfel in a row.

    Attributes:
        rays: All of them.
        starts: (N + 1,) where those of each surfel begin.
    """

    rays: Rays
    starts: NDArray[np.int64]


def _points(
    built: Any, index: SurfelIndex, rays: Rays, size_m: float
) -> tuple[Points, SurfelTable]:
    ray = mi.Ray3f(rays.o, rays.d)
    si = built.ray_intersect(ray)
    far = si.is_valid() & (si.t > NEAREST_PER_SIZE * size_m)
    place, check = index.hashes(si, -ray.d, far)
    kept: Any = dr.compress(far)
    hashes = np.column_stack([dr.gather(mi.UInt32, word, kept).numpy() for word in (place, check)])
    table, numbers = tabulate(hashes, size_m)
    order = np.argsort(numbers, kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.bincount(numbers))])
    rows = dr.gather(mi.UInt32, kept, mi.UInt32(order.astype(np.uint32)))
    sorted_rays = Rays(dr.gather(mi.Point3f, rays.o, rows), dr.gather(mi.Vector3f, rays.d, rows))
    return Points(sorted_rays, starts), table


def _gathered(
    around: Surroundings, index: SurfelIndex, white: Any, points: Points, seed: int
) -> tuple[Floats, list[list[Any]]]:
    """(orders, N, L, 3) what lights send, and by order and colour the matrices of links."""
    from scipy.sparse import csr_matrix

    count, lights = len(points.starts) - 1, around.index.count
    fitting = min(_PATHS_IN_FLIGHT, _MOST_SUMS // (3 * _ORDERS * lights))
    batch = max(1, fitting // _PATHS_A_SURFEL)
    straight = np.zeros((_ORDERS, count, lights, 3), dtype=np.float32)
    found = []
    for start in range(0, count, batch):
        surfels = np.arange(start, min(start + batch, count))
        paths = len(surfels) * _PATHS_A_SURFEL
        sampler, shifts = (mi.load_dict({"type": "independent"}) for _ in range(2))
        sampler.seed(seed + 2 * start + 2, paths)
        shifts.seed(seed + 2 * start + 3, len(surfels))
        numbers = FirstDimensions(_PATHS_A_SURFEL, paths, shifts)
        sums, links = Straight(paths, lights), Links(index, paths, around.known.passing)
        ray = points.rays.at(mi.UInt32(_turns(points.starts, surfels)))
        follow(around.knowing(links), sampler, ray, sums, white, numbers=numbers)
        entries = dr.block_sum(sums.entries, _PATHS_A_SURFEL).numpy()
        straight[:, surfels] = np.moveaxis(entries.reshape(_ORDERS, lights, 3, -1), 3, 1)
        vertex, path, surfel, weight = links.arrays()
        found.append((vertex, surfels[path // _PATHS_A_SURFEL], surfel, weight))
    vertex, row, column, weight = (np.concatenate(parts) for parts in zip(*found, strict=True))
    scale = np.float32(np.pi / _PATHS_A_SURFEL)
    matrices = []
    for order in range(_LINKED_VERTICES):
        here = vertex == order
        places = row[here], column[here]
        matrices.append(
            [
                csr_matrix((scale * weight[here, color], places), shape=(count, count))
                for color in range(3)
            ]
        )
    return scale * straight, matrices


def _turns(starts: NDArray[np.int64], surfels: NDArray[np.int64]) -> NDArray[np.uint32]:
    """The points that the paths of some surfels begin at: each in its turn."""
    held = np.diff(starts)[surfels][:, None]
    turn = np.arange(_PATHS_A_SURFEL)
    nth = np.where(held >= _PATHS_A_SURFEL, turn * held // _PATHS_A_SURFEL, turn % held)
    return np.asarray((starts[surfels][:, None] + nth).ravel(), dtype=np.uint32)


def _bounced(straight: Floats, matrices: list[list[Any]], scatterings: int) -> Floats:
    """(N, `LIMITS`, L, 3) with what is scattered so often at most, and once less, and so on."""
    found: list[Floats] = []
    for number in range(scatterings + 1):
        here = straight[number].copy() if number < len(straight) else np.zeros_like(straight[0])
        for order, colors in enumerate(matrices[:number], start=1):
            before = found[number - order]
            for color, matrix in enumerate(colors):
                here[..., color] += matrix @ before[..., color]
        found.append(here)
    sums = np.cumsum(found, axis=0)
    nothing = np.zeros_like(straight[0])
    limits = [scatterings - less for less in range(LIMITS)]
    return np.stack([sums[most] if most >= 0 else nothing for most in limits], axis=1)
