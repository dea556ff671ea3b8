"""How unlike generated rooms and the things in them are: shares of equal pieces.

Rooms are generated alone, with nothing composed. Two things are equal where their category, their
style and their size to the centimetre are. What a room has one make of by its record (chairs,
sockets) does not count.
"""

import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np

from benchmarks.report import publish, table
from openrooms_usd.furniture import category
from openrooms_usd.generation import generate
from openrooms_usd.generation.items import Item
from openrooms_usd.generation.programs import PROGRAMS
from openrooms_usd.generation.rooms import USUAL_CLUTTER

# Neighbours on one top are so near to each other, metres, and turned alike to so many degrees.
_NEAR_M, _ALIKE_DEG = 0.3, 3.0


Things = Sequence[Item]
"""All that is in a room."""


@click.command(help=__doc__)
@click.option("--rooms", type=int, default=216, show_default=True, help="How many are made.")
@click.option("--seed", type=int, default=0, show_default=True, help="Of the first rooms.")
@click.option("--quick", is_flag=True, help="Four rooms only.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(rooms: int, seed: int, quick: bool, target: Path | None) -> None:
    kinds = list(PROGRAMS)
    wanted = [(kinds[i % len(kinds)], seed + i // len(kinds)) for i in range(4 if quick else rooms)]
    with click.progressbar(wanted, file=sys.stderr) as todo:
        seen = [_seen(room_type, number) for room_type, number in todo]
    data = {"rooms": len(seen), **measured(seen)}
    text = table(("what", "value"), [list(row) for row in data.items()])
    publish("variety", data, text, target)


def _seen(room_type: str, seed: int) -> Things:
    room = generate(room_type, seed, clutter=USUAL_CLUTTER)
    return [item for _, items in room.furnishing.groups for item in items]


def measured(rooms: Sequence[Things]) -> dict[str, Any]:
    """All numbers of some rooms."""
    twins, everything = _twins(rooms)
    return {
        "makes in a room": float(np.mean([len(set(map(_make, room))) for room in rooms])),
        "objects in a room": float(np.mean([len(room) for room in rooms])),
        "equal in a room": twins / max(1, everything),
        "equal beside each other": _equal_neighbours(rooms),
    }


def _make(item: Item) -> tuple[str, str, tuple[float, ...]]:
    return item.category, item.style, tuple(round(side, 2) for side in item.size)


def _twins(rooms: Sequence[Things]) -> tuple[int, int]:
    """Things that have an equal one in their room, and all."""
    twins = everything = 0
    for room in rooms:
        makes = Counter(
            _make(item) for item in room if not category(item.category).one_variant_per_room
        )
        everything += makes.total()
        twins += sum(count for count in makes.values() if count > 1)
    return twins, everything


def _equal_neighbours(rooms: Sequence[Things]) -> float:
    """Of small things with one of their kind near on the same top: those equal, turned alike."""
    equal = total = 0
    for room in rooms:
        small = [i for i in room if i.lies or category(i.category).support == "surface"]
        for item in small:
            near = [other for other in small if other is not item and other.on == item.on
                    and other.category == item.category
                    and np.hypot(other.x - item.x, other.y - item.y) < _NEAR_M]  # fmt: skip
            total += bool(near)
            equal += any(_make(o) == _make(item) and _turn(o, item) < _ALIKE_DEG for o in near)
    return equal / max(1, total)


def _turn(a: Item, b: Item) -> float:
    return abs((a.yaw - b.yaw + 180.0) % 360.0 - 180.0)


if __name__ == "__main__":
    main()
