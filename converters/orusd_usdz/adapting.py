"""One plain layer of a stage: prims, properties and materials that simple readers know.

Instances become copies, variants what is chosen, and lights, bodies and labels are left out.
"""

from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd import atomic, imagefile, names, untrusted
from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.errors import InputError
from openrooms_usd.exporters import Report
from openrooms_usd.package import package
from openrooms_usd.portable import RESERVED
from openrooms_usd.scratch import scratch_folder
from openrooms_usd.usd.arrays import flattened
from openrooms_usd.usd.files import layers
from openrooms_usd.usd.files.diagnostics import reading
from openrooms_usd.usd.places.frames import up_axis
from openrooms_usd.usd.shading import textures
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.materials import PANE_OPACITY, define_preview_surface
from openrooms_usd.usd.shading.surfaces import BARE, SHUFFLED, PreviewSurface, Texture, ior_of
from openrooms_usd.usd.shading.textures import local_file, read_texture
from orusd_usdz.profiles import Profile

FOLDER = "textures"


@dataclass
class Textures:
    """Copies pictures into a folder beside the layer, each once.

    Attributes:
        home: The folder of the layer.
        endings: The formats that stay as they are; all else is written as PNG of 8 bits.
        losses: What was lost of each picture, in words.
    """

    home: Path
    endings: tuple[str, ...]
    losses: dict[str, str] = field(default_factory=dict)
    _places: dict[tuple[str, bool], str] = field(default_factory=dict)
    _taken: set[str] = field(default_factory=set)

    def placed(self, texture: Texture, *, is_color: bool) -> Texture:
        """A texture as it stands in the layer.

        Args:
            texture: With the path of its file.
            is_color: Whether it is a colour, which is encoded where 8 bits have to do.
        """
        encode = is_color and texture.color_space == "raw" and not self._stays(texture.file)
        key = texture.file, encode
        if key not in self._places:
            self._places[key] = self._write(texture.file, encode)
        space = "sRGB" if encode else texture.color_space
        return replace(texture, file=self._places[key], color_space=space)

    def _stays(self, file: str) -> bool:
        return Path(file.rstrip("]")).suffix.lower() in self.endings and not textures.is_udim(file)

    def _write(self, file: str, encode: bool) -> str:
        stem, ending = Path(file.rstrip("]")).stem, Path(file.rstrip("]")).suffix.lower()
        try:
            if self._stays(file):
                with local_file(file) as local:
                    data = untrusted.read_bytes(local, "picture")
                place = self._name(stem, ending)
                atomic.write_bytes(self.home / place, data)
                return place
            pixels = read_texture(file)
        except InputError as error:
            self.losses[file] = f"{file}: {error.message}; left out"
            return ""
        self.losses[file] = f"{file}: it is a PNG of 8 bits now"
        values = srgb_from_linear(np.clip(pixels, 0.0, 1.0)) if encode else pixels
        codes = np.round(np.clip(np.nan_to_num(values), 0.0, 1.0) * 255.0).astype(np.uint8)
        place = self._name(stem, ".png")
        with atomic.replacing(self.home / place) as beside:
            imagefile.write(beside, codes, "uint8", {"DateTime": "", "oiio:UnassociatedAlpha": 1})
        return place

    def _name(self, stem: str, ending: str) -> str:
        plain = "".join(c if c.isascii() and (c.isalnum() or c in "-_") else "_" for c in stem)
        name, number = f"{plain}{ending}", 1
        while name.lower() in self._taken or Path(name).stem.lower() in RESERVED:
            number += 1
            name = f"{plain}_{number}{ending}"
        self._taken.add(name.lower())
        return f"{FOLDER}/{name}"


_SCHEMAS: Final = ("MaterialBindingAPI",)
_PREFIXES: Final = ("xformOp", "primvars:", "material:binding")
_UNSEEN: Final = (UsdGeom.Tokens.guide, UsdGeom.Tokens.proxy)
_Y_UP: Final = "xformOp:rotateX:yUp"
_GROUPS: Final = ("", "Scope", "Xform")
_COLORS: Final = ("base_color", "emissive", "specular")


def write_plain(stage: Usd.Stage, target: Path, profile: Profile) -> Report:
    """Write a stage as a USDZ file of one layer and its textures.

    Args:
        stage: The composed stage.
        target: The file.
        profile: One with a list of types.

    Returns:
        What became of every prim.

    Raises:
        OutputError: The file cannot be written.
    """
    with scratch_folder() as folder:
        scene = folder / "scene.usdc"
        work = _Adaptation(_flattened(stage), profile, Textures(scene.parent, profile.pictures))
        # 1. Removes what phones do not show or support.
        work.remove_prims()
        work.remove_properties()
        # 2. Materials are written anew, with their textures beside them.
        work.write_materials()
        # 3. The frame.
        work.turn()
        layers.export(work.ordered(), scene)
        with reading(scene):
            package(scene, target)
    return work.report


def _flattened(stage: Usd.Stage) -> Usd.Stage:
    """A stage of one layer, with copies in place of instances."""
    session = Sdf.Layer.CreateAnonymous(".usda")
    whole = Usd.Stage.Open(stage.GetRootLayer(), session)
    whole.SetEditTarget(session)
    # Instances inside of what was one come to light in turn.
    while found := [prim for prim in whole.Traverse() if prim.IsInstance()]:
        for prim in found:
            prim.SetInstanceable(False)
    return Usd.Stage.Open(whole.Flatten(addSourceFileComment=False))


@dataclass
class _Adaptation:
    """A flat stage on its way to what a profile allows."""

    stage: Usd.Stage
    profile: Profile
    textures: Textures
    report: Report = field(default_factory=Report)

    def remove_prims(self) -> None:
        types = self.profile.types or frozenset()
        gone: list[Sdf.Path] = []
        for prim in self.stage.TraverseAll():
            if any(prim.GetPath().HasPrefix(path) for path in gone):
                continue
            kind = prim.GetTypeName()
            reason = _why_not(prim, types)
            if reason:
                gone.append(prim.GetPath())
                self.report.add(prim.GetPath(), "skipped", reason)
            elif kind not in types:
                prim.SetTypeName("Xform")
                self.report.add(prim.GetPath(), "approximated", f"{kind} is a group there")
        for path in gone:
            self.stage.RemovePrim(path)
        while empty := [prim for prim in self.stage.TraverseAll() if _is_empty_group(prim)]:
            for prim in empty:
                self.stage.RemovePrim(prim.GetPath())

    def remove_properties(self) -> None:
        registry = Usd.SchemaRegistry()
        for prim in self.stage.TraverseAll():
            schemas = [name for name in prim.GetAppliedSchemas() if name in _SCHEMAS]
            lost = [name for name in prim.GetAppliedSchemas() if name not in _SCHEMAS]
            prim.ClearMetadata("apiSchemas")
            for name in schemas:
                prim.AddAppliedSchema(name)
            definition = registry.FindConcretePrimDefinition(prim.GetTypeName())
            own = set(definition.GetPropertyNames()) if definition else set()
            for name in prim.GetAuthoredPropertyNames():
                kept = name in own or name.startswith(_PREFIXES)
                ours = name.startswith(f"primvars:{names.NAMESPACE}:")
                if not _is_shading(prim) and (not kept or ours):
                    prim.RemoveProperty(name)
            for key in ("customData", "assetInfo", "variantSelection", "variantSetNames"):
                prim.ClearMetadata(key)
            if not _is_shading(prim) and prim.IsA(UsdGeom.Imageable):
                self._tell(prim, lost)

    def _tell(self, prim: Usd.Prim, lost: list[str]) -> None:
        bodies = any("Physics" in name for name in lost)
        lamp = any("Light" in name for name in lost)
        reasons = [*["its body is left out"] * bodies, *["it glows, but lights nothing"] * lamp]
        outcome: Any = "approximated" if reasons else "translated"
        self.report.add(prim.GetPath(), outcome, "; ".join(reasons))

    def write_materials(self) -> None:
        found = [prim for prim in self.stage.TraverseAll() if prim.IsA(UsdShade.Material)]
        read = [(prim.GetPath(), *read_preview_surface(UsdShade.Material(prim))) for prim in found]
        for path, preview, losses in read:
            self.stage.RemovePrim(path)
            plain, lost = self._plain(preview)
            define_preview_surface(self.stage, path, plain)
            told = "; ".join(dict.fromkeys([*losses, *lost]))
            self.report.add(path, "approximated" if told else "translated", told)
        for prim in [prim for prim in self.stage.TraverseAll() if prim.IsA(UsdGeom.Gprim)]:
            self._show_color(prim)

    def _plain(self, preview: PreviewSurface) -> tuple[PreviewSurface, list[str]]:
        """The material for a phone, and what is lost."""
        lost = []
        if preview.transmission > 0.0:
            # As it is authored for all who do not know ours.
            preview = replace(preview, opacity=1.0 - preview.transmission, transmission=0.0)
            lost.append("it lets light through: shown as partly clear")
        if preview.pane is not None:
            preview = replace(preview, opacity=PANE_OPACITY, pane=None)
            lost.append("it is a clear pane: shown as partly clear")
        if preview.f0 is not None:
            preview = replace(preview, ior=ior_of(preview.f0), f0=None)
        emissive = preview.emissive
        if not isinstance(emissive, Texture) and max(emissive) > 1.0:
            red, green, blue = (value / max(emissive) for value in emissive)
            preview = replace(preview, emissive=(red, green, blue))
            lost.append("its emission is shown as white: nits are not supported there")
        if preview.specular is not None:
            lost.append("RealityKit has no specular colour")
        preview = replace(preview, opacity_mode="transparent")
        values: dict[str, Any] = {}
        for item in fields(preview):
            value = getattr(preview, item.name)
            if isinstance(value, Texture):
                values[item.name] = self.textures.placed(value, is_color=item.name in _COLORS)
                lost += filter(None, [self.textures.losses.get(value.file, "")])
                lost += [SHUFFLED] if value.is_shuffled else []
        return replace(preview, **values), lost

    def _show_color(self, prim: Usd.Prim) -> None:
        """A material for what has none: its ``displayColor``, which phones pass over."""
        if UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]:
            return
        values = flattened(UsdGeom.Gprim(prim).GetDisplayColorPrimvar())
        colors = np.asarray(values or [BARE.base_color], dtype=np.float64).reshape(-1, 3)
        red, green, blue = np.clip(np.nan_to_num(colors.mean(axis=0)), 0.0, 1.0).tolist()
        root = prim.GetPath().GetPrefixes()[0]
        path = root.AppendChild(
            f"Color_{int(red * 255):02x}{int(green * 255):02x}{int(blue * 255):02x}"
        )
        if not self.stage.GetPrimAtPath(path):
            surface = PreviewSurface(base_color=(red, green, blue))
            define_preview_surface(self.stage, path, surface)
        material = UsdShade.Material(self.stage.GetPrimAtPath(path))
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)

    def turn(self) -> None:
        """Y up, by one more operation at the top."""
        layer = self.stage.GetRootLayer()
        layer.customLayerData = {"creator": names.CREATOR}
        if self.profile.up is None or up_axis(self.stage) == self.profile.up:
            return
        UsdGeom.SetStageUpAxis(self.stage, self.profile.up)
        for prim in self.stage.TraverseAll():
            shown = UsdGeom.Xformable(prim)
            if shown and (_is_top(prim) or shown.GetResetXformStack()):
                order = shown.GetOrderedXformOps()
                resets = shown.GetResetXformStack()
                turn = shown.AddXformOp(UsdGeom.XformOp.TypeRotateX, opSuffix="yUp")
                turn.Set(-90.0)
                shown.SetXformOpOrder([turn, *order], resets)

    def ordered(self) -> Sdf.Layer:
        """The layer with its fields in the order of their names, for equal bytes."""
        layer = Sdf.Layer.CreateAnonymous(".usda")
        layer.ImportFromString(self.stage.GetRootLayer().ExportToString())
        return layer


def _why_not(prim: Usd.Prim, types: frozenset[str]) -> str:
    """Why a prim is left out with all below it; empty where it stays."""
    kind = str(prim.GetTypeName())
    if prim.IsAbstract() or not prim.IsActive():
        return "it is a class, or not active"
    drawn = any(_is_drawn(below, types) for below in Usd.PrimRange(prim))
    if kind not in types and (kind == "PointInstancer" or not drawn):
        return f"phones do not support {kind}"
    shown = UsdGeom.Imageable(prim)
    if shown and shown.ComputePurpose() in _UNSEEN:
        return f"its purpose is {shown.ComputePurpose()}"
    return ""


def _is_drawn(prim: Usd.Prim, types: frozenset[str]) -> bool:
    return bool(prim.IsA(UsdGeom.Gprim)) and prim.GetTypeName() in types


def _is_empty_group(prim: Usd.Prim) -> bool:
    return str(prim.GetTypeName()) in _GROUPS and not prim.GetAllChildren()


def _is_shading(prim: Usd.Prim) -> bool:
    # Materials are node graphs, too.
    return bool(prim.IsA(UsdShade.NodeGraph) or prim.IsA(UsdShade.Shader))


def _is_top(prim: Usd.Prim) -> bool:
    """Whether nothing above a prim has a place of its own."""
    parent = prim.GetParent()
    while parent and not parent.IsPseudoRoot():
        if UsdGeom.Xformable(parent):
            return False
        parent = parent.GetParent()
    return True
