"""Lamps that stand on the floor, on a table, or hang from the ceiling.

A shade is open above and below and leaves its bulb in sight; globes and ceiling discs are the
emitting part themselves. So light leaves every lamp without any translucent material.
"""

from typing import Final

import numpy as np

from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, lathe, sphere
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.library.furniture.joinery import (
    Parts,
    Size,
    Style,
    numbered,
    round_leg,
    splayed,
)


def _bulb(radius: float = 0.032) -> Mesh:
    """A pear-shaped bulb with its cap in the origin, about three times as tall as its radius."""
    t = np.linspace(-0.32 * np.pi, 0.5 * np.pi, 12)
    ball = np.stack([radius * np.cos(t), radius * (1.85 + np.sin(t))], axis=1)
    ball[-1, 0] = 0.0
    return lathe([(0.0, 0.0), (0.42 * radius, 0.0), (0.45 * radius, 0.3 * radius), *ball],
                 segments=24, crease=60.0)  # fmt: skip


def _shade(bottom: float, top: float, low: float, high: float) -> Mesh:
    """A thin open cone or drum."""
    t = 0.0018
    return lathe([(bottom, low), (top, high), (top - t, high), (bottom - t, low)], segments=48)


def _carrier(radius: float, z: float) -> Mesh:
    """Three rods from a shade's rim to the pole."""
    angles = np.radians([90.0, 210.0, 330.0])
    rods = [
        tube([(0.0, 0.0, z), (radius * np.cos(a), radius * np.sin(a), z)], 0.0018, segments=6)
        for a in angles
    ]
    return joined(rods)


def _holder(z: float, radius: float = 0.017) -> Mesh:
    return cylinder(radius, 0.045, bevel=0.003, segments=20, base=(0.0, 0.0, z))


def _radius(size: Size) -> float:
    return 0.5 * min(size[0], size[1])


def _foot(radius: float) -> Mesh:
    return cylinder(radius, 0.018, bevel=0.004, segments=48)


def floor_drum(size: Size, rng: np.random.Generator) -> Parts:
    """A pole on a disc, with a drum or slightly conical shade."""
    radius, height = _radius(size), size[2]
    tall = min(float(rng.uniform(0.22, 0.3)), 0.3 * height)
    top = radius * float(rng.uniform(0.72, 1.0))
    socket = height - 0.78 * tall
    return {
        "base": _foot(min(0.15, 0.75 * radius)),
        "lamp_pole": cylinder(0.0105, socket - 0.015, segments=20, base=(0.0, 0.0, 0.015)),
        "frame": joined([_holder(socket - 0.01), _carrier(radius * 0.5 + 0.5 * top - 0.003,
                                                          height - 0.5 * tall - 0.03)]),
        "lamp_shade": _shade(radius, top, height - tall, height),
        "light_bulb": _bulb().moved((0.0, 0.0, socket + 0.03)),
    }  # fmt: skip


def floor_tripod(size: Size, rng: np.random.Generator) -> Parts:
    """Three wooden legs that meet below a drum shade."""
    radius, height = _radius(size), size[2]
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
        "frame": joined([
            cylinder(0.045, 0.022, bevel=0.004, segments=28, base=(0.0, 0.0, hub - 0.012)),
            _holder(socket - 0.01),
            _carrier(0.5 * (radius + top) - 0.003, height - 0.5 * tall - 0.03),
        ]),
        "lamp_shade": _shade(radius, top, height - tall, height),
        "light_bulb": _bulb().moved((0.0, 0.0, socket + 0.03)),
    }  # fmt: skip


def floor_globe(size: Size, rng: np.random.Generator) -> Parts:
    """An opal globe on a slim pole."""
    radius, height = _radius(size), size[2]
    ball = min(radius, float(rng.uniform(0.13, 0.17)))
    middle = height - ball
    return {
        "base": _foot(radius),
        "lamp_pole": cylinder(0.011, middle - ball, segments=20, base=(0.0, 0.0, 0.014)),
        "frame": lathe([(0.0, middle - ball - 0.03), (0.02, middle - ball - 0.03),
                        (0.36 * ball, middle - 0.93 * ball), (0.0, middle - 0.9 * ball)],
                       segments=28),
        "light_bulb": sphere(ball, segments=36, center=(0.0, 0.0, middle)),
    }  # fmt: skip


def floor_uplight(size: Size, rng: np.random.Generator) -> Parts:
    """A torchiere: a bowl that throws its light to the ceiling."""
    radius, height = _radius(size), size[2]
    deep = min(0.5 * radius, 0.12) * float(rng.uniform(0.8, 1.2))
    t = np.linspace(0.0, 1.0, 12)
    outer = np.stack([radius * np.sin(0.5 * np.pi * t), height - deep * np.cos(0.5 * np.pi * t)], 1)
    inner = (outer - [0.0, height]) * [1.0 - 0.004 / radius, 1.0 - 0.004 / deep] + [0.0, height]
    rim = inner[::-1].copy()
    outer[0, 0] = rim[-1, 0] = 0.0
    bottom = height - deep
    return {
        "base": _foot(min(0.14, radius)),
        "lamp_pole": cylinder(0.0115, bottom - 0.012, segments=20, base=(0.0, 0.0, 0.014)),
        "lamp_shade": lathe(np.concatenate([outer, rim]), segments=48),
        "light_bulb": sphere(0.55 * radius, segments=32, squash=0.32 * deep / (0.55 * radius),
                             center=(0.0, 0.0, height - 0.5 * deep)),
    }  # fmt: skip


def table_urn(size: Size, rng: np.random.Generator) -> Parts:
    """A turned ceramic body under a conical shade."""
    radius, height = _radius(size), size[2]
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
        "lamp_pole": cylinder(0.008, socket - neck + 0.02, segments=16,
                              base=(0.0, 0.0, neck - 0.005)),
        "frame": joined([_holder(socket), _carrier(0.89 * radius - 0.004, low + 0.5 * tall)]),
        "lamp_shade": _shade(radius, 0.78 * radius, low, height),
        "light_bulb": _bulb(0.028).moved((0.0, 0.0, socket + 0.04)),
    }  # fmt: skip


def table_stick(size: Size, rng: np.random.Generator) -> Parts:
    """A slim stem on a disc under a drum."""
    radius, height = _radius(size), size[2]
    tall = 0.42 * height
    low = height - tall
    top = radius * float(rng.uniform(0.8, 1.0))
    socket = low + 0.02
    return {
        "base": cylinder(0.62 * radius, 0.02, bevel=0.004, segments=40),
        "lamp_pole": cylinder(0.009, socket - 0.01, segments=18, base=(0.0, 0.0, 0.016)),
        "frame": joined([_holder(socket), _carrier(0.5 * (radius + top) - 0.003,
                                                   low + 0.5 * tall)]),
        "lamp_shade": _shade(radius, top, low, height),
        "light_bulb": _bulb(0.028).moved((0.0, 0.0, socket + 0.04)),
    }  # fmt: skip


def table_globe(size: Size, rng: np.random.Generator) -> Parts:
    """An opal globe on a small turned foot."""
    radius, height = _radius(size), size[2]
    ball = min(radius, 0.42 * height)
    middle = height - ball
    low = middle - 0.9 * ball
    foot = ball * float(rng.uniform(0.5, 0.7))
    return {
        "base": lathe([(0.0, 0.0), (foot, 0.0), (foot, 0.01), (0.3 * foot, 0.4 * low),
                       (0.3 * foot, 0.6 * low), (0.46 * ball, low), (0.0, low + 0.01)],
                      segments=36, crease=50.0),
        "light_bulb": sphere(ball, segments=36, center=(0.0, 0.0, middle)),
    }  # fmt: skip


def _rose(height: float, radius: float = 0.055) -> Mesh:
    """The canopy at the ceiling."""
    return cylinder(radius, 0.028, bevel=0.006, segments=32, base=(0.0, 0.0, height - 0.028))


def _cord(low: float, high: float, radius: float = 0.0035) -> Mesh:
    return cylinder(radius, high - low, segments=10, base=(0.0, 0.0, low))


def ceiling_pendant(size: Size, rng: np.random.Generator) -> Parts:
    """A metal dome on a cord, its round bulb looking out below."""
    radius, height = _radius(size), size[2]
    deep = min(radius * float(rng.uniform(0.6, 0.95)), 0.6 * height)
    t = np.linspace(0.0, 1.0, 14)
    angle = 0.5 * np.pi * t
    outer = np.stack([0.03 + (radius - 0.03) * np.sin(angle), deep * np.cos(angle)], axis=1)
    inner = np.stack([0.028 + (radius - 0.031) * np.sin(angle), (deep - 0.003) * np.cos(angle)], 1)
    inner[-1, 1] = 0.0
    bulb = min(0.06, 0.3 * radius)
    return {
        "base": _rose(height),
        "lamp_pole": _cord(deep - 0.01, height - 0.02),
        "frame": cylinder(0.031, min(0.07, 0.4 * deep), bevel=0.004, segments=24,
                          base=(0.0, 0.0, deep - 0.3 * min(0.07, 0.4 * deep))),
        "lamp_shade": lathe(np.concatenate([outer, inner[::-1]]), segments=48),
        "light_bulb": sphere(bulb, segments=28, center=(0.0, 0.0, 0.1 * deep + bulb)),
    }  # fmt: skip


def ceiling_flush(size: Size, rng: np.random.Generator) -> Parts:
    """A glowing opal disc in a ring, close to the ceiling."""
    width, depth, height = size
    radius = 0.5 * min(width, depth)
    t = np.linspace(0.0, 1.0, 12)
    plate = min(0.3 * height, 0.03)
    deep = height - plate
    ring = radius * float(rng.uniform(0.93, 0.97))
    opal = np.stack([ring * np.sin(0.5 * np.pi * t), deep * (1.0 - np.cos(0.5 * np.pi * t) ** 0.8)],
                    axis=1)  # fmt: skip
    opal[0] = 0.0
    return {
        "base": lathe([(0.0, deep), (ring - 0.002, deep), (ring - 0.002, deep - 0.012),
                       (radius, deep - 0.012), (radius, height), (0.0, height)], segments=56),
        "light_bulb": lathe([*opal, (0.0, deep)], segments=56),
    }  # fmt: skip


def ceiling_drum(size: Size, rng: np.random.Generator) -> Parts:
    """A fabric drum on a short stem, open below, with an opal globe inside."""
    radius, height = _radius(size), size[2]
    tall = min(float(rng.uniform(0.18, 0.24)), 0.7 * height)
    globe = min(0.5 * radius, 0.5 * tall)
    return {
        "base": _rose(height),
        "lamp_pole": _cord(tall * 0.55, height - 0.02, 0.007),
        "frame": joined([_holder(0.62 * tall, 0.02), _carrier(radius - 0.003, 0.75 * tall)]),
        "lamp_shade": _shade(radius, radius, 0.0, tall),
        "light_bulb": sphere(globe, segments=32, center=(0.0, 0.0, 0.16 * tall + globe)),
    }  # fmt: skip


def ceiling_globe(size: Size, rng: np.random.Generator) -> Parts:
    """An opal globe on a rod."""
    radius, height = _radius(size), size[2]
    ball = min(radius, 0.46 * height)
    top = 2.0 * ball
    return {
        "base": _rose(height),
        "lamp_pole": _cord(top - 0.01, height - 0.02, 0.006),
        "frame": cylinder(0.3 * ball, 0.03, bevel=0.004, segments=28,
                          base=(0.0, 0.0, top - 0.024)),
        "light_bulb": sphere(ball, segments=36, center=(0.0, 0.0, ball)),
    }  # fmt: skip


def _hanging(size: Size) -> bool:
    return size[2] > 0.22


FLOOR_STYLES: Final = {
    "drum": Style(floor_drum),
    "tripod": Style(floor_tripod, size=(0.46, 0.46, 1.5)),
    "globe": Style(floor_globe, size=(0.3, 0.3, 1.5)),
    "uplight": Style(floor_uplight, lambda size: size[2] > 1.4, (0.34, 0.34, 1.8)),
}
TABLE_STYLES: Final = {
    "urn": Style(table_urn),
    "stick": Style(table_stick),
    "globe": Style(table_globe, size=(0.24, 0.24, 0.32)),
}
CEILING_STYLES: Final = {
    "pendant": Style(ceiling_pendant, _hanging),
    "flush": Style(ceiling_flush, lambda size: not _hanging(size), (0.42, 0.42, 0.1)),
    "drum": Style(ceiling_drum, _hanging),
    "globe": Style(ceiling_globe, _hanging, (0.3, 0.3, 0.45)),
}
