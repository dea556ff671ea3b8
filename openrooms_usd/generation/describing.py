"""From a generated room to the sections of a description, as plain data."""

from dataclasses import replace
from typing import Any, Final

from openrooms_usd.description.substances import Substance
from openrooms_usd.draws import generator
from openrooms_usd.furniture import category
from openrooms_usd.generation.clutter.living import ABOUT
from openrooms_usd.generation.finishlooks import shell_looks
from openrooms_usd.generation.items import Item, placed, wrapped
from openrooms_usd.generation.rooms import FITTINGS, LIGHT, ON_WALLS, Furnishing, Generated, named
from openrooms_usd.library.styles.assignment.rooms import surface_of
from openrooms_usd.library.styles.ensembles import ensemble_of
from openrooms_usd.library.styles.interiors import Color

# What hangs is placed so far before its wall, whose face is rounded to the millimetre, metres.
_BEFORE_WALL_M: Final = 0.005

Section = dict[str, Any]


def layout_section(room: Generated) -> Section:
    """The shell of a generated room."""
    return {
        "from": "polygon",
        "polygon": [[_tidy(x), _tidy(y)] for x, y in room.shell.corners.tolist()],
        "height": room.shell.height,
        "openings": [dict(row) for row in room.openings],
        **room.finish.layout,
    }


def objects(furnishing: Furnishing) -> list[tuple[str, Section]]:
    """The objects with the titles of their groups.

    The first of a group has its place in the room; the others have theirs in its frame, so that a
    group moves as one.
    """
    rows: list[tuple[str, Section]] = []
    roots: dict[int, tuple[str, Item]] = {}
    groups = [index for index, (_, items) in enumerate(furnishing.groups) for _ in items]
    for index, (title, name, item, carrier) in zip(groups, named(furnishing.groups), strict=True):
        root = roots.setdefault(index, (name, item))
        alone = root[1] is item or title in (ON_WALLS, FITTINGS, LIGHT, ABOUT)
        rows.append((title, row_of(name, item, carrier, None if alone else root)))
    return rows


def row_of(name: str, item: Item, carrier: str, root: tuple[str, Item] | None) -> Section:
    """One object of a description; in the frame of another where there is one."""
    if item.on == "wall":
        # It hangs on the wall nearest to its place: that of its back, also beside a corner.
        x, y = item.at(0.0, 0.5 * item.size[1] - _BEFORE_WALL_M)
        item = replace(item, x=x, y=y)
    x, y, yaw = item.x, item.y, item.yaw
    row: Section = {"name": name, "category": item.category}
    if root is not None:
        x, y, yaw = _within(root[1], item)
        row["relative_to"] = root[0]
    height = [round(item.z, 4)] if item.on == "wall" or item.sunk or item.lies else []
    row["at"] = [_tidy(x), _tidy(y), *height]
    if _tidy(wrapped(yaw)) and item.on != "wall":
        row["yaw"] = _tidy(wrapped(yaw))
    if any(item.tilt):
        row["tilt"] = [_tidy(angle) for angle in item.tilt]
    if carrier != category(item.category).support:
        row["on"] = carrier
    row |= {"size": list(item.size), "style": item.style}
    if item.order.fronts:
        row["fronts"] = item.order.fronts
    if item.order.cutouts:
        row["cutouts"] = [[_tidy(value) for value in hole] for hole in item.order.cutouts]
    return row


def _within(root: Item, item: Item) -> tuple[float, float, float]:
    """Place and yaw of an item in the frame of another."""
    x, y = placed((0.0, 0.0, -root.yaw), item.x - root.x, item.y - root.y)
    return x, y, item.yaw - root.yaw


def _tidy(value: float) -> float:
    """To the millimetre (or a thousandth of a degree), without a negative zero."""
    return round(value, 3) + 0.0


def materials_section(room: Generated) -> Section:
    """Floor, walls and ceiling."""
    rng = generator(room.seed, "generate", room.room_type, "materials")
    if room.interior is None:
        floor, _ = surface_of(room.room_type, "floor", rng)
        walls, _ = surface_of(room.room_type, "wall", rng)
        return {
            "floor": floor,
            "walls": walls,
            "ceiling": {"family": "paint", "color": [0.82, 0.82, 0.81]},
        }
    shared = ensemble_of(room.interior, rng)
    return {
        "floor": _look(*shared.surface(room.room_type, "floor", rng)),
        "walls": _look(*shared.surface(room.room_type, "wall", rng)),
        "ceiling": {"family": "paint", "color": list(shared.ceiling)},
        **shell_looks(room),
    }


def _look(family: str, _: Substance, color: Color | None) -> str | Section:
    """What is said of a surface: its family, and its colour where it has one."""
    return {"family": family, "color": list(color)} if color else family
