"""Showers: a tray with glass on its open sides, and the fittings on the wall."""

from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, solid, walls
from openrooms_usd.furniture.joinery.appliance import dial
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.basin import drain
from openrooms_usd.furniture.joinery.boards import FRONT, SIDE
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import vessel
from openrooms_usd.geometry.solids import cylinder, lathe
from openrooms_usd.geometry.sweeps import tube

# Of the tray, of panes, and of the profiles that hold them at the wall; metres.
_TRAY_M, _PANE_M, _PROFILE_M = 0.04, 0.008, 0.02
_DOOR_M: Final = 0.65
# How far the door's handle stands out, metres.
_GRIP_M: Final = 0.038
# Heights of the mixer and of the head, metres.
_MIXER_M: Final = 1.05


def _tray(made: Assembly, size: Size, front: float) -> None:
    """A shallow tray with a drain, from a front to the back."""
    x, y, rim = 0.5 * size[0], 0.5 * size[1], 0.035
    made.add(
        "tray",
        vessel(
            (-x, front, 0.0, x, y, _TRAY_M),
            (rim - x, rim + front, _TRAY_M - 0.014, x - rim, y - rim),
            wall_edge=0.004,
            inner_corner=0.03,
        ),
    )
    made.add("drain", drain(0.045).moved((0.0, 0.2 * y, _TRAY_M - 0.0145)))


def _fittings(made: Assembly, x: float, back: float, height: float) -> None:
    """A bar with two knobs, a riser to a broad head, and a hand shower on its hose."""
    y, top = back - 0.055, height
    bar = cylinder(0.021, 0.22, bevel=0.003, segments=20).transformed(SIDE)
    made.add("body", bar.moved((x - 0.11, y, _MIXER_M)))
    for side in (-1.0, 1.0):
        stub = tube([(x + 0.075 * side, y, _MIXER_M), (x + 0.075 * side, back, _MIXER_M)], 0.014)
        made.add("body", stub)
        out = np.array([[0.0, 0.0, side], [side, 0.0, 0.0], [0.0, 1.0, 0.0]])
        knob = dial(0.021, 0.035).transformed(np.linalg.inv(FRONT)).transformed(out)
        at = (x + 0.111 * side, y, _MIXER_M)
        names = made.add("switch", knob.moved(at))
        made.turn("switch", names, at, (side, 0.0, 0.0), (0.0, 120.0))
    reach = y - 0.3
    riser = [(x, y, _MIXER_M), (x, y, top - 0.011), (x, reach, top - 0.011), (x, reach, top - 0.07)]
    made.add("spout", tube(riser, 0.011, bend=0.06, bend_segments=6, segments=14))
    head = lathe(
        [(0.0, 0.0), (0.115, 0.0), (0.118, 0.006), (0.1, 0.012), (0.03, 0.022), (0.0, 0.03)],
        segments=36,
    )
    made.add("spout", head.moved((x, reach, top - 0.09)))
    made.add("bracket", tube([(x, y, top - 0.2), (x, back, top - 0.2)], 0.008, segments=10))
    hang = 1.45
    low, high = (x - 0.014, y - 0.045, hang - 0.015), (x + 0.014, y + 0.012, hang + 0.02)
    made.board("bracket", low, high, 0.004)
    grip = [(x, y - 0.03, hang - 0.12), (x, y - 0.03, hang + 0.06), (x, y - 0.075, hang + 0.1)]
    made.add("spout", tube(grip, 0.011, bend=0.03))
    spray = lathe(
        [(0.0, 0.0), (0.045, 0.0), (0.048, 0.01), (0.02, 0.026), (0.0, 0.028)], segments=24
    )
    turned = spray.transformed(np.array([[1.0, 0.0, 0.0], [0.0, 0.5, 0.866], [0.0, -0.866, 0.5]]))
    made.add("spout", turned.moved((x, y - 0.1, hang + 0.085)))
    hose = [
        (x, y - 0.03, hang - 0.115),
        (x + 0.03, y - 0.03, 0.8),
        (x + 0.08, y - 0.02, 0.62),
        (x + 0.12, y - 0.01, 0.8),
        (x + 0.06, y, _MIXER_M - 0.02),
    ]
    made.add("hose", tube(hose, 0.006, bend=0.1, bend_segments=6, segments=8))


def corner(size: Size, rng: np.random.Generator, *, side: int) -> Furniture:
    """A cubicle in a corner: walls behind and on one side, glass with a door on the others.

    Args:
        size: Metres.
        rng: Draws nothing.
        side: Where the wall is: -1 on the left, 1 on the right.
    """
    width, depth, height = size
    made, x, y = Assembly(), 0.5 * width, 0.5 * depth
    front = _GRIP_M - y
    _tray(made, size, front)
    _fittings(made, 0.1 * side * width, y, height)
    low, high = _TRAY_M, height - 0.03
    # The pane on the open side, held in a profile at the wall behind.
    outer = -side * x
    a, b = sorted((outer, outer + side * _PANE_M))
    made.board("pane", (a, front, low), (b, y - _PROFILE_M, high), 0.001)
    p, q = sorted((outer, outer + side * _PROFILE_M))
    made.board("frame", (p, y - _PROFILE_M, low), (q, y, high), 0.001)
    # In front: a door at the wall, and what it leaves beside it.
    wide = min(_DOOR_M, 0.75 * width)
    wall = side * x
    inner = wall - side * (_PROFILE_M + 0.002)
    p, q = sorted((wall, wall - side * _PROFILE_M))
    made.board("frame", (p, front, low), (q, front + _PROFILE_M, high), 0.001)
    end = inner - side * wide
    c, d = sorted((inner, end))
    names = made.board("pane", (c, front, low + 0.008), (d, front + _PANE_M, high), 0.001)
    grip = end + side * 0.05
    bar = [(grip, front - a, z) for z, a in ((0.95, 0.0), (0.95, 0.03), (1.25, 0.03), (1.25, 0.0))]
    names += made.add("handle", tube(bar, 0.008, bend=0.012, segments=10))
    made.hinge("door", names, (inner, front, low), "right" if side > 0 else "left", 95.0)
    rest = sorted((end - side * 0.004, outer + side * (_PANE_M + 0.001)))
    if rest[1] - rest[0] > 0.03:
        made.board("pane", (rest[0], front, low), (rest[1], front + _PANE_M, high), 0.001)
    return made.furniture()


def walk_in(size: Size, rng: np.random.Generator) -> Furniture:
    """A long tray behind one fixed pane: one walks round it."""
    width, depth, height = size
    made, y = Assembly(), 0.5 * depth
    _tray(made, size, -y)
    _fittings(made, 0.0, y, height)
    high, half = height - 0.03, 0.3 * width
    made.board("pane", (-half, -y, _TRAY_M), (half, _PANE_M - y, high), 0.001)
    foot = (-half, -y - 0.001, _TRAY_M - 0.002), (half, _PANE_M + 0.001 - y, _TRAY_M + 0.02)
    made.board("frame", *foot, 0.001)
    stay = [(0.0, 0.5 * _PANE_M - y, high - 0.012), (0.0, y, high - 0.012)]
    made.add("frame", tube([(0.35 * half, b, c) for _, b, c in stay], 0.009))
    return made.furniture()


CATEGORY: Final = BuiltCategory(
    description="a shower with its glass and its fittings",
    size=(0.9, 0.9, 2.08),
    min_size=(0.65, 0.65, 1.8),
    max_size=(2.0, 1.4, 2.5),
    styles={
        "corner_left": Style(partial(corner, side=-1), lambda size: size[0] < 1.25),
        "corner_right": Style(partial(corner, side=1), lambda size: size[0] < 1.25),
        "walk_in": Style(walk_in, lambda size: size[0] > 1.05, (1.4, 0.9, 2.08)),
    },
    size_variation=STANDARD,
    fixed=True,
    words="shower_cabin shower_cubicle shower_stall shower_enclosure shower_tray walk_in_shower",
    classes=Classes(nyu40="otherstructure", ade20k="shower"),
    schemes=(
        scheme("chrome", sanitary="tray", weight=3.0),
        scheme("chrome", sanitary="tray", tinted_glass="pane"),
        scheme("black", sanitary="tray", black="spout switch handle bracket"),
    ),
    construction=(
        row("pane", solid(2500), "common"),
        row("tray", filled(1500), "common"),
        row(ANY, walls(1.5), "common"),
    ),
    view_importance=1.0,
)
