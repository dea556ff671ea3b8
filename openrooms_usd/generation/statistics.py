"""What generated rooms are like in numbers, for tables beside those of other data sets."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from openrooms_usd.generation.floor import floor_of
from openrooms_usd.generation.rooms import Generated


@dataclass(frozen=True)
class RoomNumbers:
    """One room.

    Attributes:
        room_type: One of the 27.
        area: Of the floor, square metres.
        objects: How many there are, lamps and what hangs on walls included.
        free: Share of the floor that nothing stands on or hangs low over.
        classes: How many objects there are of each category.
    """

    room_type: str
    area: float
    objects: int
    free: float
    classes: Counter[str]


def numbers(room: Generated) -> RoomNumbers:
    """Measure a room; the free floor on a grid of 5 cm."""
    items = [item for _, group in room.furnishing.groups for item in group]
    empty = floor_of(room.shell)
    filled = empty.with_boxes(np.array([item.box for item in items]).reshape(-1, 8))
    free = int((filled.clear > 0.0).sum()) / max(1, int((empty.clear > 0.0).sum()))
    classes = Counter(item.category for item in items)
    return RoomNumbers(room.room_type, room.shell.area, len(items), free, classes)


def summary(rooms: Iterable[RoomNumbers], common: int = 6) -> dict[str, float | int | str]:
    """Means over some rooms, and the categories that there are most of.

    Args:
        rooms: At least one.
        common: How many categories to name, each with its mean number in a room.
    """
    rows = list(rooms)
    total: Counter[str] = sum((row.classes for row in rows), Counter())
    first = total.most_common(common)
    return {
        "rooms": len(rows),
        "area_m2": float(np.mean([row.area for row in rows])),
        "least_m2": float(np.min([row.area for row in rows])),
        "most_m2": float(np.max([row.area for row in rows])),
        "objects": float(np.mean([row.objects for row in rows])),
        "classes": len(total),
        "free_floor": float(np.mean([row.free for row in rows])),
        "most_common": ", ".join(f"{name} {count / len(rows):.1f}" for name, count in first),
    }
