"""The points that receive direct light: the first surface along each ray, made white."""

from collections.abc import Callable
from typing import Any, Final

import drjit as dr
import mitsuba as mi

from orusd_mitsuba.transport.light_index import LightIndex

# A surface's normal is measured by its BSDF along the vertical and four directions: sine and cosine
# of their angle to the vertical.
_PROBE_SINE: Final = 0.8
_PROBE_COSINE: Final = 0.6


class Receiver:
    """Points that receive light, and how it counts there.

    Attributes:
        si: The interactions.
        active: Where there is a surface.
        crossed: The opening that was crossed on the way from the camera.
        normal: The unit normal that incidence is measured from, with the normal map, on the
            camera's side; zero where nothing can be received.
        horizon: The same without the normal map: from behind it nothing is received.
        first: What makes surfaces white.
    """

    def __init__(self, si: Any, active: Any, crossed: Any, first: Callable[[Any], Any]) -> None:
        self.si, self.active, self.crossed = si, active, crossed
        self.first = first
        side = dr.select(si.wi.z < 0.0, -1.0, 1.0)
        self.horizon = mi.Vector3f(si.sh_frame.n) * side
        local = _normal(first(si), si, side, active)
        self.normal = mi.Vector3f(si.to_world(local))
        self._frame = mi.Frame3f(
            dr.select(dr.squared_norm(self.normal) > 0.0, self.normal, self.horizon)
        )

    def cosine(self, direction: Any) -> Any:
        """What counts of light from a direction; 0 from below."""
        counts = dr.dot(self.horizon, direction) > 0.0
        return dr.select(counts, dr.maximum(dr.dot(self.normal, direction), 0.0), 0.0)

    def density(self, direction: Any) -> Any:
        """How densely `sample` takes a direction."""
        return self.cosine(direction) * dr.inv_pi

    def sample(self, sample: Any) -> tuple[Any, Any]:
        """A direction by its cosine, and its density; 0 where it does not count."""
        direction = self._frame.to_world(mi.warp.square_to_cosine_hemisphere(sample))
        return direction, self.density(direction)


def _normal(bsdf: Any, si: Any, side: Any, active: Any) -> Any:
    """The local normal of a white Lambertian surface, from what it makes of five directions.

    The cosine is linear above the horizon: of two opposite directions one at least is there.
    """
    context = mi.BSDFContext()

    def received(x: float, y: float, z: float) -> Any:
        return dr.pi * bsdf.eval(context, si, mi.Vector3f(x, y, z * side), active)[1]

    up = received(0.0, 0.0, 1.0)
    across = [
        (received(_PROBE_SINE, 0.0, _PROBE_COSINE), received(-_PROBE_SINE, 0.0, _PROBE_COSINE)),
        (received(0.0, _PROBE_SINE, _PROBE_COSINE), received(0.0, -_PROBE_SINE, _PROBE_COSINE)),
    ]
    x, y = (
        dr.select(plus > minus, plus - _PROBE_COSINE * up, _PROBE_COSINE * up - minus) / _PROBE_SINE
        for plus, minus in across
    )
    found = mi.Vector3f(x, y, up * side)
    length = dr.norm(found)
    return dr.select(active & (up > 0.0), found / dr.select(length > 0.0, length, 1.0), 0.0)


@dr.syntax
def receive(
    built: Any, index: LightIndex, first: Callable[[Any], Any], sampler: Any, ray: Any, clear: bool
) -> Receiver:
    """The first surface along each ray; clear ones are passed by chance.

    Args:
        built: The Mitsuba scene.
        index: Its lights.
        first: What makes surfaces white.
        sampler: Seeded for as many paths as there are rays.
        ray: Where the paths begin.
        clear: Whether any surface of the scene lets light straight through.
    """
    ray = mi.Ray3f(ray)
    si = built.ray_intersect(ray)
    hit = si.is_valid()
    crossed = dr.opaque(mi.UInt32, index.elsewhere)
    crossed = index.crossed(ray.o, ray.d, dr.select(hit, si.t, dr.inf), crossed)
    if dr.hint(clear, mode="scalar"):
        passes = hit & (sampler.next_1d() < first(si).eval_null_transmission(si, hit)[1])
        while passes:
            ray = si.spawn_ray(ray.d)
            si = built.ray_intersect(ray, passes)
            hit = passes & si.is_valid()
            end = dr.select(hit, si.t, dr.inf)
            crossed = index.crossed(ray.o, ray.d, end, crossed)
            passes = hit & (sampler.next_1d() < first(si).eval_null_transmission(si, hit)[1])
    return Receiver(si, si.is_valid(), crossed, first)


class Between:
    """What stands between points and lights.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Args:
        built: The Mitsuba scene.
        clear: Whether any surface of the scene lets light straight through.
        index: Knows the panes.
    """

    def __init__(self, built: Any, clear: bool, index: LightIndex) -> None:
        self._built, self._clear, self._index = built, clear, index

    def unblocked(self, ray: Any, active: Any) -> Any:
        """The part of light that comes along rays, up to their ends: a colour.

        Args:
            ray: The rays.
            active: Which of them are wanted.
        """
        part = _unblocked(self._built, self._clear, ray, active)
        return part * self._index.through(ray, active & (part > 0.0))


@dr.syntax
def _unblocked(built: Any, clear: bool, ray: Any, active: Any) -> Any:
    """The part that surfaces leave: 0, 1, or what clear ones let pass."""
    if dr.hint(not clear, mode="scalar"):
        return dr.select(built.ray_test(ray, active), 0.0, mi.Float(1.0))
    part, active, ray = mi.Float(1.0), mi.Bool(active), mi.Ray3f(ray)
    while active:
        si = built.ray_intersect(ray, active)
        hit = active & si.is_valid()
        left = si.bsdf().eval_null_transmission(si, hit)[1]
        part = dr.select(hit, part * left, part)
        onwards = si.spawn_ray(ray.d)
        onwards.maxt = ray.maxt - si.t
        ray = onwards
        active = hit & (part > 0.0)
    return part
