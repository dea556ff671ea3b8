"""What the library builds for a box of a capture: by its word, its attributes and its height."""

from collections.abc import Mapping
from typing import Final

from openrooms_usd.categories.words import category_of, plain

UNKNOWN: Final = "box"
"""The category that stands for what the library has nothing for."""

# RoomPlan's attributes that say more than the category (CapturedRoom.Object.attributes).
_CLOSER: Final[dict[tuple[str, str, str], str]] = {
    ("chair", "chair_type", "swivel"): "office_chair",
    ("chair", "chair_type", "stool"): "stool",
    ("sofa", "sofa_type", "single_seat"): "armchair",
    ("storage", "storage_type", "shelf"): "bookshelf",
    ("table", "table_type", "coffee"): "coffee_table",
    ("table", "table_type", "desk"): "desk",
}


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
    closer = (_CLOSER.get((word, plain(key), plain(value))) for key, value in attributes.items())
    found = next((category for category in closer if category), None)
    return found or category_of(label, above_floor)
