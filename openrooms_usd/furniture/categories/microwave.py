"""Microwave ovens: with a keypad beside the door, with two dials, with a door that drops."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, MACHINE_ROWS, filled, row, solid
from openrooms_usd.furniture.joinery.appliance import SHEET, body, display, knob, liner
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.cells import HANDLE, SEAT, Cell
from openrooms_usd.furniture.joinery.fronts import FrontDesign, hang_door
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.solids import cylinder, lathe

DOOR: Final = 0.025
FOOT: Final = 0.012


def _case(size: Size) -> tuple[Assembly, Cell, float]:
    """A case on four feet; its front as a cell, and where the backs of its fronts are."""
    width, depth, height = size
    made = Assembly()
    x, face, back = 0.5 * width, -0.5 * depth + HANDLE + DOOR + SEAT, 0.5 * depth
    body(made, (-x, face, FOOT), (x, back, height))
    foot = cylinder(0.014, FOOT + 0.002, bevel=0.002, segments=12)
    made.add(
        "base",
        *(
            foot.moved((a, b, 0.0))
            for a in (0.035 - x, x - 0.035)
            for b in (face + 0.04, back - 0.04)
        ),
    )
    return made, (-x, x, FOOT, height), face


def _cavity(made: Assembly, cell: Cell, face: float, back: float) -> None:
    """The inside, with a glass plate that turns."""
    left, right, low, high = cell
    hollow = (left + SHEET, right - SHEET, low + SHEET, high - SHEET)
    inside = liner(made, hollow, face + SEAT, back - SHEET, 0.012)
    radius = 0.44 * min(inside[1] - inside[0], back - face - 0.04)
    profile = [
        (0.0, 0.0),
        (0.9 * radius, 0.0),
        (radius, 0.012),
        (0.985 * radius, 0.014),
        (0.88 * radius, 0.004),
        (0.0, 0.004),
    ]
    tray = lathe(profile)
    hub = cylinder(0.03, 0.012, segments=16)
    at = (0.5 * (left + right), 0.5 * (face + back) - 0.01, inside[2])
    made.add("tray", tray.moved(at).moved((0.0, 0.0, 0.01)))
    made.add("roller", hub.moved(at))


def _door(made: Assembly, cell: Cell, face: float, look: FrontDesign, drops: bool) -> None:
    left, right, low, high = cell
    front, inset = face - DOOR, 0.1 * (high - low)
    free = 0.05
    pane = (
        left + inset,
        right - inset - (0.0 if drops else free),
        low + inset,
        high - inset - (free if drops else 0.0),
    )
    riders = made.board(
        "glass", (pane[0], front - 0.0015, pane[2]), (pane[1], front + 0.004, pane[3]), 0.001
    )
    if drops:
        handle, length = (0.5 * (left + right), high - 0.028), 0.7 * (right - left)
    else:
        handle, length = (right - 0.028, 0.5 * (low + high)), 0.68 * (high - low)
    hang_door(
        made,
        cell,
        face,
        "bottom" if drops else "left",
        look,
        thickness=DOOR,
        handle=handle,
        length=length,
        upper=90.0 if drops else 110.0,
        riders=riders,
    )


def _side_by_side(size: Size, look: FrontDesign) -> tuple[Assembly, Cell, float]:
    """A door on the left and a panel on the right, which is given back as a cell."""
    made, (left, right, low, high), face = _case(size)
    middle = right - max(0.085, 0.23 * size[0])
    _cavity(made, (left, middle + 0.5 * SHEET, low, high), face, 0.5 * size[1])
    _door(made, (left, middle, low, high), face, look, False)
    made.board("panel", (middle + 0.0015, face - DOOR, low), (right, face, high), 0.003)
    return made, (middle, right, low, high), face - DOOR


def keypad(size: Size, rng: np.random.Generator) -> Furniture:
    """A screen over rows of keys."""
    look = FrontDesign(str(rng.choice(["bar", "rod"])))
    made, (left, right, low, high), front = _side_by_side(size, look)
    x, wide, tall = 0.5 * (left + right), right - left, high - low
    display(made, x, front, high - 0.14 * tall, (0.72 * wide, 0.13 * tall))
    a, b = 0.1 * wide, 0.035 * tall
    for line in np.linspace(0.12, 0.64, 5):
        for column in (-0.26, 0.0, 0.26):
            u, v = x + column * wide, low + float(line) * tall
            made.board(
                "button", (u - a, front - 0.002, v - b), (u + a, front + 0.002, v + b), 0.001
            )
    return made.furniture()


def dials(size: Size, rng: np.random.Generator) -> Furniture:
    """Two knobs below each other."""
    made, (left, right, low, high), front = _side_by_side(size, FrontDesign("bar"))
    radius = min(0.24 * (right - left), 0.15 * (high - low))
    for share in (0.3, 0.68):
        at = (0.5 * (left + right), front, low + share * (high - low))
        knob(made, at, radius, 0.02)
    return made.furniture()


def dropping(size: Size, rng: np.random.Generator) -> Furniture:
    """A strip of controls over a door as wide as the case that drops."""
    made, (left, right, low, high), face = _case(size)
    strip = high - max(0.045, 0.18 * size[2])
    _cavity(made, (left, right, low, strip + 0.5 * SHEET), face, 0.5 * size[1])
    _door(
        made, (left, right, low, strip), face, FrontDesign(str(rng.choice(["grip", "rod"]))), True
    )
    made.board("panel", (left, face - DOOR, strip + 0.0015), (right, face, high), 0.003)
    z, front = 0.5 * (strip + high), face - DOOR
    display(made, 0.0, front, z, (0.24 * size[0], 0.5 * (high - strip)))
    for x in (-0.34, -0.26, 0.26, 0.34):
        low_corner = (x * size[0] - 0.009, front - 0.002, z - 0.009)
        high_corner = (x * size[0] + 0.009, front + 0.002, z + 0.009)
        made.board("button", low_corner, high_corner)
    return made.furniture()


CATEGORY: Final = BuiltCategory(
    description="a microwave oven",
    size=(0.5, 0.4, 0.29),
    min_size=(0.3, 0.24, 0.18),
    max_size=(0.8, 0.65, 0.6),
    styles={
        "keypad": Style(keypad),
        "dials": Style(dials),
        "dropping": Style(dropping, lambda size: size[0] > 0.4, (0.6, 0.42, 0.39)),
    },
    size_variation=STANDARD,
    max_per_room=1,
    support="surface",
    mass_range=(9, 25),
    on_worktop_probability=0.4,
    words="microwave_oven toaster_oven",
    classes=Classes("microwave", "otherprop", "microwave", "microwave"),
    synsets=("03761084",),
    schemes=(
        scheme(
            "steel",
            enamel="container",
            black="frame base",
            plastic="tray",
            screen="panel",
            steel="handle",
        ),
        scheme("enamel", plastic="tray", enamel="handle"),
        scheme("black", enamel="container", steel="handle"),
    ),
    construction=(
        row("panel", filled(4000), "weight"),
        row("tray", solid(2500), "common"),
        *MACHINE_ROWS,
        row(ANY, filled(220), "weight"),
    ),
)
