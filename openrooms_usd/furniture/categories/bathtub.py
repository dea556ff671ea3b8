"""Bathtubs: built in behind aprons, free-standing, a slipper on claw feet."""

from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.construction import ANY, row, walls
from openrooms_usd.furniture.joinery.appliance import square
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.basin import SEGMENTS, drain, inside
from openrooms_usd.furniture.joinery.boards import corners
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import loft, ring, superellipse
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import lathe

# The drain lies at this share of the length from the middle, towards the right end.
OUTLET: Final = 0.26


def _plumbing(made: Assembly, size: Size, floor: float, x: float, wall: float) -> None:
    """A drain in the floor and an overflow in the right wall."""
    made.add("drain", drain(0.03).moved((x, 0.0, floor - 0.001)))
    sideways = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    plate = lathe(
        [(0.0, 0.0), (0.035, 0.0), (0.033, 0.006), (0.01, 0.01), (0.0, 0.01)], segments=28
    ).transformed(sideways)
    made.add("drain", plate.moved((wall, 0.0, size[2] - 0.12)))


def built_in(size: Size, rng: np.random.Generator) -> Furniture:
    """A hollow in a straight-sided block with a broad rim."""
    width, depth, height = size
    made = Assembly()
    block = square(width, depth, SEGMENTS)
    power = float(rng.choice([2.6, 4.0, 7.0]))
    opening = superellipse(width - 0.16, depth - 0.14, power, SEGMENTS)
    deep = min(0.44, height - 0.08)
    rings = [
        ring(block * 0.985, 0.0),
        ring(block * 0.985, height - 0.04),
        ring(block, height - 0.035),
        ring(block, height - 0.008),
        ring(block * 0.997, height - 0.001),
        ring(block * 0.992, height),
    ]
    hollow = inside(
        opening, height, deep, floor=(0.06 * width, 0.0), lip=0.012, power=4.5, least=0.55
    )
    made.add("container", loft(rings + hollow, crease=45.0))
    _plumbing(made, size, height - deep, OUTLET * width, 0.5 * (width - 0.16) - 0.012)
    return made.furniture()


def _shell(size: Size, low: float, rise: float, foot: float, roll: float) -> Mesh:
    """A tub of an even skin.

    Args:
        size: Metres.
        low: Z of its lower side, metres.
        rise: How much higher its left end is than its right one, metres.
        foot: Its floor's share of its outline.
        roll: How far its rim rolls outwards, metres.
    """
    width, depth, height = size
    wall, rim = 0.022, height - rise
    outer = superellipse(width, depth, 2.5, SEGMENTS)
    body = superellipse(width - 2 * roll, depth - 2 * roll, 2.5, SEGMENTS)
    opening = superellipse(width - 2 * (roll + wall), depth - 2 * (roll + wall), 2.5, SEGMENTS)
    under = rim - 0.03
    skin = []
    for u in np.linspace(0.0, 1.0, 10):
        share = foot + (1.0 - foot) * float(np.sqrt(1.0 - (1.0 - u) ** 2.4))
        skin.append(ring(body * share, low + (under - low) * float(u)))
    skin += [
        ring(outer, under + 0.004),
        ring(outer, rim - 0.01),
        ring(outer * 0.995, rim - 0.002),
        ring(0.5 * (outer + body), rim),
    ]
    deep = rim - low - 0.03
    skin += inside(opening, rim, deep, lip=0.012, power=2.8, least=0.5)
    return loft([_lifted(flat, low, rim, rise, width) for flat in skin], crease=50.0)


def _lifted(flat: Array, low: float, rim: float, rise: float, width: float) -> Array:
    """Raise the left end, the more the higher a ring lies; the floor stays flat."""
    left = np.clip(-2.0 * flat[:, 0] / width, 0.0, 1.0) ** 2
    height = np.clip((flat[:, 2] - low - 0.05) / (rim - low - 0.05), 0.0, 1.0)
    lifted = flat.copy()
    lifted[:, 2] += rise * height * left
    return lifted


def freestanding(size: Size, rng: np.random.Generator) -> Furniture:
    """An oval shell that stands on the floor; one end often higher."""
    made, height = Assembly(), size[2]
    rise = min(0.12, 0.2 * height) if rng.uniform() < 0.5 else 0.0
    made.add("container", _shell(size, 0.0, rise, 0.68, 0.006))
    _plumbing(made, (size[0], size[1], height - rise), 0.03, OUTLET * size[0], 0.43 * size[0])
    return made.furniture()


def clawfoot(size: Size, rng: np.random.Generator) -> Furniture:
    """A shell with a rolled rim on four feet."""
    width, depth, height = size
    made, low = Assembly(), min(0.13, 0.25 * height)
    rise = min(0.14, 0.22 * height)
    made.add("container", _shell(size, low, rise, 0.6, 0.035))
    _plumbing(made, (width, depth, height - rise), low + 0.03, OUTLET * width, 0.4 * width)
    claw = lathe(
        [
            (0.0, 0.0),
            (0.026, 0.0),
            (0.034, 0.016),
            (0.022, 0.04),
            (0.016, 0.06),
            (0.03, 0.1),
            (0.05, 0.16),
            (0.0, 0.17),
        ],
        segments=20,
        crease=60.0,
    )
    for x, y in corners(0.3 * width, 0.28 * depth):
        foot = claw.transformed(np.diag([1.0, 1.0, (low + 0.06) / 0.17]))
        made.add("leg", foot.moved((x, y, 0.0)))
    return made.furniture()


CATEGORY: Final = BuiltCategory(
    description="a bathtub",
    size=(1.7, 0.75, 0.58),
    min_size=(0.9, 0.5, 0.35),
    max_size=(2.3, 1.3, 0.9),
    styles={
        "built_in": Style(built_in),
        "freestanding": Style(freestanding, lambda size: size[0] > 1.3, (1.7, 0.8, 0.64)),
        "clawfoot": Style(
            clawfoot, lambda size: size[0] > 1.3 and size[2] > 0.5, (1.68, 0.78, 0.74)
        ),
    },
    fixed=True,
    mass_range=(20, 60),
    words="tub bath bathing_tub bath_tub jacuzzi",
    classes=Classes("bathtub", "bathtub", "bathtub"),
    synsets=("02808440",),
    schemes=(scheme("sanitary", metal="leg"),),
    construction=(row(f"container {ANY}", walls(5, 1200), "common", "specular_stone"),),
    offers_surfaces=("bath_rim",),
    view_importance=2.5,
)
