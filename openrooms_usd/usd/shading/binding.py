"""Parts of any stage bound to materials, as opinions of the layer that is edited."""

from collections.abc import Iterable

from pxr import Sdf, Usd, UsdShade

from openrooms_usd.usd.shading.materials import bound_subsets


def bind(prim: Usd.Prim, material: UsdShade.Material) -> None:
    """Bind a part, also where pieces of it have materials of their own."""
    tokens = UsdShade.Tokens
    strong = bool(bound_subsets(prim))
    strength = tokens.strongerThanDescendants if strong else tokens.fallbackStrength
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material, strength)


def open_instances(stage: Usd.Stage, parts: Iterable[Sdf.Path]) -> None:
    """Let instances that parts are inside of be instances no more."""
    layer = stage.GetEditTarget().GetLayer()
    for part in parts:
        for above in part.GetPrefixes():
            if stage.GetPrimAtPath(above).IsInstance():
                Sdf.CreatePrimInLayer(layer, above).instanceable = False
