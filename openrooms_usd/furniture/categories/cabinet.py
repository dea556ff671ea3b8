"""Cabinets: doors, drawers, open shelves, and a sideboard of all three."""

from collections.abc import Callable
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import STORAGE_ROWS
from openrooms_usd.furniture.joinery.carcass import Carcass, closed, plinth_height
from openrooms_usd.furniture.joinery.cells import BOARD, Cell, columns, rows
from openrooms_usd.furniture.joinery.fronts import FrontDesign, doors, drawers, drawn_look
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.record import MADE_TO_MEASURE, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import STORAGE

# Drawer boxes end this far before the back of the carcass, metres.
BEHIND: Final = 0.03


def with_doors(size: Size, rng: np.random.Generator) -> Furniture:
    """Hinged doors over the whole front, shelves behind them; tall ones in two rows."""
    cabinet = closed(size, plinth_height(size[2]))
    cabinet.plinth()
    left, right, low, high = cabinet.overlay
    look = drawn_look(rng)
    share = float(rng.uniform(0.6, 0.7))
    tiers = [1.0] if high - low < 1.5 else [share, 1.0 - share]
    for i, tier in enumerate(rows((left, right, low, high), tiers)):
        if i:
            cabinet.shelf(cabinet.inside, tier[2])
        doors(cabinet.made, tier, cabinet.face, look)
        _fitted_out(cabinet, (left, right, tier[2], tier[3]))
    return cabinet.made.furniture()


def _fitted_out(cabinet: Carcass, tier: Cell) -> None:
    """Dividers behind every second pair of doors, and shelves between them."""
    pairs = max(1, round((tier[1] - tier[0]) / 0.9))
    low, high = tier[2] + 0.5 * BOARD, tier[3] - 0.5 * BOARD
    left, right = cabinet.inside[:2]
    for i, bay in enumerate(columns((left, right, low, high), pairs)):
        if i:
            cabinet.divider(bay[0], low, high)
        cabinet.shelves(bay, setback=0.02)


def chest(size: Size, rng: np.random.Generator) -> Furniture:
    """A chest: rows of drawers, in two columns where it is wide."""
    cabinet = closed(size, plinth_height(size[2]))
    cabinet.plinth()
    left, right, low, high = cabinet.overlay
    look = drawn_look(rng, 0.3)
    count = max(1, round((right - left) / 0.75))
    for i, column in enumerate(columns((left, right, low, high), count)):
        if i:
            cabinet.divider(column[0], low + BOARD, high - BOARD)
        drawers(cabinet.made, column, cabinet.face, cabinet.back - BEHIND, look)
    return cabinet.made.furniture()


def open_case(size: Size, rng: np.random.Generator) -> Furniture:
    """An open case of shelves."""
    width, depth, height = size
    cabinet = Carcass(width, -0.5 * depth, 0.5 * depth, plinth_height(height), height).boards()
    cabinet.plinth()
    count = max(1, round(width / float(rng.uniform(0.7, 0.9))))
    for bay in cabinet.bays(count):
        cabinet.shelves(bay)
    return cabinet.made.furniture()


Fill = Callable[[Carcass, Cell, FrontDesign], None]


def _fill_doors(cabinet: Carcass, cell: Cell, look: FrontDesign) -> None:
    doors(cabinet.made, cell, cabinet.face, look)
    _fill_open(cabinet, cell, look)


def _fill_drawers(cabinet: Carcass, cell: Cell, look: FrontDesign) -> None:
    drawers(cabinet.made, cell, cabinet.face, cabinet.back - BEHIND, look)


def _fill_open(cabinet: Carcass, cell: Cell, look: FrontDesign) -> None:
    pad = 0.5 * BOARD
    inside = cabinet.inside
    cabinet.shelves((cell[0] + pad, cell[1] - pad, inside[2], inside[3]), setback=0.02)


def sideboard(size: Size, rng: np.random.Generator) -> Furniture:
    """Legs, and columns of doors, drawers and open shelves side by side."""
    cabinet = closed(size, min(0.16, 0.22 * size[2]))
    cabinet.legs()
    left, right, low, high = cabinet.overlay
    count = max(2, round((right - left) / 0.5))
    fills: list[Fill] = [_fill_doors, _fill_drawers, _fill_open]
    look, start = drawn_look(rng, 0.2), int(rng.integers(len(fills)))
    for i, column in enumerate(columns((left, right, low, high), count)):
        if i:
            cabinet.divider(column[0], low + BOARD, high - BOARD)
        fills[(start + i) % len(fills)](cabinet, column, look)
    return cabinet.made.furniture()


CATEGORY: Final = BuiltCategory(
    description="doors, drawers or open shelves",
    size=(0.9, 0.42, 0.9),
    min_size=(0.25, 0.2, 0.25),
    max_size=(6.0, 1.2, 3.2),
    styles={
        "doors": Style(with_doors),
        "drawers": Style(chest, lambda size: size[2] < 1.35),
        "shelves": Style(open_case, lambda size: size[1] < 0.5, (0.8, 0.3, 1.8)),
        "sideboard": Style(
            sideboard, lambda size: size[0] > 0.8 and size[2] < 1.1, (1.5, 0.42, 0.75)
        ),
    },
    size_variation=MADE_TO_MEASURE,
    alternative_supports=("wall",),
    mass_range=(20, 60),
    words="storage storage_cabinet cupboard sideboard credenza tv_stand tv_cabinet "
    "entertainment_center shoe_cabinet locker built_in_cabinet buffet console "
    "media_console sink_cabinet tv_bench tv_unit vanity",
    classes=Classes("cabinet", "cabinet", "cabinet"),
    synsets=("02933112",),
    schemes=STORAGE,
    construction=STORAGE_ROWS,
    offers_surfaces=("cabinet_top", "shelf", "low_shelf", "cupboard", "drawer"),
    view_importance=0.6,
)
