"""Deactivated prims of a layer, and copies of the layer in which a stage can write below them.

USD defines nothing below an inactive prim. So a stage that writes there works on a copy of the
layer in which its own prims are active, and marked.
"""

from collections.abc import Iterable
from typing import Final

from pxr import Sdf, Usd, UsdGeom

from openrooms_usd.usd.frames import TIME

_MARK: Final = "openrooms_deactivated"


def deactivations(layer: Sdf.Layer, roots: Iterable[str]) -> list[Sdf.PrimSpec]:
    """The prim specs of a layer, also those in variants, that deactivate a prim.

    Args:
        layer: Where to look.
        roots: Only specs at these prim paths and below them.
    """
    paths: list[Sdf.Path] = []
    layer.Traverse(Sdf.Path.absoluteRootPath, lambda path: paths.append(path))
    prefixes = [Sdf.Path(root) for root in roots]
    below = (
        path
        for path in sorted(paths)
        if any(path.StripAllVariantSelections().HasPrefix(prefix) for prefix in prefixes)
    )
    specs = (layer.GetPrimAtPath(path) for path in below if not path.IsPropertyPath())
    return [spec for spec in specs if spec is not None and not spec.active]


def reactivate(specs: Iterable[Sdf.PrimSpec]) -> None:
    """Take the deactivation of prim specs away, and leave a mark for `is_off`."""
    for spec in specs:
        spec.ClearActive()
        spec.customData[_MARK] = True


def is_deactivated(stage: Usd.Stage, path: str) -> bool:
    """Whether a prim, one above it or one below it is inactive."""
    prim = stage.GetPrimAtPath(path)
    if prim:
        return any(not part.IsActive() for part in Usd.PrimRange.AllPrims(prim))
    above = filter(None, map(stage.GetPrimAtPath, Sdf.Path(path).GetPrefixes()))
    return any(not prim.IsActive() for prim in above)


def is_off(prim: Usd.Prim) -> bool:
    """Whether a prim itself is deactivated, or was before `reactivate`, or is hidden."""
    if not prim or not prim.IsActive() or prim.GetCustomDataByKey(_MARK):
        return True
    shown = UsdGeom.Imageable(prim).GetVisibilityAttr()
    return bool(shown and shown.Get(TIME) == UsdGeom.Tokens.invisible)
