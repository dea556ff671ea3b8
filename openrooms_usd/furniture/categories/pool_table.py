"""Pool tables: a bed of slate under cloth, cushions and rails between six pockets, balls, a cue.

The longer side is the width; its playing surface is twice as long as wide.
"""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, solid, walls
from openrooms_usd.furniture.joinery.boards import SIDE, board, corners, profiled, square_leg
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import tapered, turned
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.curves import filleted, rectangle
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, lathe, sphere
from openrooms_usd.geometry.sweeps import extrude, tube

_RAIL: Final = 0.125  # width of rail and cushion together, metres
_CUSHION: Final = 0.042
_POCKET: Final = 0.06  # radius
_BALL: Final = 0.0286  # radius of a pool ball
_RISE: Final = 0.044  # of the rails above the cloth


def _rails(x: float, y: float, cloth: float) -> Parts:
    """Rails of wood and cushions of cloth around a bed of half sides (x, y) at a height."""
    top = cloth + _RISE
    gap = 1.05 * _POCKET
    wood, rubber = [], []
    nose = [(0.0, cloth + 0.022), (0.0, cloth + 0.038), (-_CUSHION, top), (-_CUSHION, cloth)]
    for out in (-1.0, 1.0):
        for low, high in ((-x + 0.8 * gap, -gap), (gap, x - 0.8 * gap)):
            wood.append(_bar((low, high), y, top, out))
            strip = profiled(nose, high - low, SIDE, 0.0)
            flipped = strip if out < 0 else turned(strip, "z", 180.0)
            at = (0.5 * (low + high), out * y, 0.0)
            rubber.append(flipped.moved(at))
    ends = (-y + 0.8 * gap, y - 0.8 * gap)
    for out in (-1.0, 1.0):
        wood.append(turned(_bar(ends, x, top, 1.0), "z", -90.0 * out))
        strip = turned(profiled(nose, ends[1] - ends[0], SIDE, 0.0), "z", 90.0 * -out)
        rubber.append(strip.moved((out * x, 0.0, 0.0)))
    return {**numbered("rail", wood), **numbered("cushion", rubber)}


def _bar(span: tuple[float, float], edge: float, top: float, out: float) -> Mesh:
    """A rail along X outside an edge."""
    inner, outer = edge + _CUSHION - 0.002, edge + _RAIL
    low, high = sorted((out * inner, out * outer))
    return board((span[0], low, top - 0.07), (span[1], high, top), 0.006)


def _pockets(x: float, y: float, cloth: float) -> Parts:
    """Dark cups at the corners and in the middle of the long sides, with a leather rim."""
    at = [
        *corners(x + 0.25 * _POCKET, y + 0.25 * _POCKET),
        (0.0, -y - 0.45 * _POCKET),
        (0.0, y + 0.45 * _POCKET),
    ]
    r, top = _POCKET, cloth + _RISE
    cup = lathe(
        [(0.0, cloth - 0.12), (0.75 * r, cloth - 0.12), (r, cloth + 0.0006), (0.0, cloth + 0.0006)],
        segments=24,
    )
    angle = np.radians(np.linspace(-35.0, 215.0, 15))
    path = np.column_stack(
        [1.12 * r * np.cos(angle), 1.12 * r * np.sin(angle), np.full(15, top - 0.014)]
    )
    rim = tube(path, 0.0135, segments=8)
    rims = [
        turned(rim, "z", float(np.degrees(np.arctan2(py, px))) - 90.0).moved((px, py, 0.0))
        for px, py in at
    ]
    return {
        **numbered("pocket", [cup.moved((px, py, 0.0)) for px, py in at]),
        **numbered("pocket_rim", rims),
    }


def _game(x: float, cloth: float, rng: np.random.Generator) -> Parts:
    """Fifteen balls in their triangle, the cue ball, a cue across the bed."""
    ball = sphere(_BALL, segments=14)
    z, step = cloth + _BALL, 2.0 * _BALL + 0.0003
    places = [
        (0.5 * x + row * step * np.sqrt(0.75), (k - 0.5 * row) * step, z)
        for row in range(5)
        for k in range(row + 1)
    ]
    start = (-0.5 * x, float(rng.uniform(-0.2, 0.2)), z)
    cue = turned(
        lathe([(0.0, 0.0), (0.0145, 0.0), (0.0145, 0.3), (0.0062, 1.42), (0.0, 1.42)], segments=14),
        "y",
        90.0,
    )
    lying = turned(cue, "z", float(rng.uniform(-16.0, -6.0))).moved((-0.72, -0.08, cloth + 0.0148))
    return {
        **numbered("ball", [ball.moved(place) for place in places]),
        "cue_ball": ball.moved(start),
        "cue": lying.moved((0.0, -0.22, 0.0)),
    }


def _top(size: Size, rng: np.random.Generator) -> tuple[Parts, float]:
    """All that lies on the legs, and the height of its lower edge."""
    width, depth, height = size
    x, y = 0.5 * width - _RAIL, 0.5 * depth - _RAIL
    played = width > 2.0 and depth > 1.1
    # The balls are what stands highest.
    cloth = height - (2.0 * _BALL if played else _RISE)
    bed = board((-x - _CUSHION, -y - _CUSHION, cloth - 0.028), (x + _CUSHION, y + _CUSHION, cloth))
    outline = filleted(rectangle(width - 0.03, depth - 0.03), 0.09, closed=True, segments=6)
    under = cloth - 0.17
    apron = extrude(outline, cloth - 0.03 - under, bevel=0.006, base=under)
    blocks = [
        extrude(
            filleted(_corner(0.5 * width, 0.5 * depth, sx, sy), 0.008, segments=3, closed=True),
            0.05,
            bevel=0.004,
            base=cloth - 0.03,
        )
        for sx, sy in corners(1.0, 1.0)
    ]
    game = _game(x, cloth, rng) if played else {}
    return {
        "tabletop": bed,
        "frame": joined([apron, *blocks]),
        **_rails(x, y, cloth),
        **_pockets(x, y, cloth),
        **game,
    }, under


def _corner(x: float, y: float, sx: float, sy: float) -> list[tuple[float, float]]:
    """An L that holds two rails together outside a corner pocket."""
    a, b = 0.145, 0.03
    return [
        (sx * x, sy * y),
        (sx * (x - a), sy * y),
        (sx * (x - a), sy * (y - b)),
        (sx * (x - b), sy * (y - b)),
        (sx * (x - b), sy * (y - a)),
        (sx * x, sy * (y - a)),
    ]


def classic(size: Size, rng: np.random.Generator) -> Parts:
    """Six turned legs with square heads and feet."""
    width, depth, _ = size
    top, under = _top(size, rng)
    r = 0.065
    bulge = float(rng.uniform(0.55, 0.8))
    turnings = [
        (0.7 * r, 0.1),
        (0.95 * r, 0.13),
        (0.72 * r, 0.16),
        (r, 0.3),
        (r, 0.62 * under),
        (bulge * r, 0.72 * under),
        (0.95 * r, 0.76 * under),
        (0.95 * r, 0.8 * under),
    ]
    shaft = lathe([(0.0, 0.1), *turnings, (0.0, 0.8 * under)], segments=28, crease=30.0)
    foot = board((-0.055, -0.055, 0.0), (0.055, 0.055, 0.104), 0.006)
    head = board((-0.068, -0.068, 0.79 * under), (0.068, 0.068, under + 0.01), 0.006)
    leg = joined([shaft, foot, head])
    x, y = 0.5 * width - 0.16, 0.5 * depth - 0.16
    places = [*corners(x, y), (0.0, -y), (0.0, y)]
    return {**top, **numbered("leg", [leg.moved((*at, 0.0)) for at in places])}


def pedestal(size: Size, rng: np.random.Generator) -> Parts:
    """Two broad tapered pedestals on plinths, tied by a beam."""
    width, depth, _ = size
    top, under = _top(size, rng)
    x, half = 0.3 * width, float(rng.uniform(0.26, 0.32)) * depth
    block = board((-0.13, -half, 0.05), (0.13, half, under + 0.01), 0.008)
    pillar = tapered(block, "z", (1.5, 1.2))
    plinth = board((-0.19, -1.15 * half, 0.0), (0.19, 1.15 * half, 0.06), 0.008)
    beam = board((-x, -0.05, 0.3 * under), (x, 0.05, 0.3 * under + 0.14), 0.006)
    sides = (-x, x)
    return {
        **top,
        **numbered("leg", [pillar.moved((at, 0.0, 0.0)) for at in sides]),
        "base": joined([*(plinth.moved((at, 0.0, 0.0)) for at in sides), beam]),
    }


def steel(size: Size, rng: np.random.Generator) -> Parts:
    """Slanted box-section legs, joined in pairs by a foot rail with levelling feet."""
    width, depth, _ = size
    top, under = _top(size, rng)
    y, inset = 0.36 * depth, float(rng.uniform(0.14, 0.2)) * width
    leg = square_leg(0.085, 0.06, under - 0.03).moved((0.0, 0.0, 0.04))
    legs = [
        leg.moved((at, side * y, 0.0))
        for at in (-0.5 * width + inset, 0.5 * width - inset)
        for side in (-1, 1)
    ]
    feet = [
        cylinder(0.035, 0.045, bevel=0.004, segments=20, base=(at, side * y, 0.0))
        for at in (-0.5 * width + inset, 0.5 * width - inset)
        for side in (-1, 1)
    ]
    bars = [
        board((at - 0.03, -y, 0.12), (at + 0.03, y, 0.17), 0.004)
        for at in (-0.5 * width + inset, 0.5 * width - inset)
    ]
    return {**top, **numbered("leg", legs), **numbered("foot", feet), "base": joined(bars)}


CATEGORY: Final = BuiltCategory(
    description="a pool table with its balls",
    size=(2.54, 1.42, 0.82),
    min_size=(1.4, 0.9, 0.6),
    max_size=(3.7, 2.1, 1.0),
    styles={"classic": Style(classic), "pedestal": Style(pedestal), "steel": Style(steel)},
    mass_range=(280, 450),
    words="billiard_table snooker_table",
    classes=Classes("pool_table", "otherfurniture", "pool_table"),
    schemes=(
        scheme(
            "wood",
            felt="tabletop cushion",
            black="pocket pocket_rim",
            billiard="ball",
            sanitary="cue_ball",
            steel="foot",
            weight=2.0,
        ),
        scheme(
            "black",
            felt="tabletop cushion",
            wood="cue",
            billiard="ball",
            sanitary="cue_ball",
            steel="foot",
        ),
    ),
    construction=(
        row("tabletop", solid(2700), "common"),  # slate under the felt
        row("frame leg base", walls(20), "board", "wood", "paint"),
        row("cushion", solid(1000), "common"),
        row("ball cue_ball", solid(1750), "common"),
        row(ANY, filled(600), "weight", "wood", "paint", "fabric"),
    ),
    view_importance=4.0,
)
