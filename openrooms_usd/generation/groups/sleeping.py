"""Sleeping, and keeping clothes."""

from openrooms_usd.generation.groups.sitting import above
from openrooms_usd.generation.items import Group, Item, front_zone, zone, zones
from openrooms_usd.generation.kit import Kit

# Widths of mattresses, metres.
_SINGLE, _DOUBLE = (0.9, 1.0, 1.2), (1.4, 1.6, 1.8)

# Higher rooms have something else above what is built in, metres.
_MOST_BUILT_IN_M = 2.8
# Skirting boards run behind and beside what is built in, metres.
_AT_WALL_M = 0.016


def bed_place(kit: Kit, double: float = 0.7) -> Group:
    """A bed with its head at the wall, bedside tables with lamps, a picture and a rug."""
    wide = kit.chance(double * (1.0 - kit.modesty))
    widths = _DOUBLE if wide else _SINGLE
    width = widths[int(kit.rng.integers(1 if kit.modesty > 0.6 else len(widths)))]
    bed_size = kit.size("bed", width=width, depth=kit.between(2.0, 2.12))
    bed_size, bed_style = kit.matching("bed", bed_size)
    bed = kit.item("bed", size=bed_size, style=bed_style)
    half, depth = 0.5 * width, bed.size[1]
    size, style = kit.make("night_stand")
    items: list[Item] = [bed]
    sides = (-1, 1) if wide or kit.chance(0.3) else ((1,) if kit.chance(0.5) else (-1,))
    made = kit.make("table_lamp") if kit.chance(0.85) else None
    for side in sides:
        x, y = side * (half + 0.5 * size[0] + 0.05), 0.5 * (depth - size[1]) - 0.01
        table = kit.item("night_stand", round(x, 3), round(y, 3), size=size, style=style,
                         optional=True)  # fmt: skip
        items.append(table)
        # Both sides have the same lamp.
        if made:
            lamp = kit.placed_on(table, "table_lamp", 0.0, 0.05, size=made[0], style=made[1])
            items += [lamp] if lamp else []
    items += above(kit, bed, others=items)
    if kit.chance(0.4):
        rug = kit.size("rug", width=width + 0.5, depth=kit.between(0.6, 1.0))
        y = -0.5 * (depth + rug[1]) - 0.04
        items.append(kit.item("rug", 0.0, round(y, 3), size=rug, optional=True))
    strips = [zone(s * (half + 0.3), -0.3, 0.56, depth - 0.7)
              for s in (sides if wide else sides[:1])]  # fmt: skip
    places = tuple((s * (half + 0.32), -0.3) for s in (sides if wide else sides[:1]))
    return Group("sleeping", tuple(items), zones(strips), places, back=0.5 * depth)


def built_in(kit: Kit) -> Group | None:
    """A wardrobe from wall to wall, or from a corner, as high as the room."""
    high = round(min(kit.clear_height, _MOST_BUILT_IN_M) - 0.03, 2)
    least, most = 1.5, min(3.0, kit.span[0] - 1.2)
    if high < 2.25 or most < least or kit.span[1] < 2.8:
        return None
    whole = kit.modesty < 0.3 and kit.span[1] < 4.0 and kit.chance(0.6)
    width = round(kit.span[1] - 2 * _AT_WALL_M - 0.005 if whole else kit.between(least, most), 2)
    piece = kit.item("wardrobe", size=(width, 0.62, high), style="built_in")
    return Group("clothes", (piece,), zones([front_zone(piece, 0.7)]),
                 ((0.0, -0.5 * piece.size[1] - 0.4),), back=0.5 * piece.size[1], gap=_AT_WALL_M,
                 beside=_AT_WALL_M)  # fmt: skip


def clothes(kit: Kit, name: str = "wardrobe", width: tuple[float, float] = (0.9, 2.2)) -> Group:
    """A wardrobe or a dresser, its doors free to open."""
    size = kit.size(name, width=kit.between(*width))
    size = (size[0], size[1], min(size[2], round(kit.height - 0.1, 2)))
    size, style = kit.matching(name, size)
    piece = kit.item(name, size=size, style=style)
    items: list[Item] = [piece]
    if piece.size[2] < 1.3:
        items += kit.scattered(piece, ("table_lamp", "jar", "bowl"), kit.whole(0, 3), items)
        items += above(kit, piece, others=items)
    return Group("clothes", tuple(items), zones([front_zone(piece, 0.6)]),
                 ((0.0, -0.5 * piece.size[1] - 0.4),), back=0.5 * piece.size[1])  # fmt: skip
