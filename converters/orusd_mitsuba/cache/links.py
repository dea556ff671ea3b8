"""What is recorded of paths that fill the cache: what lights send, and which surfels are met."""

from dataclasses import dataclass
from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Floats, Ints
from orusd_mitsuba.cache.surfels import NEAREST_PER_SIZE, SurfelIndex

NONE: Final = 0xFFFFFFFF
"""No surfel."""

LINKED_VERTICES: Final = 3
"""So many surfaces of a path may be links; what comes after is followed on."""

# What arrives at their sides.
_SIDES: Final = 2


@dataclass(frozen=True, eq=False)
class FoundLinks:
    """Links, one a row.

    Attributes:
        vertex: (K,) of the path, from 0.
        row: (K,) path, or the surfel that it began at.
        column: (K,) the surfel that was met.
        crossed: (K,) the opening that was crossed last on the way there.
        weight: (K, 3) what of its irradiance arrives.
    """

    vertex: Ints
    row: Ints
    column: Ints
    crossed: NDArray[np.uint32]
    weight: Floats


class Links:
    """Records what surfels are met, in place of their irradiance: see `tracing.Known`.

    No dataclass: Dr.Jit would carry its arrays through loops.
    """

    def __init__(self, index: SurfelIndex, paths: int, passing: bool) -> None:
        self._index, self._paths, self.passing = index, paths, passing
        # As a variable, not as a part of the compiled code: batches of all sizes share it.
        self._stride = dr.opaque(mi.UInt32, paths)
        slots = LINKED_VERTICES * _SIDES * paths
        self._surfels = dr.full(mi.UInt32, NONE, slots)
        self._weights = [dr.zeros(mi.Float, slots) for _ in range(3)]
        self._crossed = dr.zeros(mi.UInt32, slots)
        dr.make_opaque(self._surfels, self._crossed, self._weights)

    def find(self, si: Any, towards: Any, active: Any, *, through: bool = False) -> tuple[Any, Any]:
        """See `tracing.Known`."""
        return self._index.find(si, towards, active, through=through)

    def trusted(self, distance: Any, scatterings: Any) -> Any:
        """See `tracing.Known`; what has no slot left is followed on."""
        far = distance > NEAREST_PER_SIZE * self._index.size
        return far & (scatterings <= LINKED_VERTICES)

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
        vertex = (scatterings - 2) * _SIDES + int(through)
        slot = vertex * self._stride + dr.arange(mi.UInt32, self._paths)
        dr.scatter(self._surfels, surfel, slot, active)
        dr.scatter(self._crossed, crossed, slot, active)
        for plane, value in zip(self._weights, weight, strict=True):
            dr.scatter(plane, value, slot, active)

    def found(self) -> FoundLinks:
        """What was met."""
        surfels = np.asarray(self._surfels.numpy())
        slots = np.flatnonzero(surfels != NONE)
        weights = np.column_stack([np.asarray(plane.numpy())[slots] for plane in self._weights])
        return FoundLinks(
            slots // (self._paths * _SIDES),
            slots % self._paths,
            surfels[slots].astype(np.int64),
            np.asarray(self._crossed.numpy())[slots],
            np.where(np.isfinite(weights), weights, np.float32(0.0)),
        )


class Straight:
    """Sums what lights send along paths, by number of scatterings and light.

    No dataclass: Dr.Jit would carry its arrays through loops.
    """

    def __init__(self, paths: int, lights: int, orders: int) -> None:
        self._paths, self._lights, self._orders = paths, lights, orders
        self._stride = dr.opaque(mi.UInt32, paths)
        self.entries = dr.zeros(mi.Float, orders * lights * 3 * paths)

    def add(self, value: Any, light: Any, scatterings: Any, active: Any) -> None:
        """See `orusd_mitsuba.transport.path_tracing.PathAccumulator`."""
        slot = dr.arange(mi.UInt32, self._paths)
        row = dr.minimum(scatterings - 1, self._orders - 1) * self._lights + light
        for channel in range(3):
            dr.scatter_reduce(
                dr.ReduceOp.Add,
                self.entries,
                value[channel],
                (row * 3 + channel) * self._stride + slot,
                active,
                mode=dr.ReduceMode.NoConflicts,
            )
