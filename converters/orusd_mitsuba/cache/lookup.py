"""The light cache as it is looked up, by light or in total."""

from typing import Any, Protocol, runtime_checkable

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.rendering.scene.arrays import Scene
from orusd_mitsuba.cache.filling import CacheData
from orusd_mitsuba.cache.surfels import NEAREST_PER_SIZE, SurfelIndex
from orusd_mitsuba.plugins.memory import aligned


@runtime_checkable
class Noting(Protocol):
    """Sums that have a place for what the cache had."""

    def looked_up(self, value: Any, active: Any) -> None:
        """Add a colour, over all lights; ``add`` has it too."""
        ...


class Nothing:
    """A cache that knows nothing.

    Args:
        scene: The arrays.
    """

    def __init__(self, scene: Scene) -> None:
        self.passing = passing(scene)

    def find(self, si: Any, towards: Any, active: Any, *, through: bool = False) -> tuple[Any, Any]:
        """See `tracing.Known`."""
        return mi.UInt32(0), mi.Bool(False)

    def trusted(self, distance: Any, scatterings: Any) -> Any:
        """See `tracing.Known`."""
        return mi.Bool(False)

    def add(
        self,
        surfel: Any,
        weight: Any,
        scatterings: Any,
        crossed: Any,
        sums: Any,
        active: Any,
        through: bool,
    ) -> None:
        """See `tracing.Known`."""


class LightCache:
    """Irradiance of surfels for arrays of the active variant: see `tracing.Known`.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Args:
        scene: The arrays.
        built: The same as a Mitsuba scene.
        data: What `filling.fill` made.
        by_light: Whether to add by light, or all at once as of the first light.
        first: What ``scatterings`` is at the first surface that may be looked up: 2 where paths
            begin at a camera, 1 where they begin at points that light arrives at.
    """

    def __init__(
        self, scene: Scene, built: Any, data: CacheData, *, by_light: bool, first: int = 2
    ) -> None:
        self._first, self._split = first, by_light
        self._index = SurfelIndex(scene, built, data.table.size_m, data.table)
        values = data.irradiance if by_light else data.irradiance.sum(axis=2, keepdims=True)
        self._limits, self._lights = values.shape[1:3]
        padded = np.concatenate([values, np.zeros_like(values[..., :1])], axis=-1)
        self._values = mi.Float(aligned(padded.astype(np.float32)))
        self.passing = passing(scene)

    def find(self, si: Any, towards: Any, active: Any, *, through: bool = False) -> tuple[Any, Any]:
        """See `tracing.Known`."""
        return self._index.find(si, towards, active, through=through)

    def trusted(self, distance: Any, scatterings: Any) -> Any:
        """See `tracing.Known`."""
        return distance > NEAREST_PER_SIZE * self._index.size

    @dr.syntax
    def add(
        self,
        surfel: Any,
        weight: Any,
        scatterings: Any,
        crossed: Any,
        sums: Any,
        active: Any,
        through: bool,
    ) -> None:
        """See `tracing.Known`."""
        # The second surface of a path from the camera is the first one here.
        limit = dr.clip(mi.Int32(scatterings) - self._first, 0, self._limits - 1)
        row = (surfel * self._limits + mi.UInt32(limit)) * self._lights
        light, total = mi.UInt32(0), mi.Color3f(0.0)
        while light < self._lights:
            value = dr.gather(mi.Vector4f, self._values, row + light, active)
            color = weight * mi.Color3f(value.x, value.y, value.z)
            # The last one is elsewhere: what has come in through no opening.
            source = dr.select(light + 1 == self._lights, crossed, light) if self._split else light
            sums.add(color, source, scatterings, active)
            total += color
            light += 1
        if dr.hint(isinstance(sums, Noting), mode="scalar"):
            sums.looked_up(total, active)


def passing(scene: Scene) -> bool:
    """Whether any surface passes light on diffusely."""
    return any(patch.surface.transmission > 0.0 for patch in scene.patches)
