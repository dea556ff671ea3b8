"""Storing: single pieces and rows against a wall, shelves with aisles, boxes."""

from openrooms_usd.generation.groups.sitting import above
from openrooms_usd.generation.items import Group, Item, front_zone, zone, zones
from openrooms_usd.generation.kit import Kit

_SMALL = ("jar", "bowl", "bottle")


def piece(
    kit: Kit, name: str, width: tuple[float, float] | None = None, before: float = 0.6,
    tops: tuple[str, ...] = _SMALL, most: int = 2, fewest: int = 0, height: float | None = None,
    title: str = "storing", gap: float = 0.015,
) -> Group:  # fmt: skip
    """One piece of furniture against a wall, its front free, small things on its top."""
    style = kit.style(name)
    size = kit.size(name, kit.between(*width) if width else None, None, height, style=style)
    size = (size[0], size[1], min(size[2], round(kit.height - 0.1, 2)))
    if height is None and width is None:
        size, style = kit.matching(name, size)
        thing = kit.item(name, size=size, style=style)
    else:
        thing = kit.item(name, size=size)
    items: list[Item] = [thing]
    if size[2] < 1.4 and tops:
        items += kit.scattered(thing, tops, kit.whole(fewest, most), items)
    if size[2] < 1.1:
        items += above(kit, thing, 0.35, items)
    clear = zones([front_zone(thing, before)]) if before else zones([])
    access = ((0.0, -0.5 * size[1] - 0.4),) if before else ()
    return Group(title, tuple(items), clear, access, back=0.5 * size[1], gap=gap)


def row(
    kit: Kit, name: str, most: int = 4, before: float = 0.7, tops: tuple[str, ...] = (),
    title: str = "storing",
) -> Group:  # fmt: skip
    """Equal pieces side by side against a wall."""
    count = max(1, kit.whole(max(1, most // 2), most))
    first = kit.item(name)
    if first.size[2] > kit.height - 0.1:
        size = (*first.size[:2], round(kit.height - 0.1, 2))
        first = kit.item(name, size=size)
    width, depth, _ = first.size
    made = []
    for i in range(count):
        x = round((i - 0.5 * (count - 1)) * (width + 0.008), 3)
        made.append(kit.like(first, x, 0.0))
    items: list[Item] = list(made)
    for one in made:
        if tops and kit.chance(0.5):
            items += kit.scattered(one, tops, 1, items)
    wide = count * (width + 0.008)
    return Group(title, tuple(items), zones([zone(0.0, -0.5 * depth - 0.5 * before, wide, before)]),
                 ((0.0, -0.5 * depth - 0.4),), back=0.5 * depth)  # fmt: skip


def aisle(kit: Kit, name: str = "bookshelf", most: int = 4) -> Group:
    """Two rows of shelves back to back in the room, with an aisle on either side."""
    first = kit.item(name)
    count = max(1, min(kit.whole(1, most), int((kit.span[1] - 1.8) / first.size[0])))
    width, depth, height = first.size
    height = min(height, round(kit.height - 0.1, 2))
    items: list[Item] = []
    for side in (-1, 1):
        for i in range(count):
            x = round((i - 0.5 * (count - 1)) * (width + 0.008), 3)
            y = round(side * (0.5 * depth + 0.008), 3)
            yaw = 0.0 if side < 0 else 180.0
            items.append(kit.item(name, x, y, yaw, size=(width, depth, height), style=first.style))
    wide = count * (width + 0.008)
    lanes = [zone(0.0, s * (depth + 0.4), wide, 0.7) for s in (-1, 1)]
    places = tuple((0.0, s * (depth + 0.45)) for s in (-1, 1))
    return Group("shelves", tuple(items), zones(lanes), places, anchor="free")


def boxes(kit: Kit, most: int = 5, name: str = "box") -> Group:
    """Boxes in a stack, and one beside it."""
    count = kit.whole(1, most)
    first = kit.item(name)
    items: list[Item] = [first]
    for _ in range(count - 1):
        last = items[-1]
        if last.z + last.size[2] > 1.2 or kit.chance(0.3):
            break
        size = kit.size(name)
        size = (min(size[0], last.size[0] - 0.02), min(size[1], last.size[1] - 0.02), size[2])
        up = kit.placed_on(last, name, 0.0, 0.0, round(kit.rng.uniform(-4, 4)), size=size)
        if up is None:
            break
        items.append(up)
    if count > 2:
        size = kit.size(name)
        x = round(0.5 * (first.size[0] + size[0]) + 0.08, 2)
        items.append(kit.item(name, x, 0.0, round(kit.rng.uniform(-8, 8)), size=size,
                              optional=True))  # fmt: skip
    back = max(0.5 * item.size[1] for item in items) + 0.05
    return Group("boxes", tuple(items), back=back)


def thing(kit: Kit, name: str, anchor: str = "wall") -> Group:
    """One small thing that stands at a wall."""
    item = kit.item(name)
    return Group("besides", (item,), anchor=anchor, back=0.5 * item.size[1], gap=0.04)  # type: ignore[arg-type]


def standalone(kit: Kit, name: str, around: float = 0.5, title: str = "training") -> Group:
    """One piece in the middle of a room, with space all around."""
    item = kit.item(name)
    width, depth, _ = item.size
    room = [
        *(zone(0.0, s * 0.5 * (depth + around), width, around) for s in (-1, 1)),
        *(zone(s * 0.5 * (width + around), 0.0, around, depth) for s in (-1, 1)),
    ]
    return Group(title, (item,), zones(room), ((0.0, -0.5 * depth - 0.4),), anchor="free")


def mat(kit: Kit) -> Group:
    """A mat on the floor."""
    rug = kit.item("rug", size=kit.size("rug", kit.between(1.6, 2.0), kit.between(0.8, 1.3)))
    x, y, *_ = rug.size
    return Group("training", (rug,), zones([zone(0.0, 0.0, x, y)]), anchor="free")


def stairs(kit: Kit) -> Group:
    """Stairs that rise to a wall, free at their foot."""
    rise = round(min(kit.height - 2.1, 3.0), 2) if kit.height > 3.4 else 1.2
    size = (kit.between(0.9, 1.3), round(max(1.6, 1.5 * rise), 2), max(rise, 0.8))
    item = kit.item("stairs", size=size)
    return Group("stairs", (item,), zones([front_zone(item, 0.9)]),
                 ((0.0, -0.5 * size[1] - 0.5),), back=0.5 * size[1], gap=0.015)  # fmt: skip
