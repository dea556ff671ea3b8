"""A roll of paper on its holder beside a toilet."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import METAL, Scheme
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.library.furniture.built import NO_APPLIANCE, NO_LAMP, STANDARD, BuiltCategory
from openrooms_usd.library.furniture.joinery import FRONT, Parts, Size, Style, board

# Z of a lathe becomes X.
_LYING: Final = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def hook(size: Size, rng: np.random.Generator) -> Parts:
    """A bent rod from a rose on the wall, the roll on it; its sheet hangs in front."""
    width, depth, height = size
    radius = 0.5 * min(0.11, 0.95 * depth, height)
    back, z = 0.5 * depth, height - radius
    y = radius - back + 0.002
    inner, half = 0.35 * radius, 0.048
    roll = lathe([(inner, -half), (radius, -half), (radius, half), (inner, half)], segments=32)
    middle = 0.5 * width - half - 0.002
    rod = filleted([(-0.5 * width + 0.022, back, z), (-0.5 * width + 0.022, y, z),
                    (0.5 * width, y, z)], 0.018, segments=5)  # fmt: skip
    rose = lathe([(0.0, 0.0), (0.022, 0.0), (0.02, 0.008), (0.0, 0.009)], segments=24)
    sheet = board((middle - half, y - radius - 0.0012, 0.0), (middle + half, y - radius, z), 0.0003)
    return {
        "roll": roll.transformed(_LYING).moved((middle, y, z)),
        "sheet": sheet,
        "rail": tube(rod, 0.006, segments=12),
        "bracket": rose.transformed(FRONT).moved((-0.5 * width + 0.022, back, z)),
    }


CATEGORY: Final = BuiltCategory(
    description="a holder with a roll of toilet paper",
    size=(0.16, 0.115, 0.15),
    least=(0.12, 0.08, 0.1),
    most=(0.4, 0.2, 0.4),
    styles={"hook": Style(hook)},
    spread=STANDARD,
    round=False,
    alike=False,
    support="wall",
    also=(),
    level=0.65,
    lumen=NO_LAMP,
    weighs={ANY: (0.15, 1.5)},
    worktop=NO_APPLIANCE,
    fixed=True,
    words="toilet_paper_dispenser toilet_roll_holder paper_holder",
    classes=Classes(UNLABELED, "otherprop", UNLABELED, UNLABELED),
    synsets=NO_SYNSET,
    schemes=(
        Scheme({ANY: "chrome", "bracket": "chrome", "roll": "white_paper", "sheet": "white_paper"}),
        Scheme({ANY: METAL, "roll": "white_paper", "sheet": "white_paper"}),
    ),
    makes=(
        makes.row("roll", makes.filled(200), "common"),
        makes.row("sheet", makes.walls(0.3), "common"),
        makes.row(ANY, makes.walls(1.5), "common"),
    ),
    hinges=PLAIN_HINGES,
    yields=RIGID,
)
