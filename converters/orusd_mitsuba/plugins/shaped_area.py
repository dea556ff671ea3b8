"""A surface whose radiance depends on the direction, as an IES profile says.

It is Mitsuba's ``area`` times a table over the angle from the light's axis and about it; points are
taken as ``area`` takes them, so that all densities are its own.
"""

from functools import cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.usd.light.profiles import Shaping


def shaped_area(inner: Any, shaping: Shaping) -> Any:
    """An emitter of the active variant.

    Args:
        inner: Mitsuba's ``area`` emitter. Call its ``set_shape`` once there is one.
        shaping: What its radiance is multiplied with.
    """
    return _emitter_class(str(mi.variant()))(inner, shaping)


@cache
def _emitter_class(variant: str) -> Any:
    """The emitter's class for a variant: each has a base class of its own."""

    class ShapedArea(mi.Emitter):
        def __init__(self, inner: Any, shaping: Shaping) -> None:
            properties = mi.Properties()
            properties["sampling_weight"] = float(np.ravel(inner.sampling_weight())[0])
            super().__init__(properties)
            self.inner = inner
            # A texture interpolates between the middles of at least two by two texels.
            table = np.pad(shaping.factors, [(0, n < 2) for n in shaping.factors.shape], "edge")
            self.table = mi.load_dict(
                {
                    "type": "bitmap",
                    "bitmap": mi.Bitmap(np.ascontiguousarray(table[..., None])),
                    "raw": True,
                    "wrap_mode": "clamp",
                    "accel": False,
                }
            )
            height, width = shaping.factors.shape
            rows, columns = table.shape
            first, last = np.radians([shaping.first_deg, shaping.last_deg]).tolist()
            self.first, self.last = mi.Float(first), mi.Float(last)
            self.along = mi.Vector2f((width - 1) / (last - first) / columns, 0.5 / columns)
            self.about = mi.Vector2f((height - 1) / (2.0 * np.pi) / rows, 0.5 / rows)
            self.turn(shaping)
            dr.make_opaque(self.first, self.last, self.along, self.about)
            self.m_flags = inner.flags()

        def turn(self, shaping: Shaping) -> None:
            """Let the light's axis lie elsewhere."""
            self.axes = [mi.Vector3f(row) for row in shaping.light_from_world.tolist()]
            dr.make_opaque(*self.axes)

        def factor(self, direction: Any, active: Any) -> Any:
            x, y, z = (dr.dot(axis, direction) for axis in self.axes)
            polar = dr.atan2(dr.sqrt(dr.square(x) + dr.square(y)), -z)
            about = dr.atan2(y, x)
            about = dr.select(about < 0.0, about + dr.two_pi, about)
            si = dr.zeros(mi.SurfaceInteraction3f)
            si.uv = mi.Point2f(
                (polar - self.first) * self.along.x + self.along.y,
                about * self.about.x + self.about.y,
            )
            inside = (polar >= self.first) & (polar <= self.last)
            return dr.select(inside, self.table.eval_1(si, active), 0.0)

        def eval(self, si: Any, active: Any = True) -> Any:
            return self.inner.eval(si, active) * self.factor(si.to_world(si.wi), active)

        def sample_direction(self, it: Any, sample: Any, active: Any = True) -> Any:
            ds, value = self.inner.sample_direction(it, sample, active)
            # A pointer of arrays; scalar variants have the object itself.
            ds.emitter = self if variant.startswith("scalar") else mi.EmitterPtr(self)
            return ds, value * self.factor(-ds.d, active)

        def pdf_direction(self, it: Any, ds: Any, active: Any = True) -> Any:
            return self.inner.pdf_direction(it, ds, active)

        def eval_direction(self, it: Any, ds: Any, active: Any = True) -> Any:
            return self.inner.eval_direction(it, ds, active) * self.factor(-ds.d, active)

        def bbox(self) -> Any:
            return self.inner.bbox()

        def to_string(self) -> str:
            return "ShapedArea[]"

    return ShapedArea
