"""Clear panes: light goes straight through, dimmed and tinted, or is mirrored by their two faces.

Panes are not part of the scene that rays are traced in: occluders are found without them, and a
shadow ray stays one query. What a ray crosses on its way is found in a scene of panes alone, which
is small. A pane reflects and transmits the sum of all reflections between its faces (Fresnel's
equations for both polarizations, Airy's sum without interference), without moving a ray sideways.
No light is lost except what the glass absorbs.
"""

from typing import Any, Final

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.rendering.scene.arrays import Scene
from orusd_mitsuba.plugins.memory import aligned

# How far beyond a pane rays begin, metres for each metre of their coordinates.
_STEP_PER_M: Final = 1e-5
# Of rays that end at nothing.
_UNLIMITED_M: Final = 1e30


class Panes:
    """All panes of a scene, for arrays of rays.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Args:
        scene: The arrays.
    """

    def __init__(self, scene: Scene) -> None:
        corners = np.concatenate([pane.triangles.corners for pane in scene.panes]) - scene.origin
        sizes = [len(pane.triangles) for pane in scene.panes]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        glass = [
            [pane.surface.ior, *(pane.surface.pane or ()), float(pane.is_sheet)]
            for pane in scene.panes
        ]
        rows = np.column_stack([normals, np.repeat(np.array(glass), sizes, axis=0)])
        self._rows = mi.Float(aligned(rows.astype(np.float32)))
        mesh = mi.Mesh("panes", vertex_count=3 * len(corners), face_count=len(corners))
        arrays = mi.traverse(mesh)
        arrays["vertex_positions"] = np.ascontiguousarray(corners, dtype=np.float32).ravel()
        arrays["faces"] = np.arange(3 * len(corners), dtype=np.uint32)
        arrays.update()
        self._alone = mi.load_dict({"type": "scene", "panes": mesh}, optimize=False)

    @dr.syntax
    def through(self, ray: Any, end: Any, active: Any) -> Any:
        """What of light comes straight along rays through all panes: a colour.

        Args:
            ray: The rays.
            end: How far; infinite to the sky.
            active: Which of them are wanted.
        """
        passed, at, active = mi.Color3f(1.0), _limited(ray, end), mi.Bool(active)
        while active:
            met = _Met(self._alone, self._rows, at, active)
            passed = dr.select(met.counts, passed * met.passed, passed)
            at = met.beyond(at)
            active = met.active
        return passed

    @dr.syntax
    def meet(self, ray: Any, end: Any, sampler: Any, active: Any, mirrors: Any) -> Any:
        """Let rays go through panes or be mirrored by one, by chance.

        Args:
            ray: The rays.
            end: How far they go; infinite to the sky.
            sampler: Random numbers.
            active: Which to follow.
            mirrors: Which of these may be mirrored; others go straight on.

        Returns:
            What they carry on, a colour; whether they are mirrored; these rays from there on; and
            where the straight ones end.
        """
        weight, turned = mi.Color3f(1.0), mi.Bool(False)
        onto, at, active = mi.Ray3f(ray), _limited(ray, end), mi.Bool(active)
        length = mi.Float(end)
        while active:
            met = _Met(self._alone, self._rows, at, active)
            mirrored = mi.luminance(met.mirrored)
            total = mirrored + mi.luminance(met.passed)
            chance = dr.select(mirrors, mirrored / dr.maximum(total, 1e-6), 0.0)
            here = met.counts & (sampler.next_1d() < chance)
            carried = dr.select(here, met.mirrored / chance, met.passed / (1.0 - chance))
            weight = dr.select(met.counts, weight * carried, weight)
            length = dr.select(here, dr.norm(met.p - ray.o), length)
            back = met.back(at)
            onto.o, onto.d = dr.select(here, back.o, onto.o), dr.select(here, back.d, onto.d)
            onto.maxt = dr.select(here, _UNLIMITED_M, onto.maxt)
            turned |= here
            at = met.beyond(at)
            active = met.active & ~here
        return weight, turned, onto, length

    @dr.syntax
    def mirror(self, ray: Any, end: Any, sampler: Any, active: Any) -> Any:
        """What panes mirror towards where rays begin; of several panes one, by chance.

        Args:
            ray: The rays.
            end: How far they go; infinite to the sky.
            sampler: Random numbers.
            active: Which to follow.

        Returns:
            What of the mirrored light arrives, a colour; the rays that it comes along; and where
            there are any.
        """
        passed, total, weight = mi.Color3f(1.0), mi.Float(0.0), mi.Color3f(0.0)
        onto, at, active = mi.Ray3f(ray), _limited(ray, end), mi.Bool(active)
        while active:
            met = _Met(self._alone, self._rows, at, active)
            value = passed * met.mirrored
            bright = dr.select(met.counts, mi.luminance(value), 0.0)
            total += bright
            here = (bright > 0.0) & (sampler.next_1d() * total <= bright)
            weight = dr.select(here, value / dr.maximum(bright, 1e-12), weight)
            back = met.back(at)
            onto.o, onto.d = dr.select(here, back.o, onto.o), dr.select(here, back.d, onto.d)
            onto.maxt = dr.select(here, _UNLIMITED_M, onto.maxt)
            passed = dr.select(met.counts, passed * met.passed, passed)
            at = met.beyond(at)
            active = met.active
        return weight * mi.Color3f(total), onto, total > 0.0


class _Met:
    """The next pane on rays.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Attributes:
        active: Where there is one.
        counts: Where the ray meets the pane there, and does not leave it.
        mirrored: The part of light that it mirrors, a colour.
        passed: The part that it passes.
        p: Where.
    """

    def __init__(self, alone: Any, rows: Any, ray: Any, active: Any) -> None:
        hit = alone.ray_intersect_preliminary(ray, active=active)
        self.active = active & hit.is_valid()
        first = dr.gather(mi.Vector4f, rows, 2 * hit.prim_index, self.active)
        second = dr.gather(mi.Vector4f, rows, 2 * hit.prim_index + 1, self.active)
        self._normal = mi.Vector3f(first.x, first.y, first.z)
        self._cosine = -dr.dot(self._normal, ray.d)
        self.counts = self.active & ((self._cosine > 0.0) | (second.w > 0.5))
        tint = mi.Color3f(second.x, second.y, second.z)
        self.mirrored, self.passed = pane_shares(dr.abs(self._cosine), first.w, tint)
        self.p, self._t = ray.o + ray.d * hit.t, hit.t

    def beyond(self, ray: Any) -> Any:
        """The rays from behind it on."""
        step = self._t + self._step
        found = mi.Ray3f(ray)
        found.o = ray.o + ray.d * step
        found.maxt = ray.maxt - step
        return found

    def back(self, ray: Any) -> Any:
        """The mirrored rays."""
        side = dr.select(self._cosine < 0.0, -self._normal, self._normal)
        found = mi.Ray3f(ray)
        found.o = self.p + side * self._step
        found.d = dr.normalize(ray.d + side * (2.0 * dr.abs(self._cosine)))
        return found

    @property
    def _step(self) -> Any:
        return _STEP_PER_M * (1.0 + dr.max(dr.abs(self.p)))


def pane_shares(cosine: Any, ior: Any, tint: Any) -> tuple[Any, Any]:
    """The parts of unpolarized light that a pane mirrors and passes.

    Args:
        cosine: Of the angle to its normal, outside.
        ior: Its index of refraction.
        tint: What its glass lets through at normal incidence, once across.
    """
    inside = dr.sqrt(dr.maximum(1.0 - (1.0 - dr.square(cosine)) / dr.square(ior), 1e-12))
    # Across the glass the way is longer, by Beer's law.
    held = mi.Color3f(tint) ** dr.rcp(inside)
    mirrored, passed = mi.Color3f(0.0), mi.Color3f(0.0)
    for outer, inner in ((cosine, ior * inside), (ior * cosine, inside)):
        face = dr.square((outer - inner) / (outer + inner))
        once = dr.square(1.0 - face) * held / (1.0 - dr.square(face * held))
        passed += 0.5 * once
        mirrored += 0.5 * (face + face * held * once)
    return mirrored, passed


def _limited(ray: Any, end: Any) -> Any:
    """The rays up to their ends."""
    found = mi.Ray3f(ray)
    found.maxt = dr.minimum(ray.maxt, dr.minimum(end, _UNLIMITED_M))
    return found
