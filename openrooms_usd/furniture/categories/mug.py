"""Mugs and cups: straight ones with a handle, some filled, and a cup on its saucer."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, solid
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import cylinder, lathe
from openrooms_usd.geometry.sweeps import tube


def _handle(reach: float, low: float, high: float, thick: float, wall: float) -> Mesh:
    """A handle towards +X from a wall at x = ``wall``, between two heights, metres."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    path = [
        (wall - 0.003, 0.0, high),
        (wall + 0.75 * reach, 0.0, high),
        (wall + reach - thick, 0.0, middle + 0.1 * half),
        (wall + 0.6 * reach, 0.0, low + 0.1 * half),
        (wall - 0.003, 0.0, low),
    ]
    loop = tube(path, thick, bend=0.4 * half, bend_segments=3, segments=8)
    return loop.transformed(np.diag([1.0, 1.45, 1.0]))


def _drink(radius: float, z: float) -> Mesh:
    return cylinder(radius, 0.002, segments=28, base=(0.0, 0.0, z))


def _cup(r: float, h: float, outer: Sequence[tuple[float, float]], wall: float) -> Mesh:
    """A cup by its outside; its inside is drawn in by the wall."""
    inner = [(max(a - wall, 0.0), max(z, 2.2 * wall)) for a, z in outer if z > 2.2 * wall]
    rim = [(outer[-1][0] - 0.3 * wall, h), (outer[-1][0] - 0.75 * wall, h)]
    inside = [(inner[0][0] - wall, 1.6 * wall), (0.0, 1.4 * wall)]
    profile = [(0.0, 0.004), (0.7 * r, 0.004), *outer, *rim, *inner[::-1][1:], *inside]
    return lathe(profile, segments=30, crease=50.0)


def mug(size: Size, rng: np.random.Generator) -> Parts:
    """A mug with straight sides."""
    width, depth, h = size
    r, wall = 0.5 * depth, 0.0038
    reach = width - depth
    taper = float(rng.uniform(0.9, 1.0))
    outer = [
        (0.86 * taper * r, 0.0),
        (0.95 * taper * r, 0.004),
        (taper * r, 0.09 * h),
        (r, 0.6 * h),
        (r, h - 0.002),
    ]
    grip = _handle(reach, 0.2 * h, 0.82 * h, 0.0058, 0.97 * r)
    shift = (-0.5 * reach, 0.0, 0.0)
    parts = {"container": _cup(r, h, outer, wall).moved(shift), "handle": grip.moved(shift)}
    if rng.uniform() < 0.4:
        parts["drink"] = _drink(r - wall - 0.0002, float(rng.uniform(0.45, 0.85)) * h).moved(shift)
    return parts


def cup(size: Size, rng: np.random.Generator) -> Parts:
    """A bellied cup on its saucer, with coffee in it."""
    width, depth, height = size
    r = 0.5 * min(width, depth)
    plate = 0.018
    saucer = [
        (0.0, 0.002),
        (0.45 * r, 0.002),
        (0.47 * r, 0.0),
        (0.55 * r, 0.0),
        (0.99 * r, plate),
        (r, plate + 0.001),
        (0.97 * r, plate + 0.002),
        (0.55 * r, 0.0065),
        (0.4 * r, 0.0045),
        (0.0, 0.0045),
    ]
    a, h, foot = 0.57 * r, height - 0.0045, 0.0045
    outer = [
        (0.55 * a, 0.0),
        (0.58 * a, 0.004),
        (0.8 * a, 0.18 * h),
        (0.94 * a, 0.45 * h),
        (a, 0.8 * h),
        (1.02 * a, h - 0.001),
    ]
    body = _cup(0.5 * a, h, outer, 0.0028)
    grip = _handle(0.33 * r, 0.3 * h, 0.85 * h, 0.0032, 0.95 * a)
    turn = float(rng.uniform(-60.0, 60.0))
    up = (0.0, 0.0, foot)
    return {
        "saucer": lathe(saucer, segments=36, crease=50.0),
        "container": body.moved(up),
        "handle": turned(grip.moved(up), "z", turn),
        "drink": _drink(0.955 * a, foot + 0.74 * h),
    }


def tall(size: Size, rng: np.random.Generator) -> Parts:
    """A beaker to take along: a body that widens, a sleeve, a lid of plastic."""
    r, h = 0.5 * min(size[0], size[1]), size[2]
    body = lathe(
        [
            (0.0, 0.003),
            (0.66 * r, 0.003),
            (0.67 * r, 0.0),
            (0.7 * r, 0.0),
            (0.95 * r, 0.9 * h),
            (0.0, 0.9 * h),
        ],
        segments=30,
    )
    sleeve = lathe(
        [(0.79 * r, 0.32 * h), (0.81 * r, 0.32 * h), (0.9 * r, 0.68 * h), (0.86 * r, 0.68 * h)],
        segments=30,
    )
    lid = lathe(
        [
            (0.0, 0.89 * h),
            (0.97 * r, 0.89 * h),
            (r, 0.9 * h),
            (r, 0.925 * h),
            (0.92 * r, 0.93 * h),
            (0.9 * r, h),
            (0.8 * r, h),
            (0.77 * r, 0.96 * h),
            (0.0, 0.96 * h),
        ],
        segments=30,
    )
    return {"container": body, "seal": sleeve, "lid": lid}


CATEGORY: Final = BuiltCategory(
    description="a mug or a cup for hot drinks",
    size=(0.12, 0.084, 0.095),
    min_size=(0.05, 0.05, 0.05),
    max_size=(0.25, 0.25, 0.25),
    styles={
        "mug": Style(mug, lambda size: size[2] < 0.125 and size[0] > 1.2 * size[1]),
        "cup": Style(
            cup,
            lambda size: size[0] < 1.2 * size[1] and size[2] < 0.1,
            (0.15, 0.15, 0.07),
            mass_range=(0.2, 0.6),
        ),
        "tall": Style(
            tall, lambda size: size[2] > 1.2 * size[0], (0.085, 0.085, 0.15), mass_range=(0.05, 0.4)
        ),
    },
    support="surface",
    mass_range=(0.15, 0.6),
    words="cup mugs cups coffee_cup coffee_mug teacup beaker",
    classes=Classes(coco="cup"),
    synsets=("03797390",),
    schemes=(
        scheme("mug_glaze", coffee="drink", mug_glaze="handle"),
        scheme("porcelain", coffee="drink", porcelain="handle", needs="saucer", weight=100.0),
        scheme("white_paper", cardboard="seal", tinted_plastic="lid", needs="seal", weight=100.0),
    ),
    construction=(
        row("drink", solid(1000), "common"),
        row("handle saucer", solid(), "common", "specular_stone"),
        row("container", solid(), "common", "specular_stone"),
        row(ANY, filled(300), "common"),
    ),
    placements=(
        on("cupboard shelf", "kitchen", pose="row", count=(2, 5)),
        on("worktop sink_edge", "kitchen", cluster="coffee", pose="flat", weight=0.8),
        on("desk coffee_table", pose="flat", weight=0.6, styles="mug tall"),
        on("bedside side_table window_sill", pose="flat", clutter=2, weight=0.3),
        on("dining_table", pose="flat", cluster="setting", weight=0.3, styles="mug cup"),
    ),
)
