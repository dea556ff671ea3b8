"""Trays for papers on a desk, with papers in them."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import row, solid
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import box


def _tray(width: float, depth: float, z: float, tall: float) -> Mesh:
    """A tray that is open above and to the front, its floor at a height."""
    x, y, w = 0.5 * width, 0.5 * depth, 0.003
    return joined(
        [
            box((width, depth, w), (0.0, 0.0, z + 0.5 * w)),
            *(box((w, depth, tall), (s * (x - 0.5 * w), 0.0, z + 0.5 * tall)) for s in (-1, 1)),
            box((width, w, tall), (0.0, y - 0.5 * w, z + 0.5 * tall)),
        ]
    )


def tiers(size: Size, rng: np.random.Generator) -> Parts:
    """Two or three trays above each other on posts."""
    width, depth, height = size
    count = max(2, round(height / 0.085))
    pitch = (height - 0.045) / (count - 1)
    trays = [_tray(width, depth, k * pitch, 0.045) for k in range(count)]
    x, tall = 0.5 * width - 0.003, height - 0.01
    posts = [
        box((0.006, 0.012, tall), (s * x, y * depth, 0.5 * height))
        for s in (-1, 1)
        for y in (-0.36, 0.36)
    ]
    piles = []
    for k in range(count):
        thick = float(rng.uniform(0.004, 0.02))
        pile = board(
            (-0.41 * width, -0.44 * depth, 0.0), (0.41 * width, 0.46 * depth, thick), 0.0006
        )
        piles.append(pile.moved((0.0, 0.0, k * pitch + 0.003)))
    return {"tray": joined([*trays, *posts]), "paper": joined(piles)}


CATEGORY: Final = BuiltCategory(
    description="trays for papers",
    size=(0.26, 0.34, 0.16),
    min_size=(0.1, 0.1, 0.08),
    max_size=(0.5, 0.5, 0.5),
    styles={"tiers": Style(tiers)},
    size_variation=STANDARD,
    support="surface",
    mass_range=(0.4, 4),
    words="paper_tray letter_trays in_tray",
    classes=Classes(ade20k="tray"),
    schemes=(scheme("black", weight=2.0), scheme("tinted_plastic"), scheme("wood")),
    construction=(row("paper", solid(750), "common"), row("tray", solid(900), "common")),
    placements=(
        on("desk", weight=0.5, max_groups=1),
        on("cabinet_top shelf", "office", weight=0.4, max_groups=1),
    ),
)
