"""Pans and pots: a frying pan, a saucepan, a stockpot with its lid."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import filled, row, solid
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.sweeps import tube


def _pot(r: float, h: float, flare: float, wall: float = 0.0025) -> Mesh:
    """A pot with a rounded foot, ``flare`` times as wide at its floor as at its rim."""
    low = flare * r
    edge = min(0.012, 0.3 * h)
    outer = filleted(
        [(0.0, 0.0), (low, 0.0), (r - 0.002, h - 0.003), (r, h - 0.001)], edge, segments=3
    )
    inner = filleted(
        [(r - wall, h), (low - wall - 0.001, wall + 0.001), (0.0, wall + 0.001)], edge, segments=3
    )
    return lathe(np.concatenate([outer, [(r - 0.001, h)], inner]), segments=36, crease=50.0)


def _long_handle(start: float, end: float, z: float, rise: float, wide: float) -> Mesh:
    """A flat handle towards -Y that rises, from where the pot ends."""
    t = np.array([0.0, 0.2, 0.55, 0.9, 1.0])
    path = np.stack([np.zeros(5), -start - (end - start) * t, z + rise * t**0.7], axis=1)
    radii = wide * np.array([0.28, 0.3, 0.45, 0.5, 0.36])
    bar = tube(path, radii.tolist(), segments=10)
    flat = np.diag([1.0, 1.0, 0.62, 1.0])
    flat[2, 3] = 0.38 * z
    return bar.transformed(flat)


def _lid(r: float, z: float) -> dict[str, Mesh]:
    """A domed lid that rests on a rim at a height, and its knob."""
    dome = lathe(
        [
            (0.0, z - 0.003),
            (r - 0.005, z - 0.003),
            (r - 0.004, z),
            (r + 0.001, z),
            (r + 0.001, z + 0.002),
            (0.75 * r, z + 0.009),
            (0.3 * r, z + 0.016),
            (0.0, z + 0.017),
        ],
        segments=36,
        crease=50.0,
    )
    knob = lathe(
        [
            (0.0, z + 0.015),
            (0.008, z + 0.015),
            (0.008, z + 0.026),
            (0.018, z + 0.032),
            (0.018, z + 0.038),
            (0.012, z + 0.042),
            (0.0, z + 0.042),
        ],
        segments=18,
    )
    return {"lid": dome, "knob": knob}


def _brackets(r: float, z: float, reach: float) -> list[Mesh]:
    """Two loops to lift a pot by, at its left and at its right."""
    path = [
        (r - 0.003, -0.035, z),
        (r + reach - 0.005, -0.035, z + 0.002),
        (r + reach - 0.005, 0.035, z + 0.002),
        (r - 0.003, 0.035, z),
    ]
    loop = tube(path, 0.0048, bend=0.018, bend_segments=3, segments=8)
    return [loop, turned(loop, "z", 180.0)]


def frying(size: Size, rng: np.random.Generator) -> Parts:
    """A low pan with a long handle."""
    width, depth, height = size
    r = 0.5 * width
    wall_high = min(height, 0.055)
    shift = (0.0, 0.5 * depth - r, 0.0)
    handle = _long_handle(
        0.96 * r,
        depth - r - 0.006,
        0.8 * wall_high,
        ((height - 0.8 * wall_high) / 0.62 - 0.015) / 0.93,
        0.03,
    )
    return {
        "pan": _pot(r, wall_high, float(rng.uniform(0.76, 0.84)), 0.003).moved(shift),
        "handle": handle.moved(shift),
    }


def saucepan(size: Size, rng: np.random.Generator) -> Parts:
    """A small pot with one long handle."""
    width, depth, height = size
    r = 0.5 * width
    shift = (0.0, 0.5 * depth - r, 0.0)
    handle = _long_handle(0.98 * r, depth - r - 0.006, 0.72 * height, 0.16 * height, 0.026)
    return {"pan": _pot(r, height, 0.97).moved(shift), "handle": handle.moved(shift)}


def stockpot(size: Size, rng: np.random.Generator) -> Parts:
    """A tall pot under its lid, with two handles."""
    width, depth, height = size
    r = min(0.5 * depth, 0.5 * width - 0.03)
    z = height - 0.042
    return {
        "pan": _pot(r, z, 0.97),
        **_lid(r, z),
        **numbered("handle", _brackets(r, 0.8 * z, 0.5 * width - r)),
    }


CATEGORY: Final = BuiltCategory(
    description="a pan or a pot to cook in",
    size=(0.28, 0.46, 0.075),
    min_size=(0.1, 0.1, 0.03),
    max_size=(0.6, 0.8, 0.45),
    styles={
        "frying": Style(frying, lambda size: size[2] < 0.3 * size[0]),
        "saucepan": Style(saucepan, lambda size: size[1] > 1.3 * size[0], (0.18, 0.36, 0.1)),
        "stockpot": Style(
            stockpot, lambda size: size[1] < 1.2 * size[0] and size[2] > 0.1, (0.3, 0.24, 0.19)
        ),
    },
    support="surface",
    mass_range=(0.4, 3.5),
    words="frying_pan saucepan pots pans cooking_pot skillet wok cookware",
    schemes=(
        scheme("cookware_steel", black_plastic="handle knob", weight=2.0),
        scheme("cookware_black", black_plastic="handle knob", weight=2.0),
        scheme("cookware_enamel", cookware_enamel="handle", cookware_steel="knob"),
    ),
    construction=(
        row("pan lid", solid(3000), "weight"),
        row("handle knob", filled(1100), "common"),
    ),
    placements=(
        on("hob", cluster="cooking"),
        on("cupboard", "kitchen", pose="flat", weight=0.8, styles="saucepan stockpot"),
        on("worktop sink_edge", "kitchen", clutter=2, weight=0.3, max_groups=1),
        on("shelf", "kitchen", weight=0.4, styles="stockpot"),
    ),
)
