"""Light that arrives at points by very many rays, as of environment maps, looked up at most.

Of most rays nothing is asked but which surfel they meet and what that sends back diffusely. What is
left (lamps, the sky, short rays, surfaces that are not known, and by chance lobes) is a small part;
it is gathered together and followed apart, so that no ray waits for its neighbours' longer ways.
"""

from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.render.scene.arrays import Scene
from orusd_mitsuba.cache.filling import CacheData
from orusd_mitsuba.cache.surfels import NEAREST_PER_SIZE, SurfelIndex
from orusd_mitsuba.cache.tracing import (
    CHANCE_PER_ALBEDO,
    LEAST_CHANCE,
    LEAST_LOBE_ALBEDO,
    Surroundings,
    follow,
)
from orusd_mitsuba.plugins.memory import aligned

# Set in the piece of a triangle that is not to be looked up.
_APART: Final = 1 << 31


class ArrivingPaths:
    """Paths from points that light arrives at: see `orusd_mitsuba.transport.paths.Paths`.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Args:
        scene: The arrays.
        around: The scene as paths are followed in it, and its cache.
        data: What `filling.fill` made.
        tabulated: (patches,) whether each has a row in the table of materials.
    """

    def __init__(self, scene: Scene, around: Surroundings, data: CacheData, tabulated: Any) -> None:
        self._around = around
        self._index = SurfelIndex(scene, around.built, data.table.size_m, data.table)
        a, b, c = np.moveaxis(scene.triangles.corners, 1, 0)
        normals = np.cross(b - a, c - a)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        apart = np.array([patch.radiance is not None for patch in scene.patches]) | ~tabulated
        pieces = scene.triangles.pieces.astype(np.uint32)
        pieces |= np.repeat(apart, np.diff(scene.offsets)).astype(np.uint32) * np.uint32(_APART)
        rows = np.column_stack([normals.astype(np.float32), pieces.view(np.float32)])
        self._triangles = mi.Float(aligned(rows))
        first = data.irradiance[:, 0].sum(axis=1)
        sent = (data.reflected * first + data.passed * first[data.behind]) / np.float32(np.pi)
        chance = np.clip(CHANCE_PER_ALBEDO * data.lobe, LEAST_CHANCE, 1.0)
        chance = np.where(data.lobe > LEAST_LOBE_ALBEDO, chance, 0.0)
        self._sent = mi.Float(aligned(np.column_stack([sent, chance]).astype(np.float32)))

    def follow(
        self,
        sampler: Any,
        ray: Any,
        accumulator: Any,
        *,
        first: Any = None,
        active: Any = True,
        begun: Any = None,
        numbers: Any = None,
        prefix: Any = None,
    ) -> None:
        """See `Paths`; with ``begun``, into a `PathAccumulator`, and outside loops."""
        point, density = begun
        hit = self._around.built.ray_intersect_preliminary(ray, active=active)
        meets = active & hit.is_valid()
        row = self._index.triangle(hit.shape, hit.prim_index, meets)
        triangle = dr.gather(mi.Vector4f, self._triangles, row, meets)
        piece: Any = dr.reinterpret_array(mi.UInt32, triangle.w)
        normal = mi.Vector3f(triangle.x, triangle.y, triangle.z)
        normal = dr.select(dr.dot(normal, ray.d) <= 0.0, normal, -normal)
        far = hit.t > NEAREST_PER_SIZE * self._index.size
        asked = meets & far & (piece < _APART)
        surfel, known = self._index.find_at(ray(hit.t), normal, piece, asked)
        sent = dr.gather(mi.Vector4f, self._sent, surfel, known)
        color = mi.Color3f(sent.x, sent.y, sent.z)
        accumulator.add(color, mi.UInt32(0), mi.UInt32(1), known)
        drawn = sampler.next_1d()
        left = active & (~known | (drawn < sent.w))
        carried = dr.select(known, dr.rcp(sent.w), 1.0)
        dr.eval(left, known, carried, drawn, ray.o, ray.d, point.p, point.n, density)
        rest: Any = dr.compress(left)
        if not dr.width(rest):
            return
        self._rest(accumulator.part(rest), rest, ray, point, density, (known, carried), drawn)

    def _rest(
        self, accumulator: Any, rest: Any, ray: Any, point: Any, density: Any, counted: Any,
        drawn: Any,
    ) -> None:  # fmt: skip
        """What is followed apart."""
        sampler = mi.load_dict({"type": "independent"})
        # By what was drawn first: no other batch of rays has the same.
        sampler.seed(int(float(drawn[0]) * 2.0**32), dr.width(rest))
        at = dr.zeros(mi.SurfaceInteraction3f, dr.width(rest))
        at.p = dr.gather(mi.Point3f, point.p, rest)
        at.n = dr.gather(mi.Normal3f, point.n, rest)
        onto = mi.Ray3f(dr.gather(mi.Point3f, ray.o, rest), dr.gather(mi.Vector3f, ray.d, rest))
        follow(
            self._around, sampler, onto, accumulator,
            begun=(at, dr.gather(mi.Float, density, rest)),
            counted=tuple(dr.gather(type(part), part, rest) for part in counted),
        )  # fmt: skip
