"""Materials of MDL: OmniPBR by its constants and textures, all others by name.

OmniPBR reflects 8 % of ``specular_level`` at normal incidence, has the square of its roughness for
alpha, and emits ``emissive_color`` times ``emissive_intensity`` as exitance, which is pi times the
radiance. A texture takes the place of ``diffuse_color_constant``; those of roughness and metallic
are blended with the constants by their influence.
"""

import math
from dataclasses import replace
from pathlib import PurePosixPath
from typing import Any, Final, cast

from pxr import UsdShade

from openrooms_usd.usd.shading.networks import Network, finite_numbers
from openrooms_usd.usd.shading.nodegraphs import affine
from openrooms_usd.usd.shading.surfaces import (
    NORMAL_BIAS,
    NORMAL_SCALE,
    Color,
    ColorSpace,
    PreviewSurface,
    Texture,
    UvTransform,
    ior_of,
)
from openrooms_usd.usd.shading.textures import color_space
from openrooms_usd.usd.shading.uvtextures import over_tiles, picture_file

MDL: Final = "mdl"
_OMNI_PBR: Final = ("OmniPBR", "OmniPBR_Opacity", "OmniPBR_ClearCoat", "OmniPBR_ClearCoat_Opacity")
_WHITE: Final[Color] = (1.0, 1.0, 1.0)
_REFLECTANCE: Final = 0.08
_SPACES: Final[dict[str, ColorSpace]] = {"sRGB": "sRGB", "raw": "raw"}
_READ: Final = frozenset(
    "diffuse_color_constant diffuse_texture diffuse_tint albedo_brightness albedo_add "
    "reflection_roughness_constant reflection_roughness_texture_influence "
    "reflectionroughness_texture reflection_roughness_texture metallic_constant "
    "metallic_texture_influence metallic_texture ORM_texture enable_ORM_texture specular_level "
    "enable_emission emissive_color emissive_color_texture emissive_intensity enable_opacity "
    "opacity_constant opacity_threshold normalmap_texture texture_scale texture_rotate "
    "texture_translate".split()
)
# Of other inputs these values change nothing, beside zeros and what is empty.
_IDLE: Final[dict[str, Any]] = {
    "bump_factor": 1.0,
    "detail_bump_factor": 0.3,
    "detail_texture_scale": (1.0, 1.0),
    "flip_tangent_v": True,
    "opacity_mode": 1,
}


def name_of(shader: UsdShade.Shader) -> str:
    """The name of a material of MDL; empty for other shaders."""
    asset = shader.GetSourceAsset(MDL)
    said = shader.GetSourceAssetSubIdentifier(MDL) or shader.GetShaderId() or ""
    if asset or str(said) in _OMNI_PBR:
        # A signature may follow.
        return str(said).partition("(")[0] or PurePosixPath(str(asset.path)).stem
    return ""


def is_known(shader: UsdShade.Shader) -> bool:
    """Whether a shader is an OmniPBR."""
    return name_of(shader) in _OMNI_PBR


def read_omni_pbr(network: Network, shader: UsdShade.Shader) -> PreviewSurface:
    """Read an OmniPBR; report that it is approximated, and what is left out.

    Args:
        network: Receives what is lost.
        shader: One for which `is_known` holds.
    """
    what = f"{name_of(shader)} of MDL"
    told = f"{what} is approximated by its constants and textures"
    network.losses.append(f"{shader.GetPath()}: {told}")
    for socket in shader.GetInputs():
        name = str(socket.GetBaseName())
        if name not in _READ and not _is_idle(name, network.constant(shader, name, None)):
            network.lost(shader, name, "it is left out")
    packed = network.constant(shader, "enable_ORM_texture", False)
    cut = network.constant(shader, "enable_opacity", False)
    return PreviewSurface(
        base_color=_albedo(network, shader),
        roughness=_blended(network, shader, "reflection_roughness", 0.5, "g" if packed else ""),
        metallic=_blended(network, shader, "metallic", 0.0, "b" if packed else ""),
        ior=ior_of(
            _REFLECTANCE * min(max(network.number(shader, "specular_level", 0.5), 0.0), 1.0)
        ),
        emissive=_glow(network, shader),
        opacity=network.number(shader, "opacity_constant", 1.0) if cut else 1.0,
        opacity_threshold=network.number(shader, "opacity_threshold", 0.0) if cut else 0.0,
        opacity_mode="presence",
        normal=_normal(network, shader),
    )


def _is_idle(name: str, value: Any) -> bool:
    """Whether an input says nothing that would be seen."""
    if value is None or not getattr(value, "path", True):
        return True
    numbers = finite_numbers(value)
    usual = finite_numbers(_IDLE.get(name, 0.0))
    return bool(numbers) and (numbers == tuple(map(float, usual)) or not any(numbers))


def _albedo(network: Network, shader: UsdShade.Shader) -> Color | Texture:
    tint = _color(network, shader, "diffuse_tint", _WHITE)
    picture = _texture(network, shader, "diffuse_texture")
    if picture is None:
        found = affine(_color(network, shader, "diffuse_color_constant", (0.2, 0.2, 0.2)), tint)
        return cast(Color, found)
    brightness = network.number(shader, "albedo_brightness", 1.0)
    offset = network.number(shader, "albedo_add", 0.0)
    factor = tuple(brightness * part for part in tint)
    return cast(Texture, affine(picture, factor, tuple(offset * part for part in tint)))


def _blended(
    network: Network, shader: UsdShade.Shader, name: str, default: float, packed: str
) -> float | Texture:
    """A constant and a texture, by the share of the texture; ``packed``: its channel in ORM."""
    constant = network.number(shader, f"{name}_constant", default)
    share = network.number(shader, f"{name}_texture_influence", 0.0)
    file = "ORM_texture" if packed else _spelled(shader, f"{name}_texture")
    picture = _texture(network, shader, file, space="raw") if share else None
    if picture is None:
        return constant
    one = replace(picture, channel=packed or "r")
    return cast(Texture, affine(one, (share,), ((1.0 - share) * constant,)))


def _spelled(shader: UsdShade.Shader, name: str) -> str:
    """An input as Omniverse spells it, or as its name would be."""
    joined = name.replace("reflection_roughness", "reflectionroughness")
    return joined if shader.GetInput(joined) else name


def _glow(network: Network, shader: UsdShade.Shader) -> Color | Texture:
    if not network.constant(shader, "enable_emission", False):
        return PreviewSurface.emissive
    nits = network.number(shader, "emissive_intensity", 40.0) / math.pi
    picture = _texture(network, shader, "emissive_color_texture")
    color = _color(network, shader, "emissive_color", (1.0, 0.1, 0.1))
    return cast(Color | Texture, affine(color if picture is None else picture, (nits,)))


def _normal(network: Network, shader: UsdShade.Shader) -> Color | Texture:
    picture = _texture(network, shader, "normalmap_texture", space="raw")
    if picture is None:
        return PreviewSurface.normal
    return replace(picture, scale=NORMAL_SCALE, bias=NORMAL_BIAS)


def _color(network: Network, shader: UsdShade.Shader, name: str, default: Color) -> Color:
    found = network.finite(shader, name, network.constant(shader, name, None), default)
    return cast(Color, found)


def _texture(
    network: Network, shader: UsdShade.Shader, name: str, space: ColorSpace | None = None
) -> Texture | None:
    """A picture in an input; None where there is none, or none that can be read."""
    asset = network.constant(shader, name, None)
    if not getattr(asset, "path", ""):
        return None
    file = picture_file(network, shader, name)
    if file is None:
        return None
    said = _SPACES.get(network.source(shader, name).space)
    where = UvTransform(
        scale=_pair(network, shader, "texture_scale", (1.0, 1.0)),
        rotation=network.number(shader, "texture_rotate", 0.0),
        translation=_pair(network, shader, "texture_translate", (0.0, 0.0)),
    )
    texture = Texture(
        file,
        color_space=said or space or color_space(file),
        uv_scale=where.scale,
        uv_rotation=where.rotation,
        uv_translation=where.translation,
    )
    return over_tiles(network, shader, texture)


def _pair(
    network: Network, shader: UsdShade.Shader, name: str, default: tuple[float, float]
) -> tuple[float, float]:
    numbers = finite_numbers(network.constant(shader, name, None))
    return (numbers[0], numbers[1]) if len(numbers) == 2 else default
