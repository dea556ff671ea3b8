"""Large soft balls to sit and train on."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, row, walls
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.solids import sphere


def gym(size: Size, rng: np.random.Generator) -> Parts:
    """A ball a little flattened where it rests."""
    width, depth, height = size
    ball = sphere(0.5 * width, segments=48, squash=height / width)
    points = ball.transformed(np.diag([1.0, depth / width, 1.0])).moved((0.0, 0.0, 0.5 * height))
    return {"ball": points}


CATEGORY: Final = BuiltCategory(
    description="a large soft ball for training",
    size=(0.65, 0.65, 0.63),
    min_size=(0.3, 0.3, 0.28),
    max_size=(1.0, 1.0, 1.0),
    styles={"gym": Style(gym)},
    round=True,
    mass_range=(0.5, 4),
    words="yoga_ball gym_ball fitness_ball pilates_ball swiss_ball",
    classes=Classes(ade20k="ball", coco="sports_ball"),
    schemes=(scheme("soft_vinyl"),),
    construction=(row(ANY, walls(0.5, 1200), "common"),),
    collision_softness=0.03,
)
