"""Kitchen units without a worktop: base units in a line, tall units, corners, fillers."""

from functools import partial
from itertools import pairwise
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import STORAGE_ROWS
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.carcass import Carcass
from openrooms_usd.furniture.joinery.cells import BOARD, GAP, SEAT, Cell, columns, rows
from openrooms_usd.furniture.joinery.fronts import (
    FrontDesign,
    drawer,
    hang_door,
    leaf,
    ordered_look,
    reach,
)
from openrooms_usd.furniture.joinery.kitchen import TOE, kickboard
from openrooms_usd.furniture.joinery.pieces import (
    NOTHING_ORDERED,
    FitOptions,
    Furniture,
    Size,
    Style,
)
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import KITCHEN

# Without handles one reaches behind the upper edge of a front: what it leaves free, metres.
_GRIP_M: Final = 0.022
# Greatest width of a leaf, metres.
_LEAF_M: Final = 0.6
# A front above a base unit's height is divided here, metres.
_TALL_M, _DIVIDED_AT_M = 1.4, 0.9
# What the corner hides of a unit that runs into it: another unit's depth, and a filler, metres.
BLIND_M: Final = 0.65


def _unit(size: Size, look: FrontDesign, *, top: bool = True) -> Carcass:
    """A carcass on its plinth, with room for fronts and handles before it."""
    width, depth, height = size
    front = -0.5 * depth + reach(look) + BOARD + SEAT
    unit = Carcass(width, front, 0.5 * depth, TOE, height).boards(top=top)
    kickboard(unit.made, width, unit.face - BOARD, unit.back)
    return unit


def _fronts(unit: Carcass, look: FrontDesign) -> Cell:
    """What fronts cover: without handles, a grip remains above them."""
    left, right, low, high = unit.overlay
    return left, right, low, high - (0.0 if look.handle else _GRIP_M)


def _leaves(unit: Carcass, cell: Cell, look: FrontDesign, handle_z: float) -> None:
    """One leaf, or a pair that opens from its middle."""
    parts = columns(cell, max(1, int(np.ceil((cell[1] - cell[0]) / _LEAF_M - 1e-6))))
    for i, part in enumerate(parts):
        left = i % 2 == 0
        x = part[1] - 0.04 if left else part[0] + 0.04
        hang_door(
            unit.made, part, unit.face, "left" if left else "right", look, handle=(x, handle_z)
        )


def doors(
    size: Size,
    rng: np.random.Generator,
    order: FitOptions = NOTHING_ORDERED,
    *,
    open_top: bool = False,
) -> Furniture:
    """Doors before shelves, in two rows where it is tall; open above where a sink hangs in it."""
    look = ordered_look(order, rng)
    unit = _unit(size, look, top=not open_top)
    left, right, low, high = _fronts(unit, look)
    split = [low, low + _DIVIDED_AT_M, high] if size[2] > _TALL_M else [low, high]
    for i, (a, b) in enumerate(pairwise(split)):
        _leaves(unit, (left, right, a, b), look, a + 0.14 if i else b - 0.14)
        inside = unit.inside
        if i:
            unit.shelf(inside, a)
        bay = (inside[0], inside[1], max(a, inside[2]), min(b, inside[3]))
        if not open_top:
            unit.shelves(bay, 0.36, 0.02)
    return unit.made.furniture()


def drawers(size: Size, rng: np.random.Generator, order: FitOptions = NOTHING_ORDERED) -> Furniture:
    """A shallow drawer over deep ones; a single one below an oven."""
    look = ordered_look(order, rng)
    unit = _unit(size, look)
    cell = _fronts(unit, look)
    count = max(1, round((cell[3] - cell[2]) / 0.27))
    for part in rows(cell, [1.0, 1.0, 0.6][-count:] if count > 1 else [1.0]):
        drawer(unit.made, part, unit.face, unit.back - 0.05, look)
    return unit.made.furniture()


def corner(
    size: Size, rng: np.random.Generator, order: FitOptions = NOTHING_ORDERED, *, side: int
) -> Furniture:
    """A unit that runs into a corner: a panel where another row stands before it, then a door.

    Args:
        size: Metres.
        rng: Draws what is not ordered.
        order: How its fronts look.
        side: Where the corner is: -1 on its left, 1 on its right.
    """
    look = ordered_look(order, rng)
    unit = _unit(size, look)
    left, right, low, high = _fronts(unit, look)
    blind = min(BLIND_M, 0.65 * size[0])
    middle = left + blind if side < 0 else right - blind
    shut, open_ = (
        ((left, middle), (middle, right)) if side < 0 else ((middle, right), (left, middle))
    )
    panel = leaf(shut[1] - shut[0] - GAP, high - low - GAP)
    unit.made.add("panel", panel.moved((0.5 * sum(shut), unit.face, low + 0.5 * GAP)))
    handle = (open_[0] + 0.04 if side < 0 else open_[1] - 0.04, high - 0.14)
    hang_door(
        unit.made,
        (*open_, low, high),
        unit.face,
        "right" if side < 0 else "left",
        look,
        handle=handle,
    )
    unit.shelves(unit.inside, 0.36, 0.02)
    return unit.made.furniture()


def filler(size: Size, rng: np.random.Generator) -> Furniture:
    """A strip that closes what is left beside a wall or in a corner."""
    width, depth, height = size
    made, face, half = Assembly(), -0.5 * depth + BOARD, 0.5 * width
    made.board("panel", (-half, face - BOARD, TOE), (half, face, height), 0.001)
    made.board("frame", (-half, face, TOE), (half, 0.5 * depth, height), 0.001)
    kickboard(made, width, face - BOARD, 0.5 * depth)
    return made.furniture()


CATEGORY: Final = BuiltCategory(
    description="a kitchen unit that a worktop lies on, or a tall one",
    size=(0.6, 0.608, 0.872),
    min_size=(0.04, 0.3, 0.2),
    max_size=(1.4, 0.8, 2.6),
    styles={
        "doors": Style(doors, lambda size: size[0] > 0.25, takes=("fronts",)),
        "drawers": Style(
            drawers,
            lambda size: size[0] > 0.25 and size[2] < 1.2,
            (0.8, 0.608, 0.872),
            takes=("fronts",),
        ),
        "sink": Style(
            partial(doors, open_top=True),
            lambda size: size[0] > 0.4 and size[2] < 1.2,
            (0.8, 0.608, 0.872),
            takes=("fronts",),
        ),
        "corner_left": Style(
            partial(corner, side=-1),
            lambda size: size[0] > 0.9 and size[2] < 1.2,
            (1.1, 0.608, 0.872),
            takes=("fronts",),
        ),
        "corner_right": Style(
            partial(corner, side=1),
            lambda size: size[0] > 0.9 and size[2] < 1.2,
            (1.1, 0.608, 0.872),
            takes=("fronts",),
        ),
        "filler": Style(filler, lambda size: size[0] < 0.2, (0.05, 0.58, 0.872)),
    },
    size_variation=STANDARD,
    fixed=True,
    words="base_cabinet base_unit kitchen_base_cabinet larder_unit tall_unit",
    classes=Classes("cabinet", "cabinet", "cabinet"),
    schemes=KITCHEN,
    construction=STORAGE_ROWS,
    offers_surfaces=("cupboard", "drawer"),
)
