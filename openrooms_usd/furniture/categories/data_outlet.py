"""Outlets for aerials and networks behind televisions and at desks."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import board, wall_plate
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import facing
from openrooms_usd.furniture.record import STANDARD, BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.solids import cylinder


def coaxial(size: Size, rng: np.random.Generator) -> Parts:
    """Two round connectors of an aerial."""
    front, middle = -0.5 * size[1], 0.5 * size[2]
    rings = [
        facing(cylinder(0.0065, 0.005, segments=14), (x, front + 0.005, middle))
        for x in (-0.013, 0.013)
    ]
    holes = [
        facing(cylinder(0.0035, 0.0004, segments=10), (x, front + 0.0002, middle))
        for x in (-0.013, 0.013)
    ]
    return {
        "cover": wall_plate(size, size[1] - 0.003),
        "ring": joined(rings),
        "hole": joined(holes),
    }


def network(size: Size, rng: np.random.Generator) -> Parts:
    """Two slots for network plugs below a lip."""
    front, middle = -0.5 * size[1], 0.5 * size[2]
    lip = board((-0.022, front, middle + 0.006), (0.022, front + 0.004, middle + 0.012), 0.0)
    holes = [
        board(
            (x - 0.006, front + 0.0025, middle - 0.008),
            (x + 0.006, front + 0.004, middle + 0.005),
            0.0,
        )
        for x in (-0.0115, 0.0115)
    ]
    return {"cover": wall_plate(size, size[1] - 0.003), "insert": lip, "hole": joined(holes)}


CATEGORY: Final = BuiltCategory(
    description="an outlet for aerial or network cables",
    size=(0.082, 0.012, 0.082),
    min_size=(0.05, 0.01, 0.05),
    max_size=(0.3, 0.03, 0.2),
    styles={"coaxial": Style(coaxial), "network": Style(network)},
    size_variation=STANDARD,
    one_variant_per_room=True,
    support="wall",
    mount_height=0.26,
    fixed=True,
    words="ethernet_outlet network_outlet aerial_socket antenna_socket wall_jack",
    schemes=(scheme("plastic", dark_plastic="hole", steel="ring"),),
    construction=(row(ANY, filled(900), "common"),),
)
