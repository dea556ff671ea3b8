"""Cooking and washing: appliances in rows, and what belongs into a bathroom."""

from functools import cache

from openrooms_usd.categories.record import given
from openrooms_usd.generate.items import Group, Item, zone, zones
from openrooms_usd.generate.kit import Kit
from openrooms_usd.library.furniture import CATEGORIES, Size, category, styles

_SEAM = 0.004
_ON_COUNTERS = ("bottle", "jar", "bowl", "jar", "bottle")
# What has a cabinet on the wall above it.
_BELOW = ("counter", "sink", "dishwasher")
_KITCHEN_SINK = "kitchen"


def kitchen_row(
    kit: Kit,
    parts: tuple[str, ...] = (),
    top: tuple[str, ...] = (),
    title: str = "kitchen",
) -> Group:
    """Appliances and counters side by side below wall cabinets, things on the counters."""
    names = parts or _modules(kit)
    level, depth = 0.91, 0.62
    items: list[Item] = []
    above: list[Item] = []
    x = 0.0
    for name in names:
        size = _module(kit, name, level, depth)
        y = -0.5 * size[1]
        style = name == "sink" and _KITCHEN_SINK in styles(name, size)
        item = kit.item(name, round(x + 0.5 * size[0], 3), round(y, 3), size=size,
                        style=_KITCHEN_SINK if style else None)  # fmt: skip
        items.append(item)
        if title == "kitchen" and name in _BELOW and kit.height > 2.3:
            above += _wall_cabinet(kit, item)
        x += size[0] + _SEAM
    on: list[Item] = []
    for counter in (item for item in items if item.category == "counter"):
        if not top and (appliance := _appliance(kit)):
            at = round(kit.rng.uniform(-0.1, 0.1) * counter.size[0], 2)
            made = kit.placed_on(counter, appliance, at, 0.08, beside=[*items, *on, *above])
            on += [made] if made else []
        on += kit.scattered(counter, top or _ON_COUNTERS, kit.whole(0, 3), [*items, *on, *above])
    before = zone(0.5 * x, -depth - 0.5, x, 0.9)
    return Group(title, (*items, *above, *on), zones([before]), ((0.5 * x, -depth - 0.5),))


@cache
def _appliances() -> dict[str, float]:
    """What stands on worktops, and on which share of them."""
    return {name: given(told.worktop, 0.0) for name, told in CATEGORIES.items()}


def _appliance(kit: Kit) -> str | None:
    """The appliance of one counter, if it has any."""
    drawn = float(kit.rng.random())
    for name, share in _appliances().items():
        if drawn < share:
            return name
        drawn -= share
    return None


def _modules(kit: Kit) -> tuple[str, ...]:
    """Fridge at one end, sink and stove apart, and as many counters as the room has space for."""
    space = kit.span[0] * (1.0 - 0.5 * kit.modesty) - 0.5
    row = ["refrigerator", "counter", "sink", "stove"]
    for place, name in ((3, "counter"), (3, "dishwasher"), (len(row) + 2, "counter")):
        if 0.75 * (len(row) + 1) < space:
            row.insert(place, name)
    return tuple(row if kit.chance(0.5) else row[::-1])


def _module(kit: Kit, name: str, level: float, depth: float) -> Size:
    if name == "counter":
        return (kit.pick_number((0.6, 0.8, 1.0)), depth, level)
    if name == "refrigerator":
        return kit.size(name, width=kit.pick_number((0.6, 0.7)), depth=0.66)
    if name in ("sink", "stove", "dishwasher"):
        return (category(name).size[0], depth, max(level, category(name).size[2]))
    return kit.size(name)


def _wall_cabinet(kit: Kit, below: Item) -> list[Item]:
    size = kit.size("kitchen_cabinet", width=below.size[0], depth=0.35,
                    height=round(min(0.72, kit.height - 1.55), 2))  # fmt: skip
    return [
        kit.item("kitchen_cabinet", below.x, -0.5 * size[1] + 0.015, size=size, z=1.45, on="wall",
                 optional=True)
    ]  # fmt: skip


def fixture(kit: Kit, name: str, before: float = 0.6, beside: float = 0.15) -> Group:
    """A toilet, a sink or a tub, with room before it."""
    item = kit.item(name, size=kit.size(name))
    width, depth, _ = item.size
    clear = [zone(0.0, -0.5 * depth - 0.5 * before, width, before)]
    if beside:
        clear.append(zone(0.0, 0.0, width + 2 * beside, depth - 0.02))
    return Group("washing", (item,), zones(clear), ((0.0, -0.5 * depth - 0.35),),
                 back=0.5 * depth, gap=0.005)  # fmt: skip


def tub(kit: Kit) -> Group:
    """A bathtub along the wall with a rug before it."""
    item = kit.item("bathtub", size=kit.size("bathtub", width=kit.between(1.5, 1.8)))
    width, depth, _ = item.size
    rug = kit.size("rug", width=0.8, depth=0.5)
    mat = kit.item("rug", 0.0, round(-0.5 * (depth + rug[1]) - 0.05, 3), size=rug, optional=True)
    return Group("bathing", (item, mat), zones([zone(0.0, -0.5 * depth - 0.3, 0.7 * width, 0.56)]),
                 ((0.0, -0.5 * depth - 0.35),), back=0.5 * depth, gap=0.005)  # fmt: skip


def laundry(kit: Kit, most: int = 3) -> Group:
    """Washing machines side by side, a basket or bottles on them."""
    count = kit.whole(1, most)
    first = kit.item("washing_machine")
    pitch = first.size[0] + 0.02
    items = [kit.like(first, round(i * pitch, 3), 0.0) for i in range(count)]
    on: list[Item] = []
    for machine in items:
        if kit.chance(0.6):
            on += kit.scattered(machine, ("bottle", "basket"), 1, [*items, *on])
    wide = count * (first.size[0] + 0.02)
    middle = 0.5 * (wide - first.size[0])
    depth = first.size[1]
    return Group("laundry", (*items, *on), zones([zone(middle, -0.5 * depth - 0.35, wide, 0.7)]),
                 ((middle, -0.5 * depth - 0.4),), back=0.5 * depth)  # fmt: skip
