"""What the library builds for a box of a capture: by its word, its attributes and its height."""

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.furniture import category
from openrooms_usd.furniture.registry import BUILT
from openrooms_usd.furniture.words import category_of, meaning, plain
from openrooms_usd.scan.registration.scalelimits import SCALES

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


def of_size(found: str, label: str, above_floor: float, size: NDArray[np.float64]) -> str | None:
    """What the library builds in place of a category whose things never have some size.

    Args:
        found: The category.
        label: The source's word for it.
        above_floor: How high it begins above the floor, metres.
        size: (3,) width, depth and height, metres; which side is the front may not be known.

    Returns:
        The category itself where they may, or another that is near in use; None for neither.
    """
    groups = meaning((label,), above_floor).choices
    kinds = (found, *(kind for group in groups for kind in group))
    return next((kind for kind in kinds if kind in BUILT and _may_have(kind, size)), None)


def sizes_of(name: str) -> NDArray[np.float64]:
    """(2, 3) the least and the greatest size of what the library builds, metres."""
    spec = category(name)
    return np.asarray(np.array([spec.min_size, spec.max_size]) * np.array(SCALES)[:, None])


def _may_have(name: str, size: NDArray[np.float64]) -> bool:
    least, most = sizes_of(name)
    # How deep things are is measured worst: screens and pictures have next to no depth.
    both = [one for one in (size, size[[1, 0, 2]]) if (one <= most).all()]
    return any(bool(one[0] >= least[0] and one[2] >= least[2]) for one in both)
