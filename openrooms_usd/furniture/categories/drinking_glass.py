"""Glasses: a tumbler, and a glass with a stem."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, row, solid
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import oval
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import lathe


def _tumbler(r: float, h: float, narrow: float) -> Mesh:
    wall, floor = 0.0018, min(0.012, 0.12 * h)
    low = narrow * r
    profile = [
        (0.0, 0.0015),
        (low - 0.004, 0.0015),
        (low - 0.003, 0.0),
        (low - 0.001, 0.0),
        (low, 0.0015),
        (r, h - 0.001),
        (r - 0.0005, h),
        (r - wall + 0.0003, h),
        (r - wall, h - 0.001),
        (low - wall - 0.001, floor + 0.004),
        (low - wall - 0.005, floor),
        (0.0, floor - 0.001),
    ]
    return lathe(profile, crease=50.0)


def tumbler(size: Size, rng: np.random.Generator) -> Parts:
    """A plain glass for water."""
    r = 0.5 * min(size[0], size[1])
    return {"glassware": oval(_tumbler(r, size[2], float(rng.uniform(0.74, 0.95))), size)}


def wine(size: Size, rng: np.random.Generator) -> Parts:
    """A bowl on a stem and a foot."""
    r, h = 0.5 * min(size[0], size[1]), size[2]
    wall, bowl = 0.0013, float(rng.uniform(0.44, 0.5)) * h
    belly = 0.5 * (h - bowl)
    mouth = float(rng.uniform(0.74, 0.84))
    side = [
        (0.2 * r, 0.02),
        (0.62 * r, 0.2),
        (0.93 * r, 0.55),
        (r, 0.85),
        (0.97 * r, 1.2),
        (mouth * r, 2.0),
    ]
    outer = [(a, bowl + t * belly) for a, t in side]
    inner = [
        (max(a - wall, 0.002), z + (0.003 if i < 2 else 0.0)) for i, (a, z) in enumerate(outer)
    ]
    foot = 0.9 * r
    profile = [
        (0.0, 0.0),
        (foot - 0.001, 0.0),
        (foot, 0.001),
        (foot - 0.001, 0.002),
        (0.4 * foot, 0.005),
        (0.0055, 0.012),
        (0.0038, 0.03),
        (0.0036, bowl - 0.02),
        (0.0055, bowl - 0.006),
        *outer,
        *inner[::-1],
        (0.0, bowl + 0.007),
    ]
    return {"glassware": lathe(profile, crease=55.0)}


CATEGORY: Final = BuiltCategory(
    description="a glass to drink from",
    size=(0.076, 0.076, 0.105),
    min_size=(0.03, 0.03, 0.04),
    max_size=(0.2, 0.2, 0.35),
    styles={
        "tumbler": Style(tumbler, lambda size: size[2] < 2.1 * size[0]),
        "wine": Style(wine, lambda size: size[2] > 1.8 * size[0], (0.085, 0.085, 0.215)),
    },
    round=True,
    one_variant_per_room=True,
    support="surface",
    mass_range=(0.08, 0.5),
    words="glass tumbler wine_glass wineglass glasses_of_water water_glass drinking_glasses",
    classes=Classes(ade20k="glass", coco="cup"),
    schemes=(scheme("clear_glass"),),
    construction=(row(ANY, solid(2500), "common"),),
    placements=(
        on(
            "cupboard shelf",
            "kitchen dining_room",
            pose="row",
            count=(3, 6),
            weight=1.3,
            max_groups=4,
        ),
        on("dining_table", pose="flat", cluster="setting", weight=0.7),
        on("worktop sink_edge", "kitchen", pose="flat", cluster="washing_up", weight=0.5),
        on("bedside coffee_table desk", pose="flat", clutter=2, weight=0.35, styles="tumbler"),
    ),
)
