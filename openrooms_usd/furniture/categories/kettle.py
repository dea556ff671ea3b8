"""Kettles: electric jugs on their base, and one for the stove with an arched handle."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.vessel import smooth_line
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import loft, ring
from openrooms_usd.geometry.solids import cylinder, lathe, sphere
from openrooms_usd.geometry.sweeps import tube


def jug(size: Size, rng: np.random.Generator) -> Parts:
    """An electric kettle: a jug with a spout to its left and a handle at its right."""
    width, depth, height = size
    r = 0.49 * depth
    foot = 0.022
    top = height - 0.018
    narrow = float(rng.uniform(0.68, 0.78))
    body = lathe(
        [(0.0, foot), (0.97 * r, foot), (r, foot + 0.008), (narrow * r, top), (0.0, top)],
        segments=36,
        crease=50.0,
    )
    base = cylinder(1.02 * r, foot - 0.003, bevel=0.004)
    lid = lathe(
        [
            (0.0, top - 0.002),
            (narrow * r, top - 0.002),
            (narrow * r, top + 0.004),
            (0.6 * narrow * r, top + 0.01),
            (0.0, top + 0.011),
        ],
        segments=30,
    )
    knob = cylinder(0.012, 0.012, bevel=0.003, segments=16, base=(0.0, 0.0, height - 0.012))
    lip = narrow * r
    outline = [(-lip + 0.012, 0.02), (-lip - 0.022, 0.0), (-lip + 0.012, -0.02)]
    spout = loft(
        [
            ring(np.array(outline) * s + [(s - 1.0) * lip * 0.4, 0.0], z)
            for s, z in ((0.45, top - 0.05), (0.9, top - 0.006), (0.95, top))
        ]
    )
    left = max(1.02 * r, 0.97 * lip + 0.021)
    reach = width - left + 0.0015
    path = [
        (0.8 * narrow * r, 0.0, top - 0.008),
        (reach - 0.012, 0.0, top - 0.012),
        (reach - 0.012, 0.0, foot + 0.28 * top),
        (0.9 * r, 0.0, foot + 0.18 * top),
    ]
    grip = tube(path, 0.0105, bend=0.035, segments=10)
    return {
        "container": body,
        "base": base,
        "lid": lid,
        "knob": knob,
        "spout": spout,
        "handle": grip,
    }


def stove(size: Size, rng: np.random.Generator) -> Parts:
    """A bellied kettle for the stove."""
    width, depth, height = size
    r = 0.5 * depth
    h = 0.62 * height
    line = smooth_line(
        [
            (0.9 * r, 0.0),
            (r, 0.1 * h),
            (0.97 * r, 0.35 * h),
            (0.72 * r, 0.75 * h),
            (0.42 * r, 0.96 * h),
            (0.4 * r, h),
        ],
        12,
    )
    peak = max(a for a, _ in line)
    body = lathe(
        [(0.0, 0.0), *((a * r / peak, z) for a, z in line), (0.0, h)], segments=36, crease=50.0
    )
    lid = lathe(
        [
            (0.0, h - 0.002),
            (0.43 * r, h - 0.002),
            (0.43 * r, h + 0.003),
            (0.2 * r, h + 0.012),
            (0.0, h + 0.013),
        ],
        segments=28,
    )
    knob = sphere(0.011, segments=14, center=(0.0, 0.0, h + 0.02))
    arch = [
        (-0.6 * r, 0.0, 0.72 * h),
        (-0.55 * r, 0.0, height - 0.008),
        (0.55 * r, 0.0, height - 0.008),
        (0.6 * r, 0.0, 0.72 * h),
    ]
    grip = tube(arch, 0.0075, bend=0.4 * r, bend_segments=5, segments=10)
    end = width - r - 0.012
    beak = [
        (-0.75 * r, 0.0, 0.42 * h),
        (-0.5 * (r + end) - 0.01, 0.0, 0.62 * h),
        (-end, 0.0, 0.98 * h),
    ]
    spout = tube(beak, np.linspace(0.02, 0.011, 6).tolist(), bend=0.03, bend_segments=3)
    return {"container": body, "lid": lid, "knob": knob, "handle": grip, "spout": spout}


CATEGORY: Final = BuiltCategory(
    description="a kettle to boil water",
    size=(0.22, 0.165, 0.24),
    min_size=(0.1, 0.1, 0.12),
    max_size=(0.4, 0.35, 0.45),
    styles={"jug": Style(jug), "stove": Style(stove, size=(0.25, 0.2, 0.22))},
    max_per_room=1,
    support="surface",
    mass_range=(0.6, 2.5),
    on_worktop_probability=0.5,
    words="tea_kettle water_kettle electric_kettle teapot",
    schemes=(
        scheme(
            "cookware_steel", black_plastic="handle base knob", cookware_steel="spout", weight=2.0
        ),
        scheme("cookware_enamel", black_plastic="handle base knob", cookware_enamel="spout"),
        scheme("tinted_plastic", black_plastic="base handle", tinted_plastic="spout", needs="base"),
    ),
    construction=(row(ANY, filled(420), "weight"),),
    placements=(
        on("worktop", weight=0.9, cluster="coffee", styles="jug", max_groups=1),
        on("hob", weight=0.35, styles="stove", max_groups=1),
    ),
)
