"""The light cache of an opened room: filled once, or read from its file, and given to paths."""

from collections.abc import Callable
from functools import cached_property
from typing import Any, Final, Protocol, runtime_checkable

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from openrooms_usd.rendering import light_store
from openrooms_usd.rendering.scene.arrays import Scene
from orusd_mitsuba.cache.arriving import LookedUpArrival
from orusd_mitsuba.cache.filling import CacheData, fill
from orusd_mitsuba.cache.surfels import NEAREST_PER_SIZE, SurfelIndex, SurfelTable
from orusd_mitsuba.cache.tracing import TracingScene, follow
from orusd_mitsuba.plugins.build import Builder
from orusd_mitsuba.plugins.memory import aligned
from orusd_mitsuba.transport.light_index import LightIndex
from orusd_mitsuba.transport.path_tracing import Accumulator

# The cache depends on no request, so that all of a room share it.
_SEED: Final = 0x11647
_MAKER: Final = "orusd_mitsuba.cache.filling"
LEAST_BOUNCES: Final = 2
"""With fewer there is nothing to look up: the second surface sends nothing on."""


class RoomLight:
    """The light of a room, for paths of one number of bounces.

    Args:
        scene: The arrays.
        built: The same as a Mitsuba scene of a vectorized variant.
        builder: What made it.
        index: Its lights.
        white: What makes surfaces white: `orusd_mitsuba.transport.white.white_first`.
        bounces: At most this many scatterings between a light and a camera.
    """

    def __init__(
        self,
        scene: Scene,
        built: Any,
        builder: Builder,
        index: LightIndex,
        white: Callable[[Any], Any],
        bounces: int,
    ) -> None:
        self._scene, self._built, self._builder = scene, built, builder
        self._index, self._white, self._bounces = index, white, bounces

    def paths(self, *, by_light: bool) -> "CachedPaths":
        """Paths from a camera."""
        cache = LightCache(self._scene, self._built, self._data, by_light=by_light, first=2)
        return CachedPaths(self._around(cache, self._bounces + 1))

    def arriving(self) -> LookedUpArrival:
        """Paths from points that light arrives at, one scattering before the camera."""
        cache = LightCache(self._scene, self._built, self._data, by_light=False, first=1)
        around = self._around(cache, self._bounces)
        rows = self._builder.in_table(self._scene)
        return LookedUpArrival(self._scene, around, self._data, rows)

    @cached_property
    def _data(self) -> CacheData:
        key = light_store.content_key(
            self._scene, (_MAKER,), self._bounces, _SEED, str(mi.variant()), mi.__version__
        )
        places = light_store.places(self._scene)
        kept = light_store.load(key, places)
        scatterings = self._bounces - LEAST_BOUNCES
        if kept is not None:
            found = _data_of(kept, scatterings + 1, self._index.count)
            if found is not None:
                return found
        around = self._around(Nothing(self._scene), self._bounces)
        data = fill(self._scene, self._built, around, self._white, scatterings, _SEED)
        light_store.save(key, _arrays_of(data), places)
        return data

    def _around(self, known: Any, depth: int) -> TracingScene:
        table = self._builder.table
        assert table is not None, "without a table of materials there is nothing to look up"
        return TracingScene(self._built, self._index, table, self._tabulated, known, depth)

    @cached_property
    def _tabulated(self) -> Any:
        """By registered shape, whether it has a row in the table of materials."""
        return mi.UInt32(self._builder.tabulated(self._scene, self._built).astype(np.uint32))


class CachedPaths:
    """Paths that end in the cache: see `orusd_mitsuba.transport.paths.Paths`.

    Args:
        around: The scene and its cache.
    """

    def __init__(self, around: TracingScene) -> None:
        self._around = around

    def follow(self, sampler: Any, ray: Any, accumulator: Accumulator, **how: Any) -> None:
        """See `orusd_mitsuba.transport.paths.Paths`."""
        follow(self._around, sampler, ray, accumulator, **how)


def _arrays_of(data: CacheData) -> dict[str, NDArray[Any]]:
    """The cache as plain arrays."""
    table = data.table
    return {
        "entries": table.entries,
        "irradiance": data.irradiance,
        "reflected": data.reflected,
        "passed": data.passed,
        "lobe": data.lobe,
        "behind": data.behind,
        "probes": np.array([table.probes], dtype=np.int64),
        "size_m": np.array([table.size_m]),
    }


def _data_of(arrays: dict[str, NDArray[Any]], limits: int, lights: int) -> CacheData | None:
    """The cache of arrays from a file; None if they are not valid, since files are untrusted."""
    try:
        entries, irradiance = arrays["entries"], arrays["irradiance"]
        reflected, passed = arrays["reflected"], arrays["passed"]
        lobe, behind = arrays["lobe"], arrays["behind"]
        probes, size_m = int(arrays["probes"][0]), float(arrays["size_m"][0])
    except (KeyError, IndexError):
        return None
    slots, count = len(entries), len(irradiance)
    fits = (
        entries.dtype == np.uint32
        and entries.shape == (slots, 2)
        and slots & (slots - 1) == 0
        and irradiance.dtype == np.float32
        and irradiance.shape == (count, limits, lights, 3)
        and int(entries[:, 1].max(initial=0)) < max(count, 1)
        and reflected.shape == passed.shape == (count, 3)
        and lobe.shape == behind.shape == (count,)
        and reflected.dtype == passed.dtype == lobe.dtype == np.float32
        and behind.dtype == np.uint32
        and int(behind.max(initial=0)) < max(count, 1)
        and 0 < probes <= slots
        and size_m > 0.0
    )
    if not fits:
        return None
    table = SurfelTable(size_m, entries, probes)
    return CacheData(table, irradiance, reflected, passed, lobe, behind)


@runtime_checkable
class LinkRecorder(Protocol):
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
        if dr.hint(isinstance(sums, LinkRecorder), mode="scalar"):
            sums.looked_up(total, active)


def passing(scene: Scene) -> bool:
    """Whether any surface passes light on diffusely."""
    return any(patch.surface.transmission > 0.0 for patch in scene.patches)
