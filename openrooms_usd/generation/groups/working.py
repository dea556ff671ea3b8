"""Working: desks with what stands on them, meetings, classes."""

from openrooms_usd.generation.groups.sitting import seats_around
from openrooms_usd.generation.items import Group, Item, front_zone, zone, zones
from openrooms_usd.generation.kit import Kit


def equipped(kit: Kit, desk: Item, screen: str = "monitor", extras: int = 2) -> list[Item]:
    """What stands on a desk: a screen with a keyboard or a laptop, a telephone, a lamp."""
    made: list[Item] = []
    depth = desk.size[1]

    def put(name: str, x: float, y: float, yaw: float = 0.0) -> None:
        found = kit.placed_on(desk, name, round(x, 3), round(y, 3), yaw, beside=made)
        made.extend([found] if found else [])

    if screen == "laptop":
        put("laptop", 0.0, -0.05, round(kit.rng.uniform(-10, 10)))
    elif screen == "monitor":
        put("monitor", 0.0, 0.22 * depth)
        put("keyboard", 0.0, -0.22 * depth)
    side = 1 if kit.chance(0.5) else -1
    wide = 0.5 * desk.size[0]
    for name, x in (("telephone", 0.66), ("table_lamp", -0.72), ("jar", 0.8))[:extras]:
        if kit.chance(0.55):
            put(name, side * x * wide, 0.2 * depth, round(kit.rng.uniform(-15, 15)))
    return made


def desk_place(kit: Kit, chair: str = "office_chair", screen: str = "", extras: int = 2) -> Group:
    """A desk against the wall with a chair, a screen and a bin."""
    size = kit.size("desk", width=kit.between(1.0, 1.7), height=0.74)
    size, style = kit.matching("desk", size)
    desk = kit.item("desk", size=size, style=style)
    seat = kit.tucked(kit.item(chair), desk, 0.0, -90.0, jitter=20.0, deepest=0.5)
    items = [desk, *([seat] if seat else [])]
    items += equipped(kit, desk, screen or kit.pick(("monitor", "monitor", "laptop")), extras)
    if kit.chance(0.5):
        bin_size = kit.size("trash_bin")
        side = 1 if kit.chance(0.5) else -1
        x = side * (0.5 * (desk.size[0] + bin_size[0]) + 0.06)
        items.append(kit.item("trash_bin", round(x, 3), 0.0, size=bin_size, optional=True))
    back = 0.5 * desk.size[1]
    return Group("working", tuple(items), zones([front_zone(desk, 0.95)]),
                 ((0.0, -back - 0.75),), back=back)  # fmt: skip


def workstations(kit: Kit, most: int = 4, screen: str = "monitor", double: bool = False) -> Group:
    """Equal desks side by side, each with a chair; back to back where they stand in the room."""
    count = kit.whole(2, most)
    size = kit.size("desk", width=kit.between(1.1, 1.5), depth=kit.between(0.65, 0.75), height=0.74)
    size, style = kit.shared("workstation", size, kit.style("desk", size))
    chair = kit.item("office_chair")
    items: list[Item] = []
    rows = (1, -1) if double else (1,)
    for row in rows:
        y = -0.5 * row * (size[1] + 0.02) if double else 0.0
        yaw = 0.0 if row == 1 else 180.0
        for i in range(count):
            x = (i - 0.5 * (count - 1)) * (size[0] + 0.015)
            desk = kit.item("desk", round(x, 3), round(y, 3), yaw, size=size, style=style)
            seat = kit.tucked(chair, desk, 0.0, -90.0, items, jitter=25.0, deepest=0.5)
            items += [desk, *([seat] if seat else []), *equipped(kit, desk, screen, 1)]
    wide, deep = count * (size[0] + 0.015), (2.0 if double else 1.0) * size[1]
    aisles = [zone(0.0, -row * (0.5 * deep + 0.45), wide, 0.9) for row in rows]
    places = tuple(
        (item.x, item.y - (0.5 * size[1] + 0.7) * (1.0 if item.yaw == 0.0 else -1.0))
        for item in items
        if item.category == "desk"
    )
    anchor, back = ("free", 0.0) if double else ("wall", 0.5 * size[1])
    return Group("workstations", tuple(items), zones(aisles), places, anchor, back)  # type: ignore[arg-type]


def conference(kit: Kit) -> Group:
    """A long table with office chairs all around it."""
    long, _ = kit.span
    most = int(max(4, min(16, 2 * (long - 2.6) / 0.75)))
    count = 2 * max(2, kit.whole(max(2, most // 3), max(2, most // 2)))
    width = round(min(4.8, 0.36 * (count - 2) + 0.5), 2)
    table = kit.item("table", size=kit.size("table", width, kit.between(1.0, 1.3), 0.74))
    chair = kit.item("office_chair", optional=True)
    items: list[Item] = [table]
    for along, side in seats_around(table, count, chair.size[0]):
        seat = kit.tucked(chair, table, along, side, items[1:], deepest=0.4, jitter=12.0)
        items += [seat] if seat else []
    items += kit.scattered(table, ("laptop", "telephone", "bottle", "laptop"), 3, items)
    room = [zone(0.0, s * (0.5 * table.size[1] + 0.75), width, 0.8) for s in (-1, 1)]
    return Group("conference", tuple(items), zones(room), ((0.0, -0.5 * table.size[1] - 0.9),),
                 "free")  # fmt: skip


def classroom(kit: Kit) -> Group | None:
    """A board, the teacher's desk, and rows of desks that look at it."""
    long, short = kit.span
    size = kit.size("desk", width=kit.between(0.7, 1.3), depth=0.6, height=0.74)
    style = kit.style("desk", size)
    chair = kit.item("chair")
    columns = max(1, int((short - 0.8) / (size[0] + 0.65)))
    pitch = max(1.4, size[1] + chair.size[1] + 0.4)
    rows = max(1, int((long - 3.6) / pitch))
    columns, rows = (max(1, round(n * (1.0 - 0.7 * kit.modesty))) for n in (columns, rows))
    board = kit.size("whiteboard", width=kit.between(1.8, 3.0))
    low = 0.9
    items: list[Item] = [kit.item("whiteboard", 0.0, -0.5 * board[1], size=board, z=low, on="wall")]
    items += _teacher(kit)
    for row in range(rows):
        for column in range(columns):
            x = (column - 0.5 * (columns - 1)) * (size[0] + 0.65)
            y = -3.1 - pitch * row
            desk = kit.item("desk", round(x, 3), round(y, 3), size=size, style=style, optional=True)
            seat = kit.tucked(chair, desk, 0.0, -90.0, deepest=0.45, jitter=5.0)
            items += [desk, *([seat] if seat else [])]
    front = zone(0.0, -0.5, board[0], 0.9)
    return Group("class", tuple(items), zones([front]), ((0.0, -0.5),), gap=0.0)


def _teacher(kit: Kit) -> list[Item]:
    desk = kit.item("desk", size=kit.size("desk", width=kit.between(1.2, 1.6), height=0.74),
                    x=round(kit.rng.uniform(-1.0, 1.0), 2), y=-1.75, yaw=180.0,
                    optional=True)  # fmt: skip
    seat = kit.tucked(kit.item("office_chair"), desk, 0.0, -90.0, jitter=15.0, deepest=0.4)
    on = kit.placed_on(desk, "laptop", 0.2, 0.0)
    return [desk, *([seat] if seat else []), *([on] if on else [])]
