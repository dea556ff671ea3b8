"""Stoves and ovens: hobs of gas or glass over an oven, ovens to be built in."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.joinery.appliance import SHEET, body, display, knob, liner, rack
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.cells import HANDLE, SEAT, Cell, columns, rows
from openrooms_usd.furniture.joinery.fronts import FrontDesign, drawer, hang_door
from openrooms_usd.furniture.joinery.pieces import Furniture, Size
from openrooms_usd.furniture.joinery.posing import band
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import box, lathe

DOOR: Final = 0.035
HOB: Final = 0.035
PANEL: Final = 0.1
# What the sides of the body take behind the front of a drawer, metres.
SHEET_MARGIN: Final = 0.014


def _oven(made: Assembly, cell: Cell, face: float, back: float, side: bool = False) -> None:
    """A cavity with racks behind a door with a pane; the door drops, or opens to the side."""
    left, right, low, high = cell
    inside = liner(made, cell, face + SEAT, back, min(0.05, 0.12 * (right - left)))
    deep = back - face - 0.08
    for level in (0.3, 0.62):
        z = inside[2] + level * (inside[3] - inside[2])
        wires = rack(inside[1] - inside[0] - 0.006, deep - 0.02)
        made.add("rack", wires.moved((0.5 * (left + right), face + 0.02 + 0.5 * deep, z)))
    front = face - DOOR
    wide, tall = right - left, high - low
    inset = 0.12 * wide
    riders = made.board(
        "glass",
        (left + inset, front - 0.0015, low + 0.16 * tall),
        (right - inset, front + 0.004, high - 0.27 * tall),
        0.001,
    )
    if side:
        handle, length = (right - 0.035, 0.5 * (low + high)), 0.7 * tall
    else:
        handle, length = (0.5 * (left + right), high - 0.11 * tall), 0.84 * wide
    hang_door(
        made,
        cell,
        face,
        "left" if side else "bottom",
        FrontDesign("rod"),
        thickness=DOOR,
        handle=handle,
        length=length,
        upper=90.0,
        riders=riders,
    )


def _controls(made: Assembly, cell: Cell, face: float, knobs: int, screen: bool) -> None:
    """A strip with knobs, a clock in its middle where there is one."""
    left, right, low, high = cell
    made.board("panel", (left, face - DOOR, low + 0.0015), (right, face, high), 0.004)
    z, y = 0.5 * (low + high), face - DOOR
    radius = min(0.021, 0.32 * (high - low))
    places = np.linspace(-0.42, 0.42, knobs) * (right - left)
    if screen:
        places = places[np.abs(places) > 0.07]
        display(made, 0.5 * (left + right), y, z, (0.11, 0.42 * (high - low)))
    for x in places:
        knob(made, (0.5 * (left + right) + float(x), y, z), radius, 0.022)


def _gas_burner(radius: float) -> Mesh:
    """A ring of flames' seat with its cap, 22 mm high, on the origin."""
    profile = [
        (0.0, 0.0),
        (1.3 * radius, 0.0),
        (1.2 * radius, 0.004),
        (radius, 0.006),
        (0.96 * radius, 0.014),
        (0.8 * radius, 0.015),
        (0.78 * radius, 0.02),
        (0.6 * radius, 0.022),
        (0.0, 0.022),
    ]
    return lathe(profile, segments=28, crease=45.0)


def _bar(low: Size, high: Size) -> Mesh:
    """A sharp-edged bar between two corners: grates have dozens of them."""
    a, b = np.asarray(low), np.asarray(high)
    return box(b - a, 0.5 * (a + b))


def _grate(width: float, depth: float, spots: list[tuple[float, float]]) -> Mesh:
    """Cast bars over some burners: a frame on four feet, and a cross at each spot."""
    x, y, t, low, high = 0.5 * width, 0.5 * depth, 0.005, 0.024, 0.036
    bars = [_bar((-x, b - t, low), (x, b + t, high)) for b in (t - y, y - t)]
    bars += [_bar((a - t, -y, low), (a + t, y, high)) for a in (t - x, x - t)]
    bars += [
        _bar((a - t, b - t, 0.0), (a + t, b + t, low + 0.004))
        for a in (t - x, x - t)
        for b in (t - y, y - t)
    ]
    for sx, sy in spots:
        # Four fingers reach from the frame to the rim of the cap.
        reach, rim = (x, 0.5 * y), 0.028
        for sign in (-1, 1):
            near, far = sorted((sx + sign * rim, sx + sign * reach[0]))
            bars.append(_bar((near, sy - t, low), (far, sy + t, high)))
            near, far = sorted((sy + sign * rim, sy + sign * reach[1]))
            bars.append(_bar((sx - t, near, low), (sx + t, far, high)))
    return joined(bars)


def _spots(width: float, depth: float, count: int) -> list[tuple[float, float, float]]:
    """Where hot plates are and how large: X, Y and radius, two rows deep."""
    radii = (0.052, 0.038, 0.038, 0.046)
    return [
        (float(x), y, radii[(2 * i + j) % 4])
        for i, x in enumerate(np.linspace(-0.5, 0.5, count) * width * (1.0 - 1.0 / count))
        for j, y in enumerate((-0.25 * depth, 0.25 * depth))
    ]


def gas_hob(made: Assembly, width: float, middle: float, depth: float, top: float) -> None:
    """Burners in two rows under grates; ``top`` is where the pots stand."""
    level = top - 0.036
    pairs = max(2, round(width / 0.32))
    spots = _spots(width - 0.04, depth - 0.06, pairs)
    for x, y, radius in spots:
        made.add("burner", _gas_burner(radius).moved((x, middle + y, level)))
    wide = (width - 0.05) / pairs
    for x in sorted({x for x, _, _ in spots}):
        places = [(0.0, y) for a, y, _ in spots if a == x]
        made.add("grate", _grate(wide, depth - 0.06, places).moved((x, middle, level)))


def glass_hob(made: Assembly, width: float, middle: float, depth: float, top: float) -> None:
    """A sheet of black glass with printed rings."""
    x, y = 0.5 * width - 0.008, 0.5 * depth - 0.008
    made.board("glass", (-x, middle - y, top - 0.006), (x, middle + y, top - 0.0006))
    for a, b, radius in _spots(width - 0.04, depth - 0.06, max(2, round(width / 0.32))):
        r = 2.0 * radius
        circle = band(r - 0.004, r, 0.0, 0.002, 40)
        made.add("mark", circle.moved((a, middle + b, top - 0.002)))


def cooker(
    size: Size, rng: np.random.Generator, *, gas: bool, ovens: int = 1, guard: float = 0.0
) -> Furniture:
    """A hob of gas or glass, a strip of controls, ovens side by side, a drawer for trays."""
    width, depth, height = size
    made = Assembly()
    face, back, x = -0.5 * depth + HANDLE + DOOR + SEAT, 0.5 * depth, 0.5 * width
    top = height - guard
    level = top - (0.036 if gas else 0.0)
    low, deck = 0.07, level - HOB
    body(made, (-x, face, low), (x, back, deck))
    made.board("base", (0.02 - x, face + 0.03, 0.0), (x - 0.02, back - 0.02, low + 0.005))
    made.board(
        "cooktop", (-x, face - DOOR, deck), (x, back, level - (0.003 if not gas else 0)), 0.006
    )
    middle, deep = 0.5 * (face - DOOR + back), back - face + DOOR
    if gas:
        gas_hob(made, width, middle, deep, top)
    else:
        glass_hob(made, width, middle, deep, top)
    tray, oven, strip = rows((-x, x, low, deck), [0.16, deck - low - 0.16 - PANEL, PANEL])
    _controls(made, strip, face, 5 + 2 * (ovens - 1), True)
    drawer(made, tray, face, back - 0.06, FrontDesign("rod"), margin=SHEET_MARGIN, thickness=DOOR)
    for cell in columns((SHEET - x, x - SHEET, oven[2], oven[3]), ovens):
        _oven(made, cell, face, back - 0.03)
    if guard:
        made.board("panel", (-x, back - 0.06, level - 0.01), (x, back, height), 0.006)
        display(made, 0.0, back - 0.06, level + 0.6 * guard, (0.16, 0.35 * guard))
    return made.furniture()


def guarded(size: Size, rng: np.random.Generator) -> Furniture:
    """A panel with a clock rises at the back; gas or glass."""
    return cooker(size, rng, gas=bool(rng.integers(2)), guard=min(0.18, 0.18 * size[2]))


def oven(size: Size, rng: np.random.Generator, *, cells: int = 1, side: bool = False) -> Furniture:
    """Cavities above each other; the door drops, or hangs on its left side."""
    width, depth, height = size
    made = Assembly()
    face, back, x = -0.5 * depth + HANDLE + DOOR + SEAT, 0.5 * depth, 0.5 * width
    body(made, (-x, face, 0.0), (x, back, height))
    strip = min(0.11, 0.2 * height)
    lower, upper = rows((-x, x, 0.0, height), [height - strip, strip])
    _controls(made, upper, face, 2 if width < 0.8 else 4, True)
    for cell in rows(
        (lower[0] + SHEET, lower[1] - SHEET, lower[2] + SHEET, lower[3]), [1.0] * cells
    ):
        _oven(made, cell, face, back - 0.03, side)
    return made.furniture()
