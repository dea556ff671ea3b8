"""Materials of UsdPreviewSurface, authored."""

from collections.abc import Iterator, Sequence
from dataclasses import fields, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.usd.arrays import array_of
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.shading.surfaces import PreviewSurface, Texture, UvTransform, ior_of

__all__ = ["INPUTS", "PANE_OPACITY", "PreviewSurface", "Texture", "define_preview_surface"]

_Types = Sdf.ValueTypeNames
# Field of `PreviewSurface` -> input of UsdPreviewSurface and its type.
INPUTS: Final = {
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
        if item.name not in INPUTS:
            continue
        value = getattr(surface, item.name)
        socket = INPUTS[item.name]
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
    # A UsdUVTexture has its colours in one order alone.
    if len(texture.channel) > 1:
        return node.CreateOutput("rgb", _Types.Float3)
    return node.CreateOutput(texture.channel, _Types.Float)


_BINDING: Final = "material:binding"
# Rows of triangles, and the material that they show.
Part = tuple[NDArray[np.int32], UsdShade.Material | None]


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


def broken_bindings(prim: Usd.Prim) -> Iterator[str]:
    """The targets of bindings that stand on a prim itself where no material is."""
    for name in prim.GetAuthoredPropertyNames():
        if name.startswith(_BINDING) and (binding := prim.GetRelationship(name)):
            # A binding by a collection names that first.
            for target in binding.GetForwardedTargets()[-1:]:
                if not UsdShade.Material(prim.GetStage().GetPrimAtPath(target.GetPrimPath())):
                    yield str(target)


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
        (array_of(subset.GetIndicesAttr().Get(TIME), np.int32), material)
        for subset, material in found
        if material is not None and subset.GetElementTypeAttr().Get() == UsdGeom.Tokens.face
    ]


def parts_by_material(
    prim: Usd.Prim, faces: NDArray[np.int32], own: UsdShade.Material | None
) -> Iterator[Part]:
    """Each part of a mesh with a material of its own.

    Args:
        prim: The mesh.
        faces: (M,) the face of each of its triangles.
        own: The material of what is in no such part: `bound_material` of the mesh.
    """
    rest = np.ones(len(faces), dtype=bool)
    for indices, material in bound_subsets(prim):
        rows = np.flatnonzero(rest & np.isin(faces, indices))
        if len(rows):
            rest[rows] = False
            yield rows.astype(np.int32), material
    if rest.any():
        yield np.flatnonzero(rest).astype(np.int32), own


def material_key(material: UsdShade.Material) -> str:
    """The same for all instances of one prototype, which show it under many paths."""
    prim = material.GetPrim()
    source = prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim
    return str(source.GetPath())
