"""What lamps are made of: bulbs, shades, holders, feet, cords.

A shade is open above and below and leaves its bulb in sight; globes and ceiling discs are the
emitting part themselves. So light leaves every lamp without any translucent material.
"""

import numpy as np

from openrooms_usd.furniture.joinery.pieces import Size
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, lathe
from openrooms_usd.geometry.sweeps import tube


def dome(radius: float, deep: float, neck: float = 0.03) -> Mesh:
    """A thin metal bell, open below, its rim in z = 0."""
    angle = 0.5 * np.pi * np.linspace(0.0, 1.0, 14)
    outer = np.stack([neck + (radius - neck) * np.sin(angle), deep * np.cos(angle)], axis=1)
    inner = np.stack(
        [neck - 0.002 + (radius - neck - 0.001) * np.sin(angle), (deep - 0.003) * np.cos(angle)], 1
    )
    inner[-1, 1] = 0.0
    return lathe(np.concatenate([outer, inner[::-1]]), segments=48)


def bulb(radius: float = 0.032) -> Mesh:
    """A pear-shaped bulb with its cap in the origin, about three times as tall as its radius."""
    t = np.linspace(-0.32 * np.pi, 0.5 * np.pi, 12)
    ball = np.stack([radius * np.cos(t), radius * (1.85 + np.sin(t))], axis=1)
    ball[-1, 0] = 0.0
    return lathe(
        [(0.0, 0.0), (0.42 * radius, 0.0), (0.45 * radius, 0.3 * radius), *ball],
        segments=24,
        crease=60.0,
    )


def shade(bottom: float, top: float, low: float, high: float) -> Mesh:
    """A thin open cone or drum."""
    t = 0.0018
    return lathe([(bottom, low), (top, high), (top - t, high), (bottom - t, low)], segments=48)


def carrier(radius: float, z: float) -> Mesh:
    """Three rods from a shade's rim to the pole."""
    angles = np.radians([90.0, 210.0, 330.0])
    rods = [
        tube([(0.0, 0.0, z), (radius * np.cos(a), radius * np.sin(a), z)], 0.0018, segments=6)
        for a in angles
    ]
    return joined(rods)


def holder(z: float, radius: float = 0.017) -> Mesh:
    """What a bulb is screwed into."""
    return cylinder(radius, 0.045, bevel=0.003, segments=20, base=(0.0, 0.0, z))


def radius_of(size: Size) -> float:
    """The greatest round lamp for a box, metres."""
    return 0.5 * min(size[0], size[1])


def foot_disc(radius: float) -> Mesh:
    """A flat round foot."""
    return cylinder(radius, 0.018, bevel=0.004, segments=48)


def rose(height: float, radius: float = 0.055) -> Mesh:
    """The canopy at the ceiling."""
    return cylinder(radius, 0.028, bevel=0.006, base=(0.0, 0.0, height - 0.028))


def cord(low: float, high: float, radius: float = 0.0035) -> Mesh:
    """What a lamp hangs by, between two heights."""
    return cylinder(radius, high - low, segments=10, base=(0.0, 0.0, low))
