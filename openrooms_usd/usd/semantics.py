"""Semantic labels of prims, in our own categories and in OpenRooms' 45 classes."""

from typing import Final

from pxr import Usd, UsdSemantics

from openrooms_usd import names

# The class list of the released dataset; the position is the number in its label images.
OPENROOMS45: Final = (
    "unlabeled", "curtain", "bike", "washing_machine", "table", "desk", "pool_table", "counter",
    "dishwasher", "bowl", "bookshelf", "sofa", "speaker", "trash_bin", "piano", "guitar", "pillow",
    "jar", "bed", "bottle", "clock", "chair", "computer_keyboard", "monitor", "whiteboard",
    "bathtub", "stove", "microwave", "file_cabinet", "flowerpot", "cap", "window", "lamp",
    "telephone", "printer", "basket", "faucet", "bag", "laptop", "can", "bench", "door", "cabinet",
    "wall", "floor", "ceiling",
)  # fmt: skip

# Our categories that have another name there; a category that stands in neither is unlabeled.
_SYNONYMS: Final = {
    "armchair": "chair",
    "ceiling_lamp": "lamp",
    "coffee_table": "table",
    "dresser": "cabinet",
    "floor_lamp": "lamp",
    "keyboard": "computer_keyboard",
    "kitchen_cabinet": "cabinet",
    "office_chair": "chair",
    "plant_pot": "flowerpot",
    "shelf": "bookshelf",
    "side_table": "table",
    "storage": "cabinet",
    "stool": "chair",
    "table_lamp": "lamp",
    "television": "monitor",
    "wall_lamp": "lamp",
    "wardrobe": "cabinet",
}


def openrooms45(category: str) -> str:
    """The OpenRooms class of one of our categories; ``unlabeled`` where it has none."""
    name = _SYNONYMS.get(category, category)
    return name if name in OPENROOMS45 else OPENROOMS45[0]


def label(prim: Usd.Prim, category: str) -> None:
    """Label a prim with its category and its OpenRooms class."""
    _author(prim, names.CATEGORY, category)
    _author(prim, names.OPENROOMS45, openrooms45(category))


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
        if values:
            return str(values[0])
        prim = prim.GetParent()
    return None
