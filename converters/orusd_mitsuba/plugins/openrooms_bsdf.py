"""OpenRooms' reflectance model as a BSDF of Mitsuba, ``{"type": "openrooms", ...}``.

The same from both sides; a part of the light may leave the other side like Lambert's, as through
cloth. Its relief is part of the model rather than wrapped around it, so that the model sees the
normal that the ground truth shows. That normal is mirrored behind the surface, and bent to the
horizon where interpolation or relief turns it away from the viewer. Light is reflected only to the
viewer's side of the true surface, and transmitted only to the other one.
"""

from dataclasses import dataclass
from functools import cache, reduce
from operator import or_
from typing import Any, Final, Protocol

import drjit as dr
import mitsuba as mi

from orusd_mitsuba.plugins import microfacet

NAME: Final = "openrooms"
DEFAULT_F0: Final = 0.05
_INPUTS: Final = {"base_color": 0.5, "roughness": 0.5, "metallic": 0.0}


@dataclass(frozen=True, eq=False)
class Matter:
    """What a surface is made of at points, numbers of the active variant.

    Attributes:
        base_color: Diffuse colour of dielectrics, reflectance of metals.
        roughness: Perceptual roughness R; alpha = R^2.
        metallic: 0 dielectric to 1 metal.
        f0: Reflectance of the dielectric at normal incidence.
        transmission: What passes, in multiples of the diffuse albedo.
        relief: Tangent-space normal, of any length.
        gloss: 1, or 0 where there is no specular lobe.
    """

    base_color: Any
    roughness: Any
    metallic: Any
    f0: Any
    transmission: Any
    relief: Any
    gloss: Any = 1.0

    @property
    def diffuse(self) -> Any:
        """The diffuse albedo A."""
        return self.base_color * (1.0 - self.metallic)

    @property
    def specular(self) -> Any:
        """The colour F0: that of UsdPreviewSurface's metallic workflow."""
        return dr.lerp(mi.Color3f(self.f0), self.base_color, self.metallic)


class TextureSource(Protocol):
    """Where a BSDF has its matter from."""

    def __call__(self, si: Any, active: Any) -> Matter:
        """The matter at surface interactions."""
        ...

    def traverse(self, callback: Any) -> None:
        """Show what it holds to Mitsuba."""
        ...


class Inputs:
    """Matter from the textures of one plugin description."""

    def __init__(self, properties: Any) -> None:
        self._textures = {
            name: properties.get_texture(name, default) for name, default in _INPUTS.items()
        }
        self._f0 = mi.Float(properties.get("f0", DEFAULT_F0))
        self._transmission = mi.Float(properties.get("transmission", 0.0))
        self._normal = properties.get_texture("normal") if "normal" in properties else None

    def __call__(self, si: Any, active: Any) -> Matter:
        """The matter at surface interactions."""
        base = self._textures["base_color"].eval(si, active)
        numbers = {
            name: self._textures[name].eval_1(si, active) for name in ("roughness", "metallic")
        }
        relief = relief_of(self._normal, si, active)
        return Matter(base, **numbers, f0=self._f0, transmission=self._transmission, relief=relief)

    def traverse(self, callback: Any) -> None:
        """Show the textures and numbers to Mitsuba."""
        for name, texture in self._textures.items():
            callback.put(name, texture, mi.ParamFlags.Differentiable)
        for name, value in (("f0", self._f0), ("transmission", self._transmission)):
            callback.put(name, value, mi.ParamFlags.Differentiable)
        if self._normal is not None:
            callback.put("normal", self._normal, mi.ParamFlags.Differentiable)


@dataclass(frozen=True, eq=False)
class View:
    """The viewer's side of surface points.

    Attributes:
        frame: Its z axis is the normal, in the interaction's local coordinates.
        wi: Where the light goes, in ``frame``; z is not negative.
        outward: The true normal on this side, in local coordinates.
    """

    frame: Any
    wi: Any
    outward: Any

    def sides(self, wo: Any, local: Any) -> tuple[Any, Any]:
        """Whether a direction, in `frame` and in local coordinates, is on this side or beyond.

        Between relief and true surface it is neither.
        """
        height = dr.dot(self.outward, local)
        return (wo.z > 0.0) & (height >= 0.0), (wo.z < 0.0) & (height < 0.0)


def view_of(si: Any, relief: Any) -> View:
    """The viewer's side at surface interactions of a relief, as the ground truth shows it."""
    true = si.to_local(si.n)
    side = dr.select(dr.dot(true, si.wi) >= 0.0, mi.Float(1.0), mi.Float(-1.0))
    normal = dr.normalize(mi.Vector3f(relief.x, relief.y, relief.z * side))
    bent = normal - dr.minimum(dr.dot(normal, si.wi), 0.0) * si.wi
    # What looks straight away names no side to bend to.
    bent = dr.select(dr.squared_norm(bent) > 1e-12, bent, true * side)
    frame = mi.Frame3f(dr.normalize(bent))
    wi = frame.to_local(si.wi)
    wi.z = dr.maximum(wi.z, 0.0)
    return View(frame, wi, true * side)


@dataclass(frozen=True, eq=False)
class Reflection:
    """The model at one surface interaction, with the parts that a caller asks for.

    Attributes:
        matter: What is there.
        view: Its viewer's side.
        lobe: Weight of the specular lobe: 0 or 1.
        reflection: Weight of diffuse reflection, a number or one for each interaction.
        passage: Weight of diffuse transmission, as of ``reflection``.
    """

    matter: Matter
    view: View
    lobe: float
    reflection: Any
    passage: Any

    @staticmethod
    def at(source: TextureSource, context: Any, si: Any, active: Any) -> "Reflection":
        """All parts that a context asks for."""
        flags = mi.BSDFFlags
        parts = (flags.GlossyReflection, flags.DiffuseReflection, flags.DiffuseTransmission)
        asked = [float(context.is_enabled(part, number)) for number, part in enumerate(parts)]
        return Reflection.of(source(si, active), si, *asked)

    @staticmethod
    def of(matter: Matter, si: Any, lobe: float, reflection: Any, passage: Any) -> "Reflection":
        """The model of some matter at surface interactions, its parts weighed."""
        return Reflection(matter, view_of(si, matter.relief), lobe, reflection, passage)

    @property
    def shares(self) -> tuple[Any, Any]:
        """The parts of the samples that go into the lobe and into transmission.

        In proportion to what each reflects or passes of even light; a wide lobe is left to the
        cosine's directions, which diffuse reflection has.
        """
        matter = self.matter
        albedo = microfacet.lobe_albedo(self.view.wi.z, matter.roughness, matter.specular)
        lobe = self.lobe * matter.gloss * mi.luminance(albedo)
        diffuse = mi.luminance(matter.diffuse)
        passage = self.passage * matter.transmission * diffuse
        total = dr.maximum(lobe + passage + self.reflection * diffuse, 1e-6)
        narrow = lobe * microfacet.lobe_narrowness(matter.roughness)
        return narrow / total, passage / total

    def direction(self, which: Any, where: Any) -> tuple[Any, Any]:
        """A direction in the view's frame, and the number of the part that it is of."""
        lobe, passage = self.shares
        glossy, through = which < lobe, which >= 1.0 - passage
        mirrored = microfacet.sample_lobe(self.view.wi, self.matter.roughness, where)
        even = mi.warp.square_to_cosine_hemisphere(where)
        even.z = dr.select(through, -even.z, even.z)
        part = dr.select(through, mi.UInt32(2), mi.UInt32(1))
        return dr.select(glossy, mirrored, even), dr.select(glossy, mi.UInt32(0), part)

    def value(self, wo: Any, local: Any) -> tuple[Any, Any]:
        """The model times the cosine of a direction, and its density over solid angle."""
        matter, wi = self.matter, self.view.wi
        here, beyond = self.view.sides(wo, local)
        lobe, passage = self.shares
        # Lambert's part, and what is of the lobe where there may be one.
        even = dr.abs(wo.z) * dr.inv_pi
        color = matter.diffuse * (even * self.reflection)
        if self.lobe:
            shape = microfacet.specular(wi, wo, matter.roughness, matter.specular)
            color += shape * (wo.z * matter.gloss)
        density = (1.0 - lobe - passage) * even
        density += lobe * microfacet.lobe_density(wi, wo, matter.roughness)
        passed = matter.diffuse * (self.passage * matter.transmission * even)
        nothing = mi.Color3f(0.0)
        return (
            dr.select(here, color, dr.select(beyond, passed, nothing)),
            dr.select(here, density, dr.select(beyond, passage * even, 0.0)),
        )


@cache
def register(variant: str) -> Any:
    """Make ``openrooms`` known to the active variant, and return its class.

    Args:
        variant: The name of the active variant: each has a base class of its own.
    """
    flags = mi.BSDFFlags
    parts = (flags.GlossyReflection, flags.DiffuseReflection, flags.DiffuseTransmission)
    return define_bsdf(NAME, Inputs, Reflection, parts)


def define_bsdf(name: str, inputs: Any, model: Any, parts: tuple[Any, ...]) -> Any:
    """Make a BSDF of a model known to the active variant, and return its class.

    Args:
        name: How descriptions call it.
        inputs: Makes the source of a plugin's properties.
        model: Has ``at(source, context, si, active)`` with ``view``, ``direction`` and ``value``.
        parts: What its parts are, by their numbers.
    """

    class ModelBSDF(mi.BSDF):
        def __init__(self, properties: Any, source: Any = None) -> None:
            super().__init__(properties)
            self.source = source or inputs(properties)
            flags = mi.BSDFFlags
            sides = flags.FrontSide | flags.BackSide | flags.SpatiallyVarying
            self.m_components = [part | sides for part in parts]
            self.m_flags = reduce(or_, self.m_components)

        def sample(
            self, context: Any, si: Any, which: Any, where: Any, active: Any = True
        ) -> tuple[Any, Any]:
            at = model.at(self.source, context, si, active)
            wo, part = at.direction(which, where)
            local = at.view.frame.to_world(wo)
            value, density = at.value(wo, local)
            # What the lobe sends below the horizon is lost, not transmitted.
            active = active & (density > 0.0) & ((part == 2) | (wo.z > 0.0))
            bs: Any = dr.zeros(mi.BSDFSample3f)
            bs.wo = local
            bs.pdf = dr.select(active, density, 0.0)
            bs.eta = 1.0
            bs.sampled_type = mi.UInt32(int(parts[0]))
            for number, kind in enumerate(parts[1:], 1):
                bs.sampled_type = dr.select(part == number, int(kind), bs.sampled_type)
            bs.sampled_component = part
            return bs, dr.select(active, value / dr.select(active, density, 1.0), 0.0)

        def eval_pdf(self, context: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
            at = model.at(self.source, context, si, active)
            value, density = at.value(at.view.frame.to_local(wo), wo)
            return dr.select(active, value, 0.0), dr.select(active, density, 0.0)

        def eval(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.eval_pdf(context, si, wo, active)[0]

        def pdf(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.eval_pdf(context, si, wo, active)[1]

        def eval_diffuse_reflectance(self, si: Any, active: Any = True) -> Any:
            return self.source(si, active).diffuse

        def traverse(self, callback: Any) -> None:
            self.source.traverse(callback)

        def to_string(self) -> str:
            return f"{name}[{self.id()}]"

    mi.register_bsdf(name, ModelBSDF)
    return ModelBSDF


def relief_of(normal: Any, si: Any, active: Any) -> Any:
    """The normals that a texture stores in 0..1; flat where there is none."""
    if normal is None:
        return mi.Vector3f(0.0, 0.0, 1.0)
    stored = normal.eval_3(si, active)
    return mi.Vector3f(stored.x, stored.y, stored.z) * 2.0 - 1.0
