"""Hollow ceramic: basins, sinks let into a top, tubs."""

from collections.abc import Sequence

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.joinery.appliance import square
from openrooms_usd.geometry.lofts import loft, ring, superellipse
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import lathe

Rings = list[Array]
SEGMENTS = 64


def inside(
    opening: Array,
    rim: float,
    deep: float,
    *,
    center: Sequence[float] = (0.0, 0.0),
    floor: Sequence[float] = (0.0, 0.0),
    lip: float = 0.004,
    power: float = 3.0,
    least: float = 0.3,
) -> Rings:
    """The rings of a hollow from its rim down to its floor.

    Args:
        opening: (N, 2) outline of the hollow at the rim, metres.
        rim: Height of the rim, metres.
        deep: Metres from the rim to the floor.
        center: Middle of the opening, metres.
        floor: How much further its floor's middle lies, metres.
        lip: Radius of the rim's edge, metres.
        power: Of the profile: 2 is an ellipse, more has steeper walls and a flatter floor.
        least: The share of the opening that the flat middle of the floor has.
    """
    rings = [ring(opening * (1.0 + 2.0 * lip), rim, center)]
    start = np.asarray(center, dtype=np.float64)
    share = np.linspace(0.0, 1.0, 11)
    scale = np.concatenate([(1.0 - share[:-1] ** power) ** (1.0 / power), [0.0]])
    scale = np.maximum(scale, least * (1.0 + 0.5 * np.linspace(1.0, -1.0, 11)))
    for u, s in zip(share, scale, strict=True):
        z = rim - lip - (deep - lip) * float(u)
        rings.append(ring(opening * s, z, start + float(u) * np.asarray(floor)))
    return rings


def bowl(
    width: float,
    depth: float,
    tall: float,
    *,
    power: float = 2.0,
    wall: float = 0.014,
    ledge: float = 0.0,
    foot: float = 0.45,
) -> Mesh:
    """A basin with its rim at ``tall`` and its foot on the origin.

    Args:
        width: Metres.
        depth: Metres.
        tall: Metres.
        power: Of its superelliptic outline.
        wall: Thickness at the rim, metres.
        ledge: What is left behind the hollow for a faucet, metres.
        foot: Its foot's share of the outline.
    """
    outline = superellipse(width, depth, power, SEGMENTS)
    opening = superellipse(width - 2 * wall, depth - 2 * wall - ledge, power, SEGMENTS)
    shift = -0.5 * ledge
    rings = []
    for u in np.linspace(0.0, 1.0, 9):
        # A quarter of an ellipse from the foot to the side.
        s = foot + (1.0 - foot) * float(np.sqrt(1.0 - (1.0 - u) ** 2.2))
        rings.append(ring(outline * s, (tall - 0.01) * float(u), (0.0, shift * 0.5 * (1.0 - u))))
    rings.append(ring(outline, tall - 0.004))
    rings.append(ring(outline * (1.0 - 0.006 / width), tall))
    rings += inside(opening, tall, tall - 0.02, center=(0.0, shift), power=2.6, least=0.18)
    return loft(rings, crease=55.0)


def sunk(
    width: float,
    depth: float,
    thick: float,
    opening: tuple[float, float],
    deep: float,
    *,
    power: float = 4.0,
    center: tuple[float, float] = (0.0, 0.0),
    wall: float = 0.008,
) -> Mesh:
    """A slab with a basin in it that hangs below; its upper side at 0.

    Args:
        width: Of the slab, metres.
        depth: Of the slab, metres.
        thick: Of the slab, metres.
        opening: Width and depth of the basin, metres.
        deep: Of the basin, metres.
        power: Of its superelliptic outline.
        center: Its middle, metres.
        wall: Thickness of its skin, metres.
    """
    slab = square(width, depth, SEGMENTS)
    hole = superellipse(*opening, power, SEGMENTS)
    outer = superellipse(opening[0] + 2 * wall, opening[1] + 2 * wall, power, SEGMENTS)
    rings = inside(hole, 0.0, deep, center=center, power=4.0, least=0.35)
    hull = [
        ring(outer * 0.62, -deep - wall, center),
        ring(outer * 0.93, -0.82 * deep, center),
        ring(outer, -0.4 * deep - thick, center),
        ring(outer, -thick, center),
        ring(slab, -thick),
        ring(slab, -0.003),
        ring(slab * 0.996, 0.0),
    ]
    return loft([*hull, *rings], crease=45.0)


def drain(radius: float = 0.022) -> Mesh:
    """A plug in its ring, on the origin."""
    r = radius
    return lathe(
        [
            (0.0, 0.0),
            (r, 0.0),
            (r, 0.003),
            (0.8 * r, 0.004),
            (0.74 * r, 0.001),
            (0.7 * r, 0.001),
            (0.6 * r, 0.006),
            (0.0, 0.008),
        ],
        segments=24,
    )
