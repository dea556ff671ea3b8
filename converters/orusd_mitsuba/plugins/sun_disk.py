"""Parallel light of an angular size, such as the sun: its shadows are soft.

It is sampled over the cone that it fills, and like Mitsuba's ``directional`` found by light samples
alone: nothing meets it, neither the camera nor a mirror.
"""

import math
from functools import cache
from typing import Any

import drjit as dr
import mitsuba as mi

from openrooms_usd.rendering.scene.arrays import Sun


def towards(sun: Sun, sample: Any) -> tuple[Any, Any]:
    """A direction to a sun, uniform over its disk, and its lux over the density of that.

    Args:
        sun: The parallel light.
        sample: Two even random numbers; not used without an angle.
    """
    axis, lux = mi.Vector3f((-sun.direction).tolist()), mi.Color3f(sun.irradiance.tolist())
    if sun.angle == 0.0:
        return axis, lux
    half = math.radians(sun.angle) / 2.0
    cosine: Any = math.cos(half)
    local = mi.warp.square_to_uniform_cone(sample, cosine)
    # Of a cone wider than a hemisphere the irradiance is that of the schema's `normalize`.
    sine = math.sin(half) ** 2 * math.pi
    seen = sine if half <= math.pi / 2.0 else 2.0 * math.pi - sine
    solid = 4.0 * math.pi * math.sin(half / 2.0) ** 2
    return mi.Frame3f(axis).to_world(local), lux * (solid / seen)


def sun_disk(sun: Sun, weight: float, radius: float) -> Any:
    """An emitter of the active variant.

    Args:
        sun: The parallel light.
        weight: How often it is sampled, relative to the other lights.
        radius: Metres; of a sphere about Mitsuba's origin that holds the scene.
    """
    return _emitter_class(str(mi.variant()))(sun, weight, radius)


@cache
def _emitter_class(variant: str) -> Any:
    """The emitter's class for a variant: each has a base class of its own."""

    class SunDisk(mi.Emitter):
        def __init__(self, sun: Sun, weight: float, radius: float) -> None:
            properties = mi.Properties()
            properties["sampling_weight"] = weight
            super().__init__(properties)
            self.sun, self.radius = sun, mi.Float(radius)
            dr.make_opaque(self.radius)
            # Of a direction, so that no ray is weighted against it.
            self.m_flags = mi.EmitterFlags.Infinite | mi.EmitterFlags.DeltaDirection

        def eval(self, si: Any, active: Any = True) -> Any:
            return mi.Color3f(0.0)

        def sample_direction(self, it: Any, sample: Any, active: Any = True) -> Any:
            ds: Any = dr.zeros(mi.DirectionSample3f)
            ds.d, lux = towards(self.sun, sample)
            ds.dist = 2.0 * (self.radius + dr.norm(it.p))
            ds.p = it.p + ds.d * ds.dist
            ds.n = -ds.d
            ds.time = it.time
            ds.pdf, ds.delta = mi.Float(1.0), mi.Bool(True)
            ds.emitter = mi.EmitterPtr(self)
            return ds, lux

        def pdf_direction(self, it: Any, ds: Any, active: Any = True) -> Any:
            return mi.Float(0.0)

        def eval_direction(self, it: Any, ds: Any, active: Any = True) -> Any:
            return mi.Color3f(0.0)

        def bbox(self) -> Any:
            return mi.ScalarBoundingBox3f()

        def to_string(self) -> str:
            return f"SunDisk[{self.sun.angle} degrees]"

    return SunDisk
