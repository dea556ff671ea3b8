"""The surfaces of materials, read: UsdPreviewSurface, ours, and those of MaterialX."""

from dataclasses import fields, replace
from typing import Any, Final

from pxr import Gf, UsdShade

from openrooms_usd import names
from openrooms_usd.usd.shading import mdl, uber
from openrooms_usd.usd.shading.materials import INPUTS
from openrooms_usd.usd.shading.networks import Network, finite_numbers
from openrooms_usd.usd.shading.nodegraphs import fold, part_of
from openrooms_usd.usd.shading.surfaces import BARE, Color, PreviewSurface, Texture
from openrooms_usd.usd.shading.uvtextures import mended_normal_map, read_texture_node

# What primvars may drive.
_PAINTED: Final = {
    "base_color": "diffuseColor",
    "opacity": "opacity",
    "roughness": "roughness",
    "metallic": "metallic",
}
# The same surface, as USD and as MaterialX call it.
_PREVIEWS: Final = ("UsdPreviewSurface", "ND_UsdPreviewSurface_surfaceshader")
_MATERIALX: Final = "mtlx"
_NOR: Final = ", Standard Surface, OpenPBR, glTF PBR, RealityKit PBR or OmniPBR"
# What only a constant can say here.
_UNIFORM: Final = ("opacity_threshold", "opacity_mode", "ior")


def read_preview_surface(
    material: UsdShade.Material, *, moves: bool = False
) -> tuple[PreviewSurface, tuple[str, ...]]:
    """Read a material's UsdPreviewSurface.

    Connections are followed through node graphs and interface inputs. What a `PreviewSurface`
    cannot say is left at its default and named; nothing that a file holds raises.

    Args:
        material: Any material, of our own or of a foreign stage.
        moves: Whether the caller moves what is displaced, and tells what is not (`unmoved_by`).

    Returns:
        The surface, and one sentence for each thing that was lost.
    """
    network = Network()
    shader = _any_surface(network, material)
    surface = BARE if shader is None else _read_surface(network, material, shader)
    height = _displacement(network, material, shader, moves=moves)
    return replace(surface, displacement=height), tuple(network.losses)


def _read_surface(
    network: Network, material: UsdShade.Material, shader: UsdShade.Shader
) -> PreviewSurface:
    if mdl.is_known(shader):
        return mdl.read_omni_pbr(network, shader)
    if uber.is_known(shader):
        return uber.read_uber_surface(network, shader)
    values = {
        item.name: _read_input(network, shader, INPUTS[item.name][0], item.default)
        for item in fields(PreviewSurface)
        if item.name in INPUTS and item.name not in _UNIFORM
    }
    transmission = _part_of_light(network, material, names.MATERIAL_TRANSMISSION) or 0.0
    if transmission > 0.0:
        values["opacity"] = 1.0
    f0 = _part_of_light(network, material, names.MATERIAL_F0)
    pane = _tint(network, material)
    return replace(
        _completed(network, shader, values),
        transmission=transmission,
        f0=f0,
        pane=pane,
        painted=_painted(network, shader),
    )


def unmoved_by(material: UsdShade.Material) -> str:
    """The output whose displacement is not supported; empty where there is none."""
    if _displacer(material):
        return ""
    for context in (UsdShade.Tokens.universalRenderContext, _MATERIALX):
        if material.ComputeDisplacementSource(context)[0]:
            return f"outputs:{context}:displacement".replace("::", ":")
    return ""


def _displacement(
    network: Network, material: UsdShade.Material, surface: UsdShade.Shader | None, *, moves: bool
) -> float | Texture:
    """How far points move; 0, with a report, if they are not moved."""
    shader = _displacer(material) if material else None
    said = shader or surface
    none: float | Texture = 0.0
    height = none
    if said and str(said.GetShaderId() or "") in _PREVIEWS:
        height = _read_input(network, said, "displacement", none)
    if shader and moves:
        return height
    if height != none:
        network.lost(said, "displacement", "it is left out")
    if material and not moves and (name := unmoved_by(material)):
        network.losses.append(f"{material.GetPath()}.{name}: nothing is moved")
    return none


def _displacer(material: UsdShade.Material) -> UsdShade.Shader | None:
    """The UsdPreviewSurface that ``outputs:displacement`` leads to."""
    shader = UsdShade.Shader(material.ComputeDisplacementSource()[0])
    return shader if shader and shader.GetShaderId() in _PREVIEWS else None


def preview_shader(material: UsdShade.Material) -> UsdShade.Shader | None:
    """The UsdPreviewSurface node of a material; None where another shader makes its surface."""
    shader = UsdShade.Shader(material.ComputeSurfaceSource()[0]) if material else None
    return shader if shader and shader.GetShaderId() == _PREVIEWS[0] else None


def _part_of_light(network: Network, material: UsdShade.Material, name: str) -> float | None:
    """What an attribute of ours says, within 0 and 1; None where there is none."""
    attribute = material.GetPrim().GetAttribute(name)
    value = attribute.Get() if attribute else None
    if value is None:
        return None
    if not (isinstance(value, float) and 0.0 <= value <= 1.0):
        network.losses.append(f"{attribute.GetPath()}: {value} does not affect the light; left out")
        return None
    return value


def _painted(network: Network, shader: UsdShade.Shader) -> tuple[tuple[str, str], ...]:
    """The inputs that primvars of meshes drive, and which ones."""
    found = ((f, network.primvar(network.source(shader, name))[0]) for f, name in _PAINTED.items())
    return tuple((field, primvar) for field, primvar in found if primvar)


def _tint(network: Network, material: UsdShade.Material) -> Color | None:
    """What a pane lets through by `names.MATERIAL_PANE`; None where there is none."""
    attribute = material.GetPrim().GetAttribute(names.MATERIAL_PANE)
    value = attribute.Get() if attribute else None
    if value is None:
        return None
    if not (isinstance(value, Gf.Vec3f) and all(0.0 <= part <= 1.0 for part in value)):
        network.losses.append(f"{attribute.GetPath()}: {value} does not affect the light; left out")
        return None
    red, green, blue = map(float, value)
    return red, green, blue


def _any_surface(network: Network, material: UsdShade.Material) -> UsdShade.Shader | None:
    """The UsdPreviewSurface of a material, else its surface for MaterialX."""
    if not material:
        network.losses.append("there is no material")
        return None
    contexts = (UsdShade.Tokens.universalRenderContext, _MATERIALX, mdl.MDL)
    found = [UsdShade.Shader(material.ComputeSurfaceSource(name)[0]) for name in contexts]
    shaders = [shader for shader in found if shader]
    for shader in shaders:
        known = (uber.is_known(shader), mdl.is_known(shader))
        if str(shader.GetShaderId() or "") in _PREVIEWS or any(known):
            return shader
    if not shaders:
        network.losses.append(
            f"{material.GetPath()}: no surface shader of the universal render context"
        )
    else:
        foreign = mdl.name_of(shaders[0])
        what = f"{foreign} of MDL" if foreign else shaders[0].GetShaderId()
        what = what or "a shader without identifier"
        network.losses.append(f"{shaders[0].GetPath()}: {what} is not UsdPreviewSurface{_NOR}")
    return None


def _read_input(network: Network, shader: UsdShade.Shader, name: str, default: Any) -> Any:
    """An input that a constant or a texture drives."""
    source = network.source(shader, name)
    if source.shader is None:
        return network.finite(shader, name, source.constant, default)
    primvar, instead = network.primvar(source) if name in _PAINTED.values() else ("", None)
    if primvar:
        return network.finite(source.shader, "fallback", instead, default)
    if source.kind.startswith("ND_"):
        return _folded_input(network, shader, name, default)
    if source.kind != "UsdUVTexture":
        network.lost(shader, name, f"{source.kind or 'a shader'} cannot drive it")
        instead = network.own_value(shader, name)
        if instead is None and source.kind.startswith("UsdPrimvarReader"):
            instead = network.constant(source.shader, "fallback", None)
        return network.finite(shader, name, instead, default)
    texture = read_texture_node(network, source.shader, source.output)
    if texture is None:
        authored = finite_numbers(network.constant(source.shader, "fallback", None))
        part = "rgba".find(source.output) if len(source.output) == 1 else -1
        picked = authored[part] if 0 <= part < len(authored) else authored or None
        return network.finite(source.shader, "fallback", picked, default)
    if isinstance(default, float) and texture.channel == "rgb":
        return replace(texture, channel="r")
    return texture


def _folded_input(network: Network, shader: UsdShade.Shader, name: str, default: Any) -> Any:
    """An input that nodes of MaterialX drive."""
    found = fold(network, shader, name)
    if not isinstance(found, Texture):
        return network.finite(shader, name, found, default)
    return part_of(found, 0) if isinstance(default, float) else found


def _completed(network: Network, shader: UsdShade.Shader, values: dict[str, Any]) -> PreviewSurface:
    """The surface of what was read, with the inputs that hang on each other."""
    if not network.constant(shader, "useSpecularWorkflow", 0):
        values["specular"] = None
    elif values["specular"] is None:
        values["specular"] = (0.0, 0.0, 0.0)
    if isinstance(values["normal"], Texture):
        values["normal"] = mended_normal_map(network, values["normal"])
    presence = str(network.constant(shader, "opacityMode", "")) == "presence"
    return PreviewSurface(
        **values,
        opacity_mode="presence" if presence else "transparent",
        opacity_threshold=network.number(shader, "opacityThreshold", 0.0),
        ior=network.number(shader, "ior", 1.5),
    )
