"""What a person did in Blender, as sparse opinions about the room's own prims.

Taken over: where objects are, which are gone, what is new, lenses of cameras, the brightness and
hue of lamps and of the sky, and plain base colours. The rest of an export shows how Blender stores
the room, not how it was edited: names with numbers, meshes with retriangulated faces, and rebuilt
materials. Blender does not know the sky, portals and bodies at all.
"""

from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdLux, UsdShade

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.colorimetry import luminance
from openrooms_usd.edits.blender import DATA, PROPERTIES, Pair, Pairing, container, is_named, named
from openrooms_usd.edits.flattened import Differences
from openrooms_usd.usd.light.lightreader import read_light
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.places.placements import author_placed
from openrooms_usd.usd.shading.materialreader import preview_shader
from openrooms_usd.usd.shading.materials import bound_material, bound_subsets

# Blender counts in 32 bits and takes transforms apart: below this nothing was moved (metres) or
# turned (length by which a unit vector of the object's axes is off; 0.006 degrees).
SAME_PLACE_METRES: Final = 1e-4
SAME_AXIS: Final = 1e-4
# Numbers that differ by less than this part of theirs are equal.
SAME_PART: Final = 1e-3
# So much of two colours' components may differ.
SAME_COLOR: Final = 1e-3
# An export that lacks more of the room's meshes is a selection: the others were not removed.
MOST_REMOVED: Final = 0.5

_LENS: Final = (
    "focalLength",
    "horizontalAperture",
    "horizontalApertureOffset",
    "verticalApertureOffset",
    "focusDistance",
    "fStop",
    "clippingRange",
)
_DIFFUSE: Final = "diffuseColor"
_EMISSIVE: Final = "emissiveColor"
_SHOWN: Final = (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)


class BlenderDifferences(Differences):
    """What Blender's export of a room says otherwise than the room."""

    def find(self) -> None:
        """Compare both stages object by object, within the tolerances of this module."""
        pairing = Pairing.of(self.base, self.saved)
        for pair in pairing.pairs:
            self.compared += 1
            self._compare_place(pair)
            if pair.shape.IsA(UsdGeom.Camera):
                self._compare_lens(pair)
            elif pair.shape.IsA(UsdGeom.Mesh):
                self._compare_look(pair)
        self._compare_sky()
        self._remove(pairing)
        for parent, added in pairing.added:
            self.left.extend(adopt_object(self.base, self.opinions, parent, added))

    def _say(self, attribute: Usd.Attribute, value: Any) -> None:
        """What an attribute of a prim of ours shall be."""
        self._set(attribute.GetPrim(), attribute.GetName(), attribute.GetTypeName(), value)

    def _set(
        self, prim: Usd.Prim, name: str, kind: Sdf.ValueTypeName, value: Any
    ) -> Sdf.AttributeSpec:
        spec = self._over(prim.GetPath())
        found = spec.attributes.get(name) or Sdf.AttributeSpec(spec, name, kind)
        found.default = value
        return found

    def _compare_place(self, pair: Pair) -> None:
        if not UsdGeom.Xformable(pair.ours) or not UsdGeom.Xformable(pair.theirs):
            return
        if pair.ours.IsA(UsdLux.PortalLight):
            # Blender makes lamps of them, which is harmless.
            return
        local = pair.local()
        before = UsdGeom.Xformable(pair.ours).GetLocalTransformation(TIME)
        off = np.abs(np.array(local) - np.array(before))
        if off[3, :3].max() > SAME_PLACE_METRES or off[:3, :3].max() > SAME_AXIS:
            author_placed(self._over(pair.ours.GetPath()), pair.ours, local)

    def _compare_lens(self, pair: Pair) -> None:
        for name in _LENS:
            ours, theirs = (prim.GetAttribute(name) for prim in (pair.shape, pair.data))
            if not theirs or not theirs.HasAuthoredValue():
                continue
            before, now = np.atleast_1d(ours.Get(TIME)), np.atleast_1d(theirs.Get(TIME))
            if (np.abs(now - before) > SAME_PART * np.abs(before)).any():
                self._say(ours, theirs.Get(TIME))

    def _compare_look(self, pair: Pair) -> None:
        """Colours of the material that a mesh wears in both."""
        if bound_subsets(pair.shape):
            return
        ours, theirs = (bound_material(prim) for prim in (pair.shape, pair.data))
        shader, seen = (material and preview_shader(material) for material in (ours, theirs))
        if not (ours and theirs and shader and seen):
            return
        if not is_named(theirs.GetPrim(), ours.GetPrim().GetName(), DATA):
            worn = named(theirs.GetPrim(), DATA)
            self.left.append(f"{pair.shape.GetPath()} now has the material {worn}: bind it by hand")
            return
        self._compare_color(shader, seen, _DIFFUSE)
        if not pair.shape.HasAPI(UsdLux.MeshLightAPI):
            self._compare_color(shader, seen, _EMISSIVE)
        elif (glow := _changed(shader, seen, _EMISSIVE)) is not None:
            self._relight(pair.shape, glow)

    def _compare_color(self, shader: UsdShade.Shader, seen: UsdShade.Shader, name: str) -> None:
        color = _changed(shader, seen, name)
        if color is None:
            return
        kind = Sdf.ValueTypeNames.Color3f
        spec = self._set(shader.GetPrim(), f"inputs:{name}", kind, Gf.Vec3f(*color.tolist()))
        found = shader.GetInput(name)
        if found and found.HasConnectedSource():
            # Explicitly none: a list that is left out would leave the picture connected.
            spec.connectionPathList.ClearEditsAndMakeExplicit()

    def _relight(self, bulb: Usd.Prim, glow: Array) -> None:
        """Let a lamp shine as its material glows in Blender."""
        light, before = UsdLux.LightAPI(bulb), read_light(bulb).radiance
        if _is_same_color(glow, before):
            # It was changed after its glow was written, and Blender has what it is now.
            return
        was, now = float(luminance(before)), float(luminance(glow))
        hue = glow / now if now > 0.0 else np.ones(3)
        if was > 0.0 and (now == 0.0 or np.abs(hue - before / was).max() < SAME_COLOR):
            self._say(light.GetIntensityAttr(), light.GetIntensityAttr().Get(TIME) * now / was)
            return
        self._say(light.GetIntensityAttr(), now)
        self._say(light.GetExposureAttr(), 0.0)
        self._say(light.GetColorAttr(), Gf.Vec3f(*hue.tolist()))
        self._say(light.GetEnableColorTemperatureAttr(), False)

    def _compare_sky(self) -> None:
        ours = self.base.GetPrimAtPath(names.ENVIRONMENT)
        domes = [p for p in container(self.saved).GetChildren() if p.IsA(UsdLux.DomeLight)]
        if not ours or not domes:
            return
        before, now = (UsdLux.LightAPI(prim).GetIntensityAttr() for prim in (ours, domes[0]))
        if abs(now.Get(TIME) - before.Get(TIME)) > SAME_PART * before.Get(TIME):
            self._say(before, now.Get(TIME))

    def _remove(self, pairing: Pairing) -> None:
        """Switch off what is gone, where the file is of the whole room."""
        for kind, what in ((UsdGeom.Gprim, "meshes"), (UsdGeom.Camera, "cameras")):
            seen = {prim: list(_imported_prims(prim, kind)) for prim in pairing.missing}
            gone = sum(map(len, seen.values()))
            there = sum(1 for pair in pairing.pairs if pair.shape.IsA(kind))
            if gone > MOST_REMOVED * (gone + there):
                self.left.append(
                    f"{gone} of {gone + there} {what} are not in the file: it is treated as the "
                    "export of a selection, so none is turned off"
                )
                return
            for prim in filter(seen.get, seen):
                self._over(prim.GetPath()).active = False


def _imported_prims(prim: Usd.Prim, kind: type) -> Iterator[Usd.Prim]:
    """What of a kind is at and below a prim, as Blender imports it: nothing hidden, no guides."""
    for found in Usd.PrimRange(prim, Usd.TraverseInstanceProxies()):
        shown = UsdGeom.Imageable(found)
        if (
            found.IsA(kind)
            and shown.ComputeVisibility(TIME) != UsdGeom.Tokens.invisible
            and shown.ComputePurpose() in _SHOWN
        ):
            yield found


def _changed(ours: UsdShade.Shader, theirs: UsdShade.Shader, name: str) -> Array | None:
    """Blender's color where it is another than ours; None where a picture gives it.

    A plain color in place of our picture is another one whatever it is; not so of a glow, whose
    pictures Blender may leave out.
    """
    before, now = (shader.GetInput(name) for shader in (ours, theirs))
    if now and now.HasConnectedSource():
        return None
    if before and before.HasConnectedSource():
        is_plain = name == _DIFFUSE and now and now.Get(TIME) is not None
        return _color(now, name) if is_plain else None
    color = _color(now, name)
    return None if _is_same_color(color, _color(before, name)) else color


def _is_same_color(now: Array, before: Array) -> bool:
    return bool(np.abs(now - before).max() <= SAME_COLOR * max(1.0, float(np.abs(before).max())))


def _color(found: UsdShade.Input, name: str) -> Array:
    value = found.Get(TIME) if found else None
    fallback = (0.18, 0.18, 0.18) if name == _DIFFUSE else (0.0, 0.0, 0.0)
    return np.array(fallback if value is None else value, dtype=np.float64)


# What is new in a Blender export, as prims of the room.

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
        yield f"{path} uses data that other objects share in the file: export without instancing"
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
    """Whether an object has the parts of another one, so it is a duplicate."""
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
