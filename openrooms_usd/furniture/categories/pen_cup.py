"""Cups with pens, pencils and a ruler or scissors in them."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, solid
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import vessel
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, frustum, lathe


def _filled(size: Size, r: float, rng: np.random.Generator) -> Parts:
    """Pens that lean in a cup of an inner radius, up to the top of the box."""
    high = size[2]
    pens: list[Mesh] = []
    tips: list[Mesh] = []
    count = int(rng.integers(5, 8))
    for k in range(count):
        heading = 360.0 * k / count + float(rng.uniform(-12.0, 12.0))
        thick = float(rng.uniform(0.0034, 0.005))
        reach = 0.9 * (r - thick)
        foot = -0.6 * reach
        lean = float(np.degrees(np.arctan2(0.5 * size[0] - 0.006 - foot, high)))
        long = (high - 0.009) / np.cos(np.radians(lean))
        long *= 1.0 if k == 0 else float(rng.uniform(0.78, 0.95))
        stick = cylinder(thick, 0.94 * long, bevel=0.0008, segments=8)
        end = (0.0, 0.0, 0.939 * long)
        tip = frustum(0.85 * thick, 0.3 * thick, 0.055 * long, segments=8, base=end)
        a = np.radians(heading)
        place = (-foot * np.sin(a), foot * np.cos(a), 0.006)
        for mesh, group in ((stick, pens), (tip, tips)):
            group.append(turned(turned(mesh, "x", -lean), "z", heading).moved(place))
    return {**numbered("pen", pens), "tip": joined(tips)}


def round_(size: Size, rng: np.random.Generator) -> Parts:
    """A round cup."""
    r, cup, wall = 0.49 * min(size[0], size[1]), 0.58 * size[2], 0.0028
    body = lathe(
        [
            (0.0, 0.0),
            (r - 0.001, 0.0),
            (r, 0.001),
            (r, cup - 0.001),
            (r - 0.001, cup),
            (r - wall, cup),
            (r - wall, 0.005),
            (0.0, 0.005),
        ],
        segments=28,
    )
    return {"container": body, **_filled(size, r - wall, rng)}


def square(size: Size, rng: np.random.Generator) -> Parts:
    """A square cup of wood or leather."""
    x, cup, wall = 0.49 * min(size[0], size[1]), 0.55 * size[2], 0.004
    body = vessel(
        (-x, -x, 0.0, x, x, cup),
        (-x + wall, -x + wall, 0.005, x - wall, x - wall),
        wall_edge=0.0008,
    )
    return {"container": body, **_filled(size, x - wall, rng)}


CATEGORY: Final = BuiltCategory(
    description="a cup with pens",
    size=(0.085, 0.085, 0.185),
    min_size=(0.05, 0.05, 0.08),
    max_size=(0.2, 0.2, 0.3),
    styles={"round": Style(round_), "square": Style(square)},
    round=True,
    support="surface",
    mass_range=(0.05, 0.6),
    words="pen_holder pencil_cup pencil_holder",
    schemes=(
        scheme("glaze", toy_plastic="pen", cavity="tip"),
        scheme("wood", toy_plastic="pen", cavity="tip"),
        scheme("black", toy_plastic="pen", cavity="tip"),
    ),
    construction=(row("container", filled(1000), "common"), row(ANY, solid(900), "common")),
    placements=(
        on("desk", weight=0.8, cluster="writing", max_groups=1, pose="flat"),
        on("shelf window_sill", "office bedroom", weight=0.25, max_groups=1, pose="flat"),
    ),
)
