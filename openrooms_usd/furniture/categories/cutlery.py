"""Cutlery: a fork, a knife, a spoon, each forged of one piece and lying on its back."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, row, solid
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import at_rest
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.sweeps import sheet
from openrooms_usd.geometry.vectors import points_at


def _strip(
    outline: Sequence[tuple[float, float, float]], dish: float, thick: float, rows: int
) -> Mesh:
    """A bent strip along Y, half as wide and as high as told at some places.

    Args:
        outline: Place along Y, half width, height of the middle of the upper side, metres.
        dish: How far its sides rise above its middle, in parts of their distance from it.
        thick: Metres.
        rows: Points along it.
    """
    place, half, level = np.array(outline).T
    y = np.linspace(place[0], place[-1], rows)
    a, z = np.interp(y, place, half), np.interp(y, place, level)
    u = np.linspace(-1.0, 1.0, 3 if dish else 2)
    grid = points_at(a[:, None] * u, y[:, None], z[:, None] + dish * a[:, None] * u**2)
    return sheet(grid, thick)


def _rows(
    size: Size, rows: Sequence[tuple[float, float, float]], thick: float
) -> list[tuple[float, float, float]]:
    """Shares of the length, of half the width and of the height, in metres."""
    width, long, height = size
    return [((t - 0.5) * long, 0.5 * a * width, thick + z * (height - thick)) for t, a, z in rows]


# A handle up to its neck: it rests near its end and rises towards the head.
_HANDLE: Final = (
    (0.0, 0.3, 0.15),
    (0.02, 0.62, 0.1),
    (0.08, 0.7, 0.0),
    (0.3, 0.44, 0.15),
    (0.54, 0.22, 0.85),
    (0.64, 0.22, 1.0),
)


def fork(size: Size, rng: np.random.Generator) -> Parts:
    """A fork with four tines."""
    thick = 0.0018
    head = ((0.71, 0.7, 0.6), (0.785, 1.0, 0.12))
    body = _strip(_rows(size, (*_HANDLE, *head), thick), 0.0, thick, 26)
    tine = _strip(
        _rows(
            size,
            ((0.775, 0.19, 0.14), (0.84, 0.17, 0.0), (0.93, 0.13, 0.15), (1.0, 0.06, 0.5)),
            thick,
        ),
        0.0,
        thick,
        4,
    )
    offsets = 0.27 * size[0] * (np.arange(4) - 1.5)
    whole = joined([body, *(tine.moved((x, 0.0, 0.0)) for x in offsets.tolist())])
    return at_rest({"cutlery": whole}, size)


def spoon(size: Size, rng: np.random.Generator) -> Parts:
    """A spoon with an oval bowl."""
    thick = 0.0018
    t = np.linspace(0.06, 1.0, 9)
    around = np.sqrt(np.clip(1.0 - (2.0 * t**0.9 - 1.0) ** 2, 0.01, 1.0))
    depth = 1.0 - np.sin(0.5 * np.pi * np.clip(2.0 * t, 0.0, 1.0))
    depth[t > 0.5] = 0.35 * (2.0 * t[t > 0.5] - 1.0) ** 2
    bowl = [(0.68 + 0.32 * s, a, z) for s, a, z in zip(t, around, depth, strict=True)]
    handle = [(t, 0.6 * a, z) for t, a, z in _HANDLE]
    whole = _strip(_rows(size, (*handle, *bowl), thick), 0.28, thick, 26)
    return at_rest({"cutlery": whole}, size)


def knife(size: Size, rng: np.random.Generator) -> Parts:
    """A table knife: a thick handle, and a blade that lies flat and is rounded at its end."""
    width, long, height = size
    half, back = 0.36 * width, -0.5 * long
    grip = board((-half, back, 0.0), (half, back + 0.44 * long, height), 0.42 * height)
    rows = (
        (0.43, 0.5),
        (0.47, 0.62),
        (0.6, 0.96),
        (0.85, 1.0),
        (0.95, 0.82),
        (0.985, 0.5),
        (1.0, 0.2),
    )
    blade = _strip(_rows(size, [(t, a, 0.0) for t, a in rows], 0.0014), 0.0, 0.0014, 20)
    return {"handle": grip, "cutlery": blade}


CATEGORY: Final = BuiltCategory(
    description="a fork, a knife or a spoon",
    size=(0.026, 0.2, 0.018),
    min_size=(0.012, 0.08, 0.006),
    max_size=(0.08, 0.4, 0.06),
    styles={
        "fork": Style(fork),
        "knife": Style(knife, size=(0.021, 0.225, 0.009)),
        "spoon": Style(spoon, size=(0.042, 0.2, 0.022)),
    },
    size_variation=STANDARD,
    one_variant_per_room=True,
    support="surface",
    mass_range=(0.015, 0.13),
    words="fork knife spoon silverware utensil",
    synsets=("03624134",),
    schemes=(
        scheme("cutlery_steel", cutlery_steel="handle", weight=3.0),
        scheme("cutlery_steel", black_plastic="handle"),
    ),
    construction=(row(ANY, solid(), "common", "metal"), row(ANY, solid(1200), "common")),
    placements=(
        on("dining_table", cluster="setting", weight=0.7),
        on("drawer", "kitchen dining_room", pose="row", count=(3, 6)),
        on(
            "sink_edge worktop", "kitchen", pose="flat", cluster="washing_up", clutter=2, weight=0.4
        ),
    ),
)
