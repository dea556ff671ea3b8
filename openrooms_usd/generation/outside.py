"""Where a generated room lies: what stands before its windows, and how high up it is."""

import math
from typing import Any, Final

import numpy as np

from openrooms_usd.draws import generator
from openrooms_usd.generation.rooms import Generated
from openrooms_usd.generation.shell import Gap
from openrooms_usd.library.styles.assignment.weights import drawn

# How often a room stands in each kind of place, and how high up; homes and what is in towns.
_HOMES: Final = {"street": 4.0, "garden": 4.0, "hills": 1.5, "city": 1.5, "courtyard": 0.7}
_TOWN: Final = {"street": 1.5, "garden": 0.7, "hills": 0.3, "city": 4.0, "courtyard": 2.0}
_IN_TOWNS: Final = frozenset(
    {
        "hotel", "bookstore", "library", "classroom", "computer_cluster", "conference_room",
        "copy_room", "mail_room", "gym", "lobby", "office", "stairs",
    }
)  # fmt: skip
_UPSTAIRS: Final = frozenset(["bedroom", "bathroom", "closet"])
_BELOW: Final = frozenset(["garage", "basement", "lobby", "bookstore"])
# How high houses and trees stand before most of the sky, degrees: a lower sun seldom shines in.
_SKYLINE_DEG: Final = {
    "street": 18.0,
    "garden": 12.0,
    "hills": 0.0,
    "city": 28.0,
    "courtyard": 32.0,
}
# The part of the sky that clouds cover.
_CLOUDS: Final = (0.0, 0.5)
# A window that reaches lower than this opens onto the land, metres.
_LOW_SILL_M: Final = 0.3


def place(room: Generated, sun: float | None = None) -> dict[str, Any]:
    """What lies before the windows of a generated room: keys of its ``lights.environment``.

    Args:
        room: The room.
        sun: How high the sun stands that shall shine in, degrees; None where none shall.
    """
    rng = generator(room.seed, "generate", room.room_type, "outside")
    weights = _TOWN if room.room_type in _IN_TOWNS else _HOMES
    if sun is not None:
        weights = {name: weight for name, weight in weights.items() if _SKYLINE_DEG[name] < sun}
    scene = drawn(rng, weights or {"hills": 1.0})
    return {
        "scene": scene,
        "storey": _storey(rng, room, scene),
        "facing": _front(room),
        "clouds": round(float(rng.uniform(*_CLOUDS)), 2),
    }


def _storey(rng: np.random.Generator, room: Generated, scene: str) -> int:
    low = any(gap.kind == "window" and gap.sill < _LOW_SILL_M for gap in room.shell.gaps)
    if room.room_type in _BELOW or (low and scene not in ("city", "courtyard")):
        return 0
    if scene in ("city", "courtyard"):
        return int(rng.integers(1, 4))
    return int(rng.random() < (0.75 if room.room_type in _UPSTAIRS else 0.3))


def _front(room: Generated) -> float:
    """Degrees counter-clockwise from +X: outwards through the wall with most glass."""

    def glass(index: int) -> float:
        gaps = [gap for gap in room.shell.gaps if gap.side == index]
        return sum(_area(gap) * (1.0 if gap.kind == "window" else 0.1) for gap in gaps)

    sides = room.shell.sides
    outward = -sides[max(range(len(sides)), key=glass)].inward
    return round(math.degrees(math.atan2(outward[1], outward[0])) % 360.0, 1) % 360.0


def _area(gap: Gap) -> float:
    return gap.width * (gap.top - gap.sill)
