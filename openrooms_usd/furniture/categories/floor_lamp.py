"""Lamps that stand on the floor."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import LAMP_ROWS, filled, row
from openrooms_usd.furniture.joinery.boards import round_leg, splayed
from openrooms_usd.furniture.joinery.lamp_parts import (
    bulb,
    carrier,
    dome,
    foot_disc,
    holder,
    radius_of,
    shade,
)
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import LAMPS, SOCKETED
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.solids import cylinder, lathe, sphere
from openrooms_usd.geometry.sweeps import tube


def floor_drum(size: Size, rng: np.random.Generator) -> Parts:
    """A pole on a disc, with a drum or slightly conical shade."""
    radius, height = radius_of(size), size[2]
    tall = min(float(rng.uniform(0.22, 0.3)), 0.3 * height)
    top = radius * float(rng.uniform(0.72, 1.0))
    socket = height - 0.78 * tall
    return {
        "base": foot_disc(min(0.15, 0.75 * radius)),
        "lamp_pole": cylinder(0.0105, socket - 0.015, segments=20, base=(0.0, 0.0, 0.015)),
        "frame": joined(
            [
                holder(socket - 0.01),
                carrier(radius * 0.5 + 0.5 * top - 0.003, height - 0.5 * tall - 0.03),
            ]
        ),
        "lamp_shade": shade(radius, top, height - tall, height),
        "light_bulb": bulb().moved((0.0, 0.0, socket + 0.03)),
    }


def floor_tripod(size: Size, rng: np.random.Generator) -> Parts:
    """Three wooden legs that meet below a drum shade."""
    radius, height = radius_of(size), size[2]
    tall = min(0.26, 0.3 * height)
    hub = height - tall - 0.06
    top = radius * float(rng.uniform(0.8, 1.0))
    leg = round_leg(0.0125, 0.0105, hub)
    angles = np.radians(np.array([-90.0, 30.0, 150.0]))
    spread = radius * float(rng.uniform(0.88, 0.97)) - 0.012
    around = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    legs = [splayed(leg, spread * a, 0.03 * a) for a in around]
    socket = height - 0.75 * tall
    return {
        **numbered("leg", legs),
        "lamp_pole": cylinder(0.011, socket - hub + 0.03, segments=20, base=(0.0, 0.0, hub - 0.03)),
        "frame": joined(
            [
                cylinder(0.045, 0.022, bevel=0.004, segments=28, base=(0.0, 0.0, hub - 0.012)),
                holder(socket - 0.01),
                carrier(0.5 * (radius + top) - 0.003, height - 0.5 * tall - 0.03),
            ]
        ),
        "lamp_shade": shade(radius, top, height - tall, height),
        "light_bulb": bulb().moved((0.0, 0.0, socket + 0.03)),
    }


def floor_globe(size: Size, rng: np.random.Generator) -> Parts:
    """An opal globe on a slim pole."""
    radius, height = radius_of(size), size[2]
    ball = min(radius, float(rng.uniform(0.13, 0.17)))
    middle = height - ball
    return {
        "base": foot_disc(radius),
        "lamp_pole": cylinder(0.011, middle - ball, segments=20, base=(0.0, 0.0, 0.014)),
        "frame": lathe(
            [
                (0.0, middle - ball - 0.03),
                (0.02, middle - ball - 0.03),
                (0.36 * ball, middle - 0.93 * ball),
                (0.0, middle - 0.9 * ball),
            ],
            segments=28,
        ),
        "light_bulb": sphere(ball, segments=36, center=(0.0, 0.0, middle)),
    }


def floor_uplight(size: Size, rng: np.random.Generator) -> Parts:
    """A torchiere: a bowl that throws its light to the ceiling."""
    radius, height = radius_of(size), size[2]
    deep = min(0.5 * radius, 0.12) * float(rng.uniform(0.8, 1.2))
    t = np.linspace(0.0, 1.0, 12)
    outer = np.stack([radius * np.sin(0.5 * np.pi * t), height - deep * np.cos(0.5 * np.pi * t)], 1)
    inner = (outer - [0.0, height]) * [1.0 - 0.004 / radius, 1.0 - 0.004 / deep] + [0.0, height]
    rim = inner[::-1].copy()
    outer[0, 0] = rim[-1, 0] = 0.0
    bottom = height - deep
    return {
        "base": foot_disc(min(0.14, radius)),
        "lamp_pole": cylinder(0.0115, bottom - 0.012, segments=20, base=(0.0, 0.0, 0.014)),
        "lamp_shade": lathe(np.concatenate([outer, rim]), segments=48),
        "light_bulb": sphere(
            0.55 * radius,
            squash=0.32 * deep / (0.55 * radius),
            center=(0.0, 0.0, height - 0.5 * deep),
        ),
    }


def arc(size: Size, rng: np.random.Generator) -> Parts:
    """A heavy foot at the left, a rod that bows over, a metal bell at its right end."""
    width, depth, height = size
    radius = min(0.5 * depth, 0.22 * width)
    foot = min(0.5 * depth, 0.17)
    left, right = -0.5 * width + foot, 0.5 * width - radius
    deep = float(rng.uniform(0.62, 0.85)) * radius
    rod, drop = 0.011, float(rng.uniform(0.2, 0.32)) * height
    low = height - drop - deep
    corner = [
        (left, 0.0, 0.03),
        (left, 0.0, height - rod),
        (right, 0.0, height - rod),
        (right, 0.0, low + deep - 0.01),
    ]
    path = filleted(corner, 0.45 * (right - left), segments=12)
    ball = min(0.055, 0.3 * radius)
    at = (right, 0.0, low)
    return {
        "base": cylinder(foot, 0.05, bevel=0.006, segments=48, base=(left, 0.0, 0.0)),
        "lamp_pole": tube(path, rod, segments=14),
        "socket": cylinder(
            0.03, 0.06, bevel=0.004, segments=24, base=(right, 0.0, low + deep - 0.025)
        ),
        "lamp_shade": dome(radius, deep).moved(at),
        "light_bulb": sphere(ball, segments=28, center=(right, 0.0, low + 0.15 * deep + ball)),
    }


CATEGORY: Final = BuiltCategory(
    description="a lamp that stands on the floor",
    size=(0.42, 0.42, 1.55),
    min_size=(0.16, 0.16, 0.8),
    max_size=(1.8, 0.9, 2.4),
    styles={
        "drum": Style(floor_drum, lambda size: size[0] < 0.8),
        "tripod": Style(floor_tripod, lambda size: size[0] < 0.8, (0.46, 0.46, 1.5)),
        "globe": Style(floor_globe, lambda size: size[0] < 0.8, (0.3, 0.3, 1.5)),
        "uplight": Style(
            floor_uplight, lambda size: size[2] > 1.4 and size[0] < 0.8, (0.34, 0.34, 1.8)
        ),
        "arc": Style(arc, lambda size: size[0] >= 0.8, (1.3, 0.36, 1.9), mass_range=(12, 35)),
    },
    round=True,
    one_variant_per_room=True,
    lumen=1500.0,
    mass_range=(2.5, 9),
    words="standing_lamp torchiere",
    classes=Classes("lamp", "lamp", "lamp"),
    schemes=(*LAMPS, *SOCKETED),
    construction=(row("base", filled(4000), "weight"), *LAMP_ROWS),
    view_importance=0.2,
)
