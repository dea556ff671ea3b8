"""The layer of lightmaps: opinions for any stage that has the prims which were baked.

``primvars:st1`` of a mesh runs over its unit's rectangle, and the unit's
``primvars:openrooms:lightmap:scaleOffset`` takes it to the unit's place in an atlas. Opinions below
an instance would vanish, so an instance refers to a prim that holds the coordinates of what is
below it: instances of one prototype refer to the same prim, and stay instances of one prototype.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from openrooms_usd import names
from openrooms_usd.arrays import Array, Floats
from openrooms_usd.rendering.bake.atlases import Atlases, Placement
from openrooms_usd.rendering.bake.units import Member
from openrooms_usd.rendering.scene.lights import LightRecord
from openrooms_usd.usd.files import layers

LIGHTMAPS: Final = "Lightmaps"
SCALE_OFFSET: Final = "primvars:openrooms:lightmap:scaleOffset"
IRRADIANCE: Final = "openrooms:lightmap:irradiance"
ATLAS: Final = "openrooms:lightmap:atlas"
LIGHTS: Final = "openrooms:lightmap:lights"
LIGHT_NAMES: Final = "openrooms:lightmap:lightNames"
LIGHT_IRRADIANCE: Final = "openrooms:lightmap:lightIrradiance"

_Types = Sdf.ValueTypeNames


@dataclass(frozen=True)
class AtlasFiles:
    """The pictures of an atlas, relative to the layer.

    Attributes:
        total: The sum of all lights.
        lights: One of each light.
    """

    total: str
    lights: tuple[str, ...]


def scale_offset(atlases: Atlases, placement: Placement) -> tuple[float, float, float, float]:
    """What takes a unit's ``st1`` to its atlas: scale of s and t, then offset of s and t."""
    width, height = atlases.sizes[placement.atlas]
    across, high = placement.layout.size
    left, below = placement.corner
    return across / width, high / height, left / width, below / height


def write_layer(
    file: Path,
    folder: str,
    stage: Usd.Stage,
    atlases: Atlases,
    pictures: Sequence[AtlasFiles],
    lights: Sequence[LightRecord],
) -> None:
    """Write the layer, with its long arrays in binary files.

    Args:
        file: The layer.
        folder: Name of the folder beside it that receives the binary files.
        stage: What was baked: its axes, units and default prim are the layer's.
        atlases: Where everything is.
        pictures: Of each atlas.
        lights: By their numbers.
    """
    layer = _blank(stage)
    _define_atlases(layer, pictures, lights)
    shared = _blank(stage)
    homes: dict[str, Sdf.Path] = {}
    for placement in atlases.placements:
        unit = placement.unit
        prim = Sdf.CreatePrimInLayer(layer, unit.path)
        found = Sdf.AttributeSpec(prim, SCALE_OFFSET, _Types.Float4)
        found.default = Gf.Vec4f(*scale_offset(atlases, placement))
        found.SetInfo("interpolation", UsdGeom.Tokens.constant)
        target = Sdf.RelationshipSpec(prim, ATLAS, custom=False).targetPathList
        target.explicitItems = [_atlas(layer, placement.atlas)]
        home = Sdf.Path(unit.path)
        if unit.is_instance:
            home = homes.get(unit.prototype, Sdf.Path(f"/unit_{len(homes)}"))
        if not unit.is_instance or unit.prototype not in homes:
            _author_coordinates(shared if unit.is_instance else layer, home, placement)
        if unit.is_instance:
            homes[unit.prototype] = home
    if homes:
        binary = layers.export_by_content(shared, file.parent / folder, "instances", ".usdc")
        for placement in atlases.placements:
            if placement.unit.is_instance:
                to = Sdf.Reference(f"./{folder}/{binary.name}", homes[placement.unit.prototype])
                prim = layer.GetPrimAtPath(placement.unit.path)
                prim.referenceList.prependedItems = [to]
    layers.arrays_file(layer, file.parent / folder)
    layers.export(layer, file)


def write_lit_stage(file: Path, stage: Usd.Stage, layer: str, baked: str) -> None:
    """Write a stage that is the baked one under the layer of its lightmaps.

    Args:
        file: The stage.
        stage: What was baked.
        layer: The layer's file, relative to ``file``.
        baked: The baked stage's, relative to ``file``.
    """
    root = _blank(stage)
    settings = stage.GetRootLayer().pseudoRoot
    for key in ("renderSettingsPrimPath", "timeCodesPerSecond", "startTimeCode", "endTimeCode"):
        if settings.HasInfo(key):
            root.pseudoRoot.SetInfo(key, settings.GetInfo(key))
    root.subLayerPaths = [layer, baked]
    layers.export(root, file)


def _blank(stage: Usd.Stage) -> Sdf.Layer:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    root = stage.GetRootLayer()
    if root.defaultPrim:
        layer.defaultPrim = root.defaultPrim
    for key in (UsdGeom.Tokens.upAxis, UsdGeom.Tokens.metersPerUnit, "kilogramsPerUnit"):
        if root.pseudoRoot.HasInfo(key):
            layer.pseudoRoot.SetInfo(key, root.pseudoRoot.GetInfo(key))
    layer.customLayerData = {"creator": names.CREATOR}
    return layer


def _home(layer: Sdf.Layer) -> Sdf.Path:
    """Of the atlases: below the stage's default prim, if it has one."""
    return Sdf.Path.absoluteRootPath.AppendPath(layer.defaultPrim or ".").AppendChild(LIGHTMAPS)


def _atlas(layer: Sdf.Layer, number: int) -> Sdf.Path:
    return _home(layer).AppendChild(f"atlas_{number}")


def _define_atlases(
    layer: Sdf.Layer, pictures: Sequence[AtlasFiles], lights: Sequence[LightRecord]
) -> None:
    home = _define_scope(layer, _home(layer))
    home.SetInfo("assetInfo", {names.LICENCE_KEY: names.LICENCE})
    for number, files in enumerate(pictures):
        prim = _define_scope(layer, _atlas(layer, number))
        Sdf.AttributeSpec(prim, IRRADIANCE, _Types.Asset).default = Sdf.AssetPath(files.total)
        each = Sdf.AttributeSpec(prim, LIGHT_IRRADIANCE, _Types.AssetArray)
        each.default = Sdf.AssetPathArray([Sdf.AssetPath(file) for file in files.lights])
        called = Sdf.AttributeSpec(prim, LIGHT_NAMES, _Types.StringArray)
        called.default = Vt.StringArray([light.name for light in lights])
        targets = Sdf.RelationshipSpec(prim, LIGHTS, custom=False).targetPathList
        paths = [light.path.partition("[")[0] for light in lights if light.path]
        targets.explicitItems = list(dict.fromkeys(map(Sdf.Path, paths)))


def _define_scope(layer: Sdf.Layer, path: Sdf.Path) -> Sdf.PrimSpec:
    prim = Sdf.CreatePrimInLayer(layer, path)
    prim.specifier, prim.typeName = Sdf.SpecifierDef, "Scope"
    return prim


def _author_coordinates(layer: Sdf.Layer, home: Sdf.Path, placement: Placement) -> None:
    """``st1`` of a unit's meshes, in 0..1 of its rectangle."""
    Sdf.CreatePrimInLayer(layer, home)
    for nested in placement.unit.nested:
        Sdf.CreatePrimInLayer(layer, home.AppendPath(nested)).instanceable = False
    places = placement.layout.places / placement.layout.size
    first = 0
    for member in placement.unit.members:
        count = int(member.lit.sum())
        path = home.AppendPath(member.path) if member.path else home
        prim = Sdf.CreatePrimInLayer(layer, path)
        spec = Sdf.AttributeSpec(prim, f"primvars:{names.BAKED_ST}", _Types.TexCoord2fArray)
        spec.default = Vt.Vec2fArray.FromNumpy(_corners(member, places[first : first + count]))
        spec.SetInfo("interpolation", UsdGeom.Tokens.faceVarying)
        first += count


def _corners(member: Member, places: Array) -> Floats:
    """(K, 2) of the polygons' corners; 0 where no texels are."""
    mesh = member.mesh
    counts = UsdGeom.Mesh(mesh.prim).GetFaceVertexCountsAttr().Get()
    found = np.zeros((int(np.sum(counts)), 2), dtype=np.float32)
    assert mesh.mesh.corners is not None
    found[mesh.mesh.corners[member.lit].reshape(-1)] = places.reshape(-1, 2)
    return found
