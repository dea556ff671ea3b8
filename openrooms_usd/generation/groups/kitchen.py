"""Kitchens that are built: units in line below one worktop, what is let into it, cabinets above.

A leg is a run of units along one wall. A straight kitchen has one, an L has a second one along the
wall at its end, whose first unit stands before the blind half of the first leg's corner unit.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import groupby
from typing import Final

from openrooms_usd.furniture import CATEGORIES, FitOptions, Size
from openrooms_usd.furniture.categories.hob import BESIDE_M, SUNK_M
from openrooms_usd.furniture.categories.sink import RIM, inset_rim
from openrooms_usd.furniture.joinery.cells import HANDLE
from openrooms_usd.furniture.joinery.pieces import Cutout, Fronts
from openrooms_usd.generation.items import Group, Item, placed, wrapped, zone, zones
from openrooms_usd.generation.kit import Kit
from openrooms_usd.library.styles.assignment.weights import drawn

# Heights: of base units, and of the worktop's upper side; metres.
BASE_M: Final = 0.872
LEVEL_M: Final = 0.91
# The lower edge of what hangs on the wall, of hoods, and the upper edge of all that is tall.
WALL_LOW_M, _HOOD_LOW_M, _TALL_M = 1.46, 1.6, 2.16
_BELOW_CEILING_M: Final = 0.06
# From the wall to the backs and to the fronts of units, and to the worktop's edge; metres.
_BEHIND_M, _FRONT_M, _WORKTOP_M = 0.02, 0.6, 0.63
_WALL_DEPTH_M: Final = 0.34
# Skirting boards end before units that stand at a wall, metres.
_AT_WALL_M: Final = 0.02
_SEAM_M: Final = 0.001
_CORNER_UNIT_M, _FILLER_M = 1.1, 0.05
_OVEN_M: Final = 0.595
# How far a sink stays within its unit, and what its rim covers on each side of its hole; metres.
_WITHIN_M, _RIM_COVER_M = 0.06, 0.015
_FRONTS: Final[Mapping[Fronts, float]] = {"slab": 2, "shaker": 1, "handleless": 1}

# What a unit is for, and its width.
Module = tuple[str, float]


@dataclass
class _Leg:
    """A run under construction: x along the wall to the right, the wall at y = 0.

    Attributes:
        kit: Builds its items.
        fronts: How all fronts look.
        tall: Upper edge of tall units and of what hangs on the wall, metres.
        x: Where the next unit begins, metres.
        items: What it has so far, units and worktops first.
        above: What hangs on the wall above it.
    """

    kit: Kit
    fronts: Fronts
    tall: float
    x: float = 0.0
    items: list[Item] = field(default_factory=list)
    above: list[Item] = field(default_factory=list)

    @property
    def reach(self) -> float:
        return 0.0 if self.fronts == "handleless" else HANDLE

    @property
    def order(self) -> FitOptions:
        return FitOptions(self.fronts)

    def item(
        self, name: str, middle: float, size: Size, style: str, *, front: float = _FRONT_M,
        z: float = 0.0, on: str = "floor", ordered: bool = True, **more: bool,
    ) -> Item:  # fmt: skip
        """Something whose box ends at a distance from the wall, metres."""
        order = self.order if ordered else FitOptions()
        return self.kit.item(name, round(middle, 4), round(0.5 * size[1] - front, 4), size=size,
                             style=style, z=round(z, 4), on=on, order=order, **more)  # fmt: skip

    def unit(self, style: str, width: float, height: float = BASE_M) -> Item:
        """The next unit on the floor."""
        depth = _FRONT_M - _BEHIND_M + self.reach
        made = self.item("kitchen_unit", self.x + 0.5 * width, (width, round(depth, 3), height),
                         style, front=_FRONT_M + self.reach)  # fmt: skip
        self.x += width + _SEAM_M
        self.items.append(made)
        return made

    def filler(self) -> None:
        """Close what a corner leaves open."""
        size = (_FILLER_M, _FRONT_M - _BEHIND_M, BASE_M)
        self.items.append(
            self.item("kitchen_unit", self.x + 0.5 * _FILLER_M, size, "filler", ordered=False)
        )
        self.x += _FILLER_M + _SEAM_M

    def fridge(self, width: float, built_in: bool) -> None:
        """A tall end: behind the kitchen's fronts, or one that stands free."""
        start = self.x
        depth = _FRONT_M - _BEHIND_M + self.reach
        if built_in:
            size = (width, round(depth, 3), self.tall)
            self.items.append(self.item("refrigerator", start + 0.5 * width, size, "built_in",
                                        front=_FRONT_M + self.reach))  # fmt: skip
        else:
            size = self.kit.size("refrigerator", width=width, depth=0.66, style="two_doors")
            self.items.append(self.item("refrigerator", start + 0.5 * width + 0.01, size,
                                        "two_doors", front=0.68, ordered=False))  # fmt: skip
            width += 0.02
        self.x = start + width + _SEAM_M

    def dishwasher(self, width: float) -> None:
        """A machine behind a front of the kitchen."""
        depth = _FRONT_M - _BEHIND_M + self.reach
        self.items.append(
            self.item("dishwasher", self.x + 0.5 * width, (width, round(depth, 3), BASE_M),
                      "integrated", front=_FRONT_M + self.reach)
        )  # fmt: skip
        self.x += width + _SEAM_M

    def range(self, width: float) -> None:
        """A stove with an oven below, which divides the worktop."""
        style = self.kit.pick(("gas", "glass"))
        size = (width - 0.004, _FRONT_M - _BEHIND_M + HANDLE, LEVEL_M)
        self.items.append(self.item("stove", self.x + 0.5 * width, size, style,
                                    front=_FRONT_M + HANDLE, ordered=False))  # fmt: skip
        self.x += width + _SEAM_M

    def oven(self, width: float) -> None:
        """A built-in oven on a low drawer."""
        low = self.unit("drawers", width, round(BASE_M - _OVEN_M, 3))
        size = (width - 0.004, round(_FRONT_M - _BEHIND_M + HANDLE, 3), _OVEN_M)
        self.items.append(self.item("oven", low.x, size, "single", front=_FRONT_M + HANDLE,
                                    z=low.size[2], on=low.key, ordered=False))  # fmt: skip

    def worktop(self, first: float, last: float, sunk: Sequence[tuple[str, float, float]]) -> None:
        """A slab from one x to another, with what is let into it: name, middle and unit's width."""
        middle = 0.5 * (first + last)
        made, holes = [], []
        for name, x, width in sunk:
            thing, hole = self._sunk(name, x, width)
            made.append(thing)
            holes.append((round(x - middle, 4), round(thing.y + 0.5 * _WORKTOP_M, 4), *hole))
        size = (round(last - first, 3), _WORKTOP_M, round(LEVEL_M - BASE_M, 3))
        below = next(item for item in self.items if item.on == "floor" and first < item.x < last)
        top = self.kit.item("worktop", round(middle, 4), -0.5 * _WORKTOP_M, size=size,
                            style="slab", z=BASE_M, on=below.key,
                            order=FitOptions(cutouts=tuple(holes)), sunk=True)  # fmt: skip
        self.items += [top, *(replace(thing, on=top.key) for thing in made)]

    def _sunk(self, name: str, x: float, width: float) -> tuple[Item, tuple[float, float]]:
        """A sink or a hob, and the width and depth of its hole."""
        if name == "sink":
            size = (round(min(width - _WITHIN_M, 0.8), 3), 0.5, 0.47)
            z, style, cover = LEVEL_M - inset_rim(size[2]) + RIM, "inset", _RIM_COVER_M
        else:
            style = self.kit.pick(("glass", "glass", "gas"))
            size = (0.59, 0.52, 0.042 if style == "glass" else 0.078)
            z, cover = LEVEL_M - SUNK_M, BESIDE_M
        made = self.item(name, x, size, style, front=_FRONT_M - 0.03, z=z, ordered=False,
                         sunk=True)  # fmt: skip
        return made, (round(size[0] - 2 * cover, 4), round(size[1] - 2 * cover, 4))

    def wall(self, x: float, width: float, style: str, low: float = WALL_LOW_M) -> None:
        """A cabinet on the wall, its upper edge in line with all others."""
        reach = 0.0 if style == "open" else self.reach
        size = (width, round(_WALL_DEPTH_M + reach, 3), round(self.tall - low, 3))
        self.above.append(
            self.item("kitchen_cabinet", x, size, style, front=size[1] - 0.001, z=low, on="wall",
                      ordered=style != "open", optional=True)
        )  # fmt: skip

    def hood(self, x: float, width: float, style: str) -> None:
        """An extractor above the hob; a slim one has a cabinet above it."""
        if style == "slim":
            size = (width - 0.004, 0.36, 0.07)
            self.wall(x, width, "doors", round(_HOOD_LOW_M + size[2] + _SEAM_M, 3))
        else:
            size = (width - 0.004, 0.46, round(self.kit.clear_height - _HOOD_LOW_M - 0.004, 3))
        self.above.append(
            self.item("hood", x, size, style, front=size[1] - 0.001, z=_HOOD_LOW_M, on="wall",
                      ordered=False, optional=True)
        )  # fmt: skip


def kitchen(kit: Kit) -> Group:
    """A kitchen along one wall, or along two that meet; where it may, its sink below a window."""
    fronts = drawn(kit.rng, kit.interior.fronts if kit.interior else _FRONTS)
    tall = round(min(_TALL_M, kit.clear_height - _BELOW_CEILING_M), 2)
    space, other = (side * (1.0 - 0.35 * kit.modesty) for side in kit.span)
    bent = kit.modesty < 0.5 and other > 2.9 and space > 3.3 and kit.chance(0.6)
    main = _Leg(kit, fronts, tall)
    looks = _Looks(kit)
    if bent:
        modules, second = _bent_modules(kit, space - 0.9, other - 0.9)
    else:
        modules, second = _modules(kit, space - 0.7), ()
    _build(main, modules, looks, end=_AT_WALL_M if second else 0.0)
    items = [*main.items, *main.above]
    wide = main.x + (_AT_WALL_M if second else 0.0)
    clear = [zone(0.5 * wide, -_FRONT_M - 0.5, wide, 0.9)]
    places = [(0.5 * wide, -_FRONT_M - 0.5)]
    if second:
        leg = _Leg(kit, fronts, tall, x=_FRONT_M + 0.002)
        leg.filler()
        _build(leg, second, looks, start=_WORKTOP_M + _SEAM_M)
        turned = _turned([*leg.items, *leg.above], wide)
        items += turned
        deep = leg.x
        clear.append(zone(wide - _FRONT_M - 0.5, -0.5 * (deep + _FRONT_M), 0.9, deep - _FRONT_M))
        places.append((wide - _FRONT_M - 0.5, -0.5 * (deep + _FRONT_M)))
    group = Group("kitchen", tuple(items), zones(clear), tuple(places), gap=0.002, beside=0.02,
                  corner="right" if second else "", window_at=_sink_at(items))  # fmt: skip
    group = _mirrored(group) if kit.chance(0.5) else group
    return replace(group, items=(*group.items, *_appliances_on(kit, group.items)))


@dataclass
class _Looks:
    """What a kitchen has one way throughout."""

    kit: Kit

    def __post_init__(self) -> None:
        self.built_in = self.kit.chance(0.55)
        self.ranged = self.kit.chance(0.25)
        self.hood = self.kit.pick(("chimney", "chimney", "angled", "slim"))
        self.wall = self.kit.pick(("doors", "doors", "doors", "flaps"))
        # One of its wall cabinets may be another than the rest.
        self.special = self.kit.pick(("open", "glass", self.wall, self.wall))


def _modules(kit: Kit, space: float) -> tuple[Module, ...]:
    """A straight kitchen: the tall end, the sink, room to prepare, the hob, an end."""
    modest = space < 2.6
    row: list[Module] = [("fridge", 0.6), ("sink", 0.6), ("drawers", 0.4 if modest else 0.6),
                         ("hob", 0.6), ("doors", 0.3 if modest else 0.4)]  # fmt: skip
    for place, module in (
        (2, ("dishwasher", 0.6)), (1, ("drawers", 0.4)), (len(row) + 2, ("drawers", 0.6)),
        (1, ("tall", 0.6)),
    ):  # fmt: skip
        if sum(width for _, width in row) + module[1] < space:
            row.insert(place, module)
    return tuple(row)


def _bent_modules(
    kit: Kit, space: float, other: float
) -> tuple[tuple[Module, ...], tuple[Module, ...]]:
    """Both legs of an L: the sink on the longer one, the hob round the corner."""
    row: list[Module] = [("fridge", 0.6), ("sink", 0.6), ("corner", _CORNER_UNIT_M)]
    for place, module in ((2, ("dishwasher", 0.6)), (1, ("drawers", 0.6)), (1, ("tall", 0.6))):
        if sum(width for _, width in row) + module[1] < space:
            row.insert(place, module)
    leg: list[Module] = [("drawers", 0.4), ("hob", 0.6), ("doors", 0.3)]
    start = _FRONT_M + _FILLER_M
    if start + 1.9 < other:
        leg = [("drawers", 0.6), ("hob", 0.6), ("doors", 0.6)]
    return tuple(row), tuple(leg)


def _build(
    leg: _Leg, modules: Sequence[Module], looks: _Looks, start: float | None = None,
    end: float = 0.0,
) -> None:  # fmt: skip
    """Set up the units of a leg, its worktops and what hangs above it.

    Args:
        leg: Gets them.
        modules: What it consists of, from its left.
        looks: What is alike throughout.
        start: Where its first worktop begins, where that is not its first unit, metres.
        end: How far its last worktop reaches beyond its last unit, metres.
    """
    spans: list[tuple[str, float, float]] = []
    for name, width in modules:
        before = leg.x
        _set_up(leg, name, width, looks)
        spans.append((name, before, leg.x - _SEAM_M))
    breaks = {"fridge", "tall"} | ({"hob"} if looks.ranged else set())
    for divides, run in groupby(spans, key=lambda span: span[0] in breaks):
        parts = list(run)
        if divides:
            continue
        first = start if start is not None and parts[0] == spans[0] else parts[0][1]
        last = parts[-1][2] + (end if parts[-1] == spans[-1] else 0.0)
        sunk = [(name, 0.5 * (a + b), b - a) for name, a, b in parts if name in ("sink", "hob")]
        leg.worktop(first, last, sunk)
    special = int(leg.kit.rng.integers(len(spans)))
    for number, (name, a, b) in enumerate(spans):
        x, width = 0.5 * (a + b), round(b - a, 3)
        if name == "hob":
            leg.hood(x, width, looks.hood)
        elif name not in breaks and leg.tall - WALL_LOW_M > 0.4:
            leg.wall(x, width, looks.special if number == special else looks.wall)


def _set_up(leg: _Leg, name: str, width: float, looks: _Looks) -> None:
    """The next module of a leg."""
    if name == "fridge":
        leg.fridge(width, looks.built_in)
    elif name == "tall":
        leg.unit("doors", width, leg.tall)
    elif name == "dishwasher":
        leg.dishwasher(width)
    elif name == "hob":
        (leg.range if looks.ranged else leg.oven)(width)
    else:
        leg.unit("corner_right" if name == "corner" else name, width)


def _turned(items: Iterable[Item], wide: float) -> list[Item]:
    """A leg that begins in the corner at x = ``wide`` and runs along the wall on the right."""
    pose = (wide, 0.0, -90.0)
    return [
        replace(item, x=round(x, 4), y=round(y, 4), yaw=wrapped(item.yaw - 90.0))
        for item in items
        for x, y in [placed(pose, item.x, item.y)]
    ]


_OTHER_SIDE: Final = {"corner_right": "corner_left", "corner_left": "corner_right"}


def _mirrored(group: Group) -> Group:
    """The same kitchen from right to left."""
    boxes = group.zones.copy()
    boxes[:, [0, 3]] *= -1.0
    return replace(
        group,
        items=tuple(_mirror(item) for item in group.items),
        zones=boxes,
        access=tuple((-x, y) for x, y in group.access),
        corner="left" if group.corner else "",
        window_at=None if group.window_at is None else -group.window_at,
    )


def _mirror(item: Item) -> Item:
    holes: tuple[Cutout, ...] = tuple((-x, y, w, d) for x, y, w, d in item.order.cutouts)
    return replace(
        item, x=-item.x, yaw=wrapped(-item.yaw), style=_OTHER_SIDE.get(item.style, item.style),
        order=replace(item.order, cutouts=holes),
    )  # fmt: skip


def _sink_at(items: Iterable[Item]) -> float | None:
    """X of the sink where it is on the first leg, metres."""
    return next((item.x for item in items if item.category == "sink" and not item.yaw), None)


def island(kit: Kit) -> Group:
    """A block in the middle of a kitchen, with stools where its worktop stands out."""
    block = kit.item("counter", size=(kit.between(1.4, 2.2), 0.95, LEVEL_M), style="island")
    width, depth, _ = block.size
    first = kit.item("stool", size=(0.38, 0.38, 0.64), optional=True)
    count = max(1, int((width - 0.2) / 0.6))
    items = [block]
    for number in range(count):
        along = (number - 0.5 * (count - 1)) * 0.6
        stool = kit.tucked(first, block, along, 90.0, items[1:], jitter=12.0)
        items += [stool] if stool else []
    room = [zone(0.0, side * (0.5 * depth + 0.5), width, 0.9) for side in (-1, 1)]
    places = tuple((0.0, side * (0.5 * depth + 0.5)) for side in (-1, 1))
    return Group("island", tuple(items), zones(room), places, anchor="free")


@cache
def _appliances() -> dict[str, float]:
    """What stands on worktops, and on which share of them."""
    return {name: told.on_worktop_probability for name, told in CATEGORIES.items()}


def _appliances_on(kit: Kit, items: Sequence[Item]) -> list[Item]:
    """One appliance or two at the back of the worktops, clear of all that is there."""
    made: list[Item] = []
    for top in [item for item in items if item.category == "worktop"]:
        for name, share in _appliances().items():
            if not kit.chance(share) or name in {item.category for item in made}:
                continue
            for _ in range(6):
                x = round(float(kit.rng.uniform(-0.45, 0.45)) * top.size[0], 2)
                found = kit.placed_on(top, name, x, 0.08, beside=[*items, *made])
                if found:
                    made.append(found)
                    break
    return made
