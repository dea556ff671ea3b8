"""Surfaces of MaterialX (Standard Surface, OpenPBR, glTF PBR), read as a `PreviewSurface`."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final, cast

import numpy as np
from pxr import UsdShade

from openrooms_usd.tables import read_table
from openrooms_usd.usd.shading.networks import Network, finite_numbers
from openrooms_usd.usd.shading.nodegraphs import Folded, Numbers, affine, fold, part_of, product
from openrooms_usd.usd.shading.surfaces import Color, PreviewSurface, Texture, f0_of, ior_of
from openrooms_usd.usd.shading.uvtextures import mended_normal_map

_ONE: Final[Numbers] = (1.0,)
_NIL: Final[Numbers] = (0.0,)
_NORMAL: Final = PreviewSurface.normal
# At least so much transmission is clear glass, not a mixture.
_CLEAR: Final = 0.999
# Rougher glass is reported, since panes are clear.
_ROUGH: Final = 0.1
_MASK, _BLEND = 1, 2
_LEVEL_REFLECTANCE: Final = 0.08
# Which inputs meshes may have in primvars, by field of a `PreviewSurface`.
_PAINTED: Final = {
    "base_color": "color",
    "opacity": "opacity",
    "roughness": "roughness",
    "metallic": "metallic",
}


@dataclass(frozen=True)
class _Model:
    """Which inputs say what; each with its default.

    Attributes:
        inputs: By what they say: ``weight`` and ``color`` of the base, ``metallic``, ``roughness``,
            ``opacity``, ``thin`` and ``normal``. ``specular`` is a factor of the reflectance that
            ``ior`` gives, or ``level`` that reflectance in parts of 8 %. ``glow`` and
            ``glow_color`` are emission. ``coat`` has ``coat_roughness`` and ``coat_color`` (what it
            lets through to the base). ``clear`` is how much goes through, and ``tint`` its colour.
        idle: Other inputs with the values that change nothing.
        parts: Inputs of these first words count where the input is not zero.
    """

    inputs: Mapping[str, tuple[str, Numbers]]
    idle: Mapping[str, float]
    parts: Mapping[str, str]


_MODELS: Final[Mapping[str, _Model]] = {
    shader: _Model(model["inputs"], model["idle"], model["parts"])
    for model in read_table(__file__, "uber.toml").values()
    for shader in model["shaders"]
}


def is_known(shader: UsdShade.Shader) -> bool:
    """Whether a shader is one of the surfaces that are read here."""
    return str(shader.GetShaderId() or "") in _MODELS


def read_uber_surface(network: Network, shader: UsdShade.Shader) -> PreviewSurface:
    """Read one of the surfaces for which `is_known` holds; losses are reported.

    Args:
        network: Receives what is lost.
        shader: The surface.
    """
    model = _MODELS[str(shader.GetShaderId())]
    said = _Said(network, shader, model)
    _tell_others(said)
    color = said.whole(said.color("weight"), said.color("color"), "color")
    color = said.whole(_below_coat(said), color, "color")
    glow = said.whole(said.color("glow"), said.color("glow_color"), "glow_color")
    surface = PreviewSurface(
        base_color=_as_color(color),
        metallic=said.part("metallic"),
        roughness=said.part("roughness"),
        opacity=_number(_averaged(said.color("opacity"))),
        opacity_mode="presence",
        ior=_ior(said),
        emissive=_as_color(glow),
        normal=_normal(said),
        clearcoat=said.part("coat"),
        clearcoat_roughness=said.part("coat_roughness"),
        occlusion=said.part("occlusion"),
        painted=said.painted,
    )
    if said.primvar("color")[0] and said.color("weight") != _ONE:
        said.lost("weight", "it is left out beside colours of meshes")
    if "mode" in model.inputs:
        surface = _with_mode(said, surface)
    elif "cutoff" in model.inputs:
        surface = replace(surface, opacity_threshold=said.constant("cutoff"))
    return _with_glass(said, surface)


@dataclass(frozen=True)
class _Said:
    """What a shader says by the words of its model."""

    network: Network
    shader: UsdShade.Shader
    model: _Model

    def lost(self, word: str, what: str) -> None:
        self.network.lost(self.shader, self.model.inputs[word][0], what)

    def color(self, word: str) -> Folded:
        if word not in self.model.inputs:
            return _NIL if word in ("thin", "clear") else _ONE
        name, default = self.model.inputs[word]
        primvar, instead = self.primvar(word)
        if primvar:
            return finite_numbers(instead) or default
        found = fold(self.network, self.shader, name)
        return default if found is None else found

    def primvar(self, word: str) -> tuple[str, Any]:
        """The primvar of meshes that drives an input, if one may, and what stands in for it."""
        if word not in _PAINTED.values() or word not in self.model.inputs:
            return "", None
        source = self.network.source(self.shader, self.model.inputs[word][0])
        return self.network.primvar(source)

    @property
    def painted(self) -> tuple[tuple[str, str], ...]:
        """The inputs that meshes have in primvars (`PreviewSurface.painted`)."""
        found = ((field, self.primvar(word)[0]) for field, word in _PAINTED.items())
        return tuple((field, primvar) for field, primvar in found if primvar)

    def part(self, word: str) -> float | Texture:
        return _number(self.color(word))

    def constant(self, word: str) -> float:
        """A number; its default, with a report, if a texture drives it."""
        found = self.part(word)
        if isinstance(found, Texture):
            self.lost(word, "a texture cannot drive it")
            return self.model.inputs[word][1][0]
        return found

    def whole(self, weight: Folded, color: Folded, word: str) -> Folded:
        """A weighted colour; of two textures that of the colour."""
        found = product(weight, color)
        if found is None:
            self.lost(word, "the texture of its weight is left out")
        return color if found is None else found


def _number(value: Folded) -> float | Texture:
    if isinstance(value, Texture):
        return part_of(value, 0)
    return value[0]


def _averaged(value: Folded) -> Folded:
    """Of a colour its mean; of a texture its first channel."""
    return value if isinstance(value, Texture) else (float(np.mean(value[:3])),)


def _as_color(value: Folded) -> Color | Texture:
    if isinstance(value, Texture):
        return value
    red, green, blue = (value * 3)[:3] if len(value) < 3 else value[:3]
    return red, green, blue


def _below_coat(said: _Said) -> Folded:
    """What a coloured coat leaves of the light for the base and back."""
    if "coat_color" not in said.model.inputs or said.part("coat") == 0.0:
        return _ONE
    coat = said.constant("coat")
    return affine(said.color("coat_color"), (coat,), (1.0 - coat,))


def _ior(said: _Said) -> float:
    if "level" in said.model.inputs:
        return ior_of(_LEVEL_REFLECTANCE * min(max(said.constant("level"), 0.0), 1.0))
    ior, weight = said.constant("ior"), said.constant("specular")
    if ior <= 0.0 or weight == 1.0:
        return ior
    return ior_of(min(max(weight, 0.0) * f0_of(ior), 0.9))


def _normal(said: _Said) -> Color | Texture:
    value = said.color("normal")
    if isinstance(value, Texture):
        return mended_normal_map(said.network, value)
    if any(value) and value != _NORMAL:
        said.lost("normal", "a constant direction is left out")
    return _NORMAL


def _with_mode(said: _Said, surface: PreviewSurface) -> PreviewSurface:
    """What glTF says of alpha: none, a mask, or blending."""
    mode = said.constant("mode")
    if mode == _BLEND:
        return surface
    if mode == _MASK:
        return replace(surface, opacity_threshold=said.constant("cutoff"))
    return replace(surface, opacity=1.0)


def _with_glass(said: _Said, surface: PreviewSurface) -> PreviewSurface:
    """What goes through: clear glass is a pane, a mixture is thinner."""
    clear = said.part("clear")
    if clear == 0.0:
        return surface
    is_pane = not isinstance(clear, Texture) and clear >= _CLEAR and surface.metallic == 0.0
    if not is_pane or not isinstance(surface.opacity, float) or surface.opacity < 1.0:
        said.lost("clear", "light goes straight through, and clear parts reflect nothing")
        if "tint" in said.model.inputs and said.color("tint") not in (_ONE, _ONE * 3):
            said.lost("tint", "it is left out")
        rest = _number(affine(_folded(clear), (-1.0,), _ONE))
        opacity = product(_folded(surface.opacity), _folded(rest))
        return replace(surface, opacity=_number(_folded(rest) if opacity is None else opacity))
    if _number(said.color("thin")) == 0.0:
        said.lost("clear", "it is drawn as thin panes without refraction")
    if isinstance(surface.roughness, Texture) or surface.roughness > _ROUGH:
        said.lost("roughness", "glass is drawn clear")
    tint = said.color("tint" if "tint" in said.model.inputs else "color")
    if isinstance(tint, Texture):
        said.lost("clear", "the texture of its tint is left out")
        tint = _ONE
    red, green, blue = np.clip(cast(Any, _as_color(tint)), 0.0, 1.0).tolist()
    return replace(surface, pane=(red, green, blue))


def _folded(value: float | Texture) -> Folded:
    return value if isinstance(value, Texture) else (value,)


def _tell_others(said: _Said) -> None:
    """Name authored values that a `PreviewSurface` cannot hold."""
    read = {name for name, _ in said.model.inputs.values()}
    for socket in said.shader.GetInputs():
        name = str(socket.GetBaseName())
        if name in read or not _counts(said, name):
            continue
        source = said.network.source(said.shader, name)
        usual = said.model.idle.get(name)
        if source.shader is None:
            value = fold(said.network, said.shader, name)
            if value is None or (usual is not None and set(cast(Numbers, value)) <= {usual}):
                continue
        said.network.lost(said.shader, name, "it is left out")


def _counts(said: _Said, name: str) -> bool:
    """Whether the part that an input belongs to is there."""
    for word, weight in said.model.parts.items():
        if name.startswith(word) and name != weight:
            source = said.network.source(said.shader, weight)
            return source.shader is not None or any(finite_numbers(source.constant))
    return True
