"""Step ladders: treads between two frames that stand apart."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ALUMINIUM, ANY, row, solid, walls
from openrooms_usd.furniture.joinery.boards import board, corners, splayed
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme


def step(size: Size, rng: np.random.Generator) -> Parts:
    """Broad treads in the front frame, a platform on top, a plain frame behind."""
    width, depth, height = size
    x, y = 0.5 * width, 0.5 * depth
    top, inner = height - 0.03, 0.36 * width
    rail = board((-0.011, -0.03, 0.0), (0.011, 0.03, top))
    rear = board((-0.01, -0.015, 0.0), (0.01, 0.015, top))
    apex = 0.1 * depth
    legs = [
        splayed(rail if b < 0 else rear, (a, b), (np.sign(a) * inner, apex + 0.05 * np.sign(b)))
        for a, b in corners(x - 0.011, y - 0.03)
    ]
    count = max(2, round(height / 0.25))
    treads = []
    for i in range(1, count):
        u = i / count
        half = (1.0 - u) * (x - 0.011) + u * inner - 0.009
        b = (1.0 - u) * (0.03 - y) + u * (apex - 0.05)
        z = u * top
        treads.append(board((-half, b - 0.035, z - 0.012), (half, b + 0.045, z + 0.012), 0.003))
    plate = board(
        (-inner - 0.012, apex - 0.14, top - 0.01), (inner + 0.012, apex + 0.09, height), 0.004
    )
    ties = []
    for u in (0.25, 0.65):
        half = (1.0 - u) * (x - 0.011) + u * inner
        b = (1.0 - u) * (y - 0.03) + u * (apex + 0.05)
        ties.append(board((-half, b - 0.008, u * top - 0.012), (half, b + 0.008, u * top + 0.012)))
    return {**numbered("leg", legs), **numbered("step", [*treads, plate]), **numbered("rail", ties)}


CATEGORY: Final = BuiltCategory(
    description="a step ladder",
    size=(0.5, 0.85, 1.5),
    min_size=(0.3, 0.4, 0.5),
    max_size=(0.9, 1.6, 3.0),
    styles={"step": Style(step)},
    mass_range=(2.5, 16),
    words="step_ladder stepladder",
    classes=Classes(nyu40="otherfurniture"),
    schemes=(scheme("aluminium", weight=2.0), scheme("wood")),
    construction=(
        row(ANY, walls(1.3, ALUMINIUM), "sheet", "metal"),
        row(ANY, solid(), "common", "wood"),
    ),
)
