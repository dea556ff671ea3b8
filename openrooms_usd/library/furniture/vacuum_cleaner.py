"""Vacuum cleaners on wheels, their tube parked upright behind them."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.solids import cushion, cylinder
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    USUAL,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style, board, numbered
from openrooms_usd.library.furniture.lying import Lies
from openrooms_usd.library.furniture.posing import turned


def canister(size: Size, rng: np.random.Generator) -> Parts:
    """A rounded body with wheels at its sides, a hose, and a tube on its floor head."""
    width, depth, height = size
    x, y = 0.5 * width, 0.5 * depth
    deep = depth - 0.13
    tall = min(0.26, 0.3 * height)
    middle = deep * 0.5 - y
    body = cushion((0.84 * width, deep, tall - 0.03), radius=0.06, crown=(0.01, 0.01, 0.02),
                   center=(0.0, middle, 0.03 + 0.5 * (tall - 0.03)))  # fmt: skip
    wheel = turned(cylinder(0.32 * tall, 0.04, bevel=0.008, segments=28), "y", 90.0)
    wheels = [wheel.moved((s * x - (0.04 if s > 0 else 0.0), middle + 0.22 * deep, 0.32 * tall))
              for s in (-1.0, 1.0)]  # fmt: skip
    caster = cylinder(0.025, 0.05, segments=16, base=(0.0, middle - 0.34 * deep, 0.0))
    # The head stands on the floor behind, the tube on it.
    head = board((-0.48 * width, y - 0.1, 0.0), (0.48 * width, y, 0.055), 0.014)
    pipe = tube([(0.0, y - 0.05, 0.045), (0.0, y - 0.05, height - 0.12)], 0.0165, segments=16)
    grip = [(0.0, y - 0.05, height - 0.13), (0.0, y - 0.05, height - 0.05),
            (0.0, y - 0.12, height - 0.021)]  # fmt: skip
    end = (0.0, y - 0.12, height - 0.021)
    hose = [end, (0.02, y - 0.24, height - 0.06), (0.3 * width, middle - 0.1 * deep, 0.62 * height),
            (0.24 * width, middle - 0.3 * deep, 0.42 * height),
            (0.0, middle - 0.28 * deep, tall - 0.02)]  # fmt: skip
    knob = cylinder(0.032, 0.012, bevel=0.003, segments=20,
                    base=(0.0, middle + 0.2 * deep, tall + 0.008))  # fmt: skip
    strap = tube(filleted([(0.0, middle - 0.14 * deep, tall - 0.01),
                           (0.0, middle - 0.12 * deep, tall + 0.035),
                           (0.0, middle + 0.08 * deep, tall + 0.035),
                           (0.0, middle + 0.1 * deep, tall - 0.01)], 0.02), 0.01,
                 segments=10)  # fmt: skip
    return {
        "body": body, **numbered("wheel", [*wheels, caster]), "base": head, "pipe": pipe,
        "hose": tube(filleted(hose, 0.12, segments=5), 0.0175, segments=14),
        "grip": joined([tube(filleted(grip, 0.05, segments=4), 0.021, segments=14), strap]),
        "button": knob,
    }  # fmt: skip


CATEGORY: Final = BuiltCategory(
    description="a vacuum cleaner",
    size=(0.3, 0.52, 0.98),
    least=(0.2, 0.35, 0.6),
    most=(0.45, 0.75, 1.3),
    styles={"canister": Style(canister)},
    spread=USUAL,
    round=False,
    alike=False,
    support="floor",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (3, 11)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="vacuum hoover vacuum_cleaners floor_cleaner",
    classes=Classes(UNLABELED, "otherprop", UNLABELED, UNLABELED),
    synsets=NO_SYNSET,
    schemes=(
        Scheme({ANY: "black_plastic", "body": "toiletry", "pipe": "chrome", "wheel": "tyre",
                "button": "dark_plastic", "grip": "black_plastic"}),
    ),
    makes=(
        makes.row("pipe", makes.walls(0.8, makes.STEEL), "sheet", "metal"),
        makes.row("hose", makes.walls(1.5, 950), "common"),
        makes.row(ANY, makes.filled(230), "common"),
    ),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    lies=(
        Lies(
            on=("floor_by_wall", "floor_corner"),
            rooms=("hallway", "closet", "laundry_room", "storage", "basement", "apartment"),
            weight=0.8,
            most=1,
        ),
        Lies(
            on=("floor_corner",), rooms=("living_room", "bedroom"), clutter=2, weight=0.15, most=1
        ),
    ),
)  # fmt: skip
