"""What things are called in the class lists of others: one table from our categories to each.

A class is known by its number, which is its position in the list; 0 is ``unlabeled`` in both.
"""

from typing import Final, NamedTuple

from openrooms_usd import names

UNLABELED: Final = "unlabeled"

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


class Classes(NamedTuple):
    """What one of our categories is in the lists of others."""

    openrooms45: str
    nyu40: str


# NYU40: as ScanNet's table of labels (scannetv2-labels.combined.tsv) files the same word, so that
# numbers agree with its label images; our side tables are its end tables, our rugs its rugs.
# OpenRooms: its class of the same name, or of what it rendered such models as; else unlabeled.
CLASSES: Final[dict[str, Classes]] = {
    "armchair": Classes("chair", "chair"),
    "bag": Classes("bag", "bag"),
    "basket": Classes("basket", "otherprop"),
    "bathtub": Classes("bathtub", "bathtub"),
    "bed": Classes("bed", "bed"),
    "bench": Classes("bench", "otherfurniture"),
    "bicycle": Classes("bike", "otherprop"),
    "bookshelf": Classes("bookshelf", "bookshelf"),
    "bottle": Classes("bottle", "otherprop"),
    "bowl": Classes("bowl", "otherprop"),
    "box": Classes(UNLABELED, "box"),
    "cabinet": Classes("cabinet", "cabinet"),
    "can": Classes("can", "otherprop"),
    "cap": Classes("cap", "otherprop"),
    "ceiling": Classes("ceiling", "ceiling"),
    "ceiling_lamp": Classes("lamp", "lamp"),
    "chair": Classes("chair", "chair"),
    "clock": Classes("clock", "otherprop"),
    "coffee_table": Classes("table", "table"),
    "counter": Classes("counter", "counter"),
    "curtain": Classes("curtain", "curtain"),
    "desk": Classes("desk", "desk"),
    "dishwasher": Classes("dishwasher", "otherstructure"),
    "door": Classes("door", "door"),
    "dresser": Classes("cabinet", "dresser"),
    "faucet": Classes("faucet", "otherprop"),
    "file_cabinet": Classes("file_cabinet", "cabinet"),
    "fireplace": Classes(UNLABELED, "otherstructure"),
    "floor": Classes("floor", "floor"),
    "floor_lamp": Classes("lamp", "lamp"),
    "guitar": Classes("guitar", "otherprop"),
    "jar": Classes("jar", "otherprop"),
    "keyboard": Classes("computer_keyboard", "otherprop"),
    "kitchen_cabinet": Classes("cabinet", "cabinet"),
    "lamp": Classes("lamp", "lamp"),
    "laptop": Classes("laptop", "otherprop"),
    "microwave": Classes("microwave", "otherprop"),
    "monitor": Classes("monitor", "otherprop"),
    "office_chair": Classes("chair", "chair"),
    "opening": Classes(UNLABELED, "otherstructure"),
    "oven": Classes(UNLABELED, "otherstructure"),
    "piano": Classes("piano", "otherfurniture"),
    "picture": Classes(UNLABELED, "picture"),
    "pillow": Classes("pillow", "pillow"),
    "plant_pot": Classes("flowerpot", "otherprop"),
    "pool_table": Classes("pool_table", "otherfurniture"),
    "printer": Classes("printer", "otherprop"),
    "refrigerator": Classes(UNLABELED, "refridgerator"),
    "rug": Classes(UNLABELED, "otherprop"),
    "shelf": Classes("bookshelf", "shelves"),
    "side_table": Classes("table", "table"),
    "sink": Classes(UNLABELED, "sink"),
    "sofa": Classes("sofa", "sofa"),
    "speaker": Classes("speaker", "otherprop"),
    "stairs": Classes(UNLABELED, "otherstructure"),
    "stool": Classes("chair", "otherprop"),
    "storage": Classes("cabinet", "cabinet"),
    "stove": Classes("stove", "otherstructure"),
    "table": Classes("table", "table"),
    "table_lamp": Classes("lamp", "lamp"),
    "telephone": Classes("telephone", "otherprop"),
    "television": Classes("monitor", "television"),
    "toilet": Classes(UNLABELED, "toilet"),
    "trash_bin": Classes("trash_bin", "otherfurniture"),
    "wall": Classes("wall", "wall"),
    "wall_lamp": Classes("lamp", "lamp"),
    "wardrobe": Classes("cabinet", "otherfurniture"),
    "washing_machine": Classes("washing_machine", "otherfurniture"),
    "whiteboard": Classes("whiteboard", "whiteboard"),
    "window": Classes("window", "window"),
}

TAXONOMIES: Final[dict[str, tuple[str, ...]]] = {
    names.OPENROOMS45: OPENROOMS45,
    names.NYU40: NYU40,
}
"""The closed class lists, by the name of their taxonomy."""


def class_of(category: str, taxonomy: str) -> str:
    """The class of one of our categories in a taxonomy.

    A word that is none of ours keeps its name where the taxonomy has it too.

    Args:
        category: Such as ``armchair``; any word will do.
        taxonomy: A key of `TAXONOMIES`.

    Returns:
        A member of the taxonomy's list; ``unlabeled`` where it has no class for it.
    """
    known = CLASSES.get(category)
    name: str = getattr(known, taxonomy) if known else category
    return name if name in TAXONOMIES[taxonomy] else UNLABELED


def number_of(name: str, taxonomy: str) -> int:
    """The number of a class; 0 where the taxonomy has none of that name."""
    classes = TAXONOMIES[taxonomy]
    return classes.index(name) if name in classes else 0
