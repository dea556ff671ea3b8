"""Night stands: two drawers, or one over an open shelf."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import STORAGE
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    USUAL,
    BuiltCategory,
)
from openrooms_usd.library.furniture.carcass import closed
from openrooms_usd.library.furniture.fronts import drawers, drawn_look
from openrooms_usd.library.furniture.joinery import Furniture, Size, Style
from openrooms_usd.library.furniture.small_table import nightstand


def chest(size: Size, rng: np.random.Generator) -> Furniture:
    """Drawers on short legs or on a plinth."""
    raised = rng.uniform() < 0.6
    cabinet = closed(size, min(0.13, 0.25 * size[2]) if raised else 0.05)
    if raised:
        cabinet.legs()
    else:
        cabinet.plinth()
    look = drawn_look(rng, 0.4)
    drawers(cabinet.made, cabinet.overlay, cabinet.face, cabinet.back - 0.03, look, 0.2)
    return cabinet.made.furniture()


CATEGORY: Final = BuiltCategory(
    description="a small chest beside a bed",
    size=(0.48, 0.42, 0.55),
    least=(0.28, 0.25, 0.35),
    most=(0.9, 0.7, 0.85),
    styles={"drawers": Style(chest), "open": Style(nightstand)},
    spread=USUAL,
    round=False,
    alike=True,
    support="floor",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (6, 22)},
    worktop=NO_APPLIANCE,
    carries=("bedside", "drawer", "low_shelf"),
    fixed=False,
    words="nightstand bedside_table night_table bedside_cabinet bedside_chest",
    classes=Classes("table", "night_stand", "table", UNLABELED),
    synsets=NO_SYNSET,
    schemes=STORAGE,
    makes=makes.STORAGE,
    hinges=PLAIN_HINGES,
    yields=RIGID,
)
