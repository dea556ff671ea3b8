"""What the library builds for the words of captures: RoomPlan, ScanNet, Scan2CAD and plain ones.

The words stand in the records of the categories: those of Apple's RoomPlan, the classes of NYU40
and SUN RGB-D, the raw names of ScanNet and the names of ShapeNet's synsets, as those data sets
spell them.
"""

import re
from collections.abc import Mapping
from functools import cache
from typing import Final

from openrooms_usd.categories.record import given
from openrooms_usd.categories.registry import BUILT, records

UNKNOWN: Final = "box"
"""The category that stands for what the library has nothing for."""


@cache
def substitutes() -> dict[str, str]:
    """The library's category by a captured word in plain form: its own name, and other words."""
    built = {name: told for name, told in records() if name in BUILT}
    words = {word: name for name, told in built.items() for word in given(told.words, "").split()}
    return {**{name: name for name in built}, **words}


# RoomPlan's attributes that say more than the category (CapturedRoom.Object.attributes).
_CLOSER: Final[dict[tuple[str, str, str], str]] = {
    ("chair", "chair_type", "swivel"): "office_chair",
    ("chair", "chair_type", "stool"): "stool",
    ("sofa", "sofa_type", "single_seat"): "armchair",
    ("storage", "storage_type", "shelf"): "bookshelf",
    ("table", "table_type", "coffee"): "coffee_table",
    ("table", "table_type", "desk"): "desk",
}
# A lamp that begins so high above the floor hangs, and so low stands on it, metres.
_HANGS, _STANDS = 1.5, 0.1


def plain(word: str) -> str:
    """A word in lower case with underscores: ``washer_dryer`` for ``washerDryer``.

    It is a valid prim name, also where nothing of the word is left.
    """
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", word)
    name = re.sub(r"[^a-z0-9]+", "_", apart.lower()).strip("_")
    return name if name[:1].isalpha() else f"thing_{name}".rstrip("_")


def substitute(label: str, attributes: Mapping[str, str], above_floor: float) -> str | None:
    """What the library builds for a captured thing.

    Args:
        label: The source's word for it.
        attributes: What the source knows besides.
        above_floor: How high it begins above the floor, metres.

    Returns:
        A category of the library; None when it has nothing for it.
    """
    word = plain(label)
    if word in ("lamp", "light", "lighting"):
        if above_floor > _HANGS:
            return "ceiling_lamp"
        return "floor_lamp" if above_floor < _STANDS else "table_lamp"
    closer = (_CLOSER.get((word, plain(key), plain(value))) for key, value in attributes.items())
    return next((category for category in closer if category), None) or substitutes().get(word)
