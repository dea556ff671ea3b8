"""Sockets in a wall: a cover with inserts and the holes for plugs."""

from functools import partial
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


def round_(size: Size, rng: np.random.Generator, *, count: int) -> Parts:
    """Round inserts side by side with two holes each, as most of Europe has them."""
    front, middle = -0.5 * size[1], 0.5 * size[2]
    radius, pitch = 0.021, 0.071
    inserts, holes = [], []
    for i in range(count):
        x = (i - 0.5 * (count - 1)) * pitch
        ring = cylinder(radius, 0.0055, segments=20)
        inserts.append(facing(ring, (x, front + 0.0055, middle)))
        for aside in (-0.0095, 0.0095):
            hole = cylinder(0.0026, 0.0004, segments=8)
            holes.append(facing(hole, (x + aside, front + 0.0003, middle)))
    return {
        "cover": wall_plate(size, size[1] - 0.003),
        "insert": joined(inserts),
        "hole": joined(holes),
    }


def duplex(size: Size, rng: np.random.Generator) -> Parts:
    """Two above each other with two slots each, as in North America."""
    front, middle = -0.5 * size[1], 0.5 * size[2]
    inserts, slots = [], []
    for z in (middle - 0.0195, middle + 0.0195):
        inserts.append(
            board((-0.0165, front + 0.0002, z - 0.0145), (0.0165, front + 0.004, z + 0.0145))
        )
        for x, tall in ((-0.0064, 0.0045), (0.0064, 0.0038)):
            low, high = (
                (x - 0.0009, front - 0.0001, z - tall),
                (x + 0.0009, front + 0.001, z + tall),
            )
            slots.append(board(low, high, 0.0))
    return {
        "cover": wall_plate(size, size[1] - 0.002),
        "insert": joined(inserts),
        "hole": joined(slots),
    }


CATEGORY: Final = BuiltCategory(
    description="sockets for plugs in a wall",
    size=(0.152, 0.012, 0.082),
    min_size=(0.05, 0.01, 0.05),
    max_size=(0.4, 0.03, 0.2),
    styles={
        "double": Style(partial(round_, count=2), lambda size: size[0] > 1.5 * size[2]),
        "single": Style(
            partial(round_, count=1),
            lambda size: abs(size[0] - size[2]) < 0.01,
            (0.082, 0.012, 0.082),
        ),
        "duplex": Style(duplex, lambda size: size[2] > 1.3 * size[0], (0.07, 0.012, 0.115)),
    },
    size_variation=STANDARD,
    one_variant_per_room=True,
    support="wall",
    mount_height=0.26,
    fixed=True,
    words="outlet power_outlet electrical_outlet wall_socket power_socket receptacle",
    schemes=(scheme("plastic", dark_plastic="hole"),),
    construction=(row(ANY, filled(900), "common"),),
)
