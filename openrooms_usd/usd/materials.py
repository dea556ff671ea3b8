"""Materials: UsdPreviewSurface authored and read, and which material a prim shows."""

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.usd import uber
from openrooms_usd.usd.networks import Network, finite_numbers
from openrooms_usd.usd.nodegraphs import fold
from openrooms_usd.usd.surfaces import Color, PreviewSurface, Texture, UvTransform, ior_of
from openrooms_usd.usd.uvtextures import mended_normal_map, read_texture_node

__all__ = [
    "BARE",
    "PreviewSurface",
    "Texture",
    "bound_material",
    "bound_materials",
    "bound_subsets",
    "define_preview_surface",
    "preview_shader",
    "read_preview_surface",
]

_Types = Sdf.ValueTypeNames
# What primvars may drive.
_PAINTED: Final = {
    "base_color": "diffuseColor",
    "opacity": "opacity",
    "roughness": "roughness",
    "metallic": "metallic",
}
BARE: Final = PreviewSurface(
    painted=(("base_color", "displayColor"), ("opacity", "displayOpacity"))
)
"""What meshes show whose material nobody can read, or that have none."""
# Field of PreviewSurface -> input of UsdPreviewSurface and its type.
_INPUTS: Final = {
    "base_color": ("diffuseColor", _Types.Color3f),
    "metallic": ("metallic", _Types.Float),
    "roughness": ("roughness", _Types.Float),
    "specular": ("specularColor", _Types.Color3f),
    "opacity": ("opacity", _Types.Float),
    "opacity_threshold": ("opacityThreshold", _Types.Float),
    "opacity_mode": ("opacityMode", _Types.Token),
    "ior": ("ior", _Types.Float),
    "emissive": ("emissiveColor", _Types.Color3f),
    "normal": ("normal", _Types.Normal3f),
    "clearcoat": ("clearcoat", _Types.Float),
    "clearcoat_roughness": ("clearcoatRoughness", _Types.Float),
    "occlusion": ("occlusion", _Types.Float),
}
# Of each face of a clear pane where it is taken for a surface that is mostly absent: two of them
# hold back as much as window glass does.
PANE_OPACITY: Final = 0.05
# The same surface, as USD and as MaterialX call it.
_PREVIEWS: Final = ("UsdPreviewSurface", "ND_UsdPreviewSurface_surfaceshader")
_MATERIALX: Final = "mtlx"
# What only a constant can say here.
_UNIFORM: Final = ("opacity_threshold", "opacity_mode", "ior")


def define_preview_surface(
    stage: Usd.Stage, path: str | Sdf.Path, surface: PreviewSurface
) -> UsdShade.Material:
    """Define a material with a UsdPreviewSurface network below it.

    Only what differs from the specification's defaults is authored.

    Args:
        stage: Where to define it; the edit target receives everything.
        path: The material's path.
        surface: Its inputs; the files of its textures are authored as they are given.
    """
    material = UsdShade.Material.Define(stage, path)
    shader = _define_node(material, "Surface", "UsdPreviewSurface")
    output = shader.CreateOutput("surface", _Types.Token)
    material.CreateSurfaceOutput().ConnectToSource(output)
    coordinates = _define_coordinates(material, surface)
    surface = _with_stand_ins(material, surface)
    for item in fields(surface):
        if item.name not in _INPUTS:
            continue
        value = getattr(surface, item.name)
        socket = _INPUTS[item.name]
        if isinstance(value, Texture):
            texture = _define_texture(material, item.name, value, coordinates[_mapping(value)])
            shader.CreateInput(*socket).ConnectToSource(texture)
        elif value != item.default:
            shader.CreateInput(*socket).Set(value)
    if surface.specular is not None:
        shader.CreateInput("useSpecularWorkflow", _Types.Int).Set(1)
    return material


def _with_stand_ins(material: UsdShade.Material, surface: PreviewSurface) -> PreviewSurface:
    """Author what is ours, and show it by other inputs to those who do not know it."""
    if surface.transmission > 0.0:
        _author_ours(material, names.MATERIAL_TRANSMISSION, surface.transmission)
        surface = replace(surface, opacity=1.0 - surface.transmission)
    if surface.f0 is not None:
        _author_ours(material, names.MATERIAL_F0, surface.f0)
        surface = replace(surface, ior=ior_of(surface.f0))
    if surface.pane is not None:
        _author_ours(material, names.MATERIAL_PANE, Gf.Vec3f(*surface.pane), _Types.Color3f)
        surface = replace(surface, opacity=PANE_OPACITY)
    return surface


def _author_ours(
    material: UsdShade.Material, name: str, value: Any, kind: Sdf.ValueTypeName = _Types.Float
) -> None:
    prim = material.GetPrim()
    prim.AddAppliedSchema(names.MATERIAL_API)
    prim.CreateAttribute(name, kind, custom=False).Set(value)


def _define_node(material: UsdShade.Material, name: str, kind: str) -> UsdShade.Shader:
    path = material.GetPath().AppendChild(name)
    shader = UsdShade.Shader.Define(material.GetPrim().GetStage(), path)
    shader.CreateIdAttr(kind)
    return shader


def _mapping(texture: Texture) -> tuple[str, UvTransform]:
    transform = UvTransform(texture.uv_scale, texture.uv_rotation, texture.uv_translation)
    return texture.primvar, transform


def _define_coordinates(
    material: UsdShade.Material, surface: PreviewSurface
) -> dict[tuple[str, UvTransform], UsdShade.Output]:
    """The output that gives the coordinates of each mapping; textures that agree share it."""
    values = [getattr(surface, item.name) for item in fields(surface)]
    mappings = dict.fromkeys(_mapping(value) for value in values if isinstance(value, Texture))
    outputs = {}
    for number, (primvar, transform) in enumerate(mappings):
        suffix = f"_{number}" if number else ""
        reader = _define_node(material, f"Coordinates{suffix}", "UsdPrimvarReader_float2")
        reader.CreateInput("varname", _Types.String).Set(primvar)
        output = reader.CreateOutput("result", _Types.Float2)
        if transform != UvTransform():
            node = _define_node(material, f"Mapping{suffix}", "UsdTransform2d")
            node.CreateInput("in", _Types.Float2).ConnectToSource(output)
            node.CreateInput("scale", _Types.Float2).Set(Gf.Vec2f(*transform.scale))
            node.CreateInput("rotation", _Types.Float).Set(transform.rotation)
            node.CreateInput("translation", _Types.Float2).Set(Gf.Vec2f(*transform.translation))
            output = node.CreateOutput("result", _Types.Float2)
        outputs[primvar, transform] = output
    return outputs


def _define_texture(
    material: UsdShade.Material, name: str, texture: Texture, coordinates: UsdShade.Output
) -> UsdShade.Output:
    node = _define_node(material, f"{name}_texture", "UsdUVTexture")
    node.CreateInput("file", _Types.Asset).Set(texture.file)
    node.CreateInput("st", _Types.Float2).ConnectToSource(coordinates)
    node.CreateInput("sourceColorSpace", _Types.Token).Set(texture.color_space)
    node.CreateInput("wrapS", _Types.Token).Set(texture.wrap_s)
    node.CreateInput("wrapT", _Types.Token).Set(texture.wrap_t)
    for item in ("scale", "bias", "fallback"):
        value = getattr(texture, item)
        if value != getattr(Texture, item):
            node.CreateInput(item, _Types.Float4).Set(Gf.Vec4f(*value))
    kind = _Types.Float3 if texture.channel == "rgb" else _Types.Float
    return node.CreateOutput(texture.channel, kind)


def read_preview_surface(
    material: UsdShade.Material,
) -> tuple[PreviewSurface, tuple[str, ...]]:
    """Read a material's UsdPreviewSurface.

    Connections are followed through node graphs and interface inputs. What a `PreviewSurface`
    cannot say is left at its default and named; nothing that a file holds raises.

    Args:
        material: Any material, of our own or of a foreign stage.

    Returns:
        The surface, and one sentence for each thing that was lost.
    """
    network = Network()
    shader = _any_surface(network, material)
    if shader is None:
        return BARE, tuple(network.losses)
    if uber.is_known(shader):
        moved = material.GetDisplacementOutput(_MATERIALX)
        if moved and moved.HasConnectedSource():
            network.losses.append(f"{moved.GetAttr().GetPath()}: nothing is moved")
        return uber.read_uber_surface(network, shader), tuple(network.losses)
    values = {
        item.name: _read_input(network, shader, _INPUTS[item.name][0], item.default)
        for item in fields(PreviewSurface)
        if item.name in _INPUTS and item.name not in _UNIFORM
    }
    transmission = _part_of_light(network, material, names.MATERIAL_TRANSMISSION) or 0.0
    if transmission > 0.0:
        values["opacity"] = 1.0
    f0 = _part_of_light(network, material, names.MATERIAL_F0)
    pane = _tint(network, material)
    completed = replace(
        _completed(network, shader, values), transmission=transmission, f0=f0, pane=pane,
        painted=_painted(network, shader),
    )  # fmt: skip
    return completed, tuple(network.losses)


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
        network.losses.append(f"{attribute.GetPath()}: {value} is no part of the light; left out")
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
        network.losses.append(f"{attribute.GetPath()}: {value} is no part of the light; left out")
        return None
    red, green, blue = map(float, value)
    return red, green, blue


def _any_surface(network: Network, material: UsdShade.Material) -> UsdShade.Shader | None:
    """The UsdPreviewSurface of a material, else its surface for MaterialX."""
    if not material:
        network.losses.append("there is no material")
        return None
    contexts = (UsdShade.Tokens.universalRenderContext, _MATERIALX)
    found = [UsdShade.Shader(material.ComputeSurfaceSource(name)[0]) for name in contexts]
    shaders = [shader for shader in found if shader]
    for shader in shaders:
        if str(shader.GetShaderId() or "") in _PREVIEWS or uber.is_known(shader):
            return shader
    if not shaders:
        network.losses.append(f"{material.GetPath()}: no surface shader for every renderer")
    else:
        what = shaders[0].GetShaderId() or "a shader without identifier"
        network.losses.append(f"{shaders[0].GetPath()}: {what} is not UsdPreviewSurface")
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
    single = isinstance(default, float) and found.channel == "rgb"
    return replace(found, channel="r") if single else found


def _completed(network: Network, shader: UsdShade.Shader, values: dict[str, Any]) -> PreviewSurface:
    """The surface of what was read, with the inputs that hang on each other."""
    if not network.constant(shader, "useSpecularWorkflow", 0):
        values["specular"] = None
    elif values["specular"] is None:
        values["specular"] = (0.0, 0.0, 0.0)
    if isinstance(values["normal"], Texture):
        values["normal"] = mended_normal_map(network, values["normal"])
    if _read_input(network, shader, "displacement", 0.0) != 0.0:
        network.lost(shader, "displacement", "it is left out")
    presence = str(network.constant(shader, "opacityMode", "")) == "presence"
    return PreviewSurface(
        **values,
        opacity_mode="presence" if presence else "transparent",
        opacity_threshold=network.number(shader, "opacityThreshold", 0.0),
        ior=network.number(shader, "ior", 1.5),
    )


def bound_material(prim: Usd.Prim) -> UsdShade.Material | None:
    """The material that a prim shows: the binding for ``full``, for all purposes, or a preview."""
    api = UsdShade.MaterialBindingAPI(prim)
    for purpose in (UsdShade.Tokens.full, UsdShade.Tokens.preview):
        material, _ = api.ComputeBoundMaterial(purpose)
        if material:
            return material
    return None


def bound_materials(prims: Sequence[Usd.Prim]) -> list[UsdShade.Material | None]:
    """`bound_material` of many prims at once, on all cores."""
    api = UsdShade.MaterialBindingAPI
    found: list[UsdShade.Material | None] = [None] * len(prims)
    left = list(range(len(prims)))
    for purpose in (UsdShade.Tokens.full, UsdShade.Tokens.preview):
        materials, _ = api.ComputeBoundMaterials([prims[row] for row in left], purpose)
        for row, material in zip(left, materials, strict=True):
            found[row] = material or None
        left = [row for row in left if found[row] is None]
    return found


def bound_subsets(prim: Usd.Prim) -> list[tuple[NDArray[np.int32], UsdShade.Material]]:
    """The faces of a mesh that show another material than the mesh itself.

    Args:
        prim: A mesh.

    Returns:
        For each material subset (its face indices, its material); faces in none of them show
        `bound_material` of the mesh.
    """
    api = UsdShade.MaterialBindingAPI(prim)
    subsets = api.GetMaterialBindSubsets() if prim.IsA(UsdGeom.Mesh) else []
    found = [(subset, bound_material(subset.GetPrim())) for subset in subsets]
    return [
        (np.array(subset.GetIndicesAttr().Get() or [], dtype=np.int32), material)
        for subset, material in found
        if material is not None and subset.GetElementTypeAttr().Get() == UsdGeom.Tokens.face
    ]
