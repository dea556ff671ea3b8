"""Radiators below windows: ribbed panels, columns of iron, low convectors."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, STEEL, row, walls
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder

# Between the wall and what gives the heat, metres: brackets keep it.
_BEHIND_M: Final = 0.03
_PIPE_M: Final = 0.008
# What a valve takes of the width, on the right, metres.
_VALVE_M: Final = 0.045


def _fixings(size: Size) -> Parts:
    """Brackets to the wall, and a valve with a pipe into the wall at the lower right corner."""
    x, y, height = 0.5 * size[0], 0.5 * size[1], size[2]
    brackets = [
        board(
            (s * 0.6 * x - 0.015, y - _BEHIND_M - 0.006, z - 0.02),
            (s * 0.6 * x + 0.015, y, z + 0.02),
            0.0,
        )
        for s in (-1.0, 1.0)
        for z in (0.15 * height, 0.85 * height)
    ]
    side, level = x - 0.02, 0.07
    pipe = turned(cylinder(_PIPE_M, y + 0.02, segments=8), "x", -90.0).moved((side, 0.0, level))
    stem = turned(cylinder(_PIPE_M, 0.05, segments=8), "y", -90.0).moved((side, 0.0, level))
    pipe = pipe.moved((0.0, -0.02, 0.0))
    knob = cylinder(0.019, 0.06, bevel=0.004, segments=16, base=(side, -0.01, level - 0.03))
    return {
        "bracket": joined(brackets),
        "pipe": joined([pipe, stem.moved((0, -0.01, 0))]),
        "knob": knob,
    }


def _beside_valve(parts: Parts) -> Parts:
    """What gives the heat, on the left of the valve."""
    return {name: mesh.moved((-0.5 * _VALVE_M, 0.0, 0.0)) for name, mesh in parts.items()}


def panel(size: Size, rng: np.random.Generator) -> Parts:
    """A pressed sheet with upright flutes, closed at its sides, a grille on top."""
    x, y, height = 0.5 * (size[0] - _VALVE_M), 0.5 * size[1], size[2]
    back = y - _BEHIND_M
    flutes = max(4, round(2 * x / 0.06))
    pitch = (2 * x - 0.04) / flutes
    face = [board((-x, -y + 0.006, 0.0), (x, -y + 0.014, height - 0.01))]
    for i in range(flutes):
        left = -x + 0.02 + i * pitch
        low, high = (left + 0.006, -y, 0.04), (left + pitch - 0.006, -y + 0.008, height - 0.05)
        face.append(board(low, high, 0.004))
    rear = board((-x, back - 0.012, 0.0), (x, back, height - 0.01))
    sides = [
        board((s * x - 0.002, -y + 0.008, 0.02), (s * x + 0.002, back - 0.002, height), 0.0)
        for s in (-1.0, 1.0)
    ]
    bars = [
        board((-x, v - 0.002, height - 0.006), (x, v + 0.002, height), 0.0)
        for v in np.linspace(-y + 0.012, back - 0.004, 6).tolist()
    ]
    across = [
        board(
            (v - 0.002, -y + 0.01, height - 0.005), (v + 0.002, back - 0.002, height - 0.001), 0.0
        )
        for v in np.linspace(-x, x, max(3, round(2 * x / 0.12))).tolist()
    ]
    core = board((-x + 0.01, -y + 0.016, 0.02), (x - 0.01, back - 0.014, height - 0.06), 0.0)
    body = joined([*face, rear, *sides, *bars, *across, core])
    return {**_beside_valve({"body": body}), **_fixings(size)}


def column(size: Size, rng: np.random.Generator) -> Parts:
    """Sections of two upright tubes each, joined by headers, as cast iron or tubes of steel."""
    x, y, height = 0.5 * (size[0] - _VALVE_M), 0.5 * size[1], size[2]
    back = y - _BEHIND_M
    deep = back + y
    radius = min(0.0125, 0.2 * deep)
    sections = max(3, round(2 * x / 0.046))
    pitch = 2 * x / sections
    front, rear = -y + radius, back - radius
    made: list[Mesh] = []
    for i in range(sections):
        place = -x + (i + 0.5) * pitch
        made += [
            cylinder(radius, height - 0.04, segments=10, base=(place, v, 0.02))
            for v in (front, rear)
        ]
        head = turned(cylinder(0.45 * pitch, deep, segments=10), "x", -90.0)
        made += [head.moved((place, -y, z)) for z in (0.45 * pitch, height - 0.45 * pitch)]
    for z in (0.025, height - 0.025):
        tube = turned(cylinder(0.014, 2 * x, segments=10), "y", 90.0)
        made.append(tube.moved((-x, 0.5 * (front + rear), z)))
    return {**_beside_valve({"body": joined(made)}), **_fixings(size)}


def convector(size: Size, rng: np.random.Generator) -> Parts:
    """A smooth box with slots along its top and its foot."""
    x, y, height = 0.5 * (size[0] - _VALVE_M), 0.5 * size[1], size[2]
    back, count = y - _BEHIND_M, max(3, round(2 * x / 0.03))
    shell = board((-x, -y, 0.03), (x, back, height - 0.004), 0.006)
    slots = []
    for place in np.linspace(-x + 0.03, x - 0.03, count).tolist():
        low, high = (place - 0.009, -0.6 * y, height - 0.005), (place + 0.009, 0.3 * back, height)
        slots.append(board(low, high, 0.0))
    foot = board((-x + 0.02, -y + 0.01, 0.0), (x - 0.02, back - 0.01, 0.035), 0.0)
    parts = {"body": shell, "slot": joined(slots), "base": foot}
    return {**_beside_valve(parts), **_fixings(size)}


CATEGORY: Final = BuiltCategory(
    description="a radiator on a wall",
    size=(1.0, 0.11, 0.6),
    min_size=(0.4, 0.07, 0.2),
    max_size=(3.0, 0.3, 2.0),
    styles={
        "panel": Style(panel),
        "column": Style(column),
        "convector": Style(convector, size=(1.0, 0.12, 0.42)),
    },
    size_variation=STANDARD,
    one_variant_per_room=True,
    support="wall",
    mount_height=0.12,
    fixed=True,
    mass_range=(6, 60),
    words="heater heating_radiator convector_heater",
    classes=Classes(nyu40="otherstructure", ade20k="radiator"),
    schemes=(
        scheme("white", soot="slot base", chrome="pipe", plastic="knob", weight=4.0),
        scheme("black", soot="slot base", steel="pipe", plastic="knob"),
    ),
    construction=(row(ANY, walls(1.0, STEEL), "sheet"),),
)
