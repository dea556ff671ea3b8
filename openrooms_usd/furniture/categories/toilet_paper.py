"""Toilet paper: a roll, a few of them in their wrapping, a roll on its holder; kitchen paper."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import filled, row, solid
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import band
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, lathe, sphere


def _roll(r: float, h: float, core: float = 0.021) -> dict[str, Mesh]:
    """An upright roll about the origin, and the tube of card in it."""
    paper = lathe(
        [(core, 0.0), (r - 0.002, 0.0), (r, 0.002), (r, h - 0.002), (r - 0.002, h), (core, h)],
        crease=50.0,
    )
    card = band(core - 0.0015, core + 0.0002, 0.0004, h - 0.0004, 20)
    return {"paper": paper, "core": card}


def roll(size: Size, rng: np.random.Generator) -> Parts:
    """A roll that stands."""
    return dict(_roll(0.5 * min(size[0], size[1]), size[2]))


def kitchen(size: Size, rng: np.random.Generator) -> Parts:
    """A roll of kitchen paper on its upright stand."""
    r, height = 0.5 * min(size[0], size[1]), size[2]
    wide = float(rng.uniform(0.72, 0.86)) * r
    parts = {
        name: mesh.moved((0.0, 0.0, 0.0125)) for name, mesh in _roll(wide, 0.8 * height).items()
    }
    stand = joined(
        [
            cylinder(r, 0.012, bevel=0.002, segments=36),
            cylinder(0.006, height - 0.02, segments=14, base=(0.0, 0.0, 0.01)),
            sphere(0.012, segments=14, center=(0.0, 0.0, height - 0.012)),
        ]
    )
    return {**parts, "stand": stand}


CATEGORY: Final = BuiltCategory(
    description="a roll of toilet or kitchen paper",
    size=(0.115, 0.115, 0.1),
    min_size=(0.05, 0.05, 0.05),
    max_size=(0.25, 0.25, 0.45),
    styles={
        "roll": Style(roll, lambda size: size[2] < 1.3 * size[0]),
        "kitchen": Style(kitchen, lambda size: size[2] > 1.3 * size[0], (0.15, 0.15, 0.31)),
    },
    size_variation=STANDARD,
    round=True,
    one_variant_per_room=True,
    support="surface",
    mass_range=(0.06, 1.6),
    words="toilet_paper_roll paper_towel paper_towel_roll paper_roll kitchen_roll toilet_roll",
    schemes=(
        scheme("tissue", cardboard="core", metal="stand", weight=2.0),
        scheme("tissue", cardboard="core", wood="stand"),
    ),
    construction=(
        row("paper", filled(160), "weight"),
        row("core", filled(400), "common"),
        row("stand", solid(1500), "common"),
    ),
    placements=(
        on("cistern beside_toilet", styles="roll", pose="flat", count=(1, 2), max_groups=1),
        on(
            "shelf low_shelf in_basket cupboard",
            "bathroom",
            styles="roll",
            pose="stacked",
            count=(2, 3),
            weight=0.8,
            max_groups=1,
        ),
        on("worktop", "kitchen", styles="kitchen", weight=0.7, max_groups=1),
    ),
)
