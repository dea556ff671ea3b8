"""What covers the wall between a worktop and the cabinets above it."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme


def panel(size: Size, rng: np.random.Generator) -> Parts:
    """Tiles, stone or glass on the wall, as thick as they are."""
    x, y, height = 0.5 * size[0], 0.5 * size[1], size[2]
    return {"panel": board((-x, -y, 0.0), (x, y, height), 0.001)}


CATEGORY: Final = BuiltCategory(
    description="tiles, stone or glass on the wall above a worktop",
    size=(2.4, 0.008, 0.55),
    min_size=(0.05, 0.004, 0.03),
    max_size=(8.0, 0.03, 2.6),
    styles={"panel": Style(panel)},
    size_variation=STANDARD,
    support="wall",
    mount_height=0.91,
    fixed=True,
    classes=Classes("wall", "wall", "wall"),
    schemes=(scheme("wall_tiles", weight=4.0), scheme("stone"), scheme("back_painted_glass")),
    construction=(row(ANY, filled(2300), "common"),),
)
