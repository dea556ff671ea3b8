"""Our categories in the class lists of others.

Which classes a category has stands in its record. NYU40: as ScanNet's table of labels
(scannetv2-labels.combined.tsv) files the same word, so that numbers agree with its label images;
our side tables are its end tables, our rugs its rugs. OpenRooms: its class of the same name, or of
what it rendered such models as; else unlabeled. ADE20K and COCO: the class that the thing is by the
class's own words, and else unlabeled; what is several of COCO's at once, as cutlery is, is so too.
A class is known by its number; 0 is ``unlabeled`` in all.
"""

from functools import cache
from typing import Final

from pxr import Usd, UsdSemantics, Vt

from openrooms_usd import names
from openrooms_usd.furniture.record import UNLABELED, Classes
from openrooms_usd.furniture.registry import record, records
from openrooms_usd.tables import read_table

_TABLES: Final = read_table(__file__, "semantics.toml")
OPENROOMS45: Final[tuple[str, ...]] = _TABLES["openrooms45"]
NYU40: Final[tuple[str, ...]] = _TABLES["nyu40"]
ADE20K: Final[tuple[str, ...]] = _TABLES["ade20k"]
COCO_GROUPS: Final[dict[str, dict[str, int]]] = _TABLES["coco"]
"""Numbers of COCO's classes by their supercategories."""
COCO: Final = {0: UNLABELED} | dict(
    sorted((number, name) for group in COCO_GROUPS.values() for name, number in group.items())
)

TAXONOMIES: Final[dict[str, dict[int, str]]] = {
    names.OPENROOMS45: dict(enumerate(OPENROOMS45)),
    names.NYU40: dict(enumerate(NYU40)),
    names.ADE20K: dict(enumerate(ADE20K)),
    names.COCO: COCO,
}
"""The names of closed class lists by their numbers, by the name of their taxonomy."""

_NUMBERS: Final = {
    taxonomy: {name: number for number, name in listed.items()}
    for taxonomy, listed in TAXONOMIES.items()
}


@cache
def classes() -> dict[str, Classes]:
    """What each of our categories is in those lists, by name."""
    return {name: told.classes for name, told in sorted(records())}


def class_of(category: str, taxonomy: str) -> str:
    """The class of one of our categories in a taxonomy.

    A word that is none of ours keeps its name where the taxonomy has it too.

    Args:
        category: Such as ``armchair``; any word will do.
        taxonomy: A key of `TAXONOMIES`.

    Returns:
        A member of the taxonomy's list; ``unlabeled`` where it has no class for it.
    """
    known = record(category)
    name: str = category if known is None else getattr(known.classes, taxonomy)
    return name if name in _NUMBERS[taxonomy] else UNLABELED


def number_of(name: str, taxonomy: str) -> int:
    """The number of a class; 0 where the taxonomy has none of that name."""
    return _NUMBERS[taxonomy].get(name, 0)


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
