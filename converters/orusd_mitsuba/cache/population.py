"""Points of surfaces that light can reach: a walk through the room that begins where lights shine.

Each light path's first surface is one that a light shines at, so the walk begins at such points and
goes on as the surfaces scatter. What it meets is met as a picture's rays meet it: seldom in narrow
gaps, never in closed cupboards. So what is worked out at these points is right in the mean for
those who look it up. Nothing depends on a camera.
"""

from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.arrays import Array, Floats, Ints
from openrooms_usd.rendering.scene.arrays import Scene
from orusd_mitsuba.plugins.memory import aligned
from orusd_mitsuba.transport.path_tracing import random_numbers

_CANDIDATES: Final = 1 << 18
_WALKERS: Final = 1 << 16
# Where walkers begin is bright; after some steps they are anywhere that light reaches.
_FORGOTTEN_STEPS: Final = 6
_STEPS: Final = 12
# Edge of a place, as a part of the room's radius.
_PLACE_PART: Final = 1 / 16
# How far above a surface a ray begins that shall meet it, as a part of the room's radius.
_ABOVE_PART: Final = 1e-4


class Rays:
    """Rays that end on surfaces, of the active variant.

    No dataclass: Dr.Jit would carry its arrays through loops.
    """

    def __init__(self, origins: Any, directions: Any) -> None:
        self.o, self.d = mi.Point3f(origins), mi.Vector3f(directions)

    def __len__(self) -> int:
        return int(dr.width(self.o))

    def at(self, number: Any) -> Any:
        """Some of them, as Mitsuba's."""
        return mi.Ray3f(
            dr.gather(mi.Point3f, self.o, number), dr.gather(mi.Vector3f, self.d, number)
        )

    def rows(self, which: Ints) -> "Rays":
        """Some of them, by number."""
        number = mi.UInt32(aligned(which.astype(np.uint32)))
        return Rays(dr.gather(mi.Point3f, self.o, number), dr.gather(mi.Vector3f, self.d, number))

    @staticmethod
    def joined(parts: list["Rays"]) -> "Rays":
        """All of them, in their order."""
        return Rays(
            *(
                np.concatenate([np.asarray(getattr(part, name).numpy()) for part in parts], axis=1)
                for name in ("o", "d")
            )
        )


def reached(scene: Scene, built: Any, seed: int) -> Rays | None:
    """Rays whose ends are points that light reaches; None where there is no light.

    Args:
        scene: The arrays.
        built: The same as a Mitsuba scene.
        seed: Of random numbers.
    """
    lit = _rays_onto_lit_points(scene, built, seed)
    if lit is None:
        return None
    sampler = random_numbers(seed + 1, _WALKERS)
    first = _walk(built, sampler, lit)
    return None if first is None else _walk(built, sampler, _one_a_place(scene, first))


def _walk(built: Any, sampler: Any, starts: Rays) -> Rays | None:
    """What walkers who begin at some points meet after a while; None where it is nothing."""
    walker = dr.arange(mi.UInt32, _WALKERS)
    ray = starts.at(walker % len(starts))
    o, d = ray.o, ray.d
    sampler.schedule_state()
    dr.eval(o, d)
    found = []
    for step in range(_FORGOTTEN_STEPS + _STEPS):
        o, d, onwards = _step(built, sampler, o, d)
        if step < _FORGOTTEN_STEPS:
            continue
        kept: Any = dr.compress(onwards)
        if not dr.width(kept):
            continue
        found.append(Rays(dr.gather(mi.Point3f, o, kept), dr.gather(mi.Vector3f, d, kept)))
    return Rays.joined(found) if found else None


def _one_a_place(scene: Scene, rays: Rays) -> Rays:
    """One of the rays of each place, by the cubes of a grid that they begin in."""
    cubes = np.floor(np.asarray(rays.o.numpy()) / (_PLACE_PART * scene.room_radius)).astype(
        np.int64
    )
    _, which = np.unique(cubes, axis=1, return_index=True)
    return rays.rows(np.sort(which))


def _rays_onto_lit_points(scene: Scene, built: Any, seed: int) -> Rays | None:
    """Rays onto points of either side that some light shines at, of candidates even by area.

    What stands outside is far larger than the room, and is met by the walk as far as it counts.
    """
    corners = scene.triangles.corners[scene.indoors] - scene.origin
    a, b, c = np.moveaxis(corners, 1, 0)
    crosses = np.cross(b - a, c - a)
    areas = np.linalg.norm(crosses, axis=1)
    if not areas.sum() > 0.0:
        return None
    rng = np.random.default_rng(seed)
    below = np.cumsum(areas) / areas.sum()
    row = np.searchsorted(below, (np.arange(_CANDIDATES) + rng.random(_CANDIDATES)) / _CANDIDATES)
    row = np.minimum(row, len(areas) - 1)
    root, across = np.sqrt(rng.random(_CANDIDATES))[:, None], rng.random(_CANDIDATES)[:, None]
    place = a[row] * (1.0 - root) + b[row] * (root * (1.0 - across)) + c[row] * (root * across)
    side = np.where(rng.random(_CANDIDATES) < 0.5, 1.0, -1.0)[:, None]
    normal = side * crosses[row] / np.maximum(areas[row], 1e-30)[:, None]
    above = place + _ABOVE_PART * scene.room_radius * normal
    onto = Rays(_columns(above), _columns(-normal))
    sampler = random_numbers(seed, _CANDIDATES)
    ray = mi.Ray3f(onto.o, onto.d)
    si = built.ray_intersect(ray)
    to, incident = built.sample_emitter_direction(si, sampler.next_2d(), True, si.is_valid())
    facing = dr.dot(si.n, to.d) * dr.dot(si.n, -ray.d) > 0.0
    shone = si.is_valid() & (to.pdf > 0.0) & (dr.max(incident) > 0.0) & facing
    kept: Any = dr.compress(shone)
    if not dr.width(kept):
        return None
    return Rays(dr.gather(mi.Point3f, onto.o, kept), dr.gather(mi.Vector3f, onto.d, kept))


def _step(built: Any, sampler: Any, o: Any, d: Any) -> tuple[Any, Any, Any]:
    """One scattering: the next ray's origin and direction, and whether it meets a surface."""
    si = built.ray_intersect(mi.Ray3f(o, d))
    sample, _ = si.bsdf().sample(
        mi.BSDFContext(), si, sampler.next_1d(), sampler.next_2d(), si.is_valid()
    )
    after = si.spawn_ray(si.to_world(sample.wo))
    meets = si.is_valid() & (sample.pdf > 0.0) & built.ray_test(after, si.is_valid())
    # Who is lost stands where they stood.
    o, d = dr.select(meets, after.o, o), dr.select(meets, after.d, d)
    # With the state of the random numbers: else each step would draw those of all steps before it
    # again, by code of its own, which takes longer to compile than all steps to compute.
    sampler.schedule_state()
    dr.eval(o, d, meets)
    return o, d, meets


def _columns(vectors: Array) -> Floats:
    return np.ascontiguousarray(vectors.T, dtype=np.float32)
