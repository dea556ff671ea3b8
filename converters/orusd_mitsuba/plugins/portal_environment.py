"""The surroundings as a light that is sampled where it can come in.

A room is lit from outside through a few rectangles. Mitsuba's ``envmap`` samples directions by the
picture's brightness alone, and most of them end at a wall. This emitter has the same radiance, but
sends a part of the samples through the portals: a point on one of them, chosen by what it covers as
seen from the reference point. The rest follow the picture, which finds the sun and serves points
that no portal faces. Both are one mixture density, so that the estimate stays unbiased and
multiple importance sampling has the exact density (Veach 1997, section 9.2).
"""

from functools import cache
from typing import Any, Final

import drjit as dr
import mitsuba as mi

from openrooms_usd.arrays import Array
from openrooms_usd.usd.light.lights import Portal
from orusd_mitsuba.plugins.light_weights import Beam

# How many of the samples go through the portals.
_SHARE_THROUGH_PORTALS: Final = 0.9
# Where the sun comes in through one of them, it comes whole, and of the rest of the sky a part of
# about this size: samples that follow the picture, which find the sun, are worth more there.
_SEEN_SHARE_OF_SKY: Final = 0.125
# Beyond these the choice among portals costs more than it saves.
_MOST_PORTALS: Final = 16


def worthwhile(portals: tuple[Portal, ...]) -> bool:
    """Whether the active variant gains by portals: a scalar one would call Python a sample."""
    return 0 < len(portals) <= _MOST_PORTALS and not str(mi.variant()).startswith("scalar")


def through_portals(
    inner: Any,
    portals: tuple[Portal, ...],
    origin: Array,
    radius: float,
    weight: float,
    beam: Beam | None = None,
) -> Any:
    """The surroundings ``inner``, sampled through portals.

    Args:
        inner: Mitsuba's environment emitter.
        portals: Where it comes in.
        origin: (3,) the point of the world that is Mitsuba's origin.
        radius: Metres; of a sphere about Mitsuba's origin that holds the scene.
        weight: How often it is sampled, relative to the other lights.
        beam: Its brightest place; None where it is even.

    Returns:
        An emitter of the active variant. Call ``inner.set_scene`` once the scene is built.
    """
    rectangles = [_Rectangle(portal, origin) for portal in portals]
    return _emitter_class(str(mi.variant()))(inner, rectangles, radius, weight, beam)


class _Rectangle:
    """A portal as numbers of the active variant, opaque: no kernel is compiled for each room."""

    def __init__(self, portal: Portal, origin: Array) -> None:
        world = portal.world_from_portal
        self.center = mi.Point3f((world[:3, 3] - origin).tolist())
        self.right, self.up, self.outwards = (
            mi.Vector3f(axis) for axis in world[:3, :3].T.tolist()
        )
        self.width, self.height = mi.Float(portal.width), mi.Float(portal.height)
        self.area = mi.Float(portal.width * portal.height)
        dr.make_opaque(self.center, self.right, self.up, self.outwards)
        dr.make_opaque(self.width, self.height, self.area)

    def weight(self, p: Any) -> Any:
        """About the solid angle that it covers from ``p``; 0 from behind."""
        to = self.center - p
        squared = dr.squared_norm(to) + 0.25 * self.area
        cosine = dr.dot(to, self.outwards) * dr.rsqrt(squared)
        # From beside its plane's foot the centre says little, but some of it is seen.
        return dr.select(self.faces(p), self.area * dr.maximum(cosine, 0.05) / squared, 0.0)

    def faces(self, p: Any) -> Any:
        """Whether ``p`` is on the room's side of its plane."""
        return dr.dot(self.center - p, self.outwards) > 1e-4

    def point(self, sample: Any) -> Any:
        """A point on it, uniform by area."""
        across, along = (sample.x - 0.5) * self.width, (sample.y - 0.5) * self.height
        return self.center + self.right * across + self.up * along

    def density(self, p: Any, d: Any) -> Any:
        """Density over solid angle of ``point`` as seen from ``p`` along ``d``; 0 beside it."""
        cosine = dr.dot(d, self.outwards)
        forwards = (cosine > 1e-6) & self.faces(p)
        t = dr.dot(self.center - p, self.outwards) / dr.select(forwards, cosine, 1.0)
        at = p + d * t - self.center
        inside = (dr.abs(dr.dot(at, self.right)) <= 0.5 * self.width) & (
            dr.abs(dr.dot(at, self.up)) <= 0.5 * self.height
        )
        return dr.select(forwards & inside, t * t / (cosine * self.area), 0.0)


def _share(rectangles: list[_Rectangle], p: Any, total: Any, sunward: Any, rest: Any) -> Any:
    """The part of the samples from ``p`` that goes through portals, ``rest`` where the sun does."""
    entering = [rectangle.density(p, sunward) for rectangle in rectangles]
    sunny = sum(entering[1:], entering[0]) > 0.0
    share = dr.select(sunny, rest, mi.Float(_SHARE_THROUGH_PORTALS))
    return dr.select(total > 0.0, share, 0.0)


def _rest(beam: Beam | None) -> float:
    """The part of the samples that goes through portals where the sun comes in through one."""
    sun = beam.share if beam else 0.0
    return (
        _SHARE_THROUGH_PORTALS
        * (1.0 - sun)
        * _SEEN_SHARE_OF_SKY
        / ((1.0 - sun) * _SEEN_SHARE_OF_SKY + sun)
    )


@cache
def _emitter_class(variant: str) -> Any:
    """The emitter's class for a variant: each has a base class of its own."""

    class PortalEnvironment(mi.Emitter):
        def __init__(
            self,
            inner: Any,
            rectangles: list[_Rectangle],
            radius: float,
            weight: float,
            beam: Beam | None,
        ) -> None:
            properties = mi.Properties()
            properties["sampling_weight"] = weight
            super().__init__(properties)
            self.inner = inner
            self.rectangles = rectangles
            self.radius, self.rest = mi.Float(radius), mi.Float(_rest(beam))
            self.sunward = mi.Vector3f(beam.direction.tolist()) if beam else mi.Vector3f(0, 0, 1)
            dr.make_opaque(self.radius, self.rest, self.sunward)
            self.m_flags = mi.EmitterFlags.Infinite | mi.EmitterFlags.SpatiallyVarying

        def eval(self, si: Any, active: Any = True) -> Any:
            return self.inner.eval(si, active)

        def sample_direction(self, it: Any, sample: Any, active: Any = True) -> Any:
            weights = [rectangle.weight(it.p) for rectangle in self.rectangles]
            total = sum(weights[1:], weights[0])
            share = _share(self.rectangles, it.p, total, self.sunward, self.rest)
            portal = sample.x < share
            fresh = dr.select(portal, sample.x / share, (sample.x - share) / (1.0 - share))
            outside, _ = self.inner.sample_direction(it, mi.Point2f(fresh, sample.y), active)
            through = dr.normalize(self._point(weights, total, fresh, sample.y) - it.p)
            d = dr.select(portal, through, outside.d)
            return self._sample(it, d, active)

        def _point(self, weights: list[Any], total: Any, u: Any, v: Any) -> Any:
            """A point on a portal chosen by its weight; the choice is made from ``u``."""
            left, point = u * total, mi.Point3f(self.rectangles[0].center)
            for rectangle, weight in zip(self.rectangles, weights, strict=True):
                here = (left >= 0.0) & (left < weight)
                chosen = rectangle.point(mi.Point2f(left / weight, v))
                point = dr.select(here, chosen, point)
                left = left - weight
            return point

        def _sample(self, it: Any, d: Any, active: Any) -> Any:
            ds = dr.zeros(mi.DirectionSample3f)
            ds.d = d
            ds.dist = 2.0 * (self.radius + dr.norm(it.p))
            ds.p = it.p + d * ds.dist
            ds.n = -d
            ds.time = it.time
            ds.emitter = mi.EmitterPtr(self)
            ds.pdf = self.pdf_direction(it, ds, active)
            active = active & (ds.pdf > 0.0)
            return ds, dr.select(active, self.eval_direction(it, ds, active) / ds.pdf, 0.0)

        def pdf_direction(self, it: Any, ds: Any, active: Any = True) -> Any:
            weights = [rectangle.weight(it.p) for rectangle in self.rectangles]
            total = sum(weights[1:], weights[0])
            share = _share(self.rectangles, it.p, total, self.sunward, self.rest)
            through = mi.Float(0.0)
            for rectangle, weight in zip(self.rectangles, weights, strict=True):
                through = through + weight * rectangle.density(it.p, ds.d)
            picture = self.inner.pdf_direction(it, ds, active)
            return share * through / dr.maximum(total, 1e-30) + (1.0 - share) * picture

        def eval_direction(self, it: Any, ds: Any, active: Any = True) -> Any:
            si = dr.zeros(mi.SurfaceInteraction3f)
            si.wi = -ds.d
            si.time = it.time
            return self.inner.eval(si, active)

        def bbox(self) -> Any:
            return mi.ScalarBoundingBox3f()

        def to_string(self) -> str:
            return f"PortalEnvironment[{len(self.rectangles)} portals]"

    return PortalEnvironment
