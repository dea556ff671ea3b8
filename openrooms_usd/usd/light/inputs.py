"""Inputs of lights, also by the names that they had before USD 21.02: without ``inputs:``.

USD itself ignores the old names, and a light that has only these gets USD's fallbacks: white, 1 nit
and the default size. What people see in the file is the light that they mean.
"""

from functools import cache
from typing import Final

from pxr import Usd, UsdGeom

OLD: Final = "names of before USD 21.02"
"""How the report says that a light has `old_names`."""

_PREFIX: Final = "inputs:"
_BESIDE: Final = ("ShapingAPI", "ShadowAPI")
_FILTERS: Final = "filters"


def light_input(prim: Usd.Prim, name: str) -> Usd.Attribute:
    """The attribute that says an input of a light: its own, or one of before USD 21.02.

    Args:
        prim: The light.
        name: As it is today, such as ``inputs:intensity``.
    """
    attribute = prim.GetAttribute(name)
    if attribute and (attribute.HasAuthoredValue() or attribute.HasAuthoredConnections()):
        return attribute
    old = name.removeprefix(_PREFIX)
    return prim.GetAttribute(old) if old in old_names(prim) else attribute


def old_names(prim: Usd.Prim) -> tuple[str, ...]:
    """The inputs of a light that are read by their names of before USD 21.02."""
    # Shapes were not lights then, and their own sizes have such names.
    if prim.IsA(UsdGeom.Gprim):
        return ()
    known = _inputs(prim.GetTypeName())
    authored = set(prim.GetAuthoredPropertyNames())
    return tuple(sorted(name for name in known & authored if _PREFIX + name not in authored))


def has_filters(prim: Usd.Prim) -> bool:
    """Whether light filters are bound to a light, by the name of today or of before USD 21.02."""
    rows = (prim.GetRelationship(f"light:{_FILTERS}"), prim.GetRelationship(_FILTERS))
    return any(row and row.GetTargets() for row in rows)


@cache
def _inputs(kind: str) -> frozenset[str]:
    """The inputs that a kind of light may have, without the prefix."""
    registry = Usd.SchemaRegistry()
    own = registry.FindConcretePrimDefinition(kind)
    beside = [registry.FindAppliedAPIPrimDefinition(api) for api in _BESIDE]
    return frozenset(
        name.removeprefix(_PREFIX)
        for one in (own, *beside)
        if one
        for name in one.GetPropertyNames()
        if name.startswith(_PREFIX)
    )
