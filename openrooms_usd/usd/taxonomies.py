"""Our categories in the class lists of others.

Which classes a category has stands in its record. NYU40: as ScanNet's table of labels
(scannetv2-labels.combined.tsv) files the same word, so that numbers agree with its label images;
our side tables are its end tables, our rugs its rugs. OpenRooms: its class of the same name, or of
what it rendered such models as; else unlabeled. ADE20K and COCO: the class that the thing is by the
class's own words, and else unlabeled; what is several of COCO's at once, as cutlery is, is so too.
A class is known by its number; 0 is ``unlabeled`` in all.
"""

from typing import Final

from openrooms_usd import names
from openrooms_usd.codedigest import remembered
from openrooms_usd.furniture.record import UNLABELED, Classes
from openrooms_usd.furniture.registry import record, records

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

# The 150 classes of Zhou et al., "Scene Parsing through ADE20K Dataset", CVPR 2017, in the order
# of objectInfo150, each by one of its words; 0 is all else in its label images.
ADE20K: Final = (
    UNLABELED, "wall", "building", "sky", "floor", "tree", "ceiling", "road", "bed", "windowpane",
    "grass", "cabinet", "sidewalk", "person", "earth", "door", "table", "mountain", "plant",
    "curtain", "chair", "car", "water", "painting", "sofa", "shelf", "house", "sea", "mirror",
    "rug", "field", "armchair", "seat", "fence", "desk", "rock", "wardrobe", "lamp", "bathtub",
    "railing", "cushion", "base", "box", "column", "signboard", "chest_of_drawers", "counter",
    "sand", "sink", "skyscraper", "fireplace", "refrigerator", "grandstand", "path", "stairs",
    "runway", "case", "pool_table", "pillow", "screen_door", "stairway", "river", "bridge",
    "bookcase", "blind", "coffee_table", "toilet", "flower", "book", "hill", "bench", "countertop",
    "stove", "palm", "kitchen_island", "computer", "swivel_chair", "boat", "bar", "arcade_machine",
    "hovel", "bus", "towel", "light", "truck", "tower", "chandelier", "awning", "streetlight",
    "booth", "television_receiver", "airplane", "dirt_track", "apparel", "pole", "land",
    "bannister", "escalator", "ottoman", "bottle", "buffet", "poster", "stage", "van", "ship",
    "fountain", "conveyer_belt", "canopy", "washer", "plaything", "swimming_pool", "stool",
    "barrel", "basket", "waterfall", "tent", "bag", "minibike", "cradle", "oven", "ball", "food",
    "step", "tank", "trade_name", "microwave", "pot", "animal", "bicycle", "lake", "dishwasher",
    "screen", "blanket", "sculpture", "hood", "sconce", "vase", "traffic_light", "tray", "ashcan",
    "fan", "pier", "crt_screen", "plate", "monitor", "bulletin_board", "shower", "radiator",
    "glass", "clock", "flag",
)  # fmt: skip

# The 80 things of Lin et al., "Microsoft COCO", ECCV 2014, by the numbers of its annotations, of
# which ten up to 90 were never used.
COCO: Final = {
    0: UNLABELED, 1: "person", 2: "bicycle", 3: "car", 4: "motorcycle", 5: "airplane", 6: "bus",
    7: "train", 8: "truck", 9: "boat", 10: "traffic_light", 11: "fire_hydrant", 13: "stop_sign",
    14: "parking_meter", 15: "bench", 16: "bird", 17: "cat", 18: "dog", 19: "horse", 20: "sheep",
    21: "cow", 22: "elephant", 23: "bear", 24: "zebra", 25: "giraffe", 27: "backpack",
    28: "umbrella", 31: "handbag", 32: "tie", 33: "suitcase", 34: "frisbee", 35: "skis",
    36: "snowboard", 37: "sports_ball", 38: "kite", 39: "baseball_bat", 40: "baseball_glove",
    41: "skateboard", 42: "surfboard", 43: "tennis_racket", 44: "bottle", 46: "wine_glass",
    47: "cup", 48: "fork", 49: "knife", 50: "spoon", 51: "bowl", 52: "banana", 53: "apple",
    54: "sandwich", 55: "orange", 56: "broccoli", 57: "carrot", 58: "hot_dog", 59: "pizza",
    60: "donut", 61: "cake", 62: "chair", 63: "couch", 64: "potted_plant", 65: "bed",
    67: "dining_table", 70: "toilet", 72: "tv", 73: "laptop", 74: "mouse", 75: "remote",
    76: "keyboard", 77: "cell_phone", 78: "microwave", 79: "oven", 80: "toaster", 81: "sink",
    82: "refrigerator", 84: "book", 85: "clock", 86: "vase", 87: "scissors", 88: "teddy_bear",
    89: "hair_drier", 90: "toothbrush",
}  # fmt: skip

# The supercategories of its files, and whose they are.
COCO_GROUPS: Final = {
    "person": "person",
    "vehicle": "bicycle car motorcycle airplane bus train truck boat",
    "outdoor": "traffic_light fire_hydrant stop_sign parking_meter bench",
    "animal": "bird cat dog horse sheep cow elephant bear zebra giraffe",
    "accessory": "backpack umbrella handbag tie suitcase",
    "sports": "frisbee skis snowboard sports_ball kite baseball_bat baseball_glove skateboard "
    "surfboard tennis_racket",
    "kitchen": "bottle wine_glass cup fork knife spoon bowl",
    "food": "banana apple sandwich orange broccoli carrot hot_dog pizza donut cake",
    "furniture": "chair couch potted_plant bed dining_table toilet",
    "electronic": "tv laptop mouse remote keyboard cell_phone",
    "appliance": "microwave oven toaster sink refrigerator",
    "indoor": "book clock vase scissors teddy_bear hair_drier toothbrush",
}


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


@remembered
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
