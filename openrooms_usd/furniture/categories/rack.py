"""Open racks: for shoes, for clothes on hangers, for bottles of wine."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import filled, row, walls
from openrooms_usd.furniture.joinery.boards import board, corners
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import METAL, scheme
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.sweeps import tube


def shoe(size: Size, rng: np.random.Generator) -> Parts:
    """Slatted shelves between two ladders."""
    width, depth, height = size
    x, y, t = 0.5 * width, 0.5 * depth, 0.026
    posts = [
        board((a - 0.5 * t, b - 0.5 * t, 0.0), (a + 0.5 * t, b + 0.5 * t, height - 0.002))
        for a, b in corners(x - 0.5 * t, y - 0.5 * t)
    ]
    count = max(2, round(height / 0.24))
    levels = np.linspace(0.1, height - 0.014, count)
    shelves, ties = [], []
    for z in levels.tolist():
        slats = [
            board((t - x, b - 0.022, z), (x - t, b + 0.022, z + 0.014))
            for b in np.linspace(0.03 - y, y - 0.03, max(3, round(depth / 0.075)))
        ]
        shelves.append(joined(slats))
        ties += [
            board((a - 0.5 * t, t - y, z - 0.016), (a + 0.5 * t, y - t, z + 0.014))
            for a in (0.5 * t - x, x - 0.5 * t)
        ]
    return {**numbered("leg", posts), **numbered("shelf", shelves), **numbered("rail", ties)}


def clothes(size: Size, rng: np.random.Generator) -> Parts:
    """A rail on two posts over a low shelf, a few hangers on it."""
    width, depth, height = size
    x, y, r = 0.5 * width, 0.5 * depth, 0.014
    path = [
        (0.03 - x, 0.0, 0.03),
        (0.03 - x, 0.0, height - r),
        (x - 0.03, 0.0, height - r),
        (x - 0.03, 0.0, 0.03),
    ]
    feet = [tube([(s * (x - 0.03), -y, r), (s * (x - 0.03), y, r)], r) for s in (-1.0, 1.0)]
    ends = [
        board((s * x - 0.016 * (s > 0), -0.02, 0.0), (s * x + 0.016 * (s < 0), 0.02, 0.03))
        for s in (-1.0, 1.0)
    ]
    shelf = board((0.035 - x, 0.04 - y, 0.2), (x - 0.035, y - 0.04, 0.218))
    across = [
        tube([(s * (x - 0.04), 0.05 - y, 0.19), (s * (x - 0.04), y - 0.05, 0.19)], 0.01, segments=8)
        for s in (-1.0, 1.0)
    ]
    return {
        "tube": tube(path, r, bend=0.06, bend_segments=6, segments=14),
        **numbered("foot", feet + ends),
        **numbered("rail", across),
        "shelf": shelf,
    }


def wine(size: Size, rng: np.random.Generator) -> Parts:
    """Lattice rows that bottles lie in, their necks to the front."""
    width, depth, height = size
    x, y, t = 0.5 * width, 0.5 * depth, 0.02
    posts = [
        board((a - 0.5 * t, b - 0.5 * t, 0.0), (a + 0.5 * t, b + 0.5 * t, height))
        for a, b in corners(x - 0.5 * t, y - 0.5 * t)
    ]
    tiers, pitch = max(2, int((height - 0.06) / 0.125)), 0.115
    count = max(1, int((width - 2 * t) / pitch))
    pitch = (width - 2 * t) / count
    profile = [
        (0.0, 0.0),
        (0.037, 0.0),
        (0.038, 0.01),
        (0.038, 0.17),
        (0.03, 0.19),
        (0.0145, 0.21),
        (0.0145, 0.265),
        (0.0, 0.27),
    ]
    bottle = turned(lathe(profile, segments=20), "x", 90.0)
    rails, bottles = [], []
    for i in range(tiers):
        z = 0.05 + i * (height - 0.1) / max(tiers - 0.3, 1.0)
        rails += [
            board((-x, b - 0.5 * t, z), (x, b + 0.5 * t, z + 0.022))
            for b in (0.5 * t - y, y - 0.5 * t)
        ]
        for j in range(count):
            if rng.uniform() < 0.65:
                a = t - x + (j + 0.5) * pitch
                bottles.append(bottle.moved((a, 0.134, z + 0.022 + 0.038)))
    made = {**numbered("leg", posts), **numbered("rail", rails)}
    return {**made, **numbered("bottle", bottles[:1] and [joined(bottles)])}


CATEGORY: Final = BuiltCategory(
    description="an open rack for shoes, clothes or wine",
    size=(0.75, 0.3, 0.55),
    min_size=(0.25, 0.2, 0.25),
    max_size=(2.0, 0.8, 2.0),
    styles={
        "shoe": Style(shoe, lambda size: size[2] < 1.1),
        "clothes": Style(clothes, lambda size: size[2] > 1.1, (1.1, 0.45, 1.6)),
        "wine": Style(wine, lambda size: size[2] < 1.2 and size[0] < 0.9, (0.5, 0.28, 0.8)),
    },
    mass_range=(2, 22),
    words="shoe_rack clothes_rack garment_rack wine_rack clothing_rack drying_rack luggage_rack",
    classes=Classes("bookshelf", "shelves", "shelf"),
    schemes=(
        scheme("wood", bottle_glass="bottle", weight=2.0),
        scheme(METAL, wood="shelf", bottle_glass="bottle", needs="tube", weight=5.0),
        scheme("white", bottle_glass="bottle"),
    ),
    construction=(
        row("bottle", filled(1200), "common"),
        row("tube foot", walls(1.2), "sheet", "metal"),
        row("leg rail shelf tube foot", filled(600), "common"),
    ),
    offers_surfaces=("low_shelf", "clothes_rail"),
)
