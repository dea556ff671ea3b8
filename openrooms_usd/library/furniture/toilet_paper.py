"""Toilet paper: a roll, a few of them in their wrapping, a roll on its holder; kitchen paper."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import METAL, Scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, lathe, sphere
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    STANDARD,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style
from openrooms_usd.library.furniture.lying import Lies


def _roll(r: float, h: float, core: float = 0.021) -> dict[str, Mesh]:
    """An upright roll about the origin, and the tube of card in it."""
    paper = lathe([(core, 0.0), (r - 0.002, 0.0), (r, 0.002), (r, h - 0.002), (r - 0.002, h),
                   (core, h)], segments=32, crease=50.0)  # fmt: skip
    card = lathe([(core - 0.0015, 0.0004), (core + 0.0002, 0.0004), (core + 0.0002, h - 0.0004),
                  (core - 0.0015, h - 0.0004)], segments=20)  # fmt: skip
    return {"paper": paper, "core": card}


def roll(size: Size, rng: np.random.Generator) -> Parts:
    """A roll that stands."""
    return dict(_roll(0.5 * min(size[0], size[1]), size[2]))


def kitchen(size: Size, rng: np.random.Generator) -> Parts:
    """A roll of kitchen paper on its upright stand."""
    r, height = 0.5 * min(size[0], size[1]), size[2]
    wide = float(rng.uniform(0.72, 0.86)) * r
    parts = {name: mesh.moved((0.0, 0.0, 0.0125)) for name, mesh in
             _roll(wide, 0.8 * height).items()}  # fmt: skip
    stand = joined([cylinder(r, 0.012, bevel=0.002, segments=36),
                    cylinder(0.006, height - 0.02, segments=14, base=(0.0, 0.0, 0.01)),
                    sphere(0.012, segments=14, center=(0.0, 0.0, height - 0.012))])  # fmt: skip
    return {**parts, "stand": stand}


CATEGORY: Final = BuiltCategory(
    description="a roll of toilet or kitchen paper",
    size=(0.115, 0.115, 0.1),
    least=(0.05, 0.05, 0.05),
    most=(0.25, 0.25, 0.45),
    styles={
        "roll": Style(roll, lambda size: size[2] < 1.3 * size[0]),
        "kitchen": Style(kitchen, lambda size: size[2] > 1.3 * size[0], (0.15, 0.15, 0.31)),
    },
    spread=STANDARD,
    round=True,
    alike=True,
    support="surface",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.06, 1.6)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="toilet_paper_roll paper_towel paper_towel_roll paper_roll kitchen_roll toilet_roll",
    classes=Classes(UNLABELED, "otherprop", UNLABELED, UNLABELED),
    synsets=NO_SYNSET,
    schemes=(
        Scheme({ANY: "tissue", "core": "cardboard", "stand": METAL}, weight=2.0),
        Scheme({ANY: "tissue", "core": "cardboard", "stand": "wood"}),
    ),
    makes=(
        makes.row("paper", makes.filled(160), "weight"),
        makes.row("core", makes.filled(400), "common"),
        makes.row("stand", makes.solid(1500), "common"),
    ),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    lies=(
        Lies(
            on=("cistern", "beside_toilet"),
            styles=("roll",),
            pose="flat",
            count=(1, 2),
            weight=1.0,
            most=1,
        ),
        Lies(
            on=("shelf", "low_shelf", "in_basket", "cupboard"),
            rooms=("bathroom",),
            styles=("roll",),
            pose="stacked",
            count=(2, 3),
            weight=0.8,
            most=1,
        ),
        Lies(on=("worktop",), rooms=("kitchen",), styles=("kitchen",), weight=0.7, most=1),
    ),
)
