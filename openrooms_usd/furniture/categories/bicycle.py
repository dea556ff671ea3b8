"""Bicycles that stand on a kickstand with two legs."""

from collections.abc import Sequence
from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, STEEL, filled, row, solid, walls
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import hoop, turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder
from openrooms_usd.geometry.sweeps import tube

Point = tuple[float, float, float]
# The usual box, and in it: wheels, their axles, the crank's axle, the head tube; metres.
_SIZE: Final[Size] = (1.74, 0.58, 1.05)
_WHEEL_M, _TYRE_M, _AXLE_M = 0.34, 0.02, 0.53
_CRANK: Final[Point] = (-0.1, 0.0, 0.28)
_HEAD: Final[tuple[Point, Point]] = ((0.4, 0.0, 0.7), (0.36, 0.0, 0.86))
_SPOKES: Final = 20


def _bar(points: Sequence[Point], radius: float, bend: float = 0.0) -> Mesh:
    path = filleted(points, bend) if bend else np.array(points)
    return tube(path, radius, segments=10)


def _across(mesh: Mesh) -> Mesh:
    """What is drawn about Z, turned about Y."""
    return turned(mesh, "x", 90.0)


def _wheel(x: float) -> dict[str, Mesh]:
    """Tyre, rim with hub, and spokes about an axle."""
    at = (x, 0.0, _WHEEL_M)
    rim = _WHEEL_M - 2.0 * _TYRE_M
    angles = 2.0 * np.pi * np.arange(_SPOKES) / _SPOKES
    spokes = [
        tube(
            [
                (0.018 * np.cos(a + s * 1.2), 0.03 * s, 0.018 * np.sin(a + s * 1.2)),
                (rim * np.cos(a), 0.0, rim * np.sin(a)),
            ],
            0.0012,
            segments=4,
        )
        for a, s in zip(angles.tolist(), np.tile([-1.0, 1.0], _SPOKES // 2).tolist(), strict=True)
    ]
    hub = _across(cylinder(0.02, 0.08, segments=16, base=(0.0, 0.0, -0.04)))
    return {
        "tyre": _across(hoop(_WHEEL_M - _TYRE_M, 0.0, _TYRE_M, 40, 8)).moved(at),
        "rim": joined([_across(hoop(rim, 0.0, 0.009, 40)), hub]).moved(at),
        "spoke": joined(spokes).moved(at),
    }


def _drive() -> dict[str, Mesh]:
    """Chainring, cranks, pedals, and the chain to the rear hub."""
    x, _, z = _CRANK
    y = -0.045
    ring = _across(hoop(0.085, 0.0, 0.004, 30)).moved((x, y, z))
    cranks = [
        _bar([(x, s * 0.055, z), (x + s * 0.16, s * 0.075, z - s * 0.04)], 0.009)
        for s in (-1.0, 1.0)
    ]
    pedals = [
        board(
            (x + s * 0.16 - 0.045, s * 0.125 - 0.045, z - s * 0.04 - 0.011),
            (x + s * 0.16 + 0.045, s * 0.125 + 0.045, z - s * 0.04 + 0.011),
            0.003,
        )
        for s in (-1.0, 1.0)
    ]
    rows = [
        _bar([(x, y, z + s * 0.085), (-_AXLE_M, y, _WHEEL_M + s * 0.04)], 0.004)
        for s in (-1.0, 1.0)
    ]
    axle = _across(cylinder(0.022, 0.08, segments=16, base=(0.0, 0.0, -0.04))).moved(_CRANK)
    return {
        "chain": joined([*rows, ring]),
        "crank": joined([*cranks, axle]),
        "pedal": joined(pedals),
    }


def _frame(seat: Point, top: Point) -> Mesh:
    """Tubes between saddle, head, cranks and the rear axle, and the fork."""
    low, high = _HEAD
    tubes = [
        _bar([_CRANK, seat], 0.0155),
        _bar([_CRANK, (0.39, 0.0, 0.74)], 0.0175),
        _bar([top, (0.37, 0.0, 0.82)], 0.0145),
        _bar([low, high], 0.019),
    ]
    for s in (-1.0, 1.0):
        rear = (-_AXLE_M, s * 0.052, _WHEEL_M)
        tubes.append(_bar([(_CRANK[0], s * 0.02, _CRANK[2]), rear], 0.009))
        tubes.append(_bar([(-0.24, s * 0.012, 0.7), rear], 0.008))
        fork = [(0.405, s * 0.028, 0.69), (0.43, s * 0.05, 0.6), (_AXLE_M, s * 0.05, _WHEEL_M)]
        tubes.append(_bar(fork, 0.011, 0.03))
    tubes.append(_bar([(0.405, -0.036, 0.69), (0.405, 0.036, 0.69)], 0.014))
    return joined(tubes)


def _steering(rise: float) -> dict[str, Mesh]:
    """Stem and handlebar with grips that sweep back."""
    x, z = 0.34, 0.86
    stem = [(x + 0.02, 0.0, z), (x, 0.0, z + rise), (x + 0.05, 0.0, z + rise + 0.01)]
    end = 0.5 * _SIZE[1]
    bars, grips = [], []
    for s in (-1.0, 1.0):
        tip = (x - 0.09, s * end, z + rise + 0.03)
        bend = [(x + 0.05, s * 0.16, z + rise + 0.03), (x, s * (end - 0.1), z + rise + 0.035)]
        bars.append(_bar([(x + 0.05, 0.0, z + rise + 0.01), *bend, tip], 0.011, 0.05))
        grips.append(_bar([(x - 0.02, s * (end - 0.09), z + rise + 0.0345), tip], 0.016))
    return {"handlebar": joined([_bar(stem, 0.013), *bars]), "grip": joined(grips)}


def bicycle(size: Size, rng: np.random.Generator, *, sloping: bool) -> Parts:
    """With a level top tube, or with one that slopes and a higher handlebar."""
    seat = (-0.27, 0.0, 0.8)
    top = (-0.235, 0.0, 0.68) if sloping else (-0.262, 0.0, 0.78)
    saddle = joined(
        [
            board((-0.41, -0.075, 0.93), (-0.26, 0.075, 0.965), 0.015),
            board((-0.28, -0.03, 0.932), (-0.13, 0.03, 0.962), 0.014),
        ]
    )
    stand = [_bar([(-0.15, 0.02 * s, 0.27), (-0.2, 0.13 * s, 0.006)], 0.006) for s in (-1.0, 1.0)]
    wheels = [_wheel(x) for x in (-_AXLE_M, _AXLE_M)]
    made: Parts = {
        "frame": _frame(seat, top),
        "saddle": saddle,
        "post": _bar([(-0.265, 0.0, 0.77), (-0.3, 0.0, 0.94)], 0.0125),
        "kickstand": joined(stand),
        **_drive(),
        **_steering(0.13 if sloping else 0.1),
    }
    for name in ("tyre", "rim", "spoke"):
        made |= numbered(name, [wheel[name] for wheel in wheels])
    low, high = joined(list(made.values())).extent
    scale = np.array(size) / (high - low)
    offset = [-0.5 * (low[0] + high[0]), -0.5 * (low[1] + high[1]), -low[2]]
    return {name: mesh.moved(offset).transformed(np.diag(scale)) for name, mesh in made.items()}


CATEGORY: Final = BuiltCategory(
    description="a bicycle",
    size=_SIZE,
    min_size=(1.2, 0.4, 0.75),
    max_size=(2.0, 0.75, 1.25),
    styles={
        "city": Style(partial(bicycle, sloping=False)),
        "trekking": Style(partial(bicycle, sloping=True)),
    },
    size_variation=STANDARD,
    mass_range=(8, 22),
    words="bike bicycles bikes",
    classes=Classes("bike", "otherprop", "bicycle", "bicycle"),
    synsets=("02834778",),
    schemes=(
        scheme(
            "black",
            lacquer="frame",
            steel="rim spoke chain crank kickstand",
            chrome="handlebar post",
            tyre="tyre",
            hide="saddle grip",
        ),
        scheme("black", lacquer="frame", steel="spoke chain post", tyre="tyre"),
    ),
    construction=(
        row("tyre", filled(600), "common"),
        row("spoke chain", solid(7800), "common", "metal"),
        row("saddle grip", filled(300), "common"),
        row(ANY, walls(3.5, STEEL), "sheet", "metal", "paint"),
    ),
    placements=(
        on("floor_by_wall", "hallway garage basement", weight=1.5, max_groups=1),
        on("floor_by_wall", "living_room apartment", weight=0.15, max_groups=1),
    ),
)
