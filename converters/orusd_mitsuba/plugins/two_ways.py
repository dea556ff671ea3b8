"""A texture that repeats in one direction and ends in the other; Mitsuba's own knows one way."""

from functools import cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.rendering.scene.pictures import Picture


def two_ways(picture: Picture) -> Any:
    """A texture of the active variant.

    Args:
        picture: Whose ways differ.
    """
    return _texture_class(str(mi.variant()))(picture)


@cache
def _texture_class(variant: str) -> Any:
    """The texture's class for a variant: each has a base class of its own."""

    class TwoWays(mi.Texture):
        def __init__(self, picture: Picture) -> None:
            super().__init__(mi.Properties())
            axis = picture.ways.index("repeat")
            halves = picture.halves()
            # A texel more at both ends, so that it interpolates across the seam.
            beside = [(0, 0)] * 3
            beside[1 - axis] = (1, 1)
            texels = np.ascontiguousarray(np.pad(halves, beside, mode="wrap"))
            size = halves.shape[1 - axis]
            self.axis, self.share, self.edge = axis, size / (size + 2.0), 1.0 / (size + 2.0)
            self.rows = picture.uv[:2].tolist()
            bitmap = {"type": "bitmap", "bitmap": mi.Bitmap(texels), "raw": True}
            self.inner = mi.load_dict(bitmap | {"wrap_mode": "clamp"})

        def _inside(self, si: Any) -> Any:
            at = type(si)(si)
            u, v = (a * si.uv.x + b * si.uv.y + c for a, b, c in self.rows)
            if self.axis == 0:
                u = (u - dr.floor(u)) * self.share + self.edge
            else:
                v = (v - dr.floor(v)) * self.share + self.edge
            at.uv = mi.Point2f(u, v)
            return at

        def eval(self, si: Any, active: Any = True) -> Any:
            return self.inner.eval(self._inside(si), active)

        def eval_1(self, si: Any, active: Any = True) -> Any:
            return self.inner.eval_1(self._inside(si), active)

        def eval_3(self, si: Any, active: Any = True) -> Any:
            return self.inner.eval_3(self._inside(si), active)

        def mean(self) -> Any:
            return self.inner.mean()

        def is_spatially_varying(self) -> bool:
            return True

        def to_string(self) -> str:
            return f"TwoWays[{self.inner}]"

    return TwoWays
