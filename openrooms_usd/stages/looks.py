"""Looks: what an object is made of, as a layer that its root references beside its asset.

::

    over Chair            default prim; variantSet look
        look = default
            Materials     Scope with the UsdPreviewSurface materials
            Geometry      overs that bind each part

Bindings so live inside the object: repeats that have the same look share a prototype, and a
stronger layer may choose another variant on the root.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from pxr import Usd, UsdGeom, UsdShade

from openrooms_usd import __version__, names
from openrooms_usd.stages.base import FORMAT, StageContext
from openrooms_usd.stages.swatches import TEXTURES, Palette, Swatch
from openrooms_usd.usd.layers import apply_metadata, export
from openrooms_usd.usd.materials import bound_material, bound_subsets
from openrooms_usd.usd.semantics import read_label

LOOKS: Final = "looks"
VARIANT_SET: Final = "look"
DEFAULT: Final = "default"


@dataclass(frozen=True)
class Part:
    """A surface of an object.

    Attributes:
        path: Its prim, relative to the object's root.
        name: Its semantic part, or its prim's name.
        bound: Whether it brings its own material.
    """

    path: str
    name: str
    bound: bool


@dataclass(frozen=True)
class Dressed:
    """Bindings of one object.

    Attributes:
        asset: The name of its asset, or of the object where it has none.
        category: What it is.
        swatches: The material of each part, by the part's relative path.
        forced: The parts whose binding outdoes what is bound below them.
    """

    asset: str
    category: str
    swatches: Mapping[str, Swatch]
    forced: frozenset[str] = frozenset()

    def digest(self, palette: Palette) -> str:
        """8 hexadecimal digits of all that the look's layer depends on."""
        bindings = [
            [path, palette.name(swatch), repr(swatch), path in self.forced]
            for path, swatch in sorted(self.swatches.items())
        ]
        text = json.dumps([__version__, FORMAT, self.category, bindings])
        return hashlib.sha256(text.encode()).hexdigest()[:8]


def parts_of(root: Usd.Prim) -> list[Part]:
    """The surfaces below an object's root, also where it is an instance."""
    base = root.GetPath()
    return [
        Part(
            str(prim.GetPath().MakeRelativePath(base)),
            read_label(prim, names.PART) or prim.GetName(),
            bound_material(prim) is not None or bool(bound_subsets(prim)),
        )
        for prim in Usd.PrimRange(root, Usd.TraverseInstanceProxies())
        if prim.IsA(UsdGeom.Gprim)
    ]


def publish_look(context: StageContext, palette: Palette, look: Dressed) -> str:
    """Write a look's layer, unless it is there already.

    Args:
        context: The materials stage's context.
        palette: Its swatches; their textures lie beside the looks.
        look: What is bound.

    Returns:
        The anchored path for the stage's layer.

    Raises:
        OutputError: It cannot be written.
    """
    file = f"{LOOKS}/{look.asset}_{look.digest(palette)}.usda"
    target = context.keep(file)
    if not target.is_file():
        stage = _look_stage(palette, look)
        export(stage.GetRootLayer(), target)
    return context.asset(file)


def _look_stage(palette: Palette, look: Dressed) -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    apply_metadata(stage.GetRootLayer())
    title = "".join(word.capitalize() for word in look.category.split("_")) or "Object"
    root = stage.OverridePrim(f"/{title}")
    stage.SetDefaultPrim(root)
    variants = root.GetVariantSets().AddVariantSet(VARIANT_SET)
    variants.AddVariant(DEFAULT)
    variants.SetVariantSelection(DEFAULT)
    with variants.GetVariantEditContext():
        _author_look(stage, root, palette, look)
    return stage


def _author_look(stage: Usd.Stage, root: Usd.Prim, palette: Palette, look: Dressed) -> None:
    scope = UsdGeom.Scope.Define(stage, root.GetPath().AppendChild("Materials")).GetPath()
    distinct = {palette.name(swatch): swatch for swatch in look.swatches.values()}
    materials = {
        name: palette.define(stage, scope.AppendChild(name), swatch, f"../{TEXTURES}")
        for name, swatch in sorted(distinct.items())
    }
    for path, swatch in look.swatches.items():
        prim = stage.OverridePrim(root.GetPath().AppendPath(path))
        strength = (
            UsdShade.Tokens.strongerThanDescendants
            if path in look.forced
            else UsdShade.Tokens.fallbackStrength
        )
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(materials[palette.name(swatch)], strength)
