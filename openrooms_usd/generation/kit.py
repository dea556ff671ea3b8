"""What groups are built with: sizes and styles from the library, tops, and chairs below tables."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture import NOTHING_ORDERED, FitOptions, Size, category, styles
from openrooms_usd.generation.boxes import Pose, box, overlap, posed
from openrooms_usd.generation.items import Group, Item, with_dependants
from openrooms_usd.generation.shapes import BuiltForm, Foot, Shapes
from openrooms_usd.generation.sizes import drawn_size
from openrooms_usd.library.styles.assignment.weights import drawn
from openrooms_usd.library.styles.interiors import Interior
from openrooms_usd.names import ROOM_HEIGHT

# What rises less than this above a top is not an obstacle on it, metres.
_ROUNDING = 1e-4


def level_top(support: BuiltForm, size: Size, foot: Foot, pose: Pose, slack: float) -> float | None:
    """Height of a support's top above its base where an item shall stand.

    Args:
        support: What carries it.
        size: Of the item, metres: nothing of the support may rise into its box.
        foot: What the item stands on, in its own frame.
        pose: Of the item, in the support's frame.
        slack: How far below its middle the top may fall away under the foot, metres.

    Returns:
        None where the top is not level, too small or not free.
    """
    x, y, yaw = pose
    middle = float(support.tops(np.array([x]), np.array([y]))[0])
    if middle == -np.inf:
        return None  # beside it, or over a hole
    below = support.tops(*_grid(foot, pose))
    half = (0.5 * size[0], 0.5 * size[1])
    above = support.tops(*_grid((-half[0], -half[1], *half), pose))
    # Thin rims slip through a grid, but not their corners.
    highest = support.highest(box(x, y, size[0], size[1], 0.0, 0.0, yaw))
    if max(below.max(), above.max(), highest) > middle + _ROUNDING:
        return None
    return None if below.min() < middle - slack else middle


def above_foot(foot: Foot, x: float, y: float, yaw: float) -> tuple[float, float]:
    """Where an item stands whose foot has its middle at a place; to the millimetre."""
    u, v = 0.5 * (foot[0] + foot[2]), 0.5 * (foot[1] + foot[3])
    c, s = float(np.cos(np.radians(yaw))), float(np.sin(np.radians(yaw)))
    return round(x - c * u + s * v, 3), round(y - s * u - c * v, 3)


def _grid(area: Foot, pose: Pose) -> tuple[Array, Array]:
    """Places on a 5 by 5 grid over an area of an item that stands at a pose."""
    x, y, yaw = pose
    u, v = np.meshgrid(np.linspace(area[0], area[2], 5), np.linspace(area[1], area[3], 5))
    c, s = np.cos(np.radians(yaw)), np.sin(np.radians(yaw))
    return x + c * u.ravel() - s * v.ravel(), y + s * u.ravel() + c * v.ravel()


# An object rests on a top that is level to this, metres.
_LEVEL_TOLERANCE_M: Final = 0.001
_PILE_HEIGHT_M: Final = 0.003
# Overlap of two boxes that is no more than touching, metres.
_TOUCHING_GAP_M: Final = -0.001
# What stands farther from a chair than this does not touch it, metres.
_CHAIR_RANGE_M: Final = 2.5
# What lies between two objects of a group, metres.
APART_M: Final = 0.012


@dataclass
class Kit:
    """Builds the items of one group.

    Attributes:
        rng: Draws everything.
        shapes: The real form of objects.
        height: Floor to ceiling, metres.
        span: Width and depth of the room, the longer first; metres.
        interior: The style of the room, if it has one.
        clear_height: Up to where nothing is fixed along walls or below the ceiling, metres.
        room_type: One of the 27; empty where none is meant.
        modesty: 0 at the first try; grows when a group did not fit, and asks for less.
    """

    rng: np.random.Generator
    shapes: Shapes
    height: float = ROOM_HEIGHT
    span: tuple[float, float] = (5.0, 4.0)
    interior: Interior | None = None
    clear_height: float = ROOM_HEIGHT
    room_type: str = ""
    modesty: float = 0.0
    _count: dict[str, int] = field(default_factory=dict)
    _makes: dict[str, tuple[Size, str]] = field(default_factory=dict)
    _standing: dict[str, tuple[Size, str]] = field(default_factory=dict)

    def between(self, low: float, high: float) -> float:
        """A number, to the centimetre; nearer to the low end the more modest the group must be."""
        return round(float(self.rng.uniform(low, high - self.modesty * (high - low))), 2)

    def whole(self, low: int, high: int) -> int:
        """A whole number, both ends included; smaller the more modest the group must be."""
        most = round(high - self.modesty * (high - low))
        return int(self.rng.integers(low, most + 1))

    def chance(self, probability: float) -> bool:
        """True as often as this."""
        return bool(self.rng.random() < probability)

    def pick(self, choices: Sequence[str]) -> str:
        """One of some names."""
        return choices[int(self.rng.integers(len(choices)))]

    def pick_number(self, choices: Sequence[float]) -> float:
        """One of some numbers; one of the smaller half for a modest group."""
        count = len(choices) if self.modesty < 0.5 else (len(choices) + 1) // 2
        return choices[int(self.rng.integers(count))]

    def style(self, name: str, size: Size | None = None) -> str:
        """One of a category's styles that suit a size; of all of them when there is none.

        What stands on floors is of a style that does so by its record.
        """
        suited, known = _on_floors(name) if size is None else styles(name, size), category(name)
        own = [style for style in suited if known.styles[style].is_of(self.room_type)] or suited
        weights = {style: known.styles[style].weight for style in own}
        if self.interior is None:
            return drawn(self.rng, weights)
        return self.interior.style_of(name, weights, self.rng)

    def size(
        self,
        name: str,
        width: float | None = None,
        depth: float | None = None,
        height: float | None = None,
        *,
        style: str | None = None,
    ) -> Size:
        """A size in the category's usual range, to the centimetre; given sides are kept."""
        given = (width, depth, height)
        usual = (category(name).styles[style].size if style else None) or category(name).size
        return drawn_size(self.rng, name, usual, given, self.modesty)

    def make(self, name: str) -> tuple[Size, str]:
        """A size and a style; the same ones again for what is alike in a room."""
        if name in self._makes:
            return self._makes[name]
        style = self.style(name)
        size = self.size(name, style=style)
        if style not in styles(name, size):
            style = self.style(name, size)
        if category(name).one_variant_per_room:
            self._makes[name] = size, style
        return size, style

    def shared(self, what: str, size: Size, style: str) -> tuple[Size, str]:
        """The first make that a room drew for some use, for all that follow."""
        return self._makes.setdefault(what, (size, style))

    def matching(self, name: str, size: Size) -> tuple[Size, str]:
        """A size and a style for a piece: those of the first that stands in the room, if any.

        A piece of another width has its style, depth and height, where that suits the style.
        """
        first = self._standing.get(name)
        if first is None:
            return size, self.style(name, size)
        size = (size[0], *first[0][1:])
        return (size, first[1]) if first[1] in styles(name, size) else first

    def remember(self, items: Iterable[Item]) -> None:
        """Take in what has found its place: what comes later matches it."""
        for item in items:
            self._standing.setdefault(item.category, (item.size, item.style))

    def item(
        self,
        name: str,
        x: float = 0.0,
        y: float = 0.0,
        yaw: float = 0.0,
        *,
        size: Size | None = None,
        style: str | None = None,
        z: float = 0.0,
        on: str = "floor",
        optional: bool = False,
        order: FitOptions = NOTHING_ORDERED,
        sunk: bool = False,
    ) -> Item:
        """An item with a key of its own; size and style are drawn where they are not given."""
        if size is None:
            size, style = (
                self.make(name) if style is None else (self.size(name, style=style), style)
            )
        number = self._count.get(name, 0)
        self._count[name] = number + 1
        style = style or self.style(name, size)
        return Item(f"{name}_{number}", name, size, style, x, y, z, yaw, on, optional, order, sunk)

    def like(self, other: Item, x: float, y: float, yaw: float = 0.0) -> Item:
        """Another item of the same make."""
        return self.item(
            other.category, x, y, yaw,
            size=other.size, style=other.style, z=other.z, on=other.on, optional=other.optional,
            order=other.order, sunk=other.sunk,
        )  # fmt: skip

    def placed_on(
        self,
        support: Item,
        name: str,
        x: float,
        y: float,
        yaw: float = 0.0,
        *,
        beside: Sequence[Item] = (),
        size: Size | None = None,
        style: str | None = None,
        slack: float = _LEVEL_TOLERANCE_M,
    ) -> Item | None:
        """An item on the top of another; None where the top is not level, too small or taken.

        Args:
            support: What carries it.
            name: Its category.
            x: Place of the middle of its foot in the support's frame, metres.
            y: Likewise.
            yaw: In the support's frame, degrees.
            beside: The group's other items.
            size: Its size; drawn by default.
            style: Its style, where its size is given; drawn by default.
            slack: How far below its middle the top may fall away under it, metres.
        """
        size, style = self.make(name) if size is None else (size, style or self.style(name, size))
        foot = self.shapes.of(name, size, style).foot
        x, y = above_foot(foot, x, y, yaw)
        top = level_top(self._shape(support), size, foot, (x, y, yaw), slack)
        if top is None:
            return None
        gx, gy = support.at(x, y)
        z, turn = support.z + top, support.yaw + yaw
        found = Item("", name, size, style, gx, gy, z, turn, support.key, True)
        others = [item.box for item in beside if item.key != support.key]
        if others and overlap(found.box[None], np.array(others), 0.01).any():
            return None
        return self.item(
            name, gx, gy, turn, size=size, style=style, z=z, on=support.key, optional=True
        )

    def carpet(self, width: float, depth: float, x: float, y: float, held: Size) -> Item | None:
        """A rug that is level where it shall carry something; None when no style is.

        Args:
            width: Metres.
            depth: Metres.
            x: Its middle, metres.
            y: Likewise.
            held: What it carries in its middle, metres.
        """
        size = self.size("rug", width=width, depth=depth)
        for style in self.rng.permutation(styles("rug", size)).tolist():
            rug = self.item("rug", round(x, 3), round(y, 3), size=size, style=style)
            foot = (-0.5 * held[0], -0.5 * held[1], 0.5 * held[0], 0.5 * held[1])
            if level_top(self._shape(rug), held, foot, (0.0, 0.0, 0.0), _PILE_HEIGHT_M) is not None:
                return rug
        return None

    def scattered(
        self, support: Item, names: Sequence[str], count: int, beside: Sequence[Item]
    ) -> list[Item]:
        """Some small things on a top, wherever there is room."""
        made: list[Item] = []
        for _ in range(3 * count):
            if len(made) == count:
                break
            x, y = self.rng.uniform(-0.42, 0.42, 2) * support.size[:2]
            turn = float(self.rng.uniform(-30, 30))
            found = self.placed_on(
                support, self.pick(names), round(float(x), 2), round(float(y), 2), round(turn),
                beside=[*beside, *made],
            )  # fmt: skip
            if found:
                made.append(found)
        return made

    def slices(self, item: Item) -> Array:
        """(B, 8) boxes in the group's frame that hold all of an item."""
        boxes: Array = posed(self._shape(item).slices, (item.x, item.y, item.yaw))[0]
        boxes[:, 6:] += item.z
        return boxes

    def _shape(self, item: Item) -> BuiltForm:
        return self.shapes.of(item.category, item.size, item.style, item.order)

    def clash(self, a: Item, b: Item, gap: float = APART_M) -> bool:
        """Whether two items come too near to each other, by their real parts."""
        if not overlap(a.box[None], b.box[None], gap).any():
            return False
        return bool(overlap(self.slices(a), self.slices(b), gap).any())

    def apart(self, group: Group) -> Group | None:
        """A group without those of its optional items that run into others.

        Returns:
            None where items run into each other that it needs.
        """
        near = overlap(group.boxes, group.boxes, _TOUCHING_GAP_M)
        kept: list[bool] = []
        for index, item in enumerate(group.items):
            others = [group.items[i] for i in np.flatnonzero(near[index, :index]) if kept[i]]
            others = [other for other in others if other.key != item.on]
            free = not any(self.clash(item, other, _TOUCHING_GAP_M) for other in others)
            if not free and not item.optional:
                return None
            kept.append(free)
        standing = with_dependants(kept, group.items)
        items = [item for item, stands in zip(group.items, standing, strict=True) if stands]
        return replace(group, items=tuple(items))

    def tucked(
        self,
        chair: Item,
        table: Item,
        along: float,
        side: float,
        others: Sequence[Item] = (),
        deepest: float = 0.6,
        jitter: float = 6.0,
    ) -> Item | None:
        """A chair that looks at a table, pushed below its top as far as both allow.

        Args:
            chair: What stands there: only its make counts.
            table: The table.
            along: Place along that side of the table, in its frame, metres.
            side: Direction of the chair from the table's middle, in its frame, degrees: -90 is
                before it, 0 at its right end.
            others: What it must not touch either.
            deepest: Largest share of the chair's depth below the top.
            jitter: How far it may be turned, degrees.
        """
        turn = np.radians(side)
        out = np.array([np.cos(turn), np.sin(turn)])
        across = np.array([-out[1], out[0]])
        half = 0.5 * float(np.abs(out) @ table.size[:2])
        yaw = side - 90.0 + float(self.rng.uniform(-jitter, jitter))
        depth = chair.size[1]
        wanted = float(self.rng.uniform(0.2, deepest))
        for share in (wanted, *np.arange(round(wanted, 1) - 0.1, -0.51, -0.1)):
            place = out * (half + depth * (0.5 - share) + 0.02) + across * along
            x, y = table.at(float(place[0]), float(place[1]))
            near = Item(
                "", chair.category, chair.size, chair.style, round(x, 3), round(y, 3), chair.z,
                round(table.yaw + yaw, 1), chair.on,
            )  # fmt: skip
            close = [
                other for other in others if abs(other.x - x) + abs(other.y - y) < _CHAIR_RANGE_M
            ]
            if not any(self.clash(near, other) for other in (table, *close)):
                return self.like(chair, near.x, near.y, near.yaw)
        return None


@cache
def _on_floors(name: str) -> tuple[str, ...]:
    """A category's styles, without those that lie on furniture and sills alone."""
    known = category(name)
    if known.support != "floor":
        return tuple(known.styles)
    said = {
        style: {place for placement in known.placements if style in (placement.styles or (style,))
                for place in placement.on}
        for style in known.styles
    }  # fmt: skip
    found = tuple(
        style for style, places in said.items()
        if not places or any(place.startswith("floor_") for place in places)
    )  # fmt: skip
    return found or tuple(known.styles)
