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

from openrooms_usd import names
from openrooms_usd.categories.record import UNLABELED, Classes
from openrooms_usd.categories.registry import record, records
from openrooms_usd.tables import read_table

_TABLES: Final = read_table(__file__, "taxonomies.toml")
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
