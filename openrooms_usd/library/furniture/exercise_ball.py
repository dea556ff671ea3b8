"""Large soft balls to sit and train on."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.geometry.solids import sphere
from openrooms_usd.library.furniture.built import (
    HANGS_NOT,
    NO_APPLIANCE,
    NO_LAMP,
    USUAL,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style


def gym(size: Size, rng: np.random.Generator) -> Parts:
    """A ball a little flattened where it rests."""
    width, depth, height = size
    ball = sphere(0.5 * width, segments=48, squash=height / width)
    points = ball.transformed(np.diag([1.0, depth / width, 1.0])).moved((0.0, 0.0, 0.5 * height))
    return {"ball": points}


CATEGORY: Final = BuiltCategory(
    description="a large soft ball for training",
    size=(0.65, 0.65, 0.63),
    least=(0.3, 0.3, 0.28),
    most=(1.0, 1.0, 1.0),
    styles={"gym": Style(gym)},
    spread=USUAL,
    round=True,
    alike=False,
    support="floor",
    also=(),
    level=HANGS_NOT,
    lumen=NO_LAMP,
    weighs={ANY: (0.5, 4)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="yoga_ball gym_ball fitness_ball pilates_ball swiss_ball",
    classes=Classes(UNLABELED, "otherprop", "ball", "sports_ball"),
    synsets=NO_SYNSET,
    schemes=(Scheme({ANY: "soft_vinyl"}),),
    makes=(makes.row(ANY, makes.walls(0.5, 1200), "common"),),
    hinges=PLAIN_HINGES,
    yields=0.03,
)
