"""Heights of the upper sides of objects, on which others stand."""

from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.library.assets import Model

Array: TypeAlias = NDArray[np.float64]


def top_at(model: Model, x: float, y: float) -> float | None:
    """The highest intersection of a vertical line with a model, metres; None where it misses."""
    a, b, c = _skin(_Same(model))
    area = _cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        v = _cross(np.array([x, y]) - a[:, :2], c - a) / area
        w = _cross(b - a, np.array([x, y]) - a[:, :2]) / area
        # A line through an edge must not miss both its faces.
        hit = (area != 0.0) & (v >= -1e-9) & (w >= -1e-9) & (v + w <= 1.0 + 1e-9)
    if not hit.any():
        return None
    z = a[hit, 2] + v[hit] * (b - a)[hit, 2] + w[hit] * (c - a)[hit, 2]
    return float(z.max())


class _Same:
    """A model compared by identity: comparing its arrays would be slow."""

    def __init__(self, model: Model) -> None:
        self.model = model

    def __hash__(self) -> int:
        return id(self.model)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and other.model is self.model


# A room queries the same few models again and again; the bound limits memory.
@lru_cache(maxsize=32)
def _skin(same: _Same) -> tuple[Array, Array, Array]:
    """(T, 3) first, second and third corners of all triangles of a model, metres."""
    corners = [mesh.points[mesh.indices[mesh.triangles()[0]]] for mesh in same.model.parts.values()]
    a, b, c = np.moveaxis(np.concatenate([np.zeros((0, 3, 3)), *corners]), 1, 0)
    return a, b, c


def _cross(a: Array, b: Array) -> Array:
    """Cross product of the horizontal parts."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
