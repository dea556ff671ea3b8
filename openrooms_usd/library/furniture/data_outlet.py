"""Outlets for aerials and networks behind televisions and at desks."""

from typing import Final

import numpy as np

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder
from openrooms_usd.library.furniture.built import (
    NEVER_WEIGHED,
    NO_APPLIANCE,
    NO_LAMP,
    STANDARD,
    BuiltCategory,
)
from openrooms_usd.library.furniture.joinery import Parts, Size, Style, board
from openrooms_usd.library.furniture.posing import facing


def _plate(size: Size, thick: float) -> Mesh:
    """A cover with eased edges, flat on the wall."""
    x, y, height = 0.5 * size[0], 0.5 * size[1], size[2]
    return board((-x, y - thick, 0.0), (x, y, height), 0.002)


def coaxial(size: Size, rng: np.random.Generator) -> Parts:
    """Two round connectors of an aerial."""
    front, middle = -0.5 * size[1], 0.5 * size[2]
    rings = [facing(cylinder(0.0065, 0.005, segments=14), (x, front + 0.005, middle))
             for x in (-0.013, 0.013)]  # fmt: skip
    holes = [facing(cylinder(0.0035, 0.0004, segments=10), (x, front + 0.0002, middle))
             for x in (-0.013, 0.013)]  # fmt: skip
    return {"cover": _plate(size, size[1] - 0.003), "ring": joined(rings), "hole": joined(holes)}


def network(size: Size, rng: np.random.Generator) -> Parts:
    """Two slots for network plugs below a lip."""
    front, middle = -0.5 * size[1], 0.5 * size[2]
    lip = board((-0.022, front, middle + 0.006), (0.022, front + 0.004, middle + 0.012), 0.0)
    holes = [
        board((x - 0.006, front + 0.0025, middle - 0.008),
              (x + 0.006, front + 0.004, middle + 0.005), 0.0)
        for x in (-0.0115, 0.0115)
    ]  # fmt: skip
    return {"cover": _plate(size, size[1] - 0.003), "insert": lip, "hole": joined(holes)}


STYLES: Final = {"coaxial": Style(coaxial), "network": Style(network)}


CATEGORY: Final = BuiltCategory(
    description="an outlet for aerial or network cables",
    size=(0.082, 0.012, 0.082),
    least=(0.05, 0.01, 0.05),
    most=(0.3, 0.03, 0.2),
    styles=STYLES,
    spread=STANDARD,
    round=False,
    alike=True,
    support="wall",
    also=(),
    level=0.26,
    lumen=NO_LAMP,
    weighs=NEVER_WEIGHED,
    worktop=NO_APPLIANCE,
    fixed=True,
    words="ethernet_outlet network_outlet aerial_socket antenna_socket wall_jack",
    classes=Classes(UNLABELED, "otherprop", UNLABELED, UNLABELED),
    synsets=NO_SYNSET,
    schemes=(Scheme({ANY: "plastic", "hole": "dark_plastic", "ring": "steel"}),),
    makes=(makes.row(ANY, makes.filled(900), "common"),),
    hinges=PLAIN_HINGES,
    yields=RIGID,
)
