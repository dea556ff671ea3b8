"""From a generated room to the sections of a description, as plain data."""

from typing import Any, Final

import numpy as np

from openrooms_usd.categories.record import given
from openrooms_usd.description.substances import Substance
from openrooms_usd.draws import generator
from openrooms_usd.generate.items import Item, placed, wrapped
from openrooms_usd.generate.rooms import (
    LIGHT,
    ON_WALLS,
    Furnishing,
    Generated,
    named,
    program_of,
)
from openrooms_usd.library.assignment.rooms import surface_of
from openrooms_usd.library.ensembles import ensemble_of
from openrooms_usd.library.furniture import category
from openrooms_usd.library.interiors import Color

# Flux of lamps that are not on the ceiling, as a share of what their category usually has.
_SHARE: Final = (0.6, 1.3)
# Colour temperature, kelvin: of ceiling lamps and of all others.
_KELVIN: Final = {True: (4000, 8000), False: (4000, 5200)}
# How much of the lamps' flux reaches the floor, roughly.
_FLUX_ON_FLOOR_SHARE: Final = 0.5

Section = dict[str, Any]


def layout_section(room: Generated) -> Section:
    """The shell of a generated room."""
    return {
        "from": "polygon",
        "polygon": [[_tidy(x), _tidy(y)] for x, y in room.shell.corners.tolist()],
        "height": room.shell.height,
        "openings": [dict(row) for row in room.openings],
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
        alone = root[1] is item or title in (ON_WALLS, LIGHT)
        rows.append((title, _row(name, item, carrier, None if alone else root)))
    return rows


def _row(name: str, item: Item, carrier: str, root: tuple[str, Item] | None) -> Section:
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


def lamps(room: Generated) -> dict[str, Section]:
    """What every lamp emits: those on the ceiling together give the floor its illuminance."""
    rng = generator(room.seed, "generate", room.room_type, "lamps")
    ceiling: list[str] = []
    found: dict[str, Section] = {}
    cool = _kelvin(rng, True)
    warm = _kelvin(rng, False)
    for _, name, item, _ in named(room.furnishing.groups):
        spec = category(item.category)
        if item.category == "ceiling_lamp":
            ceiling.append(name)
        elif spec.emits:
            lumen = round(given(spec.lumen, 0.0) * float(rng.uniform(*_SHARE)), -1)
            found[name] = {"lumen": lumen, "kelvin": warm}
    lux = float(rng.uniform(*program_of(room.room_type).lux))
    each = lux * room.shell.area / _FLUX_ON_FLOOR_SHARE / max(len(ceiling), 1)
    above = {name: {"lumen": round(each, -1), "kelvin": cool} for name in ceiling}
    return above | found


def _kelvin(rng: np.random.Generator, above: bool) -> int:
    low, high = _KELVIN[above]
    return 100 * int(rng.integers(low // 100, high // 100 + 1))


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
    }


def _look(family: str, _: Substance, color: Color | None) -> str | Section:
    """What is said of a surface: its family, and its colour where it has one."""
    return {"family": family, "color": list(color)} if color else family


def environment(room: Generated) -> Section:
    """The world outside."""
    rng = generator(room.seed, "generate", room.room_type, "environment")
    lux = round(float(np.exp(rng.uniform(np.log(3_000), np.log(25_000)))), -2)
    return {"from": "constant", "color": [0.85, 0.95, 1.0], "illuminance": lux}
