"""Kitchen units: counters with a worktop, and cabinets on the wall."""

from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.carcass import Carcass
from openrooms_usd.furniture.joinery.cells import BOARD, HANDLE, SEAT, Cell, columns, rows
from openrooms_usd.furniture.joinery.fronts import (
    FrontDesign,
    doors,
    drawer,
    drawers,
    drawn_look,
    hang_door,
    leaf,
    ordered_look,
    reach,
)
from openrooms_usd.furniture.joinery.pieces import NOTHING_ORDERED, FitOptions, Furniture, Size

TOE: Final = 0.1
WORKTOP: Final = 0.038
UNIT: Final = 0.6
# How far the plinth stands back behind the fronts, metres.
RECESS: Final = 0.055


def kickboard(made: Assembly, width: float, front: float, back: float) -> None:
    """A plinth that runs on below the neighbours.

    Args:
        made: Gets it.
        width: Metres.
        front: Y of the outer side of the fronts above it, metres.
        back: Y of its back, metres.
    """
    half = 0.5 * width
    made.board("kickboard", (-half, front + RECESS, 0.0), (half, back, TOE), 0.0005)


def base_unit(size: Size, overhang: float = 0.0) -> Carcass:
    """The carcass below a worktop, with a recessed plinth and the worktop itself.

    Args:
        size: Of the whole, metres.
        overhang: How far the worktop stands out at the back, metres.
    """
    width, depth, height = size
    front = -0.5 * depth + HANDLE + BOARD + SEAT
    unit = Carcass(width, front, 0.5 * depth - overhang, TOE, height - WORKTOP).boards()
    unit.plinth(0.05)
    return unit


def worktop(unit: Carcass, size: Size) -> None:
    """A slab that stands out over the fronts, less than the handles do."""
    width, depth, height = size
    front = unit.face - BOARD - 0.015
    top = board((-0.5 * width, front, height - WORKTOP), (0.5 * width, 0.5 * depth, height), 0.004)
    unit.made.add("countertop", top)


def _bays(unit: Carcass) -> list[tuple[Cell, Cell]]:
    """What the fronts of each 60 cm cover, and the openings behind them."""
    count = max(1, round(unit.width / UNIT))
    return list(zip(columns(unit.overlay, count), unit.bays(count), strict=True))


def counter_doors(size: Size, rng: np.random.Generator) -> Furniture:
    """A drawer above a door, unit by unit."""
    unit = base_unit(size)
    worktop(unit, size)
    look = drawn_look(rng)
    for i, (cell, bay) in enumerate(_bays(unit)):
        lower, upper = rows(cell, [cell[3] - cell[2] - 0.16, 0.16])
        drawer(unit.made, upper, unit.face, unit.back - 0.05, look)
        side_by_side = cell[1] - cell[0] > 0.75
        if side_by_side:
            doors(unit.made, lower, unit.face, look)
        else:
            _single(unit, lower, look, bool(i % 2))
        unit.shelf(bay, bay[2] + 0.48 * (lower[3] - bay[2]))
    return unit.made.furniture()


def _single(unit: Carcass, cell: Cell, look: FrontDesign, right: bool) -> None:
    x = cell[0] + 0.04 if right else cell[1] - 0.04
    hang_door(
        unit.made, cell, unit.face, "right" if right else "left", look, handle=(x, cell[3] - 0.12)
    )


def counter_drawers(size: Size, rng: np.random.Generator) -> Furniture:
    """Three deep drawers in each unit."""
    unit = base_unit(size)
    worktop(unit, size)
    look = drawn_look(rng, 0.3)
    for cell, _ in _bays(unit):
        drawers(unit.made, cell, unit.face, unit.back - 0.05, look, 0.26)
    return unit.made.furniture()


def counter_open(size: Size, rng: np.random.Generator) -> Furniture:
    """Open shelves next to units with doors."""
    unit = base_unit(size)
    worktop(unit, size)
    look, start = drawn_look(rng), int(rng.integers(2))
    for i, (cell, bay) in enumerate(_bays(unit)):
        unit.shelves(bay, 0.36, 0.02)
        if (i + start) % 2:
            _single(unit, cell, look, bool(i % 2))
    return unit.made.furniture()


def island(size: Size, rng: np.random.Generator) -> Furniture:
    """Drawers and doors before, a worktop that stands out behind, where one sits."""
    unit = base_unit(size, min(0.3, 0.33 * size[1]))
    worktop(unit, size)
    look = drawn_look(rng)
    for i, (cell, bay) in enumerate(_bays(unit)):
        if i % 2:
            drawers(unit.made, cell, unit.face, unit.back - 0.05, look, 0.26)
        else:
            _single(unit, cell, look, False)
            unit.shelves(bay, 0.36, 0.02)
    panel = leaf(size[0], unit.high, 0.02, frame=0.07)
    turned = panel.transformed(np.diag([-1.0, -1.0, 1.0]))
    unit.made.add("panel", turned.moved((0.0, unit.back, 0.0)))
    return unit.made.furniture()


def _wall_unit(size: Size, look: FrontDesign | None = None) -> Carcass:
    width, depth, height = size
    room = reach(look) + BOARD + SEAT if look else 0.0
    return Carcass(width, -0.5 * depth + room, 0.5 * depth, 0.0, height).boards()


def wall_doors(
    size: Size,
    rng: np.random.Generator,
    order: FitOptions = NOTHING_ORDERED,
    *,
    glass: bool = False,
) -> Furniture:
    """Doors in pairs before shelves, their handles at the lower edge."""
    look = replace(ordered_look(order, rng), glass=glass)
    unit = _wall_unit(size, look)
    count = max(1, round(size[0] / 0.9))
    leaves = columns(unit.overlay, max(1, round(size[0] / 0.5)))
    for i, cell in enumerate(leaves):
        right = i % 2 == 1
        x = cell[0] + 0.035 if right else cell[1] - 0.035
        hang_door(
            unit.made,
            cell,
            unit.face,
            "right" if right else "left",
            look,
            handle=(x, cell[2] + 0.12),
            length=0.13,
        )
    for bay in unit.bays(count):
        unit.shelves(bay, 0.3, 0.02)
    return unit.made.furniture()


def wall_flaps(
    size: Size, rng: np.random.Generator, order: FitOptions = NOTHING_ORDERED
) -> Furniture:
    """Wide flaps that open upwards, one above the other where it is high."""
    look = ordered_look(order, rng)
    unit = _wall_unit(size, look)
    left, right, low, high = unit.overlay
    tiers = rows((left, right, low, high), [1.0] * max(1, round((high - low) / 0.4)))
    for i, cell in enumerate(tiers):
        if i:
            unit.shelf(unit.inside, cell[2])
        for part in columns(cell, max(1, round(size[0] / 1.0))):
            handle = (0.5 * (part[0] + part[1]), part[2] + 0.04)
            hang_door(unit.made, part, unit.face, "top", look, handle=handle, upper=85.0)
    return unit.made.furniture()


def wall_open(size: Size, rng: np.random.Generator) -> Furniture:
    """Open shelves, with a rail of hooks' height below the lowest one."""
    unit = _wall_unit(size)
    for bay in unit.bays(max(1, round(size[0] / 0.8))):
        unit.shelves(bay, float(rng.uniform(0.26, 0.34)))
    return unit.made.furniture()
