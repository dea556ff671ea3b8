"""Soap: a bar on its dish, a bar alone, and a sponge."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import filled, row, solid
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import seated, turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import loft, ring, superellipse
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import cushion
from openrooms_usd.geometry.uv import metric


def _bar(width: float, depth: float, height: float) -> Mesh:
    """It bulges above alone: on a bulge below it would rock."""
    crown = 0.15 * height
    bar = cushion(
        (width, depth, height + crown),
        radius=0.3 * height,
        crown=(0.001, 0.001, crown),
        divisions=2,
    )
    return seated(bar.moved((0.0, 0.0, 0.5 * (height - crown))))


def dish(size: Size, rng: np.random.Generator) -> Parts:
    """A bar of soap that lies in a shallow dish."""
    width, depth, height = size
    tall = min(0.5 * height, 0.016)
    outline = superellipse(1.0, 1.0, 3.0, 28)
    rows = [
        (0.7, 0.0),
        (0.8, 0.08),
        (1.0, 0.95),
        (1.0, 1.0),
        (0.96, 1.0),
        (0.77, 0.35),
        (0.6, 0.28),
    ]
    rings = [ring(outline * [a * width, a * depth], z * tall) for a, z in rows]
    bar = _bar(0.7 * width, 0.62 * depth, height - 0.28 * tall).moved((0.0, 0.0, 0.28 * tall))
    return {
        "dish": metric(loft(rings, crease=50.0))[0],
        "soap": turned(bar, "z", float(rng.uniform(-12.0, 12.0))),
    }


def bar(size: Size, rng: np.random.Generator) -> Parts:
    """A bar of soap."""
    return {"soap": _bar(*size)}


def sponge(size: Size, rng: np.random.Generator) -> Parts:
    """A sponge for dishes with a rough layer on its top."""
    width, depth, height = size
    split = 0.72 * height
    x, y = 0.5 * width, 0.5 * depth
    return {
        "sponge": board((-x, -y, 0.0), (x, y, split), 0.004),
        "pad": board((-x + 0.0005, -y + 0.0005, split - 0.001), (x, y, height), 0.0015),
    }


CATEGORY: Final = BuiltCategory(
    description="soap, or a sponge",
    size=(0.115, 0.085, 0.034),
    min_size=(0.04, 0.03, 0.01),
    max_size=(0.25, 0.2, 0.1),
    styles={
        "dish": Style(dish),
        "bar": Style(bar, size=(0.08, 0.05, 0.025)),
        "sponge": Style(sponge, size=(0.1, 0.065, 0.032)),
    },
    support="surface",
    mass_range=(0.005, 0.4),
    words="soap_dish sponge soap_bar",
    schemes=(
        scheme("soap", porcelain="dish"),
        scheme("sponge", scourer="pad", needs="sponge", weight=100.0),
    ),
    construction=(
        row("soap", solid(1000), "common"),
        row("sponge pad", filled(60), "common"),
        row("dish", solid(), "common", "specular_stone"),
    ),
    placements=(
        on(
            "basin_edge",
            styles="dish bar",
            weight=0.6,
            cluster="washing",
            max_groups=1,
            pose="flat",
        ),
        on("bath_rim", styles="bar dish", weight=0.5, max_groups=1, pose="flat"),
        on("sink_edge", styles="sponge", weight=0.9, cluster="washing", max_groups=1, pose="flat"),
    ),
)
