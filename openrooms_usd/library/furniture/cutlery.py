"""Cutlery: a fork, a knife, a spoon, each forged of one piece and lying on its back."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.sweeps import sheet
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    STANDARD,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style, board

Line = Sequence[tuple[float, float]]


def _blade(
    outline: Sequence[tuple[float, float, float]], dish: float, thick: float, rows: int
) -> Mesh:
    """A bent strip along Y: half width and height by the share of its length.

    Args:
        outline: Share of its length, half of its width, height of its middle, metres.
        dish: How far its sides rise above its middle, in parts of their distance from it.
        thick: Metres.
        rows: Points along it.
    """
    share, half, level = np.array(outline).T
    t = np.union1d(np.linspace(share[0], share[-1], rows), share[[0, -1]])
    a, z = np.interp(t, share, half), np.interp(t, share, level)
    u = np.linspace(-1.0, 1.0, 5)
    grid = np.stack([a[:, None] * u, np.broadcast_to(t[:, None], (len(t), 5)),
                     z[:, None] + dish * a[:, None] * u**2], axis=-1)  # fmt: skip
    return sheet(grid, thick)


def _stem(width: float, long: float, height: float, end: float) -> list[tuple[float, ...]]:
    """The handle up to where a head begins at the share ``end`` of its length."""
    half = 0.5 * width
    rows = [(0.0, 0.3 * half, 0.3 * height), (0.02, 0.62 * half, 0.28 * height),
            (0.08, 0.7 * half, 0.22 * height), (0.3, 0.42 * half, 0.3 * height),
            (end - 0.12, 0.2 * half, 0.85 * height), (end, 0.22 * half, 0.9 * height)]  # fmt: skip
    return [(t * long, a, z) for t, a, z in rows]


def _laid(meshes: list[Mesh], long: float) -> Parts:
    return {"cutlery": joined(meshes).moved((0.0, -0.5 * long, 0.0))}


def fork(size: Size, rng: np.random.Generator) -> Parts:
    """A fork with four tines."""
    width, long, height = size
    half, thick = 0.5 * width, 0.0018
    head = [(0.72 * long, 0.75 * half, 0.62 * height), (0.78 * long, half, 0.35 * height)]
    body = _blade([*_stem(width, long, height, 0.64), *head], 0.0, thick, 16)
    tines = []
    for k in range(4):
        x = (k - 1.5) * 0.54 * half
        rows = [(0.772, 0.17, 0.4), (0.84, 0.16, 0.22), (0.93, 0.13, 0.42), (1.0, 0.07, 0.75)]
        tine = _blade([(t * long, a * half, z * height) for t, a, z in rows], 0.0, thick, 4)
        tines.append(tine.moved((x, 0.0, 0.0)))
    return _laid([body, *tines], long)


def spoon(size: Size, rng: np.random.Generator) -> Parts:
    """A spoon with an oval bowl."""
    width, long, height = size
    half, thick = 0.5 * width, 0.0018
    t = np.linspace(0.0, 1.0, 8)[1:]
    around = np.sqrt(np.clip(1.0 - (2.0 * t**0.9 - 1.0) ** 2, 0.02, 1.0))
    depth = (0.62 - 0.62 * np.sin(np.pi * np.clip(1.1 * t, 0.0, 1.0)) ** 0.8) * height + 0.002
    bowl = [(float(0.7 + 0.3 * s) * long, float(a) * half, float(z))
            for s, a, z in zip(t, around, depth, strict=True)]  # fmt: skip
    return _laid([_blade([*_stem(width, long, height, 0.7), *bowl], 0.32, thick, 26)], long)


def knife(size: Size, rng: np.random.Generator) -> Parts:
    """A table knife: a thick handle and a blade that is rounded at its end."""
    width, long, height = size
    half = 0.5 * width
    grip = board((-0.72 * half, 0.0, 0.0), (0.72 * half, 0.44 * long, height), 0.42 * height)
    rows = [(0.43, 0.5), (0.47, 0.62), (0.6, 0.96), (0.85, 1.0), (0.95, 0.82), (0.985, 0.5),
            (1.0, 0.2)]  # fmt: skip
    blade = _blade([(t * long, a * half, 0.62 * height) for t, a in rows], 0.0, 0.0014, 9)
    return {
        "handle": grip.moved((0.0, -0.5 * long, 0.0)),
        "cutlery": blade.moved((0.0, -0.5 * long, 0.0)),
    }


CATEGORY: Final = BuiltCategory(
    description="a fork, a knife or a spoon",
    size=(0.026, 0.2, 0.018),
    least=(0.012, 0.08, 0.006),
    most=(0.08, 0.4, 0.06),
    styles={
        "fork": Style(fork),
        "knife": Style(knife, size=(0.022, 0.225, 0.009)),
        "spoon": Style(spoon, size=(0.042, 0.2, 0.02)),
    },
    spread=STANDARD,
    round=False,
    alike=True,
    support="surface",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.015, 0.13)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="fork knife spoon silverware utensil",
    classes=Classes(UNLABELED, "otherprop"),
    synsets=("03624134",),
    schemes=(
        Scheme({ANY: "cutlery_steel", "handle": "cutlery_steel"}, weight=3.0),
        Scheme({ANY: "cutlery_steel", "handle": "black_plastic"}),
    ),
    makes=(
        makes.row(ANY, makes.solid(), "common", "metal"),
        makes.row(ANY, makes.solid(1200), "common"),
    ),
    hinges=PLAIN_HINGES,
    yields=RIGID,
)
