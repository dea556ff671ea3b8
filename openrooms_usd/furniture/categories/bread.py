"""Bread: a loaf that is cut into, a long thin one, rolls."""

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import loft
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.uv import metric


def _arch(width: float, height: float, count: int = 14) -> Array:
    """(N, 2) the section of a loaf: flat below, its sides upright, its top domed."""
    t = np.linspace(0.0, np.pi, count)
    x = 0.5 * width * np.sign(np.cos(t)) * np.abs(np.cos(t)) ** 0.7
    z = 0.06 * height + 0.94 * height * np.sin(t) ** 0.75
    return np.concatenate([[(0.42 * width, 0.0)], np.stack([x, z], 1), [(-0.42 * width, 0.0)]])


def _along_x(sections: list[Array], x: ArrayLike) -> Mesh:
    """A solid through sections (depth, height) that stand at places along X."""
    rings = [
        np.column_stack([np.full(len(s), at), s[:, 0], s[:, 1]])
        for s, at in zip(sections, np.asarray(x).tolist(), strict=True)
    ]
    return metric(loft(np.stack(rings), crease=50.0))[0]


def loaf_of(size: Size, rng: np.random.Generator, cut: bool) -> Mesh:
    """A loaf along X, its left end cut off where ``cut`` says so; scored across its top."""
    width, depth, height = size
    x = np.linspace(-1.0, 1.0, 15)
    round_ = np.clip(1.0 - np.abs(x) ** 5, 0.12, 1.0) ** 0.5
    if cut:
        round_[x < 0.2] = 1.0
    score = 1.0 - 0.045 * (np.arange(15) % 3 == 1)
    wobble = 1.0 + 0.012 * rng.standard_normal(15)
    sections = [
        _arch(depth * a, height * a**0.6 * s * min(w, 1.0))
        for a, s, w in zip(round_, score, wobble, strict=True)
    ]
    return _along_x(sections, 0.5 * width * x)


def slice_of(depth: float, height: float, thick: float) -> Mesh:
    """An upright slice about the origin, its cut sides towards -X and +X."""
    arch = _arch(depth, height) - [0.0, 0.5 * height]
    return _along_x(
        [0.97 * arch, arch, arch, 0.97 * arch], thick * np.array([-0.5, -0.4, 0.4, 0.5])
    )


def loaf(size: Size, rng: np.random.Generator) -> Parts:
    """A whole loaf."""
    return {"bread": loaf_of(size, rng, cut=False)}


def baguette(size: Size, rng: np.random.Generator) -> Parts:
    """A long thin loaf, scored aslant."""
    width, depth, height = size
    x = np.linspace(-1.0, 1.0, 21)
    round_ = np.clip(1.0 - np.abs(x) ** 3, 0.06, 1.0) ** 0.5
    swell = 1.0 - 0.07 * (np.arange(21) % 4 == 1)
    sections = [_arch(depth * a, height * a * s) for a, s in zip(round_, swell, strict=True)]
    return {"bread": _along_x(sections, 0.5 * width * x)}


def rolls(size: Size, rng: np.random.Generator) -> Parts:
    """Three rolls beside each other."""
    width, depth, height = size
    r = min(width / 3.905, depth / 3.65)
    found = []
    for k in range(3):
        a = 2.0 * np.pi * k / 3.0 + 0.5 * np.pi
        t = np.linspace(0.0, 0.5 * np.pi, 6)
        tall = height * (1.0 if k == 0 else float(rng.uniform(0.85, 1.0)))
        dome = np.stack([r * np.cos(t), 0.15 * tall + 0.85 * tall * np.sin(t)], axis=1)
        dome[-1, 0] = 0.0
        body = lathe([(0.0, 0.0), (0.85 * r, 0.0), *map(tuple, dome)], segments=18)
        found.append(body.moved((1.1 * r * np.cos(a), 1.1 * r * np.sin(a), 0.0)))
    return numbered("bread", found)


CATEGORY: Final = BuiltCategory(
    description="a loaf of bread",
    size=(0.26, 0.12, 0.11),
    min_size=(0.06, 0.05, 0.03),
    max_size=(0.8, 0.4, 0.25),
    styles={
        "loaf": Style(loaf, lambda size: size[0] < 3.5 * size[1]),
        "baguette": Style(baguette, lambda size: size[0] > 3.0 * size[1], (0.5, 0.075, 0.055)),
        "rolls": Style(rolls, lambda size: size[0] < 1.5 * size[1], (0.19, 0.178, 0.06)),
    },
    support="surface",
    mass_range=(0.1, 1.5),
    words="loaf baguette bread_loaf",
    classes=Classes(ade20k="food"),
    schemes=(scheme("crust"),),
    construction=(row(ANY, filled(300), "common"),),
    placements=(
        on("worktop", "kitchen", pose="flat", weight=0.4, max_groups=1),
        on(
            "in_basket on_tray",
            "kitchen dining_room",
            pose="flat",
            styles="rolls",
            weight=0.4,
            max_groups=1,
        ),
    ),
)
