"""Washing, and counters in rows: what belongs into bathrooms and laundries."""

from openrooms_usd.generate.items import Group, Item, zone, zones
from openrooms_usd.generate.kit import Kit
from openrooms_usd.library.furniture import Size

_SEAM = 0.004
_ON_COUNTERS = ("bottle", "jar", "bowl", "jar", "bottle")


def counters(
    kit: Kit, parts: tuple[str, ...], top: tuple[str, ...] = _ON_COUNTERS, title: str = "counter"
) -> Group:
    """Counters and what is needed beside them in a row, things on the counters."""
    level, depth = 0.91, 0.62
    items: list[Item] = []
    x = 0.0
    for name in parts:
        size = _module(kit, name, level, depth)
        y = -0.5 * size[1]
        items.append(kit.item(name, round(x + 0.5 * size[0], 3), round(y, 3), size=size))
        x += size[0] + _SEAM
    on: list[Item] = []
    for counter in (item for item in items if item.category == "counter"):
        on += kit.scattered(counter, top, kit.whole(0, 3), [*items, *on])
    before = zone(0.5 * x, -depth - 0.5, x, 0.9)
    return Group(title, (*items, *on), zones([before]), ((0.5 * x, -depth - 0.5),))


def _module(kit: Kit, name: str, level: float, depth: float) -> Size:
    if name == "counter":
        return (kit.pick_number((0.6, 0.8, 1.0)), depth, level)
    if name == "refrigerator":
        return kit.size(name, width=kit.pick_number((0.6, 0.7)), depth=0.66)
    return kit.size(name)


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
