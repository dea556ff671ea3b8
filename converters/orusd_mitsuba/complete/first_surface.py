"""The first surface along a camera's rays: what it receives, and the parts of what it scatters.

What a surface scatters is taken apart into Lambert's reflection, of its base colour about the
normal that the ground truth shows, and the rest. Of OpenRooms' model the rest is the lobe and what
is transmitted, evaluated by themselves. Any other model is left whole.
"""

from typing import Any, Final

import drjit as dr
import mitsuba as mi

from orusd_mitsuba.complete.matter import SceneMatter, looked_up
from orusd_mitsuba.plugins import microfacet
from orusd_mitsuba.plugins.openrooms_bsdf import Reflection, view_of

# Told by the tables of the scene, once for all surfaces.
_NOTHING: Any = None
# Luminance of what a lobe reflects of even light, for there to be one.
_LEAST_LOBE: Final = 1e-4


class FirstSurface:
    """Surfaces at which paths of a camera were stopped.

    No dataclass: Dr.Jit would carry its arrays through loops.

    Args:
        matter: What surfaces are made of.
        si: The interactions.
        active: Where there is a surface.
        crossed: The opening that was crossed on the way from the camera.
        through: What of light comes from there through panes, a colour.

    Attributes:
        si: See above.
        active: See above.
        crossed: See above.
        albedo: What Lambert's reflection has of each colour, behind these panes.
        normal: That of the ground truth, on the side of the camera, in the world.
        undivided: Where the rest is all that the surface scatters; None where that is nowhere.
    """

    def __init__(
        self, matter: SceneMatter, si: Any, active: Any, crossed: Any, through: Any
    ) -> None:
        self.si, self.active, self.crossed, self._through = si, active, crossed, through
        found = matter(si, active)
        self.albedo = found.diffuse * through
        self._view = view_of(si, found.relief)
        self.normal = si.to_world(self._view.frame.n)
        self._model = Reflection(found, self._view, lobe=1.0, reflection=0.0, passage=1.0)
        self._bsdf, self.undivided, self._matte = _NOTHING, _NOTHING, _NOTHING
        if matter.matte is not None:
            self._matte = looked_up(matter.matte, si, active)
        if matter.others is not None:
            self._bsdf, self.undivided = si.bsdf(), looked_up(matter.others, si, active)
            self._opacity = 1.0 - self._bsdf.eval_null_transmission(si, active)

    def lobe(self) -> tuple[Any, Any, Any]:
        """Where the rest is one specular lobe, what that reflects of even light, and its width.

        Returns:
            The mask, a colour, and about the standard deviation of its directions, radian.
        """
        matter = self._model.matter
        albedo = microfacet.lobe_albedo(self._view.wi.z, matter.roughness, matter.specular)
        albedo *= matter.gloss * self._through
        alone = self.active & (matter.transmission <= 0.0) & (mi.luminance(albedo) > _LEAST_LOBE)
        for other in (self._matte, self.undivided):
            if other is not None:
                alone &= ~other
        return alone, albedo, microfacet.lobe_width(matter.roughness)

    def cosine(self, direction: Any) -> Any:
        """What counts of light from a direction; 0 from below."""
        local = self.si.to_local(direction)
        wo = self._view.frame.to_local(local)
        here, _ = self._view.sides(wo, local)
        return dr.select(here, wo.z, 0.0)

    def sample_cosine(self, sample: Any) -> Any:
        """A direction by its cosine; it may not count."""
        local = self._view.frame.to_world(mi.warp.square_to_cosine_hemisphere(sample))
        return self.si.to_world(local)

    def rest(self, direction: Any) -> tuple[Any, Any]:
        """The rest of the BSDF, times the cosine, and how densely directions are sampled.

        As panes let it through.
        """
        value, density = self._rest(direction)
        return value * self._through, density

    def _rest(self, direction: Any) -> tuple[Any, Any]:
        local = self.si.to_local(direction)
        value, density = self._model.value(self._view.frame.to_local(local), local)
        if self._matte is not None:
            value, density = (dr.select(self._matte, 0.0, found) for found in (value, density))
        if self._bsdf is None:
            return value, density
        context, here = mi.BSDFContext(), self.active & self.undivided
        whole, other = self._bsdf.eval_pdf(context, self.si, local, here)
        # Those paths that are not stopped at a clear surface go on from the next one.
        whole = dr.select(self._opacity > 0.0, whole / self._opacity, 0.0)
        return dr.select(self.undivided, whole, value), dr.select(self.undivided, other, density)

    def sample_rest(self, which: Any, where: Any) -> Any:
        """A direction for the rest."""
        wo, _ = self._model.direction(which, where)
        local = self._view.frame.to_world(wo)
        if self._bsdf is not None:
            here = self.active & self.undivided
            sample, _ = self._bsdf.sample(mi.BSDFContext(), self.si, which, where, here)
            local = dr.select(self.undivided, sample.wo, local)
        return self.si.to_world(local)
