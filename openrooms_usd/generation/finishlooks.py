"""What the shell of a generated room wears beside floor, walls and ceiling."""

from typing import Any, Final

import numpy as np

from openrooms_usd.draws import generator
from openrooms_usd.generation.finishing import shell_style
from openrooms_usd.generation.rooms import Generated
from openrooms_usd.generation.shell import Side
from openrooms_usd.library.styles.assignment.rooms import families_of
from openrooms_usd.library.styles.assignment.weights import drawn

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
