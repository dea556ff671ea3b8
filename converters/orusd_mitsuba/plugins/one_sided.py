"""A surface that is there for who sees its front: from behind light goes straight through.

Lamps of stages are such: a camera may stand behind a softbox, or inside of a ball that shines.
"""

from functools import cache
from typing import Any

import drjit as dr
import mitsuba as mi


def one_sided(inner: Any) -> Any:
    """A BSDF of the active variant.

    Args:
        inner: What the front is.
    """
    return _bsdf_class(str(mi.variant()))(inner)


@cache
def _bsdf_class(variant: str) -> Any:
    """The BSDF's class for a variant: each has a base class of its own."""

    class OneSided(mi.BSDF):
        def __init__(self, inner: Any) -> None:
            super().__init__(mi.Properties())
            self.inner = inner
            null = mi.BSDFFlags.Null | mi.BSDFFlags.BackSide
            parts = [inner.flags(number) for number in range(inner.component_count())]
            self.m_components = [*parts, null]
            self.m_flags = inner.flags() | null

        def sample(
            self, context: Any, si: Any, which: Any, where: Any, active: Any = True
        ) -> tuple[Any, Any]:
            front = si.wi.z > 0.0
            bs, value = self.inner.sample(context, si, which, where, active & front)
            bs.wo = dr.select(front, bs.wo, -si.wi)
            bs.pdf = dr.select(front, bs.pdf, 1.0)
            bs.eta = dr.select(front, bs.eta, 1.0)
            null = mi.UInt32(int(mi.BSDFFlags.Null))
            bs.sampled_type = dr.select(front, bs.sampled_type, null)
            bs.sampled_component = dr.select(
                front, bs.sampled_component, mi.UInt32(len(self.m_components) - 1)
            )
            return bs, dr.select(active, dr.select(front, value, mi.Color3f(1.0)), mi.Color3f(0.0))

        def eval_pdf(self, context: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
            front = active & (si.wi.z > 0.0)
            value, density = self.inner.eval_pdf(context, si, wo, front)
            return dr.select(front, value, mi.Color3f(0.0)), dr.select(front, density, 0.0)

        def eval(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.eval_pdf(context, si, wo, active)[0]

        def pdf(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.eval_pdf(context, si, wo, active)[1]

        def eval_null_transmission(self, si: Any, active: Any = True) -> Any:
            passes = active & (si.wi.z <= 0.0)
            return dr.select(passes, mi.Color3f(1.0), mi.Color3f(0.0))

        def eval_diffuse_reflectance(self, si: Any, active: Any = True) -> Any:
            return self.inner.eval_diffuse_reflectance(si, active)

        def to_string(self) -> str:
            return f"OneSided[{self.inner}]"

    return OneSided
