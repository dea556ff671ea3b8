"""Captured boxes become objects: what the library builds, where, and under which name."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.capture import Capture, CapturedBox
from openrooms_usd.description.furniture import PlacedObject, named_objects
from openrooms_usd.description.naming import captured_names
from openrooms_usd.furniture import MAX_SIDE, MIN_SIDE, Size, category
from openrooms_usd.furniture.registry import BUILT
from openrooms_usd.furniture.words import category_of, meaning, plain
from openrooms_usd.scan.registration.scalelimits import SCALES

# Captured heights are uncertain by some centimetres: boxes this near to the floor stand on it.
FLOOR_TOLERANCE: Final = 0.1
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


@dataclass(frozen=True)
class Captured:
    """A captured box as an object.

    Attributes:
        name: Its prim name: the label and what identifies it in the capture.
        box: Where it came from.
        category: What the library builds for it.
        label: What it is: the category, or the source's own word where there is none for it.
        size: Width, depth and height, metres.
        base: (3,) middle of its base, metres.
        yaw: Degrees, counter-clockwise from above.
        on_floor: Whether it stands on the floor.
    """

    name: str
    box: CapturedBox
    category: str
    label: str
    size: Size
    base: tuple[float, float, float]
    yaw: float
    on_floor: bool


def captured_objects(
    capture: Capture, floor: float, described: Sequence[PlacedObject], notes: list[str]
) -> list[Captured]:
    """All boxes of a capture as objects, in the capture's order.

    Args:
        capture: What was captured; metres, Z up.
        floor: Height of the room's floor, metres.
        described: The objects of the description, whose names stay theirs.
        notes: Receives a sentence for each label that the library has nothing for.
    """
    kinds = [_kind(box, floor) for box in capture.boxes]
    modelled = {model.id for model in capture.models if model.file}
    boxed = {
        (box.label, label)
        for box, (made, label) in zip(capture.boxes, kinds, strict=True)
        if not made and box.id not in modelled
    }
    for word, label in sorted(boxed):
        known = category_of(label, 0.0) is not None
        why = "has an impossible size for its category" if known else "is unknown"
        notes.append(f"captured {word!r} {why}: a box stands for it")
    taken = {name for name, _ in named_objects(described)}
    labels = [(label, box.id) for box, (_, label) in zip(capture.boxes, kinds, strict=True)]
    return [
        _object(name, box, made or UNKNOWN, label, floor)
        for name, box, (made, label) in zip(
            captured_names(labels, taken), capture.boxes, kinds, strict=True
        )
    ]


def _kind(box: CapturedBox, floor: float) -> tuple[str | None, str]:
    """What the library builds for a box, if it knows it, and what it is called."""
    bottom = float(box.center[2] - 0.5 * box.size[2]) - floor
    found = substitute(box.label, box.attributes, bottom)
    possible = found and of_size(found, box.label, bottom, box.size)
    return possible, possible or found or plain(box.label)


def _object(name: str, box: CapturedBox, category: str, label: str, floor: float) -> Captured:
    # Rounded to millimetres: repeats of one object become equal, and then share an asset.
    width, depth, height = np.clip(np.round(box.size, 3), MIN_SIDE, MAX_SIDE).tolist()
    right = box.rotation[:, 0]
    x, y, middle = np.asarray(box.center, dtype=np.float64).tolist()
    z = middle - 0.5 * height
    on_floor = abs(z - floor) < FLOOR_TOLERANCE
    yaw = float(np.degrees(np.arctan2(right[1], right[0])))
    base = (x, y, floor if on_floor else z)
    return Captured(name, box, category, label, (width, depth, height), base, yaw, on_floor)


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
