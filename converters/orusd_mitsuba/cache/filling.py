"""Fills the light cache: what every surfel receives of each light, with all scatterings.

From points of every surfel paths are followed that end where other surfels are met (`tracing`).
What lights send on such a path is summed by light. The rest is a link: the share of what that
surfel receives which arrives here. Links are the form factors of classical radiosity with the
albedo of the very point that was met (Goral et al. 1984; constant elements), so one set of rays
serves all bounces and all lights: the irradiance is S + T S + T T S + ..., a sparse product a
bounce. Where a path went by more than one surface, it counts as so many scatterings.
"""

from dataclasses import dataclass, fields, replace
from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Floats, Ints, Mask
from openrooms_usd.rendering.scene.arrays import Scene
from orusd_mitsuba.cache.links import LINKED_VERTICES, NONE, FoundLinks, Links, Straight
from orusd_mitsuba.cache.population import Rays, reached
from orusd_mitsuba.cache.surfels import NEAREST_PER_SIZE, SurfelIndex, SurfelTable, tabulate
from orusd_mitsuba.cache.tracing import TracingScene, follow
from orusd_mitsuba.plugins import microfacet
from orusd_mitsuba.plugins.memory import aligned
from orusd_mitsuba.transport.lattice import FirstDimensions

# So many would tile all triangles, seen or not, from one side: about as many hold the points that
# light reaches, more where surfaces are bent.
_SURFELS: Final = 20_000
_PATHS_A_SURFEL: Final = 128
_POINTS_OF_MATTER: Final = 8
_PATHS_IN_FLIGHT: Final = 1 << 20
_MOST_SUMS: Final = 1 << 26
# Of the step that keeps rays from meeting the surface that they begin at: far above rounding.
_PART_OF_STEP: Final = 0.1
# How far above a surface its points look for each other, as a part of a surfel, and which part of
# them need not.
_ABOVE_PART: Final = 0.02
_BLOCKED_SHARE: Final = 0.0


class Transport:
    """What surfels receive of what surfels receive, as sparse matrices.

    Args:
        links: All of them.
        count: Surfels.
        elsewhere: The light that has come in through no opening: where a link crosses one, it
            belongs to that.
    """

    def __init__(self, links: FoundLinks, count: int, elsewhere: int) -> None:
        self._elsewhere = elsewhere
        self._all, self._crossing = [], []
        for vertex in range(LINKED_VERTICES):
            here = links.vertex == vertex
            self._all.append(_matrices(links, here, count))
            openings = np.unique(links.crossed[here])
            self._crossing.append(
                {int(n): _matrices(links, here & (links.crossed == n), count) for n in openings}
            )

    def __call__(self, vertex: int, irradiance: Floats, into: Floats) -> None:
        """Add what arrives by links of a vertex.

        Args:
            vertex: Of paths, from 0.
            irradiance: (N, L, 3) of the surfels that are met.
            into: (N, L, 3) receives it.
        """
        for color in range(3):
            into[:, : self._elsewhere, color] += (
                self._all[vertex][color] @ irradiance[:, : self._elsewhere, color]
            )
            for opening, matrices in self._crossing[vertex].items():
                into[:, opening, color] += matrices[color] @ irradiance[:, self._elsewhere, color]


def _matrices(links: FoundLinks, which: Mask, count: int) -> list[Any]:
    """By colour."""
    from scipy.sparse import csr_matrix

    places = links.row[which], links.column[which]
    return [
        csr_matrix((links.weight[which, color], places), shape=(count, count)) for color in range(3)
    ]


def bounced(straight: Floats, transport: Transport, scatterings: int) -> Floats:
    """What surfels receive of each light, with all scatterings up to some number.

    Args:
        straight: (orders, N, L, 3) what lights send by paths of so many scatterings.
        transport: What surfels send to each other.
        scatterings: S, at most.

    Returns:
        (N, S + 1, L, 3) with at most S scatterings, with one less, and so on to none.
    """
    found: list[Floats] = []
    for number in range(scatterings + 1):
        here = straight[number].copy()
        for vertex in range(min(number, LINKED_VERTICES)):
            transport(vertex, found[number - vertex - 1], here)
        found.append(here)
    return np.ascontiguousarray(np.cumsum(found, axis=0)[::-1].swapaxes(0, 1))


@dataclass(frozen=True, eq=False)
class CacheData:
    """The light cache of a room.

    Attributes:
        table: Where surfels are found.
        irradiance: (N, S + 1, L, 3) lux that each surfel receives of each light with at most S
            scatterings, with one less, and so on to none. They apply before the second surface of a
            path, before the third one, and so on.
        reflected: (N, 3) the diffuse albedo of each surfel, in the mean.
        passed: (N, 3) what it passes on diffusely.
        lobe: (N,) what its lobe reflects of even light, luminance.
        behind: (N,) the surfel for what arrives at its other side; its own where there is none.
    """

    table: SurfelTable
    irradiance: Floats
    reflected: Floats
    passed: Floats
    lobe: Floats
    behind: NDArray[np.uint32]


def fill(
    scene: Scene, built: Any, around: TracingScene, white: Any, scatterings: int, seed: int
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
    found = None
    if rays is not None:
        found = _points(around, SurfelIndex(scene, built, size_m), rays, size_m)
    if found is None:
        return _dark(size_m, scatterings, around.index.count)
    points, table = found
    index = SurfelIndex(scene, built, size_m, table)
    straight, transport = _gathered(around, index, white, points, scatterings + 1, seed)
    irradiance = bounced(straight, transport, scatterings)
    return CacheData(table, irradiance, *_matter(around, index, points))


def _dark(size_m: float, scatterings: int, lights: int) -> CacheData:
    """An empty cache: one surfel that no lookup finds."""
    table = SurfelTable(size_m, np.zeros((1, 2), dtype=np.uint32), 1)
    irradiance = np.zeros((1, scatterings + 1, lights, 3), dtype=np.float32)
    nothing = np.zeros((1, 3), dtype=np.float32)
    return CacheData(table, irradiance, nothing, nothing, nothing[:, 0], np.zeros(1, np.uint32))


def _size(scene: Scene) -> float:
    """Metres; of the edge of a cube, such that there are about as many surfels as shall be."""
    # What is outside is seen from afar, and by few.
    corners = scene.triangles.corners[scene.indoors]
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
    starts: Ints


def _points(
    around: TracingScene, index: SurfelIndex, rays: Rays, size_m: float
) -> tuple[Points, SurfelTable] | None:
    """The rays by surfels, and these; None where none comes from far enough.

    Where sheets pass light on, there are rays onto their back as well.
    """
    built = around.built
    ray = mi.Ray3f(rays.o, rays.d)
    si = built.ray_intersect(ray)
    far = si.is_valid() & (si.t > NEAREST_PER_SIZE * size_m)
    parts = [(ray, far, index.hashes(si, -ray.d, far))]
    if around.known.passing:
        matter = around.materials(si, around.tabulated(si.shape, far))
        sheet = far & (matter.transmission > 0.0)
        # Paths that pass begin with that step away from the sheet; what is nearer to it than
        # that, another sheet, they do not meet. So rays onto its back must begin still nearer.
        step = si.spawn_ray(ray.d).o - si.p
        back = mi.Ray3f(si.p + _PART_OF_STEP * step, -ray.d)
        parts.append((back, sheet, index.hashes(si, -ray.d, sheet, through=True)))
    kept: list[tuple[Rays, NDArray[np.uint32]]] = []
    for onto, which, words in parts:
        rows: Any = dr.compress(which)
        if not dr.width(rows):
            continue
        there = Rays(dr.gather(mi.Point3f, onto.o, rows), dr.gather(mi.Vector3f, onto.d, rows))
        found = [dr.gather(mi.UInt32, word, rows).numpy() for word in words]
        kept.append((there, np.column_stack(found)))
    if not kept:
        return None
    every = Rays.joined([there for there, _ in kept])
    hashes = np.concatenate([found for _, found in kept])
    whole = ~_divided(around, index, every, tabulate(hashes, size_m)[1], size_m)
    every, hashes = every.rows(np.flatnonzero(whole)), hashes[whole]
    if not len(hashes):
        return None
    table, numbers = tabulate(hashes, size_m)
    order = np.argsort(numbers, kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.bincount(numbers))])
    return Points(every.rows(order), starts), table


def _divided(
    around: TracingScene, index: SurfelIndex, rays: Rays, surfels: Ints, size_m: float
) -> Mask:
    """Whether something stands between the points of a ray's surfel: two rooms may meet there.

    Args:
        around: The scene.
        index: Tells pieces; what is of the same piece does not divide it.
        rays: Onto the points.
        surfels: Of each.
        size_m: Edge of a cube, metres.
    """
    si = around.built.ray_intersect(mi.Ray3f(rays.o, rays.d))
    side = dr.select(dr.dot(si.n, rays.d) <= 0.0, 1.0, -1.0)
    above = mi.Point3f(si.p + mi.Vector3f(si.n) * (side * (_ABOVE_PART * size_m)))
    # From each point to the first one of its surfel.
    _, firsts = np.unique(surfels, return_index=True)
    across = dr.gather(mi.Point3f, above, _numbers(firsts[surfels])) - above
    length = dr.norm(across)
    onto = mi.Ray3f(above, mi.Vector3f(across) / dr.maximum(length, 1e-12))
    onto.maxt = length
    between = around.built.ray_intersect(onto, length > 0.0)
    blocked = between.is_valid() & (index.piece(between) != index.piece(si))
    counts = np.bincount(surfels, np.asarray(blocked.numpy()))
    return np.asarray(counts[surfels] > _BLOCKED_SHARE * np.bincount(surfels)[surfels])


def _gathered(
    around: TracingScene, index: SurfelIndex, white: Any, points: Points, orders: int, seed: int
) -> tuple[Floats, Transport]:
    """(orders, N, L, 3) what lights send, and what surfels send to each other."""
    count, lights = len(points.starts) - 1, around.index.count
    fitting = min(_PATHS_IN_FLIGHT, _MOST_SUMS // (3 * orders * lights))
    batch = max(1, fitting // _PATHS_A_SURFEL)
    straight = np.zeros((orders, count, lights, 3), dtype=np.float32)
    found = []
    for start in range(0, count, batch):
        surfels = np.arange(start, min(start + batch, count))
        paths = len(surfels) * _PATHS_A_SURFEL
        sampler, shifts = (mi.load_dict({"type": "independent"}) for _ in range(2))
        sampler.seed(seed + 2 * start + 2, paths)
        shifts.seed(seed + 2 * start + 3, len(surfels))
        numbers = FirstDimensions(_PATHS_A_SURFEL, paths, shifts)
        sums, links = Straight(paths, lights, orders), Links(index, paths, around.known.passing)
        ray = points.rays.at(_numbers(_turns(points.starts, surfels, _PATHS_A_SURFEL)))
        follow(around.knowing(links), sampler, ray, sums, white, numbers=numbers)
        entries = np.asarray(dr.block_sum(sums.entries, _PATHS_A_SURFEL).numpy())
        # As in pictures: values that are not finite are ignored.
        entries = np.where(np.isfinite(entries), entries, np.float32(0.0))
        straight[:, surfels] = np.moveaxis(entries.reshape(orders, lights, 3, -1), 3, 1)
        met = links.found()
        found.append(replace(met, row=surfels[met.row // _PATHS_A_SURFEL]))
    scale = np.float32(np.pi / _PATHS_A_SURFEL)
    every = FoundLinks(
        *(
            np.concatenate([getattr(part, field.name) for part in found])
            for field in fields(FoundLinks)
        )
    )
    every = replace(every, weight=scale * every.weight)
    return scale * straight, Transport(every, count, around.index.elsewhere)


def _matter(
    around: TracingScene, index: SurfelIndex, points: Points
) -> tuple[Floats, Floats, Floats, NDArray[np.uint32]]:
    """See `CacheData`: what surfels are made of, in the mean over some of their points."""
    surfels = np.arange(len(points.starts) - 1)
    ray = points.rays.at(_numbers(_turns(points.starts, surfels, _POINTS_OF_MATTER)))
    si = around.built.ray_intersect(ray)
    matter = around.materials(si, around.tabulated(si.shape, si.is_valid()))
    cosine = dr.abs(si.wi.z)
    albedo = microfacet.lobe_albedo(cosine, matter.roughness, matter.specular)
    passed = matter.diffuse * matter.transmission
    values = [*matter.diffuse, *passed, matter.gloss * mi.luminance(albedo)]
    sums = [dr.block_sum(mi.Float(value), _POINTS_OF_MATTER).numpy() for value in values]
    means = np.column_stack(sums).astype(np.float32) / np.float32(_POINTS_OF_MATTER)
    number, found = index.find(si, -ray.d, si.is_valid(), through=True)
    numbers = np.where(found.numpy(), number.numpy(), np.uint32(NONE))
    behind = numbers.reshape(-1, _POINTS_OF_MATTER).min(axis=1).astype(np.uint32)
    behind = np.where(behind == NONE, surfels.astype(np.uint32), behind)
    return means[:, :3], means[:, 3:6], means[:, 6], behind


def _numbers(values: NDArray[Any]) -> Any:
    """Whole numbers for a kernel, aligned: where they are not, it is another kernel."""
    return mi.UInt32(aligned(values.astype(np.uint32)))


def _turns(starts: Ints, surfels: Ints, count: int) -> NDArray[np.uint32]:
    """So many points of each of some surfels, each in its turn."""
    held = np.diff(starts)[surfels][:, None]
    turn = np.arange(count)
    nth = np.where(held >= count, turn * held // count, turn % held)
    return np.asarray((starts[surfels][:, None] + nth).ravel(), dtype=np.uint32)
