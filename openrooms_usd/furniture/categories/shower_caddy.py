"""Racks for bottles that hang in showers: trays with rails on a frame of wire."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, STEEL, row, walls
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.sweeps import tube


def caddy(size: Size, rng: np.random.Generator) -> Parts:
    """Two trays with rails on a frame of wire, as it hangs in showers."""
    width, depth, height = size
    x, y, r = 0.5 * width, 0.5 * depth, 0.0025
    trays, rails = [], []
    for z in (0.0, 0.55 * height):
        trays.append(board((-x, -y, z), (x, y, z + 0.022), 0.001))
        rim = [
            (r - x, y - r, z + 0.06),
            (r - x, r - y, z + 0.06),
            (x - r, r - y, z + 0.06),
            (x - r, y - r, z + 0.06),
        ]
        rails.append(tube(rim, r, segments=8))
        rails += [
            tube([(a, r - y, z + 0.02), (a, r - y, z + 0.06)], r, segments=6)
            for a in (r - x, 0.0, x - r)
        ]
    frame = [
        tube([(s * (x - 0.03), y - r, 0.0), (s * (x - 0.03), y - r, height)], r, segments=8)
        for s in (-1.0, 1.0)
    ]
    across = tube([(0.03 - x, y - r, height - r), (x - 0.03, y - r, height - r)], r, segments=8)
    return {**numbered("tray", trays), "rail": joined([*rails, *frame, across])}


CATEGORY: Final = BuiltCategory(
    description="a rack of trays in a shower",
    size=(0.24, 0.12, 0.42),
    min_size=(0.12, 0.07, 0.2),
    max_size=(0.5, 0.25, 0.9),
    styles={"caddy": Style(caddy)},
    one_variant_per_room=True,
    support="wall",
    mount_height=1.1,
    mass_range=(0.3, 3),
    words="shower_shelf shower_basket shower_rack",
    classes=Classes(nyu40="shelves", ade20k="shelf"),
    schemes=(scheme("chrome", weight=2.0), scheme("black")),
    construction=(row(ANY, walls(0.8, STEEL), "sheet", "metal"),),
    offers_surfaces=("shelf",),
)
