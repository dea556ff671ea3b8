"""Alarm clocks: one with two bells, one with digits."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import board, cut_level
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import facing, turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import METAL, scheme
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.solids import box, cylinder, lathe
from openrooms_usd.geometry.sweeps import tube

# Which of the seven bars of a digit are lit: top, upper right, lower right, bottom, lower left,
# upper left, middle.
_LIT: Final = (
    "1111110",
    "0110000",
    "1101101",
    "1111001",
    "0110011",
    "1011011",
    "1011111",
    "1110000",
    "1111111",
    "1111011",
)


def bells(size: Size, rng: np.random.Generator) -> Parts:
    """A round one on two feet, two bells and a handle on its top."""
    width, depth, height = size
    r = 0.5 * width
    middle = r + 0.1 * height
    deep = 0.98 * depth
    rim = [(r - 0.006, 0.0), (r, 0.002), (r, deep - 0.002), (r - 0.006, deep)]
    drum = lathe([(0.0, 0.0), *rim, (r - 0.009, deep - 0.003), (0.0, deep - 0.003)])
    dial = cylinder(r - 0.008, 0.001, base=(0.0, 0.0, deep - 0.0035))
    marks = [
        turned(box((0.0016, 0.1 * r, 0.0012), (0.0, 0.76 * r, deep - 0.0025)), "z", 30.0 * k)
        for k in range(12)
    ]
    hour, minute = float(rng.uniform(0.0, 12.0)), float(rng.uniform(0.0, 60.0))
    hands = [
        turned(box((0.003, 0.42 * r, 0.001), (0.0, 0.19 * r, deep - 0.0015)), "z", -30.0 * hour),
        turned(box((0.002, 0.66 * r, 0.001), (0.0, 0.31 * r, deep - 0.0005)), "z", -6.0 * minute),
        cylinder(0.003, 0.002, segments=10, base=(0.0, 0.0, deep - 0.002)),
    ]
    at = (0.0, 0.5 * deep, middle)
    parts = {
        name: facing(mesh, at)
        for name, mesh in (
            ("frame", drum),
            ("face", dial),
            ("number", joined(marks)),
            ("hand", joined(hands)),
        )
    }
    cap = lathe([(0.0, 0.0), (0.34 * r, 0.0), (0.3 * r, 0.16 * r), (0.0, 0.27 * r)], segments=20)
    top = [
        turned(cap.moved((0.0, 0.0, 1.02 * r)), "y", s * 32.0).moved((0.0, 0.0, middle))
        for s in (-1, 1)
    ]
    long = middle / np.cos(np.radians(33.0)) - 0.85 * r + 0.003
    leg = cylinder(0.004, long, segments=10, base=(0.0, 0.0, 0.85 * r))
    legs = [
        cut_level(turned(leg, "y", 180.0 + s * 33.0).moved((0.0, 0.0, middle))) for s in (-1, 1)
    ]
    path = [
        (-0.26 * r, 0.0, middle + 1.1 * r),
        (-0.2 * r, 0.0, height - 0.003),
        (0.2 * r, 0.0, height - 0.003),
        (0.26 * r, 0.0, middle + 1.1 * r),
    ]
    handle = tube(path, 0.0025, bend=0.1 * r, bend_segments=2, segments=6)
    return {**parts, "bell": joined(top), "foot": joined(legs), "handle": handle}


def digital(size: Size, rng: np.random.Generator) -> Parts:
    """A block with four lit digits behind its front."""
    width, depth, height = size
    x, y = 0.5 * width, 0.5 * depth
    shell = board((-x, -y + 0.001, 0.0), (x, y, height), 0.006)
    glass = board((-x + 0.006, -y + 0.0006, 0.007), (x - 0.006, -y + 0.003, height - 0.007), 0.0003)
    tall, wide = 0.5 * height, 0.13 * width
    bars = []
    clock = f"{int(rng.integers(24)):02d}{int(rng.integers(60)):02d}"
    for place, digit in zip((-0.33, -0.14, 0.14, 0.33), clock, strict=True):
        for k, lit in enumerate(_LIT[int(digit)]):
            if lit == "1":
                u, v, upright = (
                    (0, 1, 0),
                    (1, 0.5, 1),
                    (1, -0.5, 1),
                    (0, -1, 0),
                    (-1, -0.5, 1),
                    (-1, 0.5, 1),
                    (0, 0, 0),
                )[k]
                thick = 0.16 * wide
                side = (thick, 0.42 * tall) if upright else (0.8 * wide, thick)
                at = (place * width + 0.5 * wide * u, -y + 0.0004, 0.5 * height + 0.5 * tall * v)
                bars.append(box((side[0], 0.0008, side[1]), at))
    r = 0.01 * width
    dots = [
        box((2 * r, 0.0008, 2 * r), (0.0, -y + 0.0004, (0.5 + s * 0.13) * height)) for s in (-1, 1)
    ]
    return {"frame": shell, "screen": glass, "digit": joined([*bars, *dots])}


CATEGORY: Final = BuiltCategory(
    description="an alarm clock",
    size=(0.1, 0.06, 0.135),
    min_size=(0.04, 0.02, 0.03),
    max_size=(0.25, 0.15, 0.25),
    styles={
        "bells": Style(bells, lambda size: size[2] > size[0]),
        "digital": Style(digital, lambda size: size[2] < size[0], (0.15, 0.05, 0.07)),
    },
    size_variation=STANDARD,
    support="surface",
    mass_range=(0.1, 0.7),
    words="clock_radio digital_clock desk_clock",
    classes=Classes("clock", "otherprop", "clock", "clock"),
    schemes=(
        scheme(METAL, white_paper="face", print="number", black="hand"),
        scheme(
            "lacquer", white_paper="face", print="number", black="hand", chrome="bell foot handle"
        ),
        scheme("dark_plastic", lit_digit="digit", needs="digit", weight=100.0),
    ),
    construction=(row(ANY, filled(550), "weight"),),
    placements=(
        on("bedside", weight=0.6),
        on("shelf desk dresser_top", "bedroom", weight=0.25, max_groups=1),
    ),
)
