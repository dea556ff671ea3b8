"""Our categories in the class lists of others.

Which classes a category has stands in its record. NYU40: as ScanNet's table of labels
(scannetv2-labels.combined.tsv) files the same word, so that numbers agree with its label images;
our side tables are its end tables, our rugs its rugs. OpenRooms: its class of the same name, or of
what it rendered such models as; else unlabeled. A class is known by its number, which is its
position in the list; 0 is ``unlabeled`` in both.
"""

from functools import cache
from typing import Final

from openrooms_usd import names
from openrooms_usd.categories.record import UNLABELED, Classes
from openrooms_usd.categories.registry import record, records

# The class list of the released dataset; the position is the number in its label images.
OPENROOMS45: Final = (
    UNLABELED, "curtain", "bike", "washing_machine", "table", "desk", "pool_table", "counter",
    "dishwasher", "bowl", "bookshelf", "sofa", "speaker", "trash_bin", "piano", "guitar", "pillow",
    "jar", "bed", "bottle", "clock", "chair", "computer_keyboard", "monitor", "whiteboard",
    "bathtub", "stove", "microwave", "file_cabinet", "flowerpot", "cap", "window", "lamp",
    "telephone", "printer", "basket", "faucet", "bag", "laptop", "can", "bench", "door", "cabinet",
    "wall", "floor", "ceiling",
)  # fmt: skip

# The 37 frequent structures and objects of NYU Depth V2 and the three bins for all others, in the
# order of Gupta, Arbelaez and Malik, "Perceptual Organization and Recognition of Indoor Scenes from
# RGB-D Images", CVPR 2013 (classMapping40), in their spelling; spaces are underscores.
NYU40: Final = (
    UNLABELED, "wall", "floor", "cabinet", "bed", "chair", "sofa", "table", "door", "window",
    "bookshelf", "picture", "counter", "blinds", "desk", "shelves", "curtain", "dresser", "pillow",
    "mirror", "floor_mat", "clothes", "ceiling", "books", "refridgerator", "television", "paper",
    "towel", "shower_curtain", "box", "whiteboard", "person", "night_stand", "toilet", "sink",
    "lamp", "bathtub", "bag", "otherstructure", "otherfurniture", "otherprop",
)  # fmt: skip


TAXONOMIES: Final[dict[str, tuple[str, ...]]] = {
    names.OPENROOMS45: OPENROOMS45,
    names.NYU40: NYU40,
}
"""The closed class lists, by the name of their taxonomy."""


@cache
def classes() -> dict[str, Classes]:
    """What each of our categories is in those lists, by name; without what no list classifies."""
    known = {name: told.classes for name, told in records()}
    return {name: row for name, row in sorted(known.items()) if isinstance(row, Classes)}


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
    name: str = category
    if known is not None and isinstance(known.classes, Classes):
        name = getattr(known.classes, taxonomy)
    return name if name in TAXONOMIES[taxonomy] else UNLABELED


def number_of(name: str, taxonomy: str) -> int:
    """The number of a class; 0 where the taxonomy has none of that name."""
    classes = TAXONOMIES[taxonomy]
    return classes.index(name) if name in classes else 0
