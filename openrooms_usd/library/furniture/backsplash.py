"""What covers the wall between a worktop and the cabinets above it."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import (
    NO_SYNSET,
    PLAIN_HINGES,
    RIGID,
    UNLABELED,
    Classes,
    Without,
)
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.library.furniture.built import (
    NEVER_WEIGHED,
    NO_APPLIANCE,
    NO_LAMP,
    STANDARD,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style, board


def panel(size: Size, rng: np.random.Generator) -> Parts:
    """Tiles, stone or glass on the wall, as thick as they are."""
    x, y, height = 0.5 * size[0], 0.5 * size[1], size[2]
    return {"panel": board((-x, -y, 0.0), (x, y, height), 0.001)}


CATEGORY: Final = BuiltCategory(
    description="tiles, stone or glass on the wall above a worktop",
    size=(2.4, 0.008, 0.55),
    least=(0.05, 0.004, 0.03),
    most=(8.0, 0.03, 2.6),
    styles={"panel": Style(panel)},
    spread=STANDARD,
    round=False,
    alike=False,
    support="wall",
    also=(),
    level=0.91,
    lumen=NO_LAMP,
    weighs=NEVER_WEIGHED,
    worktop=NO_APPLIANCE,
    fixed=True,
    words=Without("captures call it a part of the wall"),
    classes=Classes("wall", "wall", "wall", UNLABELED),
    synsets=NO_SYNSET,
    schemes=(
        Scheme({ANY: "wall_tiles"}, weight=4.0),
        Scheme({ANY: "stone"}),
        Scheme({ANY: "back_painted_glass"}),
    ),
    makes=(makes.row(ANY, makes.filled(2300), "common"),),
    hinges=PLAIN_HINGES,
    yields=RIGID,
)
