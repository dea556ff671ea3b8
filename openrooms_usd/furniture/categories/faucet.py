"""Faucets: a mixer with one lever, a high arc, a bridge with two handles, a pillar by a bath."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, BRASS, row, walls
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import DARK_TAP, METAL, scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.sweeps import tube

Point = tuple[float, float, float]
_UP: Final = (0.0, 0.0, 1.0)


def _pillar(radius: float, height: float) -> Mesh:
    """A body that widens to its foot, on the origin."""
    r = radius
    return lathe(
        [
            (0.0, 0.0),
            (r, 0.0),
            (r, 0.004),
            (0.88 * r, 0.008),
            (0.8 * r, 0.03),
            (0.8 * r, height - 0.004),
            (0.74 * r, height),
            (0.0, height),
        ],
        segments=24,
    )


def mixer(made: Assembly, size: Size, at: Point) -> None:
    """One body, a short spout, and a lever on top; ``at`` is the middle of the base of its box."""
    width, depth, height = size
    r = 0.5 * width
    tall = 0.72 * height
    y = at[1] + 0.5 * depth - r
    made.add("body", _pillar(r, tall).moved((at[0], y, at[2])))
    tip = at[1] - 0.5 * depth + 0.012
    z = at[2] + 0.62 * tall
    spout = [(at[0], y, z - 0.01), (at[0], tip + 0.004, z + 0.015), (at[0], tip, z - 0.016)]
    made.add("spout", tube(spout, 0.012, bend=0.014, segments=14))
    top = at[2] + tall + 0.001
    cap = lathe([(0.0, 0.0), (0.8 * r, 0.0), (0.72 * r, 0.014), (0.0, 0.018)], segments=24)
    grip = tube(
        [(0.0, 0.0, 0.008), (0.0, -0.72 * (y - tip), height - tall - 0.011)],
        [0.008, 0.005],
        segments=10,
    )
    names = made.add("switch", joined([cap, grip]).moved((at[0], y, top)))
    made.turn("switch", names, (at[0], y, top), _UP, (-40.0, 40.0))


def arc(made: Assembly, size: Size, at: Point) -> None:
    """A thin tube in a high arc, a small lever on its right side."""
    width, depth, height = size
    r, pipe = min(0.025, 0.3 * width), 0.011
    y, tip = at[1] + 0.5 * depth - r, at[1] - 0.5 * depth + pipe
    x = at[0] - 0.5 * width + r
    stem = min(0.09, 0.35 * height)
    made.add("body", _pillar(r, stem).moved((x, y, at[2])))
    bend = min(0.5 * (y - tip), 0.42 * height)
    top = at[2] + height - pipe - bend
    angle = np.linspace(0.0, 0.5 * np.pi, 8)
    rise = [(x, y - bend * (1.0 - float(np.cos(a))), top + bend * float(np.sin(a))) for a in angle]
    fall = [
        (x, tip + bend * (1.0 - float(np.sin(a))), top + bend * float(np.cos(a)))
        for a in angle[1 if y - tip < 2.001 * bend else 0 :]
    ]
    path = [
        (x, y, at[2] + stem - 0.001),
        *rise,
        *fall,
        (x, tip, max(top - 0.05, at[2] + 0.45 * height)),
    ]
    names = made.add("spout", tube(path, pipe, segments=14))
    made.turn("spout", names, (x, y, at[2] + stem), _UP, (-70.0, 70.0))
    z = at[2] + 0.6 * stem
    reach = at[0] + 0.5 * width - x
    lever = joined(
        [
            tube([(0.78 * r, 0.0, 0.0), (0.62 * reach, 0.0, 0.0)], 0.55 * r, segments=14),
            tube([(0.5 * reach, 0.0, 0.0), (reach - 0.005, 0.0, 0.05)], 0.005, segments=8),
        ]
    )
    names = made.add("switch", lever.moved((x, y, z)))
    made.turn("switch", names, (x, y, z), (1.0, 0.0, 0.0), (0.0, 60.0))


def _cross(radius: float) -> Mesh:
    """A cross of four short arms around a hub, on the origin."""
    hub = lathe(
        [(0.0, 0.0), (0.011, 0.0), (0.013, 0.012), (0.008, 0.022), (0.0, 0.024)], segments=16
    )
    arms = [
        tube(
            [(-radius * a, -radius * b, 0.012), (radius * a, radius * b, 0.012)], 0.005, segments=8
        )
        for a, b in ((1.0, 0.0), (0.0, 1.0))
    ]
    return joined([hub, *arms])


def bridge(made: Assembly, size: Size, at: Point) -> None:
    """Two taps joined by a bridge from whose middle a spout rises."""
    width, depth, height = size
    arm = min(0.03, 0.16 * width)
    x, y, pipe = 0.5 * width - arm, at[1] + 0.5 * depth - arm, 0.010
    tall = min(0.075, 0.4 * height)
    for side in (-x, x):
        made.add("body", _pillar(0.02, tall).moved((at[0] + side, y, at[2])))
        top = (at[0] + side, y, at[2] + tall + 0.001)
        names = made.add("switch", _cross(arm).moved(top))
        made.turn("switch", names, top, _UP, (0.0, 180.0))
    level = at[2] + 0.55 * tall
    made.add("body", tube([(at[0] - x, y, level), (at[0] + x, y, level)], pipe))
    tip, high = at[1] - 0.5 * depth + pipe, at[2] + height - pipe
    path = [
        (at[0], y, level),
        (at[0], y, high),
        (at[0], tip, high),
        (at[0], tip, high - 0.3 * height),
    ]
    bend = 0.45 * (y - tip)
    made.add("spout", tube(path, pipe, bend=bend, bend_segments=8, segments=14))


def pillar(made: Assembly, size: Size, at: Point) -> None:
    """A column from the floor with a long spout, a lever, and a hand shower on its side."""
    width, depth, height = size
    x, y, z = at[0], at[1] + 0.5 * depth - 0.045, at[2]
    tip, level = at[1] - 0.5 * depth + 0.014, height - 0.03
    made.add(
        "body",
        lathe(
            [
                (0.0, 0.0),
                (0.045, 0.0),
                (0.045, 0.006),
                (0.02, 0.012),
                (0.02, height - 0.11),
                (0.027, height - 0.1),
                (0.027, height - 0.012),
                (0.022, height - 0.008),
                (0.0, height - 0.008),
            ],
            segments=28,
        ).moved((x, y, z)),
    )
    spout = [(x, y, z + level - 0.02), (x, tip, z + level - 0.02), (x, tip, z + level - 0.075)]
    made.add("spout", tube(spout, 0.013, bend=0.03, bend_segments=5, segments=14))
    # Beside the body, against which it turns.
    lever = tube(
        [(0.0282, 0.0, 0.0), (0.5 * width - 0.006, 0.0, 0.028)], [0.008, 0.005], segments=10
    )
    pivot = (x, y, z + level - 0.03)
    names = made.add("switch", lever.moved(pivot))
    made.turn("switch", names, pivot, (1.0, 0.0, 0.0), (0.0, 60.0))
    side = x - 0.5 * width + 0.013
    made.add(
        "bracket", tube([(x, y, z + level - 0.05), (side, y, z + level - 0.05)], 0.008, segments=10)
    )
    grip = [(side, y, z + height - 0.26), (side, y, z + height - 0.012)]
    made.add("spout", tube(grip, [0.009, 0.0125]))
    hose = [
        (side, y, z + height - 0.26),
        (side, y - 0.01, z + 0.42 * height),
        (x - 0.03, y - 0.02, z + 0.3 * height),
        (x, y, z + 0.5 * height),
    ]
    made.add("hose", tube(hose, 0.006, bend=0.06, bend_segments=5, segments=8))


KINDS: Final = {"mixer": mixer, "arc": arc, "bridge": bridge, "pillar": pillar}


def _alone(kind: str, size: Size) -> Furniture:
    made = Assembly()
    KINDS[kind](made, size, (0.0, 0.0, 0.0))
    return made.furniture()


CATEGORY: Final = BuiltCategory(
    description="a tap for a sink",
    size=(0.09, 0.2, 0.3),
    min_size=(0.03, 0.08, 0.08),
    max_size=(0.4, 0.4, 1.5),
    styles={
        "arc": Style(
            lambda size, rng: _alone("arc", size),
            lambda size: 0.06 <= size[0] < 0.16 and 0.14 < size[2] < 0.7,
        ),
        "mixer": Style(
            lambda size, rng: _alone("mixer", size), lambda size: size[0] < 0.08, (0.05, 0.15, 0.17)
        ),
        "bridge": Style(
            lambda size, rng: _alone("bridge", size),
            lambda size: size[0] >= 0.14 and size[2] < 0.7,
            (0.24, 0.2, 0.26),
        ),
        "pillar": Style(
            lambda size, rng: _alone("pillar", size),
            lambda size: size[2] > 0.7,
            (0.2, 0.26, 1.0),
            mass_range=(2, 12),
        ),
    },
    size_variation=STANDARD,
    support="surface",
    alternative_supports=("wall", "floor"),
    fixed=True,
    mass_range=(0.5, 3),
    words="tap spigot water_faucet",
    classes=Classes(openrooms45="faucet"),
    synsets=("03325088",),
    schemes=(scheme("chrome", chrome="switch bracket", weight=2.0), scheme(METAL, DARK_TAP)),
    construction=(row(ANY, walls(3, BRASS), "common"),),
)
