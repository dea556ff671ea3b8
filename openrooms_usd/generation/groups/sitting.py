"""Sitting together: sofas, armchairs and what they look at."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from openrooms_usd.furniture import Size
from openrooms_usd.generation.boxes import overlap
from openrooms_usd.generation.items import Group, Item, front_zone, zone, zones
from openrooms_usd.generation.kit import Kit


def sofa_place(kit: Kit, armchairs: int = 2) -> Group:
    """A sofa with a coffee table before it, armchairs across its ends, a lamp and a side table."""
    size, style = kit.matching("sofa", kit.size("sofa", width=kit.between(1.6, 2.5), depth=0.92))
    sofa = kit.item("sofa", size=size, style=style)
    width, depth, _ = sofa.size
    table_size = kit.size("coffee_table", width=kit.between(0.6, 0.6 * width))
    gap = kit.between(0.36, 0.5)
    y = -0.5 * (depth + table_size[1]) - gap
    items = [sofa]
    rug = _rug_before(kit, sofa, table_size, y) if kit.chance(0.7) else None
    if rug:
        items.append(rug)
    table = kit.item(
        "coffee_table", 0.0, round(y, 3), size=table_size, z=rug.size[2] if rug else 0.0,
        on=rug.key if rug else "floor", optional=kit.modesty > 0.4,
    )  # fmt: skip
    items.append(table)
    items += kit.scattered(table, ("bowl", "jar", "bottle"), kit.whole(0, 2), items)
    items += _armchairs(kit, table, kit.whole(0, armchairs))
    items += _beside(kit, sofa, items)
    items += above(kit, sofa, others=items)
    legs = zone(0.0, -0.5 * depth - 0.5 * gap, 0.9 * width, gap - 0.04)
    front = table.y - 0.5 * table.size[1] - 0.3
    return Group("sitting", tuple(items), zones([legs]), ((0.0, front),), back=0.5 * depth)


def _rug_before(kit: Kit, sofa: Item, table: Size, y: float) -> Item | None:
    """A rug that begins before a sofa, with the table in its middle."""
    depth = 2.0 * (-0.5 * sofa.size[1] - 0.03 - y)
    return kit.carpet(table[0] + kit.between(0.4, 0.6), round(depth, 2), 0.0, y, table)


def _armchairs(kit: Kit, table: Item, count: int) -> list[Item]:
    size = kit.size("armchair")
    style = kit.style("armchair", size)
    away = 0.5 * table.size[0] + kit.between(0.42, 0.6) + 0.5 * size[1]
    first = 1 if kit.chance(0.5) else -1
    made = []
    for side in (first, -first)[:count]:
        yaw = -90.0 * side + round(kit.rng.uniform(-12, 12))
        made.append(
            kit.item("armchair", side * away, table.y, yaw, size=size, style=style, optional=True)
        )
    return made


def _beside(kit: Kit, sofa: Item, others: list[Item]) -> list[Item]:
    """A side table with a lamp on one side, a floor lamp or a plant on the other."""
    made: list[Item] = []
    side = 1 if kit.chance(0.5) else -1
    back = 0.5 * sofa.size[1]
    if kit.chance(0.6):
        size = kit.size("side_table")
        x = side * (0.5 * (sofa.size[0] + size[0]) + 0.06)
        table = kit.item("side_table", x, back - 0.5 * size[1] - 0.02, size=size, optional=True)
        lamp = kit.placed_on(table, kit.pick(("table_lamp", "table_lamp", "jar")), 0.0, 0.0)
        made += [table, *([lamp] if lamp else [])]
    if kit.chance(0.7):
        name = kit.pick(("floor_lamp", "floor_lamp", "plant_pot"))
        thing = kit.item(name, optional=True)
        x = -side * (0.5 * (sofa.size[0] + thing.size[0]) + 0.08)
        made.append(_at(thing, x, back - 0.5 * thing.size[1] - 0.04))
    return made


def _at(item: Item, x: float, y: float, yaw: float = 0.0) -> Item:
    return replace(item, x=round(x, 3), y=round(y, 3), yaw=yaw)


def above(kit: Kit, below: Item, chance: float = 0.6, others: Sequence[Item] = ()) -> list[Item]:
    """A picture on the wall above a piece of furniture, clear of what stands on that."""
    if not kit.chance(chance):
        return []
    size = kit.size("picture")
    size = (min(size[0], round(0.8 * below.size[0], 2)), size[1], size[2])
    low = max(below.z + below.size[2] + 0.15, 1.25)
    if low + size[2] > kit.height - 0.2:
        return []
    y = below.y + 0.5 * below.size[1] + 0.015 - 0.5 * size[1]
    found = kit.item("picture", below.x, y, size=size, z=round(low, 2), on="wall", optional=True)
    taken = [item.box for item in others]
    return [] if taken and overlap(found.box[None], np.array(taken), 0.03).any() else [found]


def media(kit: Kit) -> Group:
    """A low cabinet with a television on it, and speakers beside."""
    width = kit.between(1.2, 2.0)
    stand = kit.item("cabinet", size=kit.size("cabinet", width=width, depth=0.42, height=0.52))
    items: list[Item] = [stand]
    size = kit.size("television", width=min(kit.between(0.9, 1.4), width - 0.1))
    screen = kit.placed_on(stand, "television", 0.0, 0.0, size=size)
    items += [screen] if screen else []
    if kit.chance(0.5):
        box = kit.size("speaker", width=0.24, depth=0.3, height=kit.between(0.6, 0.95))
        for side in (-1, 1):
            x = side * (0.5 * width + 0.2)
            items.append(kit.item("speaker", x, 0.0, size=box, optional=True))
    items += kit.scattered(stand, ("jar", "bowl"), kit.whole(0, 2), items)
    back = 0.5 * stand.size[1]
    return Group("television", tuple(items), zones([front_zone(stand, 0.6)]), _before(stand),
                 back=back)  # fmt: skip


def _before(item: Item, away: float = 0.4) -> tuple[tuple[float, float], ...]:
    return ((item.x, item.y - 0.5 * item.size[1] - away),)


def reading_corner(kit: Kit) -> Group:
    """An armchair with a lamp, perhaps a side table and a shelf of books."""
    chair = kit.item("armchair")
    width, depth, _ = chair.size
    side = 1 if kit.chance(0.5) else -1
    lamp = kit.item("floor_lamp", optional=True)
    lamp = _at(lamp, side * (0.5 * width + 0.08 + 0.5 * lamp.size[0]), 0.5 * depth - 0.2)
    table = kit.item("side_table", optional=True)
    table = _at(table, -side * (0.5 * width + 0.08 + 0.5 * table.size[0]), 0.0)
    items = [chair, lamp, table]
    items += kit.scattered(table, ("jar", "bowl", "bottle"), kit.whole(0, 1), items)
    legs = front_zone(chair, 0.45)
    return Group("reading", tuple(items), zones([legs]), _before(chair), back=0.5 * depth)


def dining(
    kit: Kit, seats: tuple[int, int] = (4, 6), chair: str = "chair", lamp: bool = True,
    tops: tuple[str, ...] = ("bowl", "bottle", "jar"), title: str = "dining",
) -> Group:  # fmt: skip
    """A table with chairs tucked below it, perhaps a rug below and a lamp above."""
    count = kit.whole(*seats)
    if count <= 2:
        size = kit.size("table", kit.between(0.7, 0.9), 0.75, 0.74)
    else:
        size = kit.size("table", round(0.68 * (count // 2) + kit.between(0.1, 0.4), 2),
                        kit.between(0.8, 1.0), 0.74)  # fmt: skip
    make = kit.item(chair)
    items: list[Item] = []
    z, on = 0.0, "floor"
    if kit.chance(0.3):
        reach = 2 * make.size[1] + 0.5
        held = (size[0] + reach - 0.4, size[1] + reach - 0.4, 0.1)
        rug = kit.carpet(size[0] + reach, size[1] + reach, 0.0, 0.0, held)
        if rug:
            items, z, on = [rug], rug.size[2], rug.key
    table = kit.item("table", size=size, z=z, on=on)
    items = [*items, table]
    make = kit.item(chair, size=make.size, style=make.style, z=z, on=on, optional=True)
    chairs: list[Item] = []
    for along, side in seats_around(table, count, make.size[0]):
        placed = kit.tucked(make, table, along, side, chairs)
        chairs += [placed] if placed else []
    items += chairs
    items += kit.scattered(table, tops, kit.whole(0, 3), items)
    if lamp and kit.chance(0.6):
        items += pendant(kit, table)
    room = [zone(0.0, s * (0.5 * size[1] + 0.62), size[0], 0.5) for s in (-1, 1)]
    places = ((0.0, -0.5 * size[1] - 0.85),)
    return Group(title, tuple(items), zones(room), places, anchor="free")


def seats_around(table: Item, count: int, width: float) -> list[tuple[float, float]]:
    """Places for chairs: along the long sides first, then at the ends."""
    long = table.size[0]
    fit = max(1, int((long - 0.12) / (width + 0.06)))
    along = min(fit, (count + 1) // 2)
    pitch = (long - 0.1) / along
    rows = [((i - 0.5 * (along - 1)) * pitch, side) for side in (-90.0, 90.0) for i in range(along)]
    rows = rows[:count]
    return [*rows, *[(0.0, side) for side in (0.0, 180.0)][: count - len(rows)]]


def pendant(kit: Kit, table: Item) -> list[Item]:
    """A lamp that hangs above a table."""
    style = kit.style("ceiling_lamp")
    low = table.z + table.size[2] + kit.between(0.65, 0.9)
    size = kit.size("ceiling_lamp", style=style)
    high = size[2] if size[2] < 0.4 else round(kit.height - low, 2)
    if kit.height - high < table.z + table.size[2] + 0.5:
        return []
    size = (size[0], size[1], high)
    z = round(kit.height - high, 3)
    return [kit.item("ceiling_lamp", table.x, table.y, size=size, z=z, on="ceiling", optional=True)]
