"""Semantic labels of prims: our own categories and parts, and the class lists of others."""

from pxr import Usd, UsdSemantics, Vt

from openrooms_usd import names
from openrooms_usd.usd.taxonomies import TAXONOMIES, class_of, number_of


def label(prim: Usd.Prim, category: str) -> None:
    """Label a prim with its category and its class in every taxonomy."""
    _author(prim, names.CATEGORY, category)
    for taxonomy in TAXONOMIES:
        _author(prim, taxonomy, class_of(category, taxonomy))


def label_part(prim: Usd.Prim, part: str) -> None:
    """Label a mesh of an object with the semantic part that it is."""
    _author(prim, names.PART, part)


def _author(prim: Usd.Prim, taxonomy: str, value: str) -> None:
    UsdSemantics.LabelsAPI.Apply(prim, taxonomy).CreateLabelsAttr([value])


def read_label(prim: Usd.Prim, taxonomy: str) -> str | None:
    """The nearest label of a taxonomy on a prim or above it; None where there is none."""
    while prim and not prim.IsPseudoRoot():
        labels = UsdSemantics.LabelsAPI(prim, taxonomy)
        values = labels.GetLabelsAttr().Get() if labels else None
        # A layer of others may have written anything under this name.
        if isinstance(values, Vt.TokenArray) and len(values):
            return str(values[0])
        prim = prim.GetParent()
    return None


def read_number(prim: Usd.Prim, taxonomy: str) -> int:
    """The number of a prim's class: as it is labelled, or else as its category says.

    Args:
        prim: The prim; labels above it count too.
        taxonomy: A key of `TAXONOMIES`.

    Returns:
        The number; 0 for what has no class in the taxonomy.
    """
    label = read_label(prim, taxonomy)
    return number_of(label or class_of(read_label(prim, names.CATEGORY) or "", taxonomy), taxonomy)
