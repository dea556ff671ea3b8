"""The rectangles of all openings as tables, and directions through each of them."""

from collections.abc import Sequence
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.rendering.scene.sources import GRAZING_COS, Source


class Rectangles:
    """The openings of a scene; rows are theirs, in the order of the lights.

    Args:
        sources: All lights.
        origin: (3,) the point of the world that is Mitsuba's origin.
    """

    def __init__(self, sources: Sequence[Source], origin: Array) -> None:
        found = [(n, s.portal) for n, s in enumerate(sources) if s.portal is not None]
        self._count = len(found)
        rows = np.full(len(sources), self._count, dtype=np.uint32)
        rows[[number for number, _ in found]] = np.arange(self._count)
        self._row, self._light = mi.UInt32(rows), mi.UInt32([number for number, _ in found])
        frames = np.array([portal.world_from_portal for _, portal in found]).reshape(-1, 4, 4)
        sizes = np.array([(p.width, p.height) for _, p in found]).reshape(-1, 2)
        self._center = _flat(frames[:, :3, 3] - origin)
        self._across = _flat(frames[:, :3, 0] * sizes[:, :1])
        self._up = _flat(frames[:, :3, 1] * sizes[:, 1:])
        self._outwards = _flat(frames[:, :3, 2])

    def __len__(self) -> int:
        return self._count

    def light(self, row: Any) -> Any:
        """The number of an opening's light."""
        return dr.gather(mi.UInt32, self._light, row)

    def sample(self, row: Any, at: Any, sample: Any) -> tuple[Any, Any]:
        """A direction through an opening, even over its area, and its density over solid angle."""
        center, across, up, _ = self._frame(row, True)
        point = center + across * (sample.x - 0.5) + up * (sample.y - 0.5)
        direction = dr.normalize(point - at)
        return direction, self._density(row, at, direction, True)

    def density(self, light: Any, at: Any, direction: Any) -> Any:
        """Density of `sample` for a direction through a light; 0 if it is not an opening."""
        row = dr.gather(mi.UInt32, self._row, light)
        return self._density(row, at, direction, row < self._count)

    def _frame(self, row: Any, active: Any) -> tuple[Any, Any, Any, Any]:
        return (
            dr.gather(mi.Point3f, self._center, row, active),
            dr.gather(mi.Vector3f, self._across, row, active),
            dr.gather(mi.Vector3f, self._up, row, active),
            dr.gather(mi.Vector3f, self._outwards, row, active),
        )

    def _density(self, row: Any, at: Any, direction: Any, active: Any) -> Any:
        center, across, up, outwards = self._frame(row, active)
        cosine, distance = dr.dot(direction, outwards), dr.dot(center - at, outwards)
        forwards = active & (cosine > GRAZING_COS) & (distance >= 0.0)
        t = distance / dr.select(forwards, cosine, 1.0)
        area = dr.norm(dr.cross(across, up))
        return dr.select(forwards, dr.square(t) / (cosine * area), 0.0)


def _flat(values: Array) -> Any:
    return mi.Float(np.ascontiguousarray(values, dtype=np.float32).ravel())
