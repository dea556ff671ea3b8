"""Mobile phones, on their back or on their screen."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    STANDARD,
    BuiltCategory,
)
from openrooms_usd.library.furniture.handheld import slab
from openrooms_usd.library.furniture.joinery import Parts, Size, Style
from openrooms_usd.library.furniture.lying import Lies


def face_up(size: Size, rng: np.random.Generator) -> Parts:
    """A phone that shows its screen."""
    return slab(size, 0.009, 0.0022, camera=False)


def face_down(size: Size, rng: np.random.Generator) -> Parts:
    """A phone that lies on its screen, its cameras up."""
    return slab(size, 0.009, 0.0022, camera=True)


CATEGORY: Final = BuiltCategory(
    description="a mobile phone",
    size=(0.072, 0.148, 0.008),
    least=(0.04, 0.08, 0.005),
    most=(0.12, 0.22, 0.03),
    styles={"face_up": Style(face_up), "face_down": Style(face_down)},
    spread=STANDARD,
    round=False,
    alike=False,
    support="surface",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.1, 0.3)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="cell_phone cellphone smartphone cellular_telephone iphone",
    classes=Classes("telephone", "otherprop", UNLABELED, "cell_phone"),
    synsets=NO_SYNSET,
    schemes=(
        Scheme({ANY: "black_plastic", "lens": "screen"}, weight=2.0),
        Scheme({ANY: "phone_back", "lens": "screen"}),
    ),
    makes=(makes.row(ANY, makes.filled(2100), "weight"),),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    lies=(
        Lies(on=("desk", "bedside"), pose="flat", weight=0.5, cluster="charging", most=1),
        Lies(
            on=("coffee_table", "dining_table", "worktop", "sofa_arm", "sofa_seat"),
            pose="flat",
            clutter=2,
            weight=0.3,
            most=1,
        ),
    ),
)
