"""Lamps that stand on a table."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import LAMP_ROWS, STEEL, row, walls
from openrooms_usd.furniture.joinery.lamp_parts import bulb, carrier, holder, radius_of, shade
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import LAMPS, SOCKETED
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.solids import cylinder, lathe, sphere
from openrooms_usd.geometry.sweeps import tube


def table_urn(size: Size, rng: np.random.Generator) -> Parts:
    """A turned ceramic body under a conical shade."""
    radius, height = radius_of(size), size[2]
    tall = 0.41 * height
    low = height - tall
    belly = radius * float(rng.uniform(0.5, 0.62))
    neck = low + 0.03
    place = float(rng.uniform(0.38, 0.6))
    t = np.linspace(0.0, 1.0, 24)
    swell = np.sin(np.pi * t ** (np.log(0.5) / np.log(place))) ** 1.2
    foot, throat = 0.55 * belly, 0.024
    r = foot + (throat - foot) * t**2 + (belly - foot) * swell
    body = np.stack([r, 0.016 + (neck - 0.016) * t], axis=1)
    stand = [(0.0, 0.0), (foot + 0.008, 0.0), (foot + 0.01, 0.004), (foot + 0.008, 0.012)]
    socket = neck + 0.01
    return {
        "base": lathe([*stand, *body, (0.0, neck)], segments=40, crease=50.0),
        "lamp_pole": cylinder(
            0.008, socket - neck + 0.02, segments=16, base=(0.0, 0.0, neck - 0.005)
        ),
        "frame": joined([holder(socket), carrier(0.89 * radius - 0.004, low + 0.5 * tall)]),
        "lamp_shade": shade(radius, 0.78 * radius, low, height),
        "light_bulb": bulb(0.028).moved((0.0, 0.0, socket + 0.04)),
    }


def table_stick(size: Size, rng: np.random.Generator) -> Parts:
    """A slim stem on a disc under a drum."""
    radius, height = radius_of(size), size[2]
    tall = 0.42 * height
    low = height - tall
    top = radius * float(rng.uniform(0.8, 1.0))
    socket = low + 0.02
    return {
        "base": cylinder(0.62 * radius, 0.02, bevel=0.004, segments=40),
        "lamp_pole": cylinder(0.009, socket - 0.01, segments=18, base=(0.0, 0.0, 0.016)),
        "frame": joined([holder(socket), carrier(0.5 * (radius + top) - 0.003, low + 0.5 * tall)]),
        "lamp_shade": shade(radius, top, low, height),
        "light_bulb": bulb(0.028).moved((0.0, 0.0, socket + 0.04)),
    }


def table_globe(size: Size, rng: np.random.Generator) -> Parts:
    """An opal globe on a small turned foot."""
    radius, height = radius_of(size), size[2]
    ball = min(radius, 0.42 * height)
    middle = height - ball
    low = middle - 0.9 * ball
    foot = ball * float(rng.uniform(0.5, 0.7))
    return {
        "base": lathe(
            [
                (0.0, 0.0),
                (foot, 0.0),
                (foot, 0.01),
                (0.3 * foot, 0.4 * low),
                (0.3 * foot, 0.6 * low),
                (0.46 * ball, low),
                (0.0, low + 0.01),
            ],
            segments=36,
            crease=50.0,
        ),
        "light_bulb": sphere(ball, segments=36, center=(0.0, 0.0, middle)),
    }


def task(size: Size, rng: np.random.Generator) -> Parts:
    """A work lamp: a weighted foot, two jointed arms, a conical head that looks down."""
    width, depth, height = size
    foot = min(0.5 * width, 0.3 * depth)
    middle = 0.5 * depth - foot
    tilt = float(rng.uniform(22.0, 34.0))
    mouth = min(0.5 * width, 0.22 * depth)
    long = 1.7 * mouth
    # The head's rim touches the front of the box, its cap the far end of the upper arm.
    c, s = np.cos(np.radians(tilt)), np.sin(np.radians(tilt))
    rim = np.array([0.0, -0.5 * depth + mouth * c, height - 0.62 * height])
    rim[2] = height - 0.03 - long * c - 0.1 * height
    cap = rim + long * np.array([0.0, s, c])
    elbow = np.array([0.0, 0.5 * depth - 0.02, height - 0.02])
    knee = np.array([0.0, middle, 0.045])
    arms = [
        tube([np.add(knee, [x, 0, 0]), np.add(elbow, [x, 0, 0])], 0.005, segments=10)
        for x in (-0.014, 0.014)
    ] + [tube([np.add(elbow, [0, 0, -0.004]), cap], 0.006, segments=10)]
    joints = [
        tube([np.add(point, [-0.024, 0, 0]), np.add(point, [0.024, 0, 0])], 0.012, segments=16)
        for point in (knee, elbow, cap)
    ]
    neck = 0.3 * mouth
    cone = lathe(
        [
            (mouth, 0.0),
            (0.42 * mouth, 0.72 * long),
            (neck, long),
            (neck - 0.002, long),
            (0.42 * mouth - 0.002, 0.72 * long),
            (mouth - 0.002, 0.0),
        ],
        segments=40,
    )
    socket = cylinder(neck, 0.32 * long, bevel=0.003, segments=24, base=(0.0, 0.0, 0.7 * long))
    head = {
        "lamp_shade": cone,
        "socket": socket,
        "light_bulb": sphere(0.3 * mouth, segments=24, center=(0.0, 0.0, 0.4 * mouth)),
    }
    posed = {name: turned(mesh, "x", -tilt).moved(rim) for name, mesh in head.items()}
    return {
        "base": cylinder(foot, 0.022, bevel=0.005, segments=40, base=(0.0, middle, 0.0)),
        "lamp_pole": joined(arms),
        "frame": joined([*joints, cylinder(0.016, 0.04, segments=18, base=(0.0, middle, 0.015))]),
        **posed,
    }


CATEGORY: Final = BuiltCategory(
    description="a lamp that stands on a table",
    size=(0.3, 0.3, 0.48),
    min_size=(0.12, 0.12, 0.2),
    max_size=(0.6, 0.9, 0.9),
    styles={
        "urn": Style(table_urn, lambda size: size[1] < 1.3 * size[0]),
        "stick": Style(table_stick, lambda size: size[1] < 1.3 * size[0]),
        "globe": Style(table_globe, lambda size: size[1] < 1.3 * size[0], (0.24, 0.24, 0.32)),
        "task": Style(task, lambda size: size[1] >= 1.3 * size[0], (0.2, 0.46, 0.5)),
    },
    round=True,
    one_variant_per_room=True,
    support="surface",
    lumen=600.0,
    mass_range=(1, 6),
    words="desk_lamp reading_lamp",
    classes=Classes("lamp", "lamp", "lamp"),
    synsets=("03636649",),
    schemes=(*LAMPS, *SOCKETED),
    construction=(row("base", walls(3, STEEL), "weight", "metal", "paint"), *LAMP_ROWS),
)
