"""Dishwashers and washing machines: doors that drop, portholes, lids, drawers."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.joinery.appliance import (
    SHEET,
    basket,
    body,
    display,
    knob,
    liner,
    pierced,
    square,
)
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.boards import FRONT, board
from openrooms_usd.furniture.joinery.cells import BOARD, HANDLE, SEAT, Cell, rows
from openrooms_usd.furniture.joinery.fronts import (
    FrontDesign,
    drawer,
    hang_door,
    ordered_look,
    reach,
)
from openrooms_usd.furniture.joinery.kitchen import TOE, kickboard
from openrooms_usd.furniture.joinery.pieces import NOTHING_ORDERED, FitOptions, Furniture, Size
from openrooms_usd.geometry.lofts import superellipse
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.rotations import about_z
from openrooms_usd.geometry.solids import cylinder, lathe

DOOR: Final = 0.04


def _machine(size: Size, reach: float, low: float) -> tuple[Assembly, Cell, float]:
    """A case on a recessed base; its front as a cell, and where the backs of its fronts are."""
    width, depth, height = size
    made = Assembly()
    x, face, back = 0.5 * width, -0.5 * depth + reach + DOOR + SEAT, 0.5 * depth
    body(made, (-x, face, low), (x, back, height))
    made.board("base", (0.015 - x, face + 0.04, 0.0), (x - 0.015, back - 0.02, low + 0.004))
    return made, (-x, x, low, height), face


def _tub(made: Assembly, cell: Cell, face: float, back: float) -> None:
    """A steel tub with two baskets."""
    inside = liner(made, cell, face + SEAT, back - SHEET, 0.02)
    wide, deep, tall = inside[1] - inside[0], back - face - 0.1, inside[3] - inside[2]
    y, x = 0.5 * (face + back) - 0.01, 0.5 * (inside[0] + inside[1])
    for share in (0.06, 0.54):
        mesh = basket(wide - 0.02, deep, min(0.12, 0.25 * tall))
        made.add("rack", mesh.moved((x, y, inside[2] + share * tall)))


def console(size: Size, rng: np.random.Generator) -> Furniture:
    """A dishwasher with its controls on a strip over the door."""
    made, (left, right, low, high), face = _machine(size, HANDLE, TOE)
    lower, strip = rows((left, right, low, high), [high - low - 0.12, 0.12])
    _tub(made, (left + SHEET, right - SHEET, low + SHEET, high - SHEET), face, 0.5 * size[1])
    made.board("panel", (left, face - DOOR, strip[2] + 0.0015), (right, face, high), 0.004)
    z, front = 0.5 * (strip[2] + strip[3]), face - DOOR
    display(made, 0.0, front, z, (0.1, 0.035))
    for x in np.linspace(0.14, 0.38, 4) * size[0]:
        least, most = (x - 0.011, front - 0.002, z - 0.006), (x + 0.011, front + 0.002, z + 0.006)
        made.board("button", least, most, 0.001)
    hang_door(
        made,
        lower,
        face,
        "bottom",
        FrontDesign(str(rng.choice(["grip", "bar"]))),
        thickness=DOOR,
        handle=(0.0, lower[3] - 0.03),
        length=0.4 * size[0],
        upper=90.0,
    )
    return made.furniture()


def integrated(
    size: Size, rng: np.random.Generator, order: FitOptions = NOTHING_ORDERED
) -> Furniture:
    """A dishwasher behind a front of the kitchen; the controls are in its door's upper edge."""
    look = ordered_look(order, rng)
    width, depth, height = size
    made, x, back = Assembly(), 0.5 * width, 0.5 * depth
    face = -back + reach(look) + BOARD + SEAT
    high = height if look.handle else height - 0.022
    body(made, (-x, face, TOE), (x, back, height))
    kickboard(made, width, face - BOARD, back)
    _tub(made, (SHEET - x, x - SHEET, TOE + SHEET, height - SHEET), face, back)
    hang_door(
        made,
        (-x, x, TOE, high),
        face,
        "bottom",
        look,
        handle=(0.0, high - 0.05),
        length=0.2,
        upper=90.0,
    )
    return made.furniture()


def two_drawers(size: Size, rng: np.random.Generator) -> Furniture:
    """A dishwasher of two drawers, each with a tub of its own."""
    made, cell, face = _machine(size, HANDLE, TOE)
    for part in rows(cell, [1.0, 1.0]):
        drawer(
            made, part, face, 0.5 * size[1] - 0.04, FrontDesign("rod"), margin=SHEET, thickness=DOOR
        )
    return made.furniture()


def _porthole(radius: float) -> tuple[Mesh, Mesh]:
    """A round door and its glass bowl, backs at y = 0, the middle in the origin."""
    r = radius
    frame = lathe(
        [
            (0.76 * r, 0.0),
            (r, 0.0),
            (r, 0.022),
            (0.95 * r, 0.032),
            (0.8 * r, 0.034),
            (0.76 * r, 0.026),
        ],
        segments=48,
        crease=50.0,
    )
    bowl = lathe(
        [
            (0.0, -0.075),
            (0.4 * r, -0.075),
            (0.58 * r, -0.055),
            (0.68 * r, 0.0),
            (0.78 * r, 0.006),
            (0.78 * r, 0.02),
            (0.6 * r, 0.02),
            (0.4 * r, 0.028),
            (0.0, 0.03),
        ],
        segments=48,
    )
    return frame.transformed(FRONT), bowl.transformed(FRONT)


def _drum(radius: float, depth: float) -> Mesh:
    """A cup that opens upwards, with three ribs inside, its rim at z = 0."""
    r, t = radius, 0.004
    cup = lathe(
        [
            (0.0, -depth),
            (0.96 * r, -depth),
            (r, 0.03 - depth),
            (r, 0.0),
            (r - t, 0.0),
            (r - t, 0.03 - depth),
            (0.95 * r, t - depth),
            (0.0, t - depth),
        ],
        segments=40,
    )
    ribs = []
    for angle in np.radians([90.0, 210.0, 330.0]):
        rib = board((0.86 * r, -0.02, 0.04 - depth), (r - 0.5 * t, 0.02, -0.03), 0.012)
        ribs.append(rib.transformed(about_z(angle)))
    return joined([cup, *ribs])


def _front_loader(
    made: Assembly, cell: Cell, depth: float, knob_left: bool, *, clear: bool = True
) -> None:
    """A case with a door, clear or shut, a drawer and a panel, between two heights."""
    left, right, low, high = cell
    face, back, x = -0.5 * depth + 0.036, 0.5 * depth, right
    body(made, (left, face + 0.02, low), (right, back, high))
    tall = high - low - 0.13
    radius = min(0.36 * (right - left), 0.4 * tall)
    z = low + 0.5 * tall + 0.01
    hole = superellipse(1.64 * radius, 1.64 * radius, segments=64)
    shift = np.array([0.0, z - low - 0.5 * tall])
    plate = pierced(square(right - left, tall) - shift, hole, 0.0, 0.02)
    made.add("frame", plate.transformed(FRONT).moved((0.0, face + 0.02, z)))
    drum = _drum(0.9 * radius, min(0.42, back - face - 0.06)).transformed(FRONT)
    made.add("drum", drum.moved((0.0, face + 0.03, z)))
    if clear:
        frame, bowl = (mesh.moved((0.0, face, z)) for mesh in _porthole(radius))
        names = made.add("door", frame) + made.add("glass", bowl)
    else:
        disc = cylinder(radius, 0.026, bevel=0.008, segments=48).transformed(FRONT)
        names = made.add("door", disc.moved((0.0, face, z)))
    grip = board(
        (0.8 * radius, face - 0.036, z - 0.05), (0.92 * radius, face - 0.02, z + 0.05), 0.004
    )
    names += made.add("handle", grip)
    made.hinge("door", names, (-radius, face - 0.036, z), "left")
    strip = (left, right, high - 0.13, high)
    middle = left + 0.32 * (right - left)
    made.board(
        "panel", (middle + 0.001, face - 0.012, strip[2] + 0.001), (x, face + 0.02, high), 0.004
    )
    tray = (left, middle, strip[2], strip[3])
    drawer(
        made,
        tray,
        face + 0.02,
        face + 0.02 + 0.22,
        FrontDesign("grip"),
        margin=SHEET,
        thickness=0.026,
    )
    center, at = 0.5 * (strip[2] + strip[3]), face - 0.012
    wide = right - left
    near, far = (0.05, 0.31) if knob_left else (0.33, 0.05)
    knob(made, (near * wide, at, center), 0.026, 0.022)
    display(made, far * wide, at, center, (0.2 * wide, 0.045))


def front_loader(size: Size, rng: np.random.Generator, *, clear: bool = True) -> Furniture:
    """A washing machine with a porthole, or a dryer with a shut door."""
    width, depth, height = size
    made = Assembly()
    x, low = 0.5 * width, 0.02
    cell = (-x, x, low, height - 0.022)
    _front_loader(made, cell, depth, bool(rng.integers(2)), clear=clear)
    _feet(made, size)
    lid = board((-x, 0.02 - 0.5 * depth, height - 0.022), (x, 0.5 * depth, height), 0.006)
    made.add("top", lid)
    return made.furniture()


def stacked(size: Size, rng: np.random.Generator) -> Furniture:
    """A dryer on a washing machine."""
    width, depth, height = size
    made = Assembly()
    x, half = 0.5 * width, 0.5 * (height - 0.02)
    knob_left = bool(rng.integers(2))
    for low in (0.02, 0.02 + half):
        _front_loader(made, (-x, x, low, low + half), depth, knob_left)
    _feet(made, size)
    return made.furniture()


def _feet(made: Assembly, size: Size) -> None:
    foot = cylinder(0.02, 0.024, bevel=0.002, segments=14)
    x, y = 0.5 * size[0] - 0.05, 0.5 * size[1] - 0.08
    made.add("base", *(foot.moved((a, b, 0.0)) for a in (-x, x) for b in (-y, y)))


def top_loader(size: Size, rng: np.random.Generator) -> Furniture:
    """A washing machine with a lid on top and its controls behind it."""
    width, depth, height = size
    made = Assembly()
    x, y, low = 0.5 * width, 0.5 * depth, 0.02
    guard = min(0.14, 0.14 * height)
    deck = height - guard
    body(made, (-x, -y, low), (x, y, deck - 0.02), top=False)
    made.board("frame", (SHEET - x, -y, low), (x - SHEET, SHEET - y, deck - 0.02), 0.004)
    _feet(made, size)
    rear = y - 0.13
    middle, wide, deep = 0.5 * (rear - y), width - 0.12, rear + y - 0.08
    hole = superellipse(wide, deep, 6.0, 64)
    plate = pierced(square(width, depth) - [0.0, middle], hole, 0.0, 0.02)
    made.add("top", plate.moved((0.0, middle, deck - 0.02)))
    radius = 0.5 * min(wide, deep) - 0.01
    made.add("drum", _drum(radius, deck - 0.16).moved((0.0, middle, deck - 0.05)))
    post = lathe(
        [(0.0, 0.0), (0.3 * radius, 0.0), (0.12 * radius, 0.06), (0.09 * radius, 0.3), (0.0, 0.32)],
        segments=24,
    )
    made.add("agitator", post.moved((0.0, middle, 0.115)))
    _lid(made, (wide + 0.04, deep + 0.04), middle, deck + 0.001)
    made.board("panel", (-x, rear + 0.03, deck - 0.004), (x, y, height), 0.012)
    z, front = deck + 0.5 * guard, rear + 0.03
    for a in (-0.28, 0.28):
        knob(made, (a * width, front, z), 0.028, 0.022)
    display(made, 0.0, front, z, (0.14, 0.05))
    return made.furniture()


def _lid(made: Assembly, size: tuple[float, float], middle: float, low: float) -> None:
    """A lid hung on its back edge, with a grip at its front."""
    x, y, high = 0.5 * size[0], 0.5 * size[1], low + 0.018
    names = made.board("lid", (-x, middle - y, low), (x, middle + y, high), 0.006)
    least, most = (-0.06, middle - y - 0.012, low + 0.003), (0.06, middle - y + 0.01, high - 0.003)
    names += made.board("handle", least, most, 0.003)
    made.hinge("lid", names, (0.0, middle + y, high), "top", 85.0)
