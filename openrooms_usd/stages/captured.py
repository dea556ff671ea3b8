"""Captured boxes become objects: what the library builds for which label."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.capture import Capture, CapturedBox
from openrooms_usd.description.alignment import Placed
from openrooms_usd.description.naming import unique_names
from openrooms_usd.library.furniture import MAX_SIDE, MIN_SIDE, Size

# Captured heights are uncertain by some centimetres: what begins that near to the floor stands on
# it.
FLOOR_TOLERANCE: Final = 0.1


@dataclass(frozen=True)
class Substitute:
    """What the library makes for a captured label.

    Attributes:
        label: Our own name of what was captured.
        category: What is built: a category of the library or one of its stand-ins.
    """

    label: str
    category: str


# RoomPlan's categories (CapturedRoom.Object.Category).
SUBSTITUTES: Final = {
    "bathtub": Substitute("bathtub", "basin"),
    "bed": Substitute("bed", "bed"),
    "chair": Substitute("chair", "chair"),
    "dishwasher": Substitute("dishwasher", "fridge"),
    "fireplace": Substitute("fireplace", "fireplace"),
    "oven": Substitute("stove", "oven"),
    "refrigerator": Substitute("refrigerator", "fridge"),
    "sink": Substitute("sink", "basin"),
    "sofa": Substitute("sofa", "sofa"),
    "stairs": Substitute("stairs", "stairs"),
    "storage": Substitute("cabinet", "cabinet"),
    "stove": Substitute("stove", "oven"),
    "table": Substitute("table", "table"),
    "television": Substitute("television", "screen"),
    "toilet": Substitute("toilet", "toilet"),
    "washerDryer": Substitute("washing_machine", "washer"),
}


@dataclass(frozen=True)
class Captured:
    """A captured box as an object.

    Attributes:
        name: Its prim name: the label and its number in the capture.
        box: Where it came from.
        substitute: What is built for it.
        size: Width, depth and height, metres.
        base: (3,) middle of its base, metres.
        yaw: Degrees, counter-clockwise from above.
        on_floor: Whether it stands on the floor.
    """

    name: str
    box: CapturedBox
    substitute: Substitute
    size: Size
    base: tuple[float, float, float]
    yaw: float
    on_floor: bool


def captured_objects(
    capture: Capture, floor: float, described: Sequence[Placed], notes: list[str]
) -> list[Captured]:
    """All boxes of a capture as objects, in the capture's order.

    Args:
        capture: What was captured; metres, Z up.
        floor: Height of the room's floor, metres.
        described: The objects of the description, whose names are not used again.
        notes: Receives a sentence for each label that has no category of its own.
    """
    substitutes = [_substitute(box, notes) for box in capture.boxes]
    given = ((thing.name, thing.category) for thing in described)
    numbered = unique_names([*((None, one.label) for one in substitutes), *given])
    return [
        _object(name, box, substitute, floor)
        for name, box, substitute in zip(numbered, capture.boxes, substitutes, strict=False)
    ]


def _substitute(box: CapturedBox, notes: list[str]) -> Substitute:
    found = SUBSTITUTES.get(box.label)
    if found is None:
        notes.append(f"captured {box.label!r} is unknown: a cabinet fills its box")
        return Substitute("cabinet", "cabinet")
    if found.label != found.category:
        notes.append(f"captured {box.label!r}: a plain {found.category} fills its box")
    return found


def _object(name: str, box: CapturedBox, substitute: Substitute, floor: float) -> Captured:
    # Millimetres: repeats of one thing become equal, and then share an asset.
    width, depth, height = np.clip(np.round(box.size, 3), MIN_SIDE, MAX_SIDE).tolist()
    right = box.rotation[:, 0]
    x, y, middle = np.asarray(box.center, dtype=np.float64).tolist()
    z = middle - 0.5 * height
    on_floor = abs(z - floor) < FLOOR_TOLERANCE
    yaw = float(np.degrees(np.arctan2(right[1], right[0])))
    base = (x, y, floor if on_floor else z)
    return Captured(name, box, substitute, (width, depth, height), base, yaw, on_floor)
