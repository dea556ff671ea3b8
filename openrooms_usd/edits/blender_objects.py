"""What is new in a Blender export, as prims of the room."""

from collections.abc import Iterator
from typing import Final

from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.edits.blender import DATA, PROPERTIES, is_named, named
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.places.placements import author_placed

# Where the materials of new objects go.
LOOKS: Final = f"{names.WORLD}/Looks"

# Points cannot be hit by rays: a lamp without size gets this radius and keeps its power, metres.
_POINT_RADIUS: Final = 0.01

_KELVIN: Final = "inputs:colorTemperature"
# What Blender divides its suns by when it writes them: watts per square metre, and the angle.
_SUN: Final = {"inputs:intensity": 4.0, "inputs:angle": 2.0}


def adopt_object(
    base: Usd.Stage, opinions: Sdf.Layer, parent: Usd.Prim, added: Usd.Prim
) -> Iterator[str]:
    """Define a new object below a prim of the room.

    A copy of an object of the room refers to that one, and so keeps its labels, materials and
    bodies; all else is copied with its meshes and materials.

    Args:
        base: The composed room.
        opinions: Receives the object.
        parent: The prim that it lies below.
        added: The object, in Blender's stage.

    Yields:
        A sentence about what cannot be taken over.
    """
    path = _free(base, opinions, parent.GetPath(), added)
    for above in filter(Usd.Prim.IsInstance, map(base.GetPrimAtPath, path.GetPrefixes()[:-1])):
        Sdf.CreatePrimInLayer(opinions, above.GetPath()).instanceable = False
    original = next((x for x in parent.GetChildren() if _is_copy(x, added)), None)
    if original is not None:
        spec = _defined(opinions, path, original.GetTypeName())
        spec.referenceList.Prepend(Sdf.Reference("", original.GetPath()))
        spec.instanceable = original.IsInstanceable()
        place = UsdGeom.Xformable(added)
        author_placed(spec, original, place.GetLocalTransformation(TIME))
        return
    if any(_is_shared(spec) for spec in _specs(added.GetPrimStack()[0])):
        yield f"{path} is made of what other objects share in the file: export without instancing"
        return
    source = added.GetPrimStack()[0]
    _defined(opinions, path, added.GetTypeName())
    Sdf.CopySpec(source.layer, source.path, opinions, path)
    for spec in _specs(opinions.GetPrimAtPath(path)):
        _clean(spec)
    for prim in Usd.PrimRange(added):
        target = path.AppendPath(prim.GetPath().MakeRelativePath(added.GetPath()))
        _bind(base, opinions, prim, target if prim != added else path)


def _free(base: Usd.Stage, opinions: Sdf.Layer, parent: Sdf.Path, added: Usd.Prim) -> Sdf.Path:
    """A path below ``parent`` that nothing has."""
    name, number = Tf.MakeValidIdentifier(added.GetName()), 0
    path = parent.AppendChild(name)
    while base.GetPrimAtPath(path) or opinions.GetPrimAtPath(path):
        number += 1
        path = parent.AppendChild(f"{name}_{number}")
    return path


def _defined(opinions: Sdf.Layer, path: Sdf.Path, kind: str) -> Sdf.PrimSpec:
    spec = Sdf.CreatePrimInLayer(opinions, path)
    spec.specifier, spec.typeName = Sdf.SpecifierDef, kind
    return spec


def _is_copy(original: Usd.Prim, added: Usd.Prim) -> bool:
    """Whether an object has the parts of another one: then somebody has duplicated it."""
    parts = [x.GetName() for x in original.GetFilteredChildren(Usd.TraverseInstanceProxies())]
    copies = added.GetChildren()
    return (
        is_named(added, original.GetName())
        and len(copies) == len(parts) > 0
        and all(any(is_named(copy, part) for copy in copies) for part in parts)
    )


def _specs(spec: Sdf.PrimSpec) -> Iterator[Sdf.PrimSpec]:
    yield spec
    for child in spec.nameChildren:
        yield from _specs(child)


def _is_shared(spec: Sdf.PrimSpec) -> bool:
    references = spec.referenceList.GetAddedOrExplicitItems()
    return any(not reference.assetPath for reference in references)


def _clean(spec: Sdf.PrimSpec) -> None:
    """Take away what only Blender reads, and what leads out of the object."""
    for found in list(spec.properties):
        outward = found.name == UsdShade.Tokens.materialBinding
        if outward or found.name.startswith(PROPERTIES):
            spec.RemoveProperty(found)
    if spec.HasInfo("active") and spec.active:
        spec.ClearInfo("active")
    _clean_light(spec)


def _clean_light(spec: Sdf.PrimSpec) -> None:
    """Let a lamp be as bright and as white as Blender shows it."""
    radius = spec.attributes.get("inputs:radius")
    if spec.typeName == "SphereLight" and radius is not None and radius.default == 0.0:
        radius.default = _POINT_RADIUS
        extent = spec.attributes.get("extent")
        if extent is not None:
            extent.default = [Gf.Vec3f(-_POINT_RADIUS), Gf.Vec3f(_POINT_RADIUS)]
    if "inputs:enableColorTemperature" in spec.attributes and _KELVIN not in spec.attributes:
        # Blender says so of every lamp, and nothing else of those that have no temperature: they
        # would get the tint of 6500 K.
        spec.RemoveProperty(spec.attributes["inputs:enableColorTemperature"])
    for name, factor in _SUN.items() if spec.typeName == "DistantLight" else ():
        if name in spec.attributes:
            spec.attributes[name].default *= factor


def _bind(base: Usd.Stage, opinions: Sdf.Layer, prim: Usd.Prim, path: Sdf.Path) -> None:
    """Bind the material that a new mesh has in Blender, which the room may have already."""
    material = UsdShade.MaterialBindingAPI(prim).GetDirectBinding().GetMaterial()
    if not material:
        return
    target = Sdf.Path(f"{names.MATERIALS}/{named(material.GetPrim(), DATA)}")
    if not base.GetPrimAtPath(target):
        target = Sdf.Path(LOOKS).AppendChild(material.GetPrim().GetName())
        if not opinions.GetPrimAtPath(target):
            _defined(opinions, Sdf.Path(LOOKS), "Scope")
            source = material.GetPrim().GetPrimStack()[0]
            _defined(opinions, target, "Material")
            Sdf.CopySpec(source.layer, source.path, opinions, target)
            for spec in _specs(opinions.GetPrimAtPath(target)):
                _clean(spec)
    binding = Sdf.RelationshipSpec(
        opinions.GetPrimAtPath(path), UsdShade.Tokens.materialBinding, custom=False
    )
    binding.targetPathList.explicitItems = [target]
