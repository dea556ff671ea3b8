"""The emitting faces of all lamps as tables, and points on them by what can be seen.

A face of a lamp is chosen by its flux and by its orientation to the sector of the receiving point,
seen from the lamp's centre. A part of the samples depends on flux alone, so that no face is ever
left out (a defensive mixture, Hesterberg 1995). Rays meet the faces alone in a scene of their own,
because light without occlusion knows nothing else.
"""

from collections.abc import Sequence
from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.colorimetry import luminance
from openrooms_usd.rendering.scene.arrays import Patch, Scene
from openrooms_usd.rendering.scene.pictures import Picture, Value
from openrooms_usd.rendering.scene.sources import Source
from orusd_mitsuba.transport.light_index import registered

# The part of the samples that goes by flux alone.
_SHARE_BY_FLUX: Final = 0.1
# Sectors of equal solid angle around a lamp: bands of height, and of each so many around. In each
# direction of both it is judged by so many places.
_SECTOR_BANDS: Final = 6
_SECTORS_AROUND: Final = 12
_PLACES_A_SIDE: Final = 3


class LampFaces:
    """The faces of the lamps that shine; rows are theirs, lamp by lamp.

    Args:
        scene: The arrays.
        built: The Mitsuba scene, its shapes in the order of the scene's patches.
        sources: The lights.

    Attributes:
        lights: The number of each lamp's light.
        starts: First row of each lamp, and the number of all rows.
        even: Of each lamp whether all of it has one radiance per patch, in all directions.
        alone: A Mitsuba scene of nothing but the faces, whose primitives are the rows.
    """

    def __init__(self, scene: Scene, built: Any, sources: Sequence[Source]) -> None:
        shining = [(n, source) for n, source in enumerate(sources) if _flux(scene, source) > 0.0]
        self.lights = [number for number, _ in shining]
        patches = [number for _, source in shining for number in source.patches]
        sizes = [len(scene.patches[number].triangles) for number in patches]
        per_lamp = [
            sum(len(scene.patches[number].triangles) for number in source.patches)
            for _, source in shining
        ]
        self.starts = np.concatenate([[0], np.cumsum(per_lamp)]).astype(np.int64)
        self.even = [
            all(_is_even(scene.patches[number]) for number in source.patches)
            for _, source in shining
        ]
        corners = np.concatenate(
            [np.zeros((0, 3, 3)), *(scene.patches[n].triangles.corners for n in patches)]
        )
        st = np.concatenate(
            [np.zeros((0, 3, 2)), *(scene.patches[n].triangles.st for n in patches)]
        )
        corners = corners - scene.origin
        self._tabulate(corners, st)
        shapes = built.shapes()
        emitters = [registered(mi.EmitterPtr(shapes[number].emitter()))[0] for number in patches]
        self._shaped = any(scene.patches[number].shaping is not None for number in patches)
        self._emitters = mi.UInt32(np.repeat(np.array(emitters, dtype=np.uint32), sizes))
        shone = np.repeat([_luminance(scene.patches[number]) for number in patches], sizes)
        self._weigh(corners, shone)
        self.alone = _scene_of(corners)

    def __len__(self) -> int:
        return len(self.lights)

    def _tabulate(self, corners: Array, st: Array) -> None:
        crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        doubled = np.linalg.norm(crosses, axis=1)
        self._normals = crosses / np.where(doubled > 0.0, doubled, 1.0)[:, None]
        self._areas = 0.5 * doubled
        self._corners = [_flat(corners[:, i]) for i in range(3)]
        self._st = [_flat(st[:, i]) for i in range(3)]
        self._normal = _flat(self._normals)
        self._area = _flat(self._areas)

    def _weigh(self, corners: Array, shone: Array) -> None:
        """Tables by sector and row: the chance of the row, and of all up to it, in its lamp."""
        lamp = np.repeat(np.arange(len(self)), np.diff(self.starts))
        flux = self._areas * shone
        middles = np.zeros((len(self), 3))
        ways = _sectors()
        chance = np.zeros((len(ways), len(flux)))
        below = np.ones(chance.shape)
        turned = np.mean([np.maximum(way @ self._normals.T, 0.0) for way in ways.swapaxes(0, 1)], 0)
        for number in range(len(self)):
            rows = slice(*self.starts[number : number + 2])
            held = corners[rows].reshape(-1, 3)
            middles[number] = (held.min(axis=0) + held.max(axis=0)) / 2.0
            by_flux = flux[rows] / flux[rows].sum()
            seen = by_flux * turned[:, rows]
            total = seen.sum(axis=1, keepdims=True)
            by_view = np.where(total > 0.0, seen / np.where(total > 0.0, total, 1.0), by_flux)
            chance[:, rows] = _SHARE_BY_FLUX * by_flux + (1.0 - _SHARE_BY_FLUX) * by_view
            below[:, rows] = np.cumsum(chance[:, rows], axis=1)
        self._lamp, self._middle = mi.UInt32(lamp.astype(np.uint32)), _flat(middles)
        self._chance, self._below = _flat(chance), _flat(below)
        self._first = mi.UInt32(self.starts[:-1].astype(np.uint32))
        self._last = mi.UInt32((self.starts[1:] - 1).astype(np.uint32))
        self._light = mi.UInt32(np.array(self.lights, dtype=np.uint32))
        self._steps = int(np.diff(self.starts).max(initial=1)).bit_length()

    def light(self, lamp: Any) -> Any:
        """The number of a lamp's light."""
        return dr.gather(mi.UInt32, self._light, lamp)

    def lamp(self, row: Any, active: Any) -> Any:
        """The lamp that a row is part of."""
        return dr.gather(mi.UInt32, self._lamp, row, active)

    def rows(self, lamp: Any) -> tuple[Any, Any]:
        """First and last row of a lamp."""
        return dr.gather(mi.UInt32, self._first, lamp), dr.gather(mi.UInt32, self._last, lamp)

    def corners(self, row: Any) -> tuple[Any, Any, Any]:
        """The corners of a row, counter-clockwise seen from the front."""
        a, b, c = (dr.gather(mi.Point3f, corner, row) for corner in self._corners)
        return a, b, c

    def normal(self, row: Any, active: Any = True) -> Any:
        """The unit normal of a row; zero where it has no area."""
        return dr.gather(mi.Normal3f, self._normal, row, active)

    def density(self, row: Any, lamp: Any, at: Any, active: Any = True) -> Any:
        """How densely `sample` takes points of a row, per square metre."""
        entry = self._sector(lamp, at) * len(self._normals) + row
        chance = dr.gather(mi.Float, self._chance, entry, active)
        area = dr.gather(mi.Float, self._area, row, active)
        return dr.select(area > 0.0, chance / area, 0.0)

    def sample(self, lamp: Any, at: Any, choice: Any, within: Any) -> tuple[Any, Any, Any]:
        """A point on a lamp.

        Args:
            lamp: Which one.
            at: What receives its light.
            choice: A number in [0, 1) that the face is chosen by.
            within: Two that the point on it is chosen by.

        Returns:
            Row, and the point's two barycentric coordinates and place.
        """
        low, high = self.rows(lamp)
        table = self._sector(lamp, at) * len(self._normals)
        for _ in range(self._steps):
            middle = (low + high) // 2
            above = dr.gather(mi.Float, self._below, table + middle) <= choice
            low, high = (
                dr.select(above & (low < high), middle + 1, low),
                dr.select(above, high, middle),
            )
        root = dr.sqrt(1.0 - within.x)
        place = mi.Point2f(1.0 - root, root * within.y)
        a, b, c = self.corners(low)
        return low, place, a + (b - a) * place.x + (c - a) * place.y

    def place(self, row: Any, point: Any) -> Any:
        """Barycentric coordinates of a point of a row's plane."""
        a, b, c = self.corners(row)
        u, v, w = b - a, c - a, point - a
        normal = dr.cross(u, v)
        squared = dr.maximum(dr.squared_norm(normal), 1e-30)
        return mi.Point2f(
            dr.dot(dr.cross(w, v), normal) / squared, dr.dot(dr.cross(u, w), normal) / squared
        )

    def radiance(self, row: Any, place: Any, active: Any = True, towards: Any = None) -> Any:
        """What a point of a row emits to its front.

        Args:
            row: Which face.
            place: Barycentric coordinates of its second and third corner.
            active: Where it is wanted.
            towards: The unit vector along which; None of lamps that are even.
        """
        a, b, c = (dr.gather(mi.Point2f, corner, row, active) for corner in self._st)
        si = dr.zeros(mi.SurfaceInteraction3f, dr.width(row))
        si.uv = a + (b - a) * place.x + (c - a) * place.y
        si.wi = mi.Vector3f(0.0, 0.0, 1.0)
        if self._shaped and towards is not None:
            si.sh_frame = mi.Frame3f(self.normal(row, active))
            si.wi = si.to_local(towards)
        number = dr.gather(mi.UInt32, self._emitters, row, active)
        emitter: Any = dr.reinterpret_array(mi.EmitterPtr, number)
        return emitter.eval(si, active)

    def _sector(self, lamp: Any, at: Any) -> Any:
        to = at - dr.gather(mi.Point3f, self._middle, lamp)
        height = to.z * dr.rsqrt(dr.maximum(dr.squared_norm(to), 1e-30))
        turn = dr.atan2(to.y, to.x) * dr.inv_two_pi
        band = dr.minimum(mi.UInt32((0.5 * height + 0.5) * _SECTOR_BANDS), _SECTOR_BANDS - 1)
        around = dr.minimum(
            mi.UInt32((turn - dr.floor(turn)) * _SECTORS_AROUND), _SECTORS_AROUND - 1
        )
        return band * _SECTORS_AROUND + around


def _sectors() -> Array:
    """(sectors, D, 3) unit vectors, evenly spread over each sector around a lamp."""
    steps = (np.arange(_PLACES_A_SIDE) + 0.5) / _PLACES_A_SIDE
    shape = (_SECTOR_BANDS, _SECTORS_AROUND, _PLACES_A_SIDE, _PLACES_A_SIDE)
    z = 2.0 * (np.arange(_SECTOR_BANDS)[:, None] + steps) / _SECTOR_BANDS - 1.0
    phi = 2.0 * np.pi * (np.arange(_SECTORS_AROUND)[:, None] + steps) / _SECTORS_AROUND
    z, phi = np.broadcast_to(z[:, None, :, None], shape), np.broadcast_to(phi[None, :, None], shape)
    level = np.sqrt(1.0 - z**2)
    ways = np.stack([level * np.cos(phi), level * np.sin(phi), z], axis=-1)
    return np.asarray(ways.reshape(_SECTOR_BANDS * _SECTORS_AROUND, _PLACES_A_SIDE**2, 3))


def _flux(scene: Scene, source: Source) -> float:
    """What a lamp sends out, in some unit; 0 where it is off or has no area."""
    total = 0.0
    for number in source.patches:
        a, b, c = np.moveaxis(scene.patches[number].triangles.corners, 1, 0)
        area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
        total += float(area) * _luminance(scene.patches[number])
    return total


def _is_even(patch: Patch) -> bool:
    return isinstance(patch.radiance, tuple) and patch.shaping is None


def _luminance(patch: Patch) -> float:
    return float(luminance(mean_radiance(patch.radiance)))


def mean_radiance(radiance: Value | None) -> Array:
    """(3,) nits, of a picture the mean of its pixels."""
    held = radiance.pixels if isinstance(radiance, Picture) else np.array([[radiance or 0.0]])
    mean = held.reshape(-1, held.shape[-1]).mean(axis=0, dtype=np.float64)
    return np.asarray(np.broadcast_to(mean, 3))


def _scene_of(corners: Array) -> Any:
    if not len(corners):
        return None
    mesh = mi.Mesh("lamps", vertex_count=3 * len(corners), face_count=len(corners))
    arrays = mi.traverse(mesh)
    arrays["vertex_positions"] = _flat(corners)
    arrays["faces"] = np.arange(3 * len(corners), dtype=np.uint32)
    arrays.update()
    return mi.load_dict({"type": "scene", "lamps": mesh}, optimize=False)


def _flat(values: Array) -> Any:
    return mi.Float(np.ascontiguousarray(values, dtype=np.float32).ravel())
