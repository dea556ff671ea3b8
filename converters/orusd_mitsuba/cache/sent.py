"""What surfels send on, as very many rays look it up: a hit, a hash, four numbers."""

from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from openrooms_usd.rendering.scene.arrays import Scene
from orusd_mitsuba.cache.filling import CacheData
from orusd_mitsuba.cache.surfels import SurfelIndex
from orusd_mitsuba.plugins.memory import aligned

Floats = NDArray[np.float32]

# Set in the piece of a triangle that emits, and of one whose surface is not known.
_EMITS: Final = 1 << 31
_FOREIGN: Final = 1 << 30


class Met:
    """What rays meet.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Attributes:
        surfel: Its number.
        known: Whether there is one.
        emits: Whether the surface is a lamp's.
        foreign: Whether it is one that the cache does not know.
    """

    def __init__(self, surfel: Any, known: Any, emits: Any, foreign: Any) -> None:
        self.surfel, self.known, self.emits, self.foreign = surfel, known, emits, foreign


class SurfelLight:
    """Finds surfels along rays, and what they send.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Args:
        scene: The arrays.
        built: The same as a Mitsuba scene.
        data: What `filling.fill` made.
        tabulated: (patches,) whether each has a row in the table of materials.

    Attributes:
        size: Edge of a surfel, metres.
    """

    def __init__(self, scene: Scene, built: Any, data: CacheData, tabulated: Any) -> None:
        self._data = data
        self._index = SurfelIndex(scene, built, data.table.size_m, data.table)
        self.size = self._index.size
        a, b, c = np.moveaxis(scene.triangles.corners, 1, 0)
        normals = np.cross(b - a, c - a)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        emits = np.array([patch.radiance is not None for patch in scene.patches], dtype=bool)
        flags = emits * np.uint32(_EMITS) | ~tabulated * np.uint32(_FOREIGN)
        pieces = scene.triangles.pieces.astype(np.uint32)
        pieces |= np.repeat(flags.astype(np.uint32), np.diff(scene.offsets))
        rows = np.column_stack([normals.astype(np.float32), pieces.view(np.float32)])
        self._triangles = mi.Float(aligned(rows))

    def meet(self, ray: Any, hit: Any, active: Any) -> Met:
        """The surfels that rays meet.

        Args:
            ray: The rays.
            hit: Preliminary intersections.
            active: Which meet anything.
        """
        row = self._index.triangle(hit.shape, hit.prim_index, active)
        triangle = dr.gather(mi.Vector4f, self._triangles, row, active)
        piece: Any = dr.reinterpret_array(mi.UInt32, triangle.w)
        normal = mi.Vector3f(triangle.x, triangle.y, triangle.z)
        normal = dr.select(dr.dot(normal, ray.d) <= 0.0, normal, -normal)
        emits = active & ((piece & _EMITS) != 0)
        foreign = active & ((piece & _FOREIGN) != 0)
        asked = active & ~foreign
        surfel, known = self._index.find_at(ray(hit.t), normal, piece & (_FOREIGN - 1), asked)
        return Met(surfel, known, emits, foreign)

    def sent(self, scattered: int, lobes: Floats, last: Floats) -> Any:
        """A table of what surfels send on.

        What of them goes by lobes is taken as even: what a lobe reflects of even light, times what
        the surfel receives in the mean. All directions together that is right.

        Args:
            scattered: How often light is scattered after it has left the surfel, at most less than
                the cache has been filled for.
            lobes: (N,) of each surfel's lobe, luminance.
            last: (N,) a number that is found beside it.
        """
        received = self._data.irradiance
        if scattered >= received.shape[1]:
            return mi.Float(aligned(np.zeros((len(last), 4), dtype=np.float32)))
        irradiance = received[:, scattered].sum(axis=1)
        albedo = self._data.reflected + lobes[:, None]
        sent = albedo * irradiance + self._data.passed * irradiance[self._data.behind]
        table = np.column_stack([sent / np.float32(np.pi), last]).astype(np.float32)
        return mi.Float(aligned(table))
