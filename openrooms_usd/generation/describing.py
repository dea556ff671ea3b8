"""From a generated room to the sections of a description, as plain data."""

from dataclasses import replace
from typing import Any, Final

import numpy as np

from openrooms_usd.description.substances import Substance
from openrooms_usd.draws import generator
from openrooms_usd.furniture import category
from openrooms_usd.generation.clutter.living import ABOUT
from openrooms_usd.generation.finishing import shell_style
from openrooms_usd.generation.items import Item, placed, wrapped
from openrooms_usd.generation.rooms import FITTINGS, LIGHT, ON_WALLS, Furnishing, Generated, named
from openrooms_usd.generation.shell import Side
from openrooms_usd.library.styles.assignment.rooms import families_of, surface_of
from openrooms_usd.library.styles.assignment.weights import drawn
from openrooms_usd.library.styles.ensembles import ensemble_of
from openrooms_usd.library.styles.interiors import Color

# Groups whose wall people paint in another colour.
_BEFORE: Final = ("sleeping", "sitting", "media", "dining", "conference", "working")
_COLORS: Final = ((0.2, 0.26, 0.27), (0.33, 0.36, 0.3), (0.5, 0.42, 0.34))
_DECIMALS: Final = 3
_SQUARE_DEG: Final = 1.0


def shell_looks(room: Generated) -> dict[str, Any]:
    """The keys of the materials section for tiles, a wall that differs, boards and beams."""
    rng = generator(room.seed, "generate", room.room_type, "shell looks")
    finish, interior, looks = room.finish, room.interior, dict[str, Any]()
    if finish.accent and (side := _accent_side(room)):
        looks["accents"] = {f"wall_{side.number}": _accent(room, rng)}
    if finish.tiles is not None:
        tiles = families_of(room.room_type, "wall", "specular_stone")
        family = drawn(rng, interior.weighted(tiles) if interior else tiles)
        looks["walls"] = {"family": "paint", "color": _wall_color(room, rng)}
        looks["cladding"] = {"tiles": {"family": family}}
    if finish.wooden and (wood := _wood(room, rng)):
        looks["trim"] = wood
    if finish.ceiling.get("kind") == "beams":
        looks["beams"] = _wood(room, rng) or {"family": "quartered_oak"}
    if finish.ceiling.get("kind") == "coffers":
        looks["beams"] = {"family": "sprayed_satin", "color": [0.79, 0.785, 0.77]}
    return looks


def _accent_side(room: Generated) -> Side | None:
    """The wall behind what the room is about, of whose openings none is a door."""
    doors = {gap.side for gap in room.shell.doors}
    sides = {i: side for i, side in enumerate(room.shell.sides) if i not in doors}
    for title in _BEFORE:
        for name, items in room.furnishing.groups:
            if name == title and items:
                place = np.array([items[0].x, items[0].y])
                yaw = items[0].yaw
                behind = [s for s in sides.values() if abs(_turn(s.yaw - yaw)) < _SQUARE_DEG]
                if behind:
                    return min(behind, key=lambda s: abs(float((place - s.start) @ s.inward)))
    return max(sides.values(), key=lambda side: side.length, default=None)


def _turn(degrees: float) -> float:
    return (degrees + 180.0) % 360.0 - 180.0


def _accent(room: Generated, rng: np.random.Generator) -> dict[str, Any]:
    family = drawn(rng, shell_style(room.style).accents)
    if family != "paint":
        return {"family": family}
    colors = (*room.interior.walls[1:], *room.interior.accents[:2]) if room.interior else _COLORS
    return {"family": "roller_matt", "color": _rounded(colors[int(rng.integers(len(colors)))])}


def _wall_color(room: Generated, rng: np.random.Generator) -> list[float]:
    colors = room.interior.walls if room.interior else ((0.74, 0.74, 0.72),)
    return _rounded(colors[int(rng.integers(len(colors)))])


def _wood(room: Generated, rng: np.random.Generator) -> dict[str, Any] | None:
    if room.interior is None:
        return None
    pairs = {f"{a} {b}": weight for (a, b), weight in room.interior.woods.items()}
    return {"family": drawn(rng, pairs).partition(" ")[0]}


def _rounded(color: tuple[float, float, float]) -> list[float]:
    return [round(value, _DECIMALS) for value in color]


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
