"""A roll of paper on its holder beside a toilet."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, walls
from openrooms_usd.furniture.joinery.boards import FRONT, SIDE, board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import band
from openrooms_usd.furniture.record import STANDARD, BuiltCategory
from openrooms_usd.furniture.schemes import METAL, scheme
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.sweeps import tube

# Z of a lathe becomes X.


def hook(size: Size, rng: np.random.Generator) -> Parts:
    """A bent rod from a rose on the wall, the roll on it; its sheet hangs in front."""
    width, depth, height = size
    radius = 0.5 * min(0.11, 0.95 * depth, height)
    back, z = 0.5 * depth, height - radius
    y = radius - back + 0.002
    inner, half = 0.35 * radius, 0.048
    roll = band(inner, radius, -half, half)
    middle = 0.5 * width - half - 0.002
    rod = filleted(
        [(-0.5 * width + 0.022, back, z), (-0.5 * width + 0.022, y, z), (0.5 * width, y, z)],
        0.018,
        segments=5,
    )
    rose = lathe([(0.0, 0.0), (0.022, 0.0), (0.02, 0.008), (0.0, 0.009)], segments=24)
    sheet = board((middle - half, y - radius - 0.0012, 0.0), (middle + half, y - radius, z), 0.0003)
    return {
        "roll": roll.transformed(SIDE).moved((middle, y, z)),
        "sheet": sheet,
        "rail": tube(rod, 0.006),
        "bracket": rose.transformed(FRONT).moved((-0.5 * width + 0.022, back, z)),
    }


CATEGORY: Final = BuiltCategory(
    description="a holder with a roll of toilet paper",
    size=(0.16, 0.115, 0.15),
    min_size=(0.12, 0.08, 0.1),
    max_size=(0.4, 0.2, 0.4),
    styles={"hook": Style(hook)},
    size_variation=STANDARD,
    support="wall",
    mount_height=0.65,
    fixed=True,
    mass_range=(0.15, 1.5),
    words="toilet_paper_dispenser toilet_roll_holder paper_holder",
    schemes=(
        scheme("chrome", chrome="bracket", white_paper="roll sheet"),
        scheme(METAL, white_paper="roll sheet"),
    ),
    construction=(
        row("roll", filled(200), "common"),
        row("sheet", walls(0.3), "common"),
        row(ANY, walls(1.5), "common"),
    ),
)
