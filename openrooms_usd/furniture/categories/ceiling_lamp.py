"""Lamps at the ceiling."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import LAMP_ROWS
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.lamp_parts import (
    bulb,
    carrier,
    cord,
    dome,
    holder,
    radius_of,
    rose,
    shade,
)
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import hoop, turned
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import LAMPS, SOCKETED, scheme
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, lathe, sphere
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.geometry.vectors import points_at


def ceiling_pendant(size: Size, rng: np.random.Generator) -> Parts:
    """A metal dome on a cord, its round bulb looking out below."""
    radius, height = radius_of(size), size[2]
    deep = min(radius * float(rng.uniform(0.6, 0.95)), 0.6 * height)
    ball = min(0.06, 0.3 * radius)
    return {
        "base": rose(height),
        "lamp_pole": cord(deep - 0.01, height - 0.02),
        "socket": cylinder(
            0.031,
            min(0.07, 0.4 * deep),
            bevel=0.004,
            segments=24,
            base=(0.0, 0.0, deep - 0.3 * min(0.07, 0.4 * deep)),
        ),
        "lamp_shade": dome(radius, deep),
        "light_bulb": sphere(ball, segments=28, center=(0.0, 0.0, 0.1 * deep + ball)),
    }


def ceiling_flush(size: Size, rng: np.random.Generator) -> Parts:
    """A glowing opal disc in a ring, close to the ceiling."""
    width, depth, height = size
    radius = 0.5 * min(width, depth)
    t = np.linspace(0.0, 1.0, 12)
    plate = min(0.3 * height, 0.03)
    deep = height - plate
    ring = radius * float(rng.uniform(0.93, 0.97))
    opal = points_at(ring * np.sin(0.5 * np.pi * t), deep * (1.0 - np.cos(0.5 * np.pi * t) ** 0.8))
    opal[0] = 0.0
    return {
        "base": lathe(
            [
                (0.0, deep),
                (ring - 0.002, deep),
                (ring - 0.002, deep - 0.012),
                (radius, deep - 0.012),
                (radius, height),
                (0.0, height),
            ],
            segments=56,
        ),
        "light_bulb": lathe([*opal, (0.0, deep)], segments=56),
    }


def ceiling_drum(size: Size, rng: np.random.Generator) -> Parts:
    """A fabric drum on a short stem, open below, with an opal globe inside."""
    radius, height = radius_of(size), size[2]
    tall = min(float(rng.uniform(0.18, 0.24)), 0.7 * height)
    globe = min(0.5 * radius, 0.5 * tall)
    return {
        "base": rose(height),
        "lamp_pole": cord(tall * 0.55, height - 0.02, 0.007),
        "frame": joined([holder(0.62 * tall, 0.02), carrier(radius - 0.003, 0.75 * tall)]),
        "lamp_shade": shade(radius, radius, 0.0, tall),
        "light_bulb": sphere(globe, center=(0.0, 0.0, 0.16 * tall + globe)),
    }


def ceiling_globe(size: Size, rng: np.random.Generator) -> Parts:
    """An opal globe on a rod."""
    radius, height = radius_of(size), size[2]
    ball = min(radius, 0.46 * height)
    top = 2.0 * ball
    return {
        "base": rose(height),
        "lamp_pole": cord(top - 0.01, height - 0.02, 0.006),
        "frame": cylinder(0.3 * ball, 0.03, bevel=0.004, segments=28, base=(0.0, 0.0, top - 0.024)),
        "light_bulb": sphere(ball, segments=36, center=(0.0, 0.0, ball)),
    }


def _hanging(size: Size) -> bool:
    return size[2] > 0.22


def chandelier(size: Size, rng: np.random.Generator) -> Parts:
    """A hoop on arms that curve out of a turned column, and candle bulbs in cups on it."""
    radius, height = radius_of(size), size[2]
    count = int(rng.integers(5, 8))
    cup = min(0.12 * radius, 0.045)
    reach, hub = radius - max(cup, 0.012), min(0.16, 0.4 * height)
    # Bulbs end below the rose, or beside the chain where the lamp hangs long.
    top = min(0.62 * height, hub + 0.16)
    arm = filleted(
        [
            (0.02, 0.0, 0.6 * hub),
            (0.45 * reach, 0.0, 0.012),
            (reach, 0.0, 0.012),
            (reach, 0.0, 0.42 * top),
        ],
        0.4 * hub,
        segments=6,
    )
    parts: dict[str, list[Mesh]] = {"frame": [], "holder": [], "light_bulb": []}
    for i in range(count):
        heading = 360.0 * i / count
        plate = lathe(
            [(0.0, 0.0), (0.5 * cup, 0.0), (cup, 0.012), (0.95 * cup, 0.015), (0.0, 0.006)],
            segments=20,
        )
        stick = cylinder(0.011, 0.5 * (top - 0.42 * top), segments=14)
        place = (reach, 0.0, 0.42 * top)
        parts["frame"] += [
            turned(m, "z", heading) for m in (tube(arm, 0.006, segments=8), plate.moved(place))
        ]
        parts["holder"].append(turned(stick.moved(place), "z", heading))
        size_ = 0.25 * (top - 0.42 * top) / 1.45
        lit = bulb(min(0.024, size_)).moved((reach, 0.0, 0.42 * top + 0.48 * (top - 0.42 * top)))
        parts["light_bulb"].append(turned(lit, "z", heading))
    body = [
        (0.0, 0.0),
        (0.014, 0.004),
        (0.03, 0.02),
        (0.016, 0.35 * hub),
        (0.042, 0.6 * hub),
        (0.03, 0.8 * hub),
        (0.012, hub),
        (0.0, hub),
    ]
    parts["frame"].append(hoop(radius - 0.006, 0.42 * top - 0.004, 0.006, 48))
    return {
        "base": rose(height),
        "lamp_pole": cord(hub - 0.01, height - 0.02, 0.006),
        "frame": joined([*parts["frame"], lathe(body, segments=24, crease=60.0)]),
        "candle": joined(parts["holder"]),
        "light_bulb": joined(parts["light_bulb"]),
    }


def cluster(size: Size, rng: np.random.Generator) -> Parts:
    """Three opal globes that hang from one rose at different heights."""
    radius, height = radius_of(size), size[2]
    ball = min(0.42 * radius, 0.2 * height)
    angle = float(rng.uniform(0.0, 2.0 * np.pi)) + np.radians([0.0, 120.0, 240.0])
    around = points_at(np.cos(angle), np.sin(angle))
    # The globes touch all four sides of the box.
    low, high = around.min(axis=0), around.max(axis=0)
    centers = (radius - ball) * (2.0 * (around - low) / (high - low) - 1.0)
    cords, caps, globes = [], [], []
    for (x, y), level in zip(centers.tolist(), (0.0, 0.24, 0.46), strict=True):
        z = level * height + ball
        root = (float(np.clip(0.35 * x, -0.03, 0.03)), float(np.clip(0.35 * y, -0.03, 0.03)))
        knot = [(*root, height - 0.02), (0.9 * x, 0.9 * y, height - 0.045), (x, y, z + ball)]
        cords.append(tube(knot, 0.0028, bend=0.03, segments=8))
        caps.append(
            cylinder(0.3 * ball, 0.035, bevel=0.004, segments=20, base=(x, y, z + 0.93 * ball))
        )
        globes.append(sphere(ball, segments=28, center=(x, y, z)))
    fitted_radius = min(0.7 * radius, 0.12)
    return {
        "base": rose(height, fitted_radius),
        "lamp_pole": joined(cords),
        "frame": joined(caps),
        "light_bulb": joined(globes),
    }


def spots(size: Size, rng: np.random.Generator) -> Parts:
    """A rail with three or more heads that can be turned."""
    width, depth, height = size
    rail = 0.035
    count = max(3, round(width / 0.32))
    radius = min(0.3 * depth, 0.3 * width / count)
    long = min(2.0 * radius, 0.6 * (height - rail))
    heads: dict[str, list[Mesh]] = {"lamp_shade": [], "socket": [], "light_bulb": []}
    for i in range(count):
        x = width * ((i + 0.5) / count - 0.5)
        tilt, swing = float(rng.uniform(6.0, 18.0)), float(rng.choice([0.0, 180.0]))
        can = lathe(
            [
                (radius, 0.0),
                (radius, 0.75 * long),
                (0.5 * radius, long),
                (0.0, long),
                (0.0, 0.7 * long),
                (radius - 0.003, 0.7 * long),
                (radius - 0.003, 0.0),
            ]
        )
        lens = lathe(
            [
                (0.0, 0.02 * long),
                (0.8 * radius, 0.05 * long),
                (radius - 0.004, 0.16 * long),
                (0.0, 0.16 * long),
            ]
        )
        pivot = (0.0, 0.0, 0.8 * long)
        low = float(turned(can, "x", tilt, pivot).extent[0, 2])
        for name, mesh in (("lamp_shade", can), ("light_bulb", lens)):
            tilted = turned(turned(mesh, "x", tilt, pivot), "z", swing)
            heads[name].append(tilted.moved((x, 0.0, -low)))
        stem = [(x, 0.0, 0.8 * long - low), (x, 0.0, height - rail + 0.01)]
        heads["socket"].append(tube(stem, 0.007, segments=10))
    bar = board((-0.5 * width, -0.018, height - rail), (0.5 * width, 0.018, height), 0.004)
    plate = board((-0.09, -0.5 * depth, height - 0.016), (0.09, 0.5 * depth, height), 0.004)
    return {
        "base": joined([bar, plate]),
        **{name: joined(meshes) for name, meshes in heads.items()},
    }


def _short(size: Size) -> bool:
    return size[0] < 2.0 * size[1]


# Where people live and receive others; water and work want plainer light.
_GRAND: Final = (
    "apartment bedroom dining_room game_room hallway hotel library living_room lobby lounge stairs"
)
CATEGORY: Final = BuiltCategory(
    description="a lamp at the ceiling",
    size=(0.45, 0.45, 0.35),
    min_size=(0.1, 0.1, 0.05),
    max_size=(2.4, 1.6, 2.5),
    styles={
        "pendant": Style(ceiling_pendant, lambda size: _hanging(size) and _short(size)),
        "flush": Style(
            ceiling_flush, lambda size: not _hanging(size) and _short(size), (0.42, 0.42, 0.1)
        ),
        "drum": Style(ceiling_drum, lambda size: _hanging(size) and _short(size)),
        "globe": Style(
            ceiling_globe, lambda size: _hanging(size) and _short(size), (0.3, 0.3, 0.45)
        ),
        "chandelier": Style(
            chandelier,
            lambda size: _hanging(size) and 0.5 < size[0] < 2 * size[1],
            (0.7, 0.7, 0.6),
            weight=0.6,
            rooms=_GRAND,
        ),
        "cluster": Style(cluster, lambda size: size[2] > 0.6 and _short(size), (0.5, 0.5, 0.9)),
        "spots": Style(spots, lambda size: not _short(size), (1.0, 0.14, 0.2)),
    },
    size_variation=(0.25, 0.25, 0.1),
    round=True,
    support="ceiling",
    fixed=True,
    lumen=3000.0,
    mass_range=(0.7, 8),
    words="pendant_lamp chandelier ceiling_light hanging_lamp",
    classes=Classes("lamp", "lamp", "chandelier"),
    schemes=(
        *LAMPS,
        scheme("white", weight=2.0),
        scheme("brass", white="candle", needs="candle", weight=100.0),
        *SOCKETED,
    ),
    construction=LAMP_ROWS,
    view_importance=0.0,
)
