"""Flat things of glass and metal, or with keys, that lie: phones, tablets, remote controls."""

import numpy as np

from openrooms_usd.furniture.joinery.pieces import Parts, Size
from openrooms_usd.geometry.lofts import rounded_rectangle
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.solids import box, cylinder
from openrooms_usd.geometry.sweeps import extrude


def slab(
    size: Size, rng: np.random.Generator, *, corner: float, rim: float, camera: bool = False
) -> Parts:
    """A slab with a screen on its upper side, ``rim`` metres from its edge.

    Args:
        size: Width, depth and thickness, metres.
        rng: Of any builder; here it draws nothing.
        corner: Radius of its corners, metres.
        rim: How much of its edge the screen leaves, metres.
        camera: Whether it lies on its screen and shows its cameras instead.
    """
    width, depth, height = size
    proud = 0.0012 if camera else 0.0002
    body = extrude(rounded_rectangle(width, depth, corner, 5), height - proud, bevel=0.0012)
    z = height - proud
    if not camera:
        inner = rounded_rectangle(width - 2 * rim, depth - 2 * rim, max(corner - rim, 0.001))
        return {"body": body, "screen": extrude(inner, proud + 0.0005, base=z - 0.0005)}
    at = (-0.5 * width + 0.017, 0.5 * depth - 0.019)
    island = extrude(rounded_rectangle(0.026, 0.03, 0.006) + at, 0.0013, base=z - 0.0007)
    lenses = [
        cylinder(0.0052, 0.0017, segments=16, base=(at[0], at[1] + y, z - 0.0005))
        for y in (-0.0068, 0.0068)
    ]
    return {"body": joined([body, island]), "lens": joined(lenses)}


def keyed(size: Size, rng: np.random.Generator, *, rows: int, ring: bool) -> Parts:
    """A bar with keys on its upper side, its front end towards -Y."""
    width, depth, height = size
    proud = 0.0018
    body = extrude(
        rounded_rectangle(width, depth, 0.3 * width, 5), height - proud, bevel=0.25 * height
    )
    z = height - proud
    pitch = 0.86 * depth / (rows + (3 if ring else 0))
    keys, accents = [], []
    y = 0.45 * depth
    accents.append(
        cylinder(
            0.11 * width,
            proud + 0.0005,
            segments=14,
            base=(-0.28 * width, y - 0.3 * pitch, z - 0.0006),
        )
    )
    y -= pitch
    if ring:
        middle = y - 1.2 * pitch
        keys += [
            cylinder(0.33 * width, 0.6 * proud, segments=24, base=(0, middle, z - 0.0006)),
            cylinder(0.14 * width, proud + 0.0005, segments=16, base=(0, middle, z - 0.0006)),
        ]
        y -= 3.0 * pitch
    for k in range(rows - 1):
        at = y - k * pitch
        for x in (-0.28, 0.0, 0.28):
            wide, deep = 0.2 * width, 0.6 * pitch
            keys.append(box((wide, deep, 0.0024), (x * width, at, height - 0.0012)))
    return {"body": body, "button": joined(keys), "switch": joined(accents)}
