"""ShapeNet's synsets under the names of our own categories, or under plain words."""

from functools import cache
from typing import Final

from openrooms_usd.furniture.registry import records

# What ShapeNetCore has besides our categories. WordNet 3.0 offsets of noun synsets, as ShapeNetCore
# and Scan2CAD name their folders.
_OTHERS: Final = {
    "02691156": "airplane",
    "02942699": "camera",
    "02958343": "car",
    "03261776": "earphone",
    "03513137": "helmet",
    "03624134": "knife",
    "03710193": "mailbox",
    "03759954": "microphone",
    "03797390": "mug",
    "04099429": "rocket",
    "04225987": "skateboard",
    "04460130": "tower",
    "04468005": "train",
    "04530566": "watercraft",
}
UNKNOWN: Final = "object"


@cache
def categories() -> dict[str, str]:
    """A category or a plain word by its synset."""
    ours = {synset: name for name, told in records() for synset in told.synsets}
    return {**_OTHERS, **ours}
