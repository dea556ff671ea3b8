"""UsdPreviewSurface as a BSDF of Mitsuba, ``{"type": "usd_preview", ...}``.

By the specification, with the formulas of OpenUSD's own ``previewSurface.glslfx``: with d the
diffuse colour, m the metalness, r = ((1 - ior) / (1 + ior))^2, t = mix(1, d, m), h the half vector

    f = (1 - m) d / pi (1 - F) + D F V + c D_c F_c V_c,
    F = mix(F0, F90, (1 - v.h)^5),    F0 = mix(r t, t, m),    F90 = t,
    D of GGX with alpha = roughness^2,    V = 1 / (4 (n.l (1 - k) + k) (n.v (1 - k) + k)),

k = alpha / 2. In the specular workflow m is 0, F0 the specular colour and F90 white. The coat c has
F0 = r, F90 = 1 and a roughness of its own. What Storm adds to keep shaders finite is left out.

Sides and relief are those of OpenRooms' model (`openrooms_bsdf`), and of the ground truth.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import drjit as dr
import mitsuba as mi

from orusd_mitsuba.plugins import microfacet
from orusd_mitsuba.plugins.openrooms_bsdf import View, define_bsdf, relief_of, view_of

NAME: Final = "usd_preview"
_TEXTURES: Final = {"base_color": 0.18, "roughness": 0.5, "metallic": 0.0}
DEFAULT_F0: Final = 0.04


@dataclass(frozen=True, eq=False)
class Inputs:
    """The inputs of surfaces at points, numbers of the active variant.

    Attributes:
        base_color: ``diffuseColor``.
        roughness: Of the first lobe.
        metallic: 0 dielectric to 1 metal.
        f0: r of the module's formulas.
        relief: Tangent-space normal, of any length.
        specular: ``specularColor``, and 1 where there is one; None where none has any.
        coat: Weight and roughness of the clearcoat; None where none has any.
    """

    base_color: Any
    roughness: Any
    metallic: Any
    f0: Any
    relief: Any
    specular: tuple[Any, Any] | None = None
    coat: tuple[Any, Any] | None = None

    @property
    def diffuse(self) -> Any:
        """What is left to the diffuse part before Fresnel's share."""
        return self.base_color * (1.0 - self.metallic)

    @property
    def ends(self) -> tuple[Any, Any]:
        """F0 and F90, colours."""
        white = mi.Color3f(1.0)
        tint = dr.lerp(white, self.base_color, self.metallic)
        by_ior = dr.lerp(self.f0 * tint, tint, self.metallic)
        if self.specular is None:
            return by_ior, tint
        color, given = self.specular
        return dr.lerp(by_ior, color, given), dr.lerp(tint, white, given)


class TextureInputs:
    """Inputs from the textures of one plugin description."""

    def __init__(self, properties: Any) -> None:
        self._textures = {n: properties.get_texture(n, v) for n, v in _TEXTURES.items()}
        self._f0 = mi.Float(properties.get("f0", DEFAULT_F0))
        self._normal, self._specular = (
            properties.get_texture(name) if name in properties else None
            for name in ("normal", "specular")
        )
        coat = [properties.get(name, 0.0) for name in ("clearcoat", "clearcoat_roughness")]
        self._coat = (mi.Float(coat[0]), mi.Float(coat[1])) if coat[0] > 0.0 else None

    def __call__(self, si: Any, active: Any) -> Inputs:
        """The inputs at surface interactions."""
        base = self._textures["base_color"].eval(si, active)
        others = {n: self._textures[n].eval_1(si, active) for n in ("roughness", "metallic")}
        relief, specular = relief_of(self._normal, si, active), None
        if self._specular is not None:
            specular = self._specular.eval(si, active), mi.Float(1.0)
        return Inputs(
            base, **others, f0=self._f0, relief=relief, specular=specular, coat=self._coat
        )

    def traverse(self, callback: Any) -> None:
        """Show nothing to Mitsuba."""


@dataclass(frozen=True, eq=False)
class Preview:
    """The model at one surface interaction.

    Attributes:
        inputs: What is there.
        view: Its viewer's side.
        lobes: Weight of both lobes: 0 or 1.
        reflection: Weight of diffuse reflection: 0 or 1.
    """

    inputs: Inputs
    view: View
    lobes: float
    reflection: float

    @staticmethod
    def at(source: Any, context: Any, si: Any, active: Any) -> "Preview":
        """All parts that a context asks for."""
        flags, inputs = mi.BSDFFlags, source(si, active)
        lobes = float(context.is_enabled(flags.GlossyReflection, 0))
        reflection = float(context.is_enabled(flags.DiffuseReflection, 1))
        return Preview(inputs, view_of(si, inputs.relief), lobes, reflection)

    @property
    def shares(self) -> tuple[Any, Any]:
        """The parts of the samples that go into the first lobe and into the coat's.

        About in proportion to what each reflects of even light.
        """
        inputs, fresnel = self.inputs, _schlick(self.view.wi.z)
        lobe = self.lobes * mi.luminance(dr.lerp(*inputs.ends, fresnel))
        weight, rough = inputs.coat or (mi.Float(0.0), mi.Float(1.0))
        coat = self.lobes * weight * dr.lerp(inputs.f0, 1.0, fresnel)
        diffuse = self.reflection * mi.luminance(inputs.diffuse)
        total = dr.maximum(lobe + coat + diffuse, 1e-6)
        lobe *= microfacet.lobe_narrowness(inputs.roughness) / total
        coat *= microfacet.lobe_narrowness(rough) / total
        return lobe, coat

    def direction(self, which: Any, where: Any) -> tuple[Any, Any]:
        """A direction in the view's frame, and the number of the part that it is of."""
        lobe, coat = self.shares
        rough = self.inputs.roughness
        if self.inputs.coat is not None:
            rough = dr.select(which < lobe, rough, self.inputs.coat[1])
        glossy = which < lobe + coat
        mirrored = microfacet.sample_lobe(self.view.wi, rough, where)
        wo = dr.select(glossy, mirrored, mi.warp.square_to_cosine_hemisphere(where))
        return wo, dr.select(glossy, mi.UInt32(0), mi.UInt32(1))

    def value(self, wo: Any, local: Any) -> tuple[Any, Any]:
        """The model times the cosine of a direction, and its density over solid angle."""
        inputs, wi = self.inputs, self.view.wi
        here, _ = self.view.sides(wo, local)
        fresnel = _schlick(dr.dot(wi, dr.normalize(wi + wo)))
        reflected = dr.lerp(*inputs.ends, fresnel)
        color = inputs.diffuse * (1.0 - reflected) * (self.reflection * dr.inv_pi)
        color += reflected * (self.lobes * _shape(wi, wo, inputs.roughness))
        lobe, coat = self.shares
        density = (1.0 - lobe - coat) * dr.abs(wo.z) * dr.inv_pi
        density += lobe * microfacet.lobe_density(wi, wo, inputs.roughness)
        if inputs.coat is not None:
            weight, rough = inputs.coat
            reflected = weight * dr.lerp(inputs.f0, 1.0, fresnel)
            color += reflected * (self.lobes * _shape(wi, wo, rough))
            density += coat * microfacet.lobe_density(wi, wo, rough)
        return dr.select(here, color * wo.z, 0.0), dr.select(here, density, 0.0)


def _schlick(cosine: Any) -> Any:
    return (1.0 - dr.clip(cosine, 0.0, 1.0)) ** 5


def _shape(wi: Any, wo: Any, roughness: Any) -> Any:
    """D V of two directions on the normal's side."""
    k = 0.5 * dr.maximum(roughness, microfacet.LEAST_ROUGHNESS) ** 2
    n_v, n_l = dr.maximum(wi.z, 0.0), dr.maximum(wo.z, 0.0)
    masked = 0.25 / ((n_v * (1.0 - k) + k) * (n_l * (1.0 - k) + k))
    return masked * microfacet.distribution(dr.normalize(wi + wo), roughness)


@cache
def register(variant: str) -> Any:
    """Make ``usd_preview`` known to the active variant, and return its class.

    Args:
        variant: The name of the active variant: each has a base class of its own.
    """
    parts = (mi.BSDFFlags.GlossyReflection, mi.BSDFFlags.DiffuseReflection)
    return define_bsdf(NAME, TextureInputs, Preview, parts)
