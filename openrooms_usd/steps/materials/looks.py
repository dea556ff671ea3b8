"""Looks: what an object is made of, as a layer that its root references beside its asset.

::

    over Chair            default prim; variantSet look
        look = default
            Materials     Scope with the UsdPreviewSurface materials
            Geometry      overs that bind each part
        look = look_1
            ...

Bindings so live inside the object: repeats that have the same look share a prototype, and a
stronger layer may choose another variant on the root.
"""

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

from pxr import Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.codedigest import code_digest
from openrooms_usd.library.styles.assignment.kinds import kind_of
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.materials.palette import TEXTURES, Palette, Swatch
from openrooms_usd.usd.files.layers import apply_metadata, export
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shading.materials import bound_material, bound_subsets

LOOKS: Final = "looks"
VARIANT_SET: Final = names.LOOK
DEFAULT: Final = "default"


def variant(look: int) -> str:
    """How the look of a number is called: ``default``, ``look_1``, ``look_2`` ..."""
    return f"{VARIANT_SET}_{look}" if look else DEFAULT


@dataclass(frozen=True)
class ObjectSurface:
    """A surface of an object.

    Attributes:
        path: Its prim, relative to the object's root.
        name: Its semantic part, or its prim's name.
        bound: Whether it brings its own material.
    """

    path: str
    name: str
    bound: bool

    @property
    def kind(self) -> str:
        """What it is, whatever its number: parts of one kind share a material."""
        return kind_of(self.name)

    @property
    def handles(self) -> tuple[str, ...]:
        """What people may call it, the most special first: its prim, its part, its kind."""
        return tuple(dict.fromkeys((self.path.rpartition("/")[2], self.name, self.kind)))


@dataclass(frozen=True)
class PartMaterials:
    """Bindings of one object.

    Attributes:
        asset: The name of its asset, or of the object where it has none.
        category: What it is.
        looks: For each look, the material of each part, by the part's relative path.
        forced: The parts whose binding outdoes what is bound below them.
    """

    asset: str
    category: str
    looks: tuple[Mapping[str, Swatch], ...]
    forced: frozenset[str] = frozenset()

    def digest(self, palette: Palette) -> str:
        """8 hexadecimal digits of all that the look's layer depends on."""
        bindings = [
            [number, path, palette.name(swatch), palette.content(swatch), path in self.forced]
            for number, look in enumerate(self.looks)
            for path, swatch in sorted(look.items())
        ]
        text = json.dumps([code_digest(__name__), self.category, bindings])
        return hashlib.sha256(text.encode()).hexdigest()[:8]


def parts_of(root: Usd.Prim) -> list[ObjectSurface]:
    """The surfaces below an object's root, also where it is an instance."""
    base = root.GetPath()
    return [
        ObjectSurface(
            str(prim.GetPath().MakeRelativePath(base)),
            read_label(prim, names.PART) or prim.GetName(),
            bound_material(prim) is not None or bool(bound_subsets(prim)),
        )
        for prim in Usd.PrimRange(root, Usd.TraverseInstanceProxies())
        if prim.IsA(UsdGeom.Gprim)
    ]


def publish_look(context: StepContext, palette: Palette, look: PartMaterials) -> str:
    """Write a look's layer, unless it is there already.

    Args:
        context: The materials step's context.
        palette: Its swatches; their textures lie beside the looks.
        look: What is bound.

    Returns:
        The anchored path for the step's layer.

    Raises:
        OutputError: It cannot be written.
    """
    file = f"{LOOKS}/{look.asset}_{look.digest(palette)}.usda"
    target = context.keep(file)
    if not target.is_file():
        stage = _look_stage(palette, look)
        export(stage.GetRootLayer(), target)
    return context.asset(file)


def _look_stage(palette: Palette, look: PartMaterials) -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    apply_metadata(stage.GetRootLayer())
    title = "".join(word.capitalize() for word in look.category.split("_")) or "Object"
    root = stage.OverridePrim(f"/{title}")
    stage.SetDefaultPrim(root)
    variants = root.GetVariantSets().AddVariantSet(VARIANT_SET)
    for number in range(len(look.looks)):
        variants.AddVariant(variant(number))
        variants.SetVariantSelection(variant(number))
        with variants.GetVariantEditContext():
            _author_look(stage, root, palette, look.looks[number], look.forced)
    variants.SetVariantSelection(DEFAULT)
    return stage


def _author_look(
    stage: Usd.Stage,
    root: Usd.Prim,
    palette: Palette,
    worn: Mapping[str, Swatch],
    forced: frozenset[str],
) -> None:
    scope = UsdGeom.Scope.Define(stage, root.GetPath().AppendChild("Materials")).GetPath()
    materials = define_all(stage, scope, palette, worn.values(), f"../{TEXTURES}")
    for path, swatch in worn.items():
        prim = stage.OverridePrim(root.GetPath().AppendPath(path))
        strength = (
            UsdShade.Tokens.strongerThanDescendants
            if path in forced
            else UsdShade.Tokens.fallbackStrength
        )
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(materials[swatch], strength)


def define_all(
    stage: Usd.Stage, scope: Sdf.Path, palette: Palette, swatches: Iterable[Swatch], folder: str
) -> dict[Swatch, UsdShade.Material]:
    """Define the Materials of distinct swatches in the order of their names.

    Args:
        stage: Where; its edit target receives everything.
        scope: What holds them.
        palette: Its swatches.
        swatches: Which; repeats are defined once.
        folder: The textures' folder, relative to the layer that is written.
    """
    distinct = sorted({(palette.name(swatch), swatch) for swatch in swatches}, key=lambda n: n[0])
    return {
        swatch: palette.define(stage, scope.AppendChild(name), swatch, folder)
        for name, swatch in distinct
    }
