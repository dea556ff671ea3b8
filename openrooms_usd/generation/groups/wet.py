"""Washing, and counters in rows: what belongs into bathrooms and laundries."""

from openrooms_usd.furniture import Size
from openrooms_usd.generation.items import Group, Item, zone, zones
from openrooms_usd.generation.kit import Kit

_SEAM = 0.004
_DRYER_HEIGHT_M = 0.86
# Behind a bath that stands free is its tap, metres.
_BEHIND_BATH_M = 0.115
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
    """A toilet or a sink, with room before it; paper beside the one."""
    item = kit.item(name, size=kit.size(name))
    width, depth, _ = item.size
    items = [item]
    if name == "toilet":
        side = 1 if kit.chance(0.5) else -1
        items.append(
            _hang_above(kit, "toilet_paper_holder", side * (0.5 * width + 0.16), item, 0.66)
        )
        items.append(_brush(kit, -side, item))
    clear = [zone(0.0, -0.5 * depth - 0.5 * before, width, before)]
    if beside:
        clear.append(zone(0.0, 0.0, width + 2 * beside, depth - 0.02))
    return Group("washing", tuple(items), zones(clear), ((0.0, -0.5 * depth - 0.35),),
                 back=0.5 * depth, gap=0.005)  # fmt: skip


def _brush(kit: Kit, side: int, toilet: Item) -> Item:
    """A brush on the floor beside a toilet, at the wall."""
    size, style = kit.make("toilet_brush")
    x = side * (0.5 * (toilet.size[0] + size[0]) + 0.05)
    y = 0.5 * (toilet.size[1] - size[1]) - 0.04
    return kit.item("toilet_brush", round(x, 3), round(y, 3), size=size, style=style,
                    optional=True)  # fmt: skip


def _hang_above(
    kit: Kit, name: str, x: float, below: Item, z: float, size: Size | None = None,
    style: str | None = None,
) -> Item:  # fmt: skip
    """Something on the wall behind or beside an item."""
    size = size or kit.size(name, style=style)
    y = below.y + 0.5 * below.size[1] + 0.004 - 0.5 * size[1]
    return kit.item(name, round(below.x + x, 3), round(y, 3), size=size, style=style,
                    z=round(z, 3), on="wall", optional=True)  # fmt: skip


def washstand(kit: Kit) -> Group:
    """A basin, most in a vanity unit, with a mirror above it and a rail for towels beside."""
    style = kit.pick(("vanity", "vanity", "vessel", "pedestal"))
    wide = style in ("vanity", "vessel") and kit.modesty < 0.5
    basin = kit.item("sink", size=kit.size("sink", kit.between(0.6, 1.1) if wide else None,
                                           style=style), style=style)  # fmt: skip
    width, depth, height = basin.size
    made = kit.pick(("framed", "oval", "cabinet", "framed"))
    low = round(max(height + 0.06, 1.12), 2)
    tall = min(0.9, kit.height - low - 0.2)
    across = round(min(max(width - 0.1, 0.4), 1.2), 2)
    size = {"framed": (across, 0.03, min(tall, 0.8)),
            "oval": (min(across, 0.7), 0.03, min(across, 0.7, tall)),
            "cabinet": (across, 0.14, min(tall, 0.68))}[made]  # fmt: skip
    items = [basin, _hang_above(kit, "mirror", 0.0, basin, low, size, made)]
    if kit.chance(0.6):
        side = 1 if kit.chance(0.5) else -1
        rail = kit.size("towel_rail", width=kit.between(0.4, 0.6), style="bar")
        x = side * (0.5 * (width + rail[0]) + 0.08)
        items.append(_hang_above(kit, "towel_rail", x, basin, 1.1, rail, "bar"))
    if made != "cabinet" and low - height > 0.16:
        shelf = (round(min(across, 0.6), 2), 0.12, 0.036)
        items.append(_hang_above(kit, "wall_shelf", 0.0, basin, low - 0.05, shelf, "glass"))
    clear = [zone(0.0, -0.5 * depth - 0.3, width, 0.6),
             zone(0.0, 0.0, width + 0.16, depth - 0.02)]  # fmt: skip
    return Group("washing", tuple(items), zones(clear), ((0.0, -0.5 * depth - 0.35),),
                 back=0.5 * depth, gap=0.005)  # fmt: skip


def bathing(kit: Kit) -> Group:
    """A shower or a bathtub; the smaller the room, the more often a shower."""
    return shower(kit) if kit.modesty > 0.5 or kit.chance(0.5) else tub(kit)


def shower(kit: Kit) -> Group:
    """A shower in a corner, or a long one that one walks into; a mat before it."""
    side = kit.pick(("left", "right"))
    if kit.modesty < 0.3 and kit.span[0] > 2.4 and kit.chance(0.35):
        size, style, corner = (kit.between(1.2, 1.5), 0.9, 2.08), "walk_in", ""
    else:
        across = kit.pick_number((0.8, 0.9, 1.0))
        size, style, corner = (across, across, 2.05), f"corner_{side}", side
    stall = kit.item("shower", size=size, style=style)
    width, depth, _ = stall.size
    items = [stall, _caddy(kit, stall, side if style != "walk_in" else "right"), _mat(kit, depth)]
    clear = [zone(0.0, -0.5 * depth - 0.3, 0.9 * width, 0.6)]
    return Group("bathing", tuple(items), zones(clear), ((0.0, -0.5 * depth - 0.35),),
                 back=0.5 * depth, gap=0.006, corner=corner)  # type: ignore[arg-type]  # fmt: skip


def _caddy(kit: Kit, stall: Item, side: str) -> Item:
    """Trays for bottles on the wall of a shower, away from its fittings."""
    x = (-0.27 if side == "right" else 0.27) * stall.size[0]
    return _hang_above(kit, "shower_caddy", x, stall, 1.12)


def _mat(kit: Kit, depth: float) -> Item:
    """A mat before what one steps out of."""
    rug = kit.size("rug", width=0.8, depth=0.5)
    y = round(-0.5 * (depth + rug[1]) - 0.05, 3)
    return kit.item("rug", 0.0, y, size=rug, optional=True)


def tub(kit: Kit) -> Group:
    """A bathtub along the wall with its tap, perhaps a pane on its rim; a mat before it."""
    item = kit.item("bathtub", size=kit.size("bathtub", width=kit.between(1.5, 1.8)))
    width, depth, height = item.size
    items: list[Item] = [item]
    paned = False
    back = 0.5 * depth
    if item.style != "built_in":
        items.append(_standing_tap(kit, item))
        back += _BEHIND_BATH_M
    else:
        tap = kit.placed_on(item, "faucet", 0.5 * width - 0.04, 0.0, -90.0,
                            size=(0.05, 0.17, 0.16), beside=items)  # fmt: skip
        items += [tap] if tap else []
        if kit.modesty < 0.3 and kit.chance(0.6):
            size = (0.8, 0.026, round(min(1.45, kit.height - height - 0.15), 2))
            # It stands on the front rim, its hinge at the wall beside the tap.
            x, y = round(0.5 * (width - size[0]) - 0.004, 3), round(0.035 - 0.5 * depth, 3)
            pane = kit.placed_on(item, "shower_screen", x, y, 180.0, size=size, beside=items)
            items += [pane] if pane else []
            paned = pane is not None
    items.append(_mat(kit, depth))
    return Group("bathing", tuple(items), zones([zone(0.0, -0.5 * depth - 0.3, 0.7 * width, 0.56)]),
                 ((0.0, -0.5 * depth - 0.35),), back=back, gap=0.005,
                 corner="right" if paned else "")  # fmt: skip


def _standing_tap(kit: Kit, bath: Item) -> Item:
    """A tap on a pillar behind a bath that stands free, its spout over the rim."""
    size = (0.2, 0.27, round(bath.size[2] + 0.36, 2))
    y = 0.5 * bath.size[1] + _BEHIND_BATH_M - 0.5 * size[1]
    return kit.item("faucet", round(0.1 * bath.size[0], 3), round(y, 3), size=size,
                    style="pillar", optional=True)  # fmt: skip


def laundry(kit: Kit, most: int = 2) -> Group:
    """A washing machine, perhaps a dryer beside it, a basket or bottles on them."""
    wanted = kit.whole(1, most)
    size, style = kit.make("washing_machine")
    first = kit.item("washing_machine", size=size, style=style)
    pitch = first.size[0] + 0.02
    items = [first]
    if wanted > 1 and style not in ("stacked", "dryer"):
        dryer = (size[0], size[1], min(size[2], _DRYER_HEIGHT_M))
        items.append(kit.item("washing_machine", round(pitch, 3), 0.0, size=dryer, style="dryer"))
    on: list[Item] = []
    for machine in items:
        if kit.chance(0.6):
            on += kit.scattered(machine, ("bottle", "basket"), 1, [*items, *on])
    wide = len(items) * (first.size[0] + 0.02)
    middle = 0.5 * (wide - first.size[0])
    depth = first.size[1]
    return Group("laundry", (*items, *on), zones([zone(middle, -0.5 * depth - 0.35, wide, 0.7)]),
                 ((middle, -0.5 * depth - 0.4),), back=0.5 * depth)  # fmt: skip
