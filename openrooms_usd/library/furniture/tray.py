"""Trays to carry things, and coasters below glasses."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import METAL, Scheme
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.lofts import loft, ring, rounded_rectangle, superellipse
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.geometry.uv import metric
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    USUAL,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style, numbered
from openrooms_usd.library.furniture.lying import Lies


def _rimmed(outline: NDArray[np.float64], height: float, wall: float, floor: float) -> Mesh:
    """A flat dish with upright sides over an outline about the origin."""
    half = np.abs(outline).max(axis=0)
    inner = outline * (1.0 - wall / half)
    rows = [(outline * 0.985, 0.0), (outline, 0.003), (outline, height - 0.001),
            (outline * (1.0 - 0.3 * wall / half), height), (inner * 1.002, height - 0.001),
            (inner, floor + 0.001), (inner * 0.99, floor)]  # fmt: skip
    return metric(loft(np.array([ring(flat, z) for flat, z in rows])))[0]


def rectangular(size: Size, rng: np.random.Generator) -> Parts:
    """A rectangular tray with two handles."""
    width, depth, height = size
    rim = 0.62 * height
    base = _rimmed(rounded_rectangle(width, depth, 0.02, 4), rim, 0.009, 0.007)
    grips = []
    for side in (-1.0, 1.0):
        x = side * (0.5 * width - 0.006)
        path = [(x, -0.07, 0.8 * rim), (x, -0.07, height - 0.004), (x, 0.07, height - 0.004),
                (x, 0.07, 0.8 * rim)]  # fmt: skip
        grips.append(tube(filleted(path, 0.015, segments=3), 0.004, segments=8))
    return {"tray": base, **numbered("handle", grips)}


def round_(size: Size, rng: np.random.Generator) -> Parts:
    """A round tray."""
    width, depth, height = size
    return {"tray": _rimmed(superellipse(width, depth, 2.0, 40), height, 0.006, 0.005)}


CATEGORY: Final = BuiltCategory(
    description="a tray",
    size=(0.44, 0.3, 0.055),
    least=(0.12, 0.1, 0.015),
    most=(0.8, 0.6, 0.15),
    styles={
        "rectangular": Style(rectangular, lambda size: size[0] > 1.15 * size[1]),
        "round": Style(round_, lambda size: size[0] < 1.2 * size[1], (0.34, 0.34, 0.03)),
    },
    spread=USUAL,
    round=False,
    alike=False,
    support="surface",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.2, 2.5)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="trays serving_tray",
    classes=Classes(UNLABELED, "otherprop", "tray", UNLABELED),
    synsets=NO_SYNSET,
    schemes=(
        Scheme({ANY: "wood", "handle": METAL}, weight=2.0),
        Scheme({ANY: METAL, "handle": METAL}, weight=0.7),
        Scheme({ANY: "lacquer", "handle": METAL}),
    ),
    makes=(
        makes.row(ANY, makes.solid(1400), "weight", "metal", "paint"),
        makes.row("handle", makes.solid(2000), "common"),
        makes.row(ANY, makes.solid(700), "common"),
    ),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    lies=(
        Lies(on=("coffee_table",), weight=0.5, most=1, pose="flat"),
        Lies(
            on=("worktop", "cabinet_top", "dresser_top"),
            weight=0.25,
            most=1,
            pose="flat",
        ),
        Lies(on=("bed_foot",), clutter=2, weight=0.05, most=1, pose="flat"),
    ),
)
