"""How unlike generated rooms and the things in them are: shares of equal pieces, and odd ones out.

Rooms are generated alone, with nothing composed. Two things are equal where their category, their
style and their size to the centimetre are. What a room has one make of by its record (chairs,
sockets) does not count.
"""

import sys
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any, Final

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
# Wall that furniture of one kind stands side by side along, metres.
_BESIDE_M: Final = 0.5
_WORST: Final = 8


@dataclass(frozen=True)
class Seen:
    """A room and all that is in it."""

    room_type: str
    items: Sequence[Item]

    def of(self, *names: str) -> list[Item]:
        """The things of some categories."""
        return [item for item in self.items if item.category in names]


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
    rows = [[key, value] for key, value in data.items() if not isinstance(value, dict)]
    worst = [[key, name, share] for key, value in data.items() if isinstance(value, dict)
             for name, share in value.items()]  # fmt: skip
    text = "\n\n".join(
        [table(("what", "value"), rows), table(("what", "category", "share"), worst)]
    )
    publish("variety", data, text, target)


def _seen(room_type: str, seed: int) -> Seen:
    room = generate(room_type, seed, clutter=USUAL_CLUTTER)
    return Seen(room_type, [item for _, items in room.furnishing.groups for item in items])


def measured(rooms: Sequence[Seen]) -> dict[str, Any]:
    """All numbers of some rooms."""
    across = _equal_across(rooms)
    twins, all_ = _twins(rooms)
    return {
        "makes in a room": float(np.mean([len(set(map(_make, room.items))) for room in rooms])),
        "objects in a room": float(np.mean([len(room.items) for room in rooms])),
        "equal in a room": sum(twins.values()) / max(1, sum(all_.values())),
        "equal beside each other": _equal_neighbours(rooms),
        "equal style in two rooms": float(np.mean(list(across.values()))) if across else 0.0,
        **{name: rule(rooms) for name, rule in _RULES.items()},
        "twins": {name: twins[name] / all_[name] for name, _ in twins.most_common(_WORST)},
        "same style": dict(sorted(across.items(), key=lambda row: -row[1])[:_WORST]),
    }


def _make(item: Item) -> tuple[str, str, tuple[float, ...]]:
    return item.category, item.style, tuple(round(side, 2) for side in item.size)


def _differs(item: Item) -> bool:
    return not category(item.category).one_variant_per_room


def _twins(rooms: Sequence[Seen]) -> tuple[Counter[str], Counter[str]]:
    """By category: things that have an equal one in their room, and all."""
    twins, everything = Counter[str](), Counter[str]()
    for room in rooms:
        some = [item for item in room.items if _differs(item)]
        counts = Counter(_make(item) for item in some)
        everything.update(item.category for item in some)
        twins.update(item.category for item in some if counts[_make(item)] > 1)
    return twins, everything


def _equal_neighbours(rooms: Sequence[Seen]) -> float:
    """Of small things with one of their kind near on the same top: those equal, turned alike."""
    equal = total = 0
    for room in rooms:
        small = [i for i in room.items if i.lies or category(i.category).support == "surface"]
        for item in small:
            near = [other for other in small if other is not item and other.on == item.on
                    and other.category == item.category
                    and np.hypot(other.x - item.x, other.y - item.y) < _NEAR_M]  # fmt: skip
            total += bool(near)
            equal += any(_make(o) == _make(item) and _turn(o, item) < _ALIKE_DEG for o in near)
    return equal / max(1, total)


def _turn(a: Item, b: Item) -> float:
    return abs((a.yaw - b.yaw + 180.0) % 360.0 - 180.0)


def _equal_across(rooms: Sequence[Seen]) -> dict[str, float]:
    """By category of several styles: the chance that it has one style in two rooms."""
    found: dict[str, list[Counter[str]]] = {}
    for room in rooms:
        for name in {item.category for item in room.items}:
            if len(category(name).styles) > 1:
                found.setdefault(name, []).append(Counter(i.style for i in room.of(name)))
    shares = {}
    for name, counts in found.items():
        if len(counts) >= 10:
            parts = [{s: n / sum(c.values()) for s, n in c.items()} for c in counts]
            pairs = [sum(a[s] * b.get(s, 0.0) for s in a) for a, b in combinations(parts, 2)]
            shares[name] = float(np.mean(pairs))
    return shares


def _most(*names: str) -> Callable[[Sequence[Seen]], float]:
    return lambda rooms: max((len(room.of(*names)) for room in rooms), default=0)


def _share(items: str, style: str) -> Callable[[Sequence[Seen]], float]:
    def rule(rooms: Sequence[Seen]) -> float:
        found = [item.style for room in rooms for item in room.of(items)]
        return found.count(style) / max(1, len(found))

    return rule


def _rooms_where(
    kinds: str, holds: Callable[[Seen], bool]
) -> Callable[[Sequence[Seen]], float | None]:
    def rule(rooms: Sequence[Seen]) -> float | None:
        some = [room for room in rooms if not kinds or room.room_type in kinds.split()]
        return sum(map(holds, some)) / len(some) if some else None

    return rule


def _unlike(name: str) -> Callable[[Seen], bool]:
    return lambda room: len({item.style for item in room.of(name)}) > 1


def _middle(rooms: Sequence[Seen]) -> float | None:
    found = [i.z + 0.5 * i.size[2] for room in rooms for i in room.of("clock") if i.on == "wall"]
    return float(np.median(found)) if found else None


def _rows_of_machines(room: Seen) -> bool:
    styles = Counter(_make(item) for item in room.of("washing_machine"))
    return max(styles.values(), default=0) > 1


_HUNG: Final = ("picture", "clock", "whiteboard", "wall_shelf", "mirror")
_RULES: Final[dict[str, Callable[[Sequence[Seen]], float | None]]] = {
    "most remote controls in a room": _most("remote_control"),
    "most kettles in a room": _most("kettle"),
    "most clocks on the walls of a room": _most("clock"),
    "share of triptychs among pictures": _share("picture", "triptych"),
    "share of round cushions": _share("pillow", "round"),
    "share of tube monitors": _share("monitor", "tube"),
    "share of tube televisions": _share("television", "tube"),
    "bedrooms of unlike wardrobes": _rooms_where("bedroom", _unlike("wardrobe")),
    "offices of unlike desks": _rooms_where("office", _unlike("desk")),
    "lounges of unlike sofas": _rooms_where("lounge lobby", _unlike("sofa")),
    "laundries with equal machines": _rooms_where(
        "laundry_room basement bathroom", _rows_of_machines
    ),
    "bathrooms with a chandelier": _rooms_where(
        "bathroom", lambda room: any(i.style == "chandelier" for i in room.of("ceiling_lamp"))
    ),
    "offices with bare walls": _rooms_where("office", lambda room: not room.of(*_HUNG)),
    "dining rooms with a laid table": _rooms_where(
        "dining_room", lambda room: any("table" in item.on for item in room.of("plate"))
    ),
    "middle of clocks on walls, m": _middle,
}


if __name__ == "__main__":
    main()
