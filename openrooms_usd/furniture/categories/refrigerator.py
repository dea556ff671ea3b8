"""Refrigerators: one door, two doors above each other, side by side, French doors over drawers."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, MACHINE_ROWS, STEEL, filled, row, walls
from openrooms_usd.furniture.joinery.appliance import SHEET, body, display, liner
from openrooms_usd.furniture.joinery.assembly import Assembly, Side
from openrooms_usd.furniture.joinery.cells import BOARD, HANDLE, SEAT, Cell, columns, rows
from openrooms_usd.furniture.joinery.fronts import (
    FrontDesign,
    drawer,
    hang_door,
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
from openrooms_usd.furniture.record import BuiltCategory, Classes, JointDamping
from openrooms_usd.furniture.schemes import PANELLED, finished, scheme
from openrooms_usd.geometry.lofts import vessel

WALL: Final = 0.035
FOOT: Final = 0.03
# Of those behind the fronts of a kitchen: how tall they are, and from which height of the whole on
# a cupboard is above them, metres.
_COLD_M, _CUPBOARD_FROM_M = 1.7, 2.05


def _door_depth(size: Size) -> float:
    return min(0.065, 0.13 * size[1])


def _case(size: Size) -> tuple[Assembly, Cell, float]:
    """The body on its base; its front as a cell, and where the backs of its doors are."""
    width, depth, height = size
    made = Assembly()
    x, face, back = 0.5 * width, -0.5 * depth + HANDLE + _door_depth(size) + SEAT, 0.5 * depth
    body(made, (-x, face + 0.004, FOOT), (x, back, height))
    made.board("base", (0.02 - x, face + 0.02, 0.0), (x - 0.02, back - 0.02, FOOT + 0.004))
    return made, (-x, x, FOOT, height), face


def _compartment(made: Assembly, cell: Cell, face: float, size: Size, drawers: int) -> Cell:
    """A lined hollow with shelves, and boxes at its bottom; the hollow is given back."""
    left, right, low, high = cell
    x = 0.5 * size[0] - SHEET
    block = (max(left, -x), min(right, x), max(low, FOOT + SHEET), min(high, size[2] - SHEET))
    back = 0.5 * size[1] - SHEET
    inside = liner(made, block, face + 0.004, back, WALL)
    # Room for what the doors carry.
    front, rear = face + 0.1, back - WALL
    top = inside[2] + 0.004
    if drawers:
        tall = min(0.19, 0.3 * (inside[3] - inside[2]))
        for part in columns((inside[0] + 0.004, inside[1] - 0.004, 0.0, 0.0), drawers):
            outer = (part[0] + 0.002, front, top, part[1] - 0.002, rear, top + tall)
            inner = (outer[0] + 0.004, front + 0.004, top + 0.004, outer[3] - 0.004, rear - 0.004)
            made.add("drawer_box", vessel(outer, inner, wall_edge=0.001, corner=0.01))
        top += tall + 0.012
    count = max(1, round((inside[3] - top) / 0.28))
    for i in range(count if drawers else count - 1):
        z = top + (i + (0 if drawers else 1)) * (inside[3] - top) / count
        low_corner, high_corner = (inside[0], front, z), (inside[1], rear, z + 0.006)
        made.board("shelf", low_corner, high_corner)
    return inside


def _bins(made: Assembly, inside: Cell, face: float) -> tuple[str, ...]:
    """Trays on the inner side of a door."""
    left, right, low, high = inside
    count = max(1, round((high - low) / 0.33))
    names: tuple[str, ...] = ()
    for part in rows((left + 0.03, right - 0.03, low + 0.03, high - 0.05), [1.0] * count):
        outer = (part[0], face - 0.002, part[2], part[1], face + 0.075, part[2] + 0.075)
        inner = (outer[0] + 0.004, face + 0.006, part[2] + 0.004, outer[3] - 0.004, face + 0.071)
        names += made.add("tray", vessel(outer, inner, wall_edge=0.001, corner=0.008))
    return names


def _cold(
    made: Assembly,
    cell: Cell,
    face: float,
    size: Size,
    look: FrontDesign,
    side: Side,
    boxes: int,
    *,
    low_handle: bool = False,
    thickness: float | None = None,
) -> None:
    """A compartment and the door before it."""
    inside = _compartment(made, cell, face, size, boxes)
    riders = _bins(made, inside, face) if inside[3] - inside[2] > 0.3 else ()
    tall = cell[3] - cell[2]
    length = min(0.5, 0.6 * tall)
    x = cell[1] - 0.045 if side == "left" else cell[0] + 0.045
    z = cell[2] + 0.06 + 0.5 * length if low_handle else cell[3] - 0.06 - 0.5 * length
    hang_door(
        made,
        cell,
        face,
        side,
        look,
        thickness=thickness or _door_depth(size),
        handle=(x, z),
        length=length,
        riders=riders,
    )


def single(size: Size, rng: np.random.Generator) -> Furniture:
    """One compartment; the small ones that stand below a worktop."""
    made, cell, face = _case(size)
    look = FrontDesign(str(rng.choice(["bar", "rod"])))
    _cold(made, cell, face, size, look, "left" if rng.integers(2) else "right", 1)
    return made.furniture()


def two_doors(size: Size, rng: np.random.Generator) -> Furniture:
    """A cold compartment with the freezer above or below it."""
    made, cell, face = _case(size)
    look = FrontDesign(str(rng.choice(["bar", "rod"])))
    side: Side = "left" if rng.integers(2) else "right"
    above = bool(rng.integers(2))
    lower, upper = rows(cell, [0.7, 0.3] if above else [0.38, 0.62])
    _cold(made, lower, face, size, look, side, 1 if above else 2)
    _cold(made, upper, face, size, look, side, 0 if above else 2, low_handle=True)
    return made.furniture()


def side_by_side(size: Size, rng: np.random.Generator) -> Furniture:
    """Two tall doors; water and ice from the left one."""
    made, cell, face = _case(size)
    left, right, low, high = cell
    middle = left + float(rng.uniform(0.42, 0.5)) * (right - left)
    look = FrontDesign("rod")
    _cold(made, (middle, right, low, high), face, size, look, "right", 1)
    front = face - _door_depth(size)
    x, z = 0.5 * (left + middle) - 0.01, low + 0.62 * (high - low)
    panel = made.board(
        "glass", (x - 0.09, front - 0.002, z - 0.16), (x + 0.09, front + 0.004, z + 0.16)
    )
    panel += (display(made, x, front - 0.002, z + 0.1, (0.1, 0.04)),)
    _cold(made, (left, middle, low, high), face, size, look, "left", 1)
    made.ride(*panel)
    return made.furniture()


def french(size: Size, rng: np.random.Generator) -> Furniture:
    """A pair of doors over one or two wide drawers for frozen food."""
    made, cell, face = _case(size)
    count = int(rng.integers(1, 3))
    share = 0.32 if count == 1 else 0.4
    lower, upper = rows(cell, [share, 1.0 - share])
    inside = _compartment(made, upper, face, size, 2)
    look = FrontDesign("rod")
    sides: tuple[Side, Side] = ("left", "right")
    for part, side in zip(columns(upper, 2), sides, strict=True):
        half = (max(part[0], inside[0]), min(part[1], inside[1]), inside[2], inside[3])
        x = part[1] - 0.045 if side == "left" else part[0] + 0.045
        length = min(0.5, 0.6 * (part[3] - part[2]))
        hang_door(
            made,
            part,
            face,
            side,
            look,
            thickness=_door_depth(size),
            handle=(x, part[2] + 0.08 + 0.5 * length),
            length=length,
            riders=_bins(made, half, face),
        )
    back = 0.5 * size[1] - SHEET
    block = (SHEET - 0.5 * size[0], 0.5 * size[0] - SHEET, FOOT + SHEET, lower[3])
    liner(made, block, face + 0.004, back, WALL)
    for part in rows(lower, [1.0] * count):
        drawer(
            made,
            part,
            face,
            back - WALL - 0.01,
            FrontDesign("rod"),
            margin=SHEET + WALL,
            thickness=_door_depth(size),
        )
    return made.furniture()


def built_in(
    size: Size, rng: np.random.Generator, order: FitOptions = NOTHING_ORDERED
) -> Furniture:
    """A tall unit of a kitchen: freezer and refrigerator behind its fronts, a cupboard above."""
    look = ordered_look(order, rng)
    width, depth, height = size
    made, x, back = Assembly(), 0.5 * width, 0.5 * depth
    face = -back + reach(look) + BOARD + SEAT
    body(made, (-x, face + 0.004, TOE), (x, back, height))
    kickboard(made, width, face - BOARD, back)
    side: Side = "left" if rng.integers(2) else "right"
    top = height if height < _CUPBOARD_FROM_M else TOE + _COLD_M
    lower, upper = rows((-x, x, TOE, top), [0.4, 0.6])
    _cold(made, lower, face, size, look, side, 2, thickness=BOARD)
    _cold(made, upper, face, size, look, side, 1, low_handle=True, thickness=BOARD)
    if top < height:
        made.board("frame", (SHEET - x, face + 0.004, top), (x - SHEET, back - SHEET, top + SHEET))
        hand = x - 0.045 if side == "left" else 0.045 - x
        hang_door(made, (-x, x, top, height), face, side, look, handle=(hand, top + 0.14))
    return made.furniture()


_COLD: Final = finished(plastic="container shelf drawer_box tray", black="base")

CATEGORY: Final = BuiltCategory(
    description="a refrigerator, most with a freezer",
    size=(0.7, 0.7, 1.8),
    min_size=(0.4, 0.4, 0.45),
    max_size=(1.3, 1.0, 2.3),
    styles={
        "two_doors": Style(two_doors, lambda size: size[2] > 1.2 and size[0] < 0.85),
        "single": Style(
            single,
            lambda size: size[0] < 0.8 or size[2] <= 1.2,
            (0.56, 0.58, 0.86),
            mass_range=(20, 60),
        ),
        "side_by_side": Style(
            side_by_side, lambda size: size[0] > 0.78 and size[2] > 1.4, (0.91, 0.74, 1.78)
        ),
        "built_in": Style(
            built_in,
            lambda size: size[2] > 1.9 and size[0] < 0.78,
            (0.6, 0.608, 2.1),
            takes=("fronts",),
            mass_range=(40, 100),
        ),
        "french": Style(french, lambda size: size[0] > 0.68 and size[2] > 1.4, (0.91, 0.76, 1.78)),
    },
    mass_range=(50, 130),
    words="fridge freezer refridgerator mini_fridge deep_freeze electric_refrigerator icebox",
    classes=Classes(nyu40="refridgerator", ade20k="refrigerator", coco="refrigerator"),
    schemes=(
        scheme("enamel", _COLD, steel="handle"),
        scheme("steel", _COLD, grey="frame", steel="handle"),
        *PANELLED,
    ),
    construction=(
        row("frame", walls(0.3, STEEL), "sheet"),
        row("container", filled(70), "weight"),
        row("door drawer_front", filled(130), "weight"),
        row("shelf tray drawer_box", walls(2.5), "common", "plastic"),
        row("base", filled(1200), "weight"),
        *MACHINE_ROWS,
        row(ANY, filled(80), "weight"),
    ),
    joint_damping=JointDamping(0.5, 1.0),
    offers_surfaces=("appliance_top",),
    view_importance=0.8,
)
