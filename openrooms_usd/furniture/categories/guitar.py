"""Guitars on a stand: with a hollow body, or a solid one."""

from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.construction import ANY, STEEL, filled, row, walls
from openrooms_usd.furniture.joinery.boards import FRONT, board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.solids import cylinder
from openrooms_usd.geometry.sweeps import extrude, tube

# How far it leans back on its stand, degrees.
_LEAN_DEG: Final = 12.0


def _waisted(width: float, tall: float) -> Array:
    """(N, 2) an outline with a waist, wider below; its lower end at 0."""
    t = np.linspace(0.0, 1.0, 25)
    # Half widths from the lower bout over the waist to the upper bout.
    shape = np.sqrt(np.clip(np.sin(np.pi * t), 0.0, 1.0)) * (1.0 - 0.28 * t)
    shape *= 1.0 - 0.24 * np.exp(-(((t - 0.58) / 0.13) ** 2))
    half = 0.5 * width * shape / shape.max()
    right = np.column_stack([half, tall * t])[1:-1]
    left = right[::-1] * [-1.0, 1.0]
    return np.concatenate([[(0.0, 0.0)], right, [(0.0, tall)], left])


def _stand(back: float, thick: float, tall: float, seat: float) -> Parts:
    """A stand of bent tube for a body of some thickness and height, its seat at a height."""
    r, y = 0.009, 0.02
    legs = [
        tube(
            [
                (s * 0.14, -back + r, r),
                (s * 0.12, y - thick - 0.02, seat - 0.012),
                (0.0, 0.16, 0.55 * tall + seat),
            ],
            r,
            bend=0.05,
            segments=10,
        )
        for s in (-1.0, 1.0)
    ]
    # The end of the leg that leans is cut square: its lower edge stands on the floor.
    rise, run = 0.55 * tall + seat, back - r - 0.16
    foot = r * run / np.hypot(rise, run)
    legs.append(tube([(0.0, back - r, foot), (0.0, 0.16, rise)], r, segments=10))
    rest = tube(
        [(-0.13, y - 0.5 * thick, seat - 0.012), (0.13, y - 0.5 * thick, seat - 0.012)],
        r,
        segments=10,
    )
    return {**numbered("leg", legs), "support": rest}


def on_stand(size: Size, rng: np.random.Generator, *, solid: bool) -> Parts:
    """A guitar that leans in a stand of bent tube."""
    width, depth, height = size
    lean = np.radians(_LEAN_DEG)
    seat = 0.12
    long = (height - seat - 0.01) / np.cos(lean)
    tall = (0.42 if solid else 0.49) * long
    thick = 0.045 if solid else 0.1
    body = extrude(_waisted(width, tall), thick, bevel=0.006).transformed(FRONT)
    neck = board((-0.026, -thick - 0.012, 0.7 * tall), (0.026, -thick + 0.012, 0.88 * long), 0.006)
    frets = board(
        (-0.025, -thick - 0.017, 0.62 * tall), (0.025, -thick - 0.011, 0.88 * long), 0.001
    )
    head = board((-0.036, -thick - 0.006, 0.87 * long), (0.036, -thick + 0.01, long), 0.003)
    bridge = board((-0.075, -thick - 0.012, 0.27 * tall), (0.075, -thick + 0.001, 0.31 * tall))
    z = np.linspace(0.89 * long, 0.98 * long, 3)
    pegs = [cylinder(0.008, 0.03, segments=10) for _ in range(6)]
    pins = joined(
        [
            turned(peg, "y", 90.0).moved(
                (s * 0.036 - (0.0 if s > 0 else 0.03), 0.0 - thick, float(a))
            )
            for peg, (s, a) in zip(pegs, [(s, a) for s in (-1.0, 1.0) for a in z], strict=True)
        ]
    )
    strings = joined(
        [
            tube(
                [(a, -thick - 0.0135, 0.29 * tall), (a, -thick - 0.0195, 0.88 * long)],
                0.0006,
                segments=4,
            )
            for a in np.linspace(-0.02, 0.02, 6).tolist()
        ]
    )
    made: Parts = {
        "body": body,
        "neck": neck,
        "fretboard": frets,
        "head": head,
        "bridge": bridge,
        "peg": pins,
        "string": strings,
    }
    if not solid:
        rose = cylinder(0.05, 0.002, segments=28)
        made["rosette"] = turned(rose, "x", 90.0).moved((0.0, -thick + 0.0005, 0.6 * tall))
    leaning = {
        name: turned(mesh, "x", -_LEAN_DEG).moved((0.0, 0.02, seat)) for name, mesh in made.items()
    }
    return {**leaning, **_stand(0.5 * depth, thick, tall, seat)}


CATEGORY: Final = BuiltCategory(
    description="a guitar on its stand",
    size=(0.39, 0.5, 1.12),
    min_size=(0.25, 0.3, 0.7),
    max_size=(0.6, 0.8, 1.4),
    styles={
        "acoustic": Style(partial(on_stand, solid=False)),
        "electric": Style(partial(on_stand, solid=True), size=(0.34, 0.5, 1.1)),
    },
    size_variation=STANDARD,
    mass_range=(2, 9),
    words="acoustic_guitar electric_guitar bass_guitar ukulele",
    classes=Classes(openrooms45="guitar"),
    synsets=("03467517",),
    schemes=(
        scheme(
            "wood",
            steel="string",
            chrome="peg",
            black="rosette leg",
            tyre="support",
            ebony="fretboard",
            weight=2.0,
        ),
        scheme(
            "piano_lacquer",
            wood="neck head",
            steel="string",
            chrome="peg",
            black="rosette leg",
            tyre="support",
            ebony="fretboard",
        ),
    ),
    construction=(
        row("leg", walls(1.2, STEEL), "sheet"),
        row("body", filled(250), "weight"),
        row(ANY, filled(600), "common"),
    ),
)
