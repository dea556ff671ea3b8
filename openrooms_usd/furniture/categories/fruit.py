"""Fruit: apples, oranges, lemons, pears and bananas, one by one."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.linens import boxed
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import at_rest, turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.sweeps import tube


def _round(profile: list[tuple[float, float]], size: Size) -> Mesh:
    """A body turned about Z, of a profile whose widest place is 1 and whose height is 1."""
    width, _, height = size
    line = [(0.5 * width * a, height * z) for a, z in profile]
    return boxed(lathe(line, segments=20, crease=60.0), size)


def apple(size: Size, rng: np.random.Generator) -> Parts:
    """An apple: dimpled above and below, with its stalk."""
    width, depth, height = size
    body = 0.9 * height
    profile = [
        (0.0, 0.1),
        (0.14, 0.07),
        (0.32, 0.0),
        (0.5, 0.02),
        (0.78, 0.16),
        (0.96, 0.4),
        (1.0, 0.6),
        (0.93, 0.8),
        (0.72, 0.95),
        (0.45, 1.0),
        (0.2, 0.93),
        (0.0, 0.82),
    ]
    lean = float(rng.uniform(-0.006, 0.006))
    stalk = tube(
        [(0.0, 0.0, 0.72 * body), (0.3 * lean, 0.0, 0.93 * body), (lean, 0.0, height)],
        0.0014,
        segments=6,
    )
    return {"apple": _round(profile, (width, depth, body)), "stem": stalk}


def orange(size: Size, rng: np.random.Generator) -> Parts:
    """An orange, a little flat at its poles."""
    t = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 13)
    profile = [(float(np.cos(a)) ** 0.95, 0.5 + 0.5 * float(np.sin(a))) for a in t]
    orange = _round([(0.0, 0.0), *profile[1:-1], (0.0, 0.985)], size)
    return at_rest({"orange": orange}, size)


def pear(size: Size, rng: np.random.Generator) -> Parts:
    """A pear that stands."""
    width, depth, height = size
    body = 0.88 * height
    profile = [
        (0.0, 0.06),
        (0.3, 0.0),
        (0.6, 0.04),
        (0.9, 0.18),
        (1.0, 0.34),
        (0.92, 0.5),
        (0.68, 0.66),
        (0.5, 0.8),
        (0.44, 0.9),
        (0.3, 0.98),
        (0.0, 1.0),
    ]
    stalk = tube([(0.0, 0.0, 0.95 * body), (0.004, 0.0, height)], 0.0016, segments=6)
    return {"pear": _round(profile, (width, depth, body)), "stem": stalk}


def lemon(size: Size, rng: np.random.Generator) -> Parts:
    """A lemon on its side."""
    width, depth, height = size
    profile = [
        (0.0, 0.0),
        (0.14, 0.02),
        (0.22, 0.07),
        (0.55, 0.18),
        (0.88, 0.36),
        (1.0, 0.52),
        (0.9, 0.68),
        (0.6, 0.84),
        (0.28, 0.93),
        (0.2, 0.97),
        (0.0, 1.0),
    ]
    standing = _round(profile, (depth, height, width))
    return at_rest({"lemon": turned(standing, "y", 90.0)}, size)


def banana(size: Size, rng: np.random.Generator) -> Parts:
    """A banana on its side, its ends to the front."""
    bend = np.radians(np.linspace(205.0, 335.0, 11))
    path = np.stack([np.cos(bend), -np.sin(bend), 0.0 * bend], axis=1) * 0.1
    radii = [0.005, 0.006, 0.013, 0.0165, 0.018, 0.018, 0.018, 0.017, 0.013, 0.006, 0.004]
    return at_rest({"banana": boxed(tube(path, radii, segments=8), size)}, size)


CATEGORY: Final = BuiltCategory(
    description="a piece of fruit",
    size=(0.078, 0.078, 0.08),
    min_size=(0.03, 0.03, 0.02),
    max_size=(0.3, 0.2, 0.2),
    styles={
        "apple": Style(apple, lambda size: size[2] < 1.25 * size[0]),
        "orange": Style(orange, lambda size: size[2] < 1.25 * size[0], (0.078, 0.078, 0.074)),
        "pear": Style(pear, lambda size: size[2] > 1.1 * size[0], (0.072, 0.072, 0.105)),
        "lemon": Style(lemon, lambda size: size[0] > 1.1 * size[1], (0.085, 0.06, 0.058)),
        "banana": Style(
            banana,
            lambda size: size[0] > 1.6 * size[1],
            (0.18, 0.085, 0.036),
            mass_range=(0.05, 0.35),
        ),
    },
    support="surface",
    mass_range=(0.08, 0.5),
    words="apple apples orange oranges lemon pear banana bananas fruits",
    classes=Classes(ade20k="food"),
    schemes=(
        scheme("apple_skin"),
        scheme("orange_skin", needs="orange", weight=100.0),
        scheme("pear_skin", needs="pear", weight=100.0),
        scheme("lemon_skin", needs="lemon", weight=100.0),
        scheme("banana_skin", needs="banana", weight=100.0),
    ),
    construction=(row(ANY, filled(950), "common"),),
    placements=(
        on("in_bowl", pose="flat", max_groups=10, max_variants=6),
        on(
            "worktop dining_table",
            "kitchen dining_room apartment",
            pose="flat",
            count=(1, 3),
            clutter=2,
            weight=0.3,
            max_groups=1,
        ),
        on("desk coffee_table bedside", pose="flat", clutter=2, weight=0.12, max_groups=1),
    ),
)
