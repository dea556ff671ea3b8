"""Ironing boards on crossed legs."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, STEEL, filled, row, walls
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.sweeps import extrude, tube


def crossed(size: Size, rng: np.random.Generator) -> Parts:
    """A padded board with a round nose at its left end, legs of bent tube."""
    width, depth, height = size
    x, y, r = 0.5 * width, 0.5 * depth, 0.011
    t = np.linspace(0.0, np.pi, 13)
    # The nose is a long half ellipse.
    nose = np.column_stack([-x + 0.36 * width * (1.0 - np.sin(t)), -y * np.cos(t)])
    outline = np.concatenate([nose[::-1], [(x, -y), (x, y)]])
    under = height - 0.03
    pad = extrude(outline, 0.024, bevel=0.008, base=height - 0.024)
    tray = extrude(outline * 0.94, 0.006, base=under)
    legs = []
    for s, w in ((1.0, 0.36), (-1.0, 0.3)):
        a, b = s * 0.33 * width, -s * 0.26 * width
        path = [
            (b, -w * depth, under),
            (a, -w * depth, r),
            (a, w * depth, r),
            (b, w * depth, under),
        ]
        legs.append(tube(path, r, segments=10))
        legs.append(tube([(a, -0.5 * depth, r), (a, 0.5 * depth, r)], r, segments=10))
    return {"cushion": pad, "frame": tray, **numbered("leg", legs)}


CATEGORY: Final = BuiltCategory(
    description="an ironing board",
    size=(1.28, 0.38, 0.9),
    min_size=(0.8, 0.25, 0.6),
    max_size=(1.6, 0.55, 1.1),
    styles={"crossed": Style(crossed)},
    mass_range=(3, 11),
    words="ironing_table iron_board",
    classes=Classes(nyu40="otherfurniture"),
    schemes=(
        scheme("white", throw="cushion", aluminium="leg"),
        scheme("grey", linen="cushion", grey="leg"),
    ),
    construction=(
        row("cushion", filled(90), "foam"),
        row("frame", walls(0.4, STEEL), "sheet"),
        row(ANY, walls(1.2, STEEL), "sheet"),
    ),
    offers_surfaces=("worktop",),
)
