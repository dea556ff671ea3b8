"""What towels hang on: a bar, a heated ladder, a ring."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, STEEL, row, walls
from openrooms_usd.furniture.joinery.boards import FRONT
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import STANDARD, BuiltCategory
from openrooms_usd.furniture.schemes import METAL, scheme
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.sweeps import tube


def bar(size: Size, rng: np.random.Generator) -> Parts:
    """One bar on two posts."""
    width, depth, height = size
    back, r = 0.5 * depth, min(0.011, 0.2 * height)
    rose = 0.5 * height
    x, y, z = 0.5 * width - rose, r - back, rose
    disc = lathe([(0.0, 0.0), (rose, 0.0), (0.9 * rose, 0.008), (0.0, 0.009)], segments=24)
    plates = [disc.transformed(FRONT).moved((s * x, back, z)) for s in (-1.0, 1.0)]
    posts = [tube([(s * x, back, z), (s * x, y, z)], 0.7 * r, segments=10) for s in (-1.0, 1.0)]
    rail = tube([(-0.5 * width, y, z), (0.5 * width, y, z)], r, segments=14)
    return {"rail": rail, **numbered("bracket", posts + plates)}


def ladder(size: Size, rng: np.random.Generator) -> Parts:
    """A heated rail: rungs in groups between two pipes."""
    width, depth, height = size
    back, r, rung = 0.5 * depth, 0.015, 0.011
    y, x = r - back + 0.002, 0.5 * width - r
    pipes = [tube([(s * x, y, 0.0), (s * x, y, height)], r, segments=14) for s in (-1.0, 1.0)]
    count = max(4, int(height / 0.075))
    left_out = {i for i in range(count) if i % 6 == 5}
    levels = [0.04 + (height - 0.08) * i / (count - 1) for i in range(count) if i not in left_out]
    rungs = [tube([(-x, y, z), (x, y, z)], rung, segments=10) for z in levels]
    feet = [
        tube([(s * x, y, z), (s * x, back, z)], 0.01, segments=10)
        for s in (-1.0, 1.0)
        for z in (0.1, height - 0.1)
    ]
    front = tube([(-x, rung - back, levels[-1]), (x, rung - back, levels[-1])], rung, segments=10)
    return {
        **numbered("pipe", pipes),
        **numbered("rail", [*rungs[:-1], front]),
        **numbered("bracket", feet),
    }


CATEGORY: Final = BuiltCategory(
    description="a rail for towels",
    size=(0.6, 0.075, 0.05),
    min_size=(0.15, 0.04, 0.02),
    max_size=(1.4, 0.3, 2.0),
    styles={
        "bar": Style(bar, lambda size: size[2] < 0.2),
        "ladder": Style(ladder, lambda size: size[2] > 0.5, (0.5, 0.09, 1.1), mass_range=(3, 15)),
    },
    size_variation=STANDARD,
    support="wall",
    mount_height=1.2,
    fixed=True,
    mass_range=(0.3, 3),
    words="towel_rack towel_bar towel_holder towel_warmer heated_towel_rail towel_hanger",
    schemes=(
        scheme("chrome", chrome="bracket", weight=2.0),
        scheme(METAL),
        scheme("white", white="bracket", needs="pipe", weight=2.0),
    ),
    construction=(row(ANY, walls(1.2, STEEL), "sheet"),),
    offers_surfaces=("towel_rail",),
)
