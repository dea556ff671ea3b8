"""A thin surface that lights without being seen: it stands for a light that has none.

It is found by those who look for light, and sends nothing along a ray that meets it. What that
loses in narrow highlights is as little as what such a surface covers.
"""

from functools import cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np


def unseen_area(inner: Any) -> Any:
    """An emitter of the active variant.

    Args:
        inner: The emitter of a surface.
    """
    return _emitter_class(str(mi.variant()))(inner)


@cache
def _emitter_class(variant: str) -> Any:
    """The emitter's class for a variant: each has a base class of its own."""

    class UnseenArea(mi.Emitter):
        def __init__(self, inner: Any) -> None:
            properties = mi.Properties()
            properties["sampling_weight"] = float(np.ravel(inner.sampling_weight())[0])
            super().__init__(properties)
            self.inner = inner
            self.m_flags = inner.flags()

        def eval(self, si: Any, active: Any = True) -> Any:
            # Points of lamps that were looked for are at no distance along a ray.
            looked_for = si.t == 0.0
            value = self.inner.eval(si, active & looked_for)
            return dr.select(looked_for, value, mi.Color3f(0.0))

        def sample_direction(self, it: Any, sample: Any, active: Any = True) -> Any:
            ds, value = self.inner.sample_direction(it, sample, active)
            # A pointer of arrays; scalar variants have the object itself.
            ds.emitter = self if variant.startswith("scalar") else mi.EmitterPtr(self)
            return ds, value

        def pdf_direction(self, it: Any, ds: Any, active: Any = True) -> Any:
            return self.inner.pdf_direction(it, ds, active)

        def eval_direction(self, it: Any, ds: Any, active: Any = True) -> Any:
            return self.inner.eval_direction(it, ds, active)

        def bbox(self) -> Any:
            return self.inner.bbox()

        def to_string(self) -> str:
            return f"UnseenArea[{self.inner}]"

    return UnseenArea
