"""Panes that stand on the rim of a bathtub."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, row, solid, walls
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme

_PROFILE_M: Final = 0.025


def hung(size: Size, rng: np.random.Generator) -> Furniture:
    """A pane that turns about a profile at the wall, on its left."""
    width, depth, height = size
    made, x, y = Assembly(), 0.5 * width, 0.5 * depth
    made.board("frame", (-x, -y, 0.0), (_PROFILE_M - x, y, height))
    pane = board((_PROFILE_M + 0.002 - x, -0.003, 0.006), (x, 0.003, height), 0.001)
    names = made.add("pane", pane)
    names += made.board("seal", (_PROFILE_M + 0.004 - x, -0.002, 0.0), (x, 0.002, 0.0058), 0.0005)
    made.hinge("leaf", names, (_PROFILE_M + 0.002 - x, 0.0, 0.0), "left", 90.0)
    return made.furniture()


CATEGORY: Final = BuiltCategory(
    description="a pane of glass on the rim of a bathtub",
    size=(0.8, 0.03, 1.4),
    min_size=(0.4, 0.015, 0.9),
    max_size=(1.6, 0.06, 2.0),
    styles={"hung": Style(hung)},
    size_variation=STANDARD,
    support="surface",
    fixed=True,
    mass_range=(10, 35),
    words="bath_screen bathtub_screen shower_door shower_doors glass_partition",
    classes=Classes(nyu40="otherstructure", ade20k="screen_door"),
    schemes=(
        scheme("chrome", plastic="seal", weight=3.0),
        scheme("chrome", tinted_glass="pane", plastic="seal"),
        scheme("black", plastic="seal"),
    ),
    construction=(row("pane", solid(2500), "common"), row(ANY, walls(1.5), "common")),
)
