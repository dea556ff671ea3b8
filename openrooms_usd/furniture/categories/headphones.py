"""Headphones that lie on their side, and ones on a stand."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, solid
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import at_rest, turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, lathe
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.geometry.uv import metric


def _pair(width: float, height: float, cup: float) -> tuple[Mesh, list[Mesh], list[Mesh]]:
    """A band in the plane y = 0 from cup to cup, the cups below it, and their pads."""
    r = 0.5 * width - 0.014
    top = height - 0.006
    a = np.linspace(np.pi, 0.0, 13)
    z = top - (top - 0.72 * cup) * (1.0 - np.sin(a) ** 0.8)
    arch = np.stack([r * np.cos(a), np.zeros(13), z], axis=1)
    band = tube(arch, 0.0055, segments=8).transformed(np.diag([1.0, 2.2, 1.0]))
    cups: list[Mesh] = []
    pads: list[Mesh] = []
    for side in (-1.0, 1.0):
        shell = lathe([(0.0, 0.0), (0.9, 0.0), (1.0, 0.15), (1.0, 0.5), (0.0, 0.5)], segments=24)
        pad = lathe(
            [
                (0.35, 0.45),
                (0.95, 0.45),
                (1.02, 0.6),
                (0.98, 0.9),
                (0.8, 1.0),
                (0.5, 0.95),
                (0.4, 0.7),
            ],
            segments=24,
            crease=60.0,
        )
        for mesh, group in ((shell, cups), (pad, pads)):
            scaled = mesh.transformed(np.diag([0.42 * cup, 0.5 * cup, 0.03]))
            inward = turned(turned(scaled, "z", 90.0), "y", -side * 90.0)
            group.append(metric(inward)[0].moved((side * (0.5 * width), 0.0, 0.5 * cup)))
    return band, cups, pads


def lying(size: Size, rng: np.random.Generator) -> Parts:
    """Headphones that lie flat, the band to the back."""
    width, depth, height = size
    band, cups, pads = _pair(width, depth, height / 0.84)
    lie = np.array(
        [
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, -0.5 * depth],
            [0.0, -1.0, 0.0, 0.5 * height],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
    parts = {"band": band, "cup": joined(cups), "pad": joined(pads)}
    return at_rest({name: mesh.transformed(lie) for name, mesh in parts.items()}, size)


def stand(size: Size, rng: np.random.Generator) -> Parts:
    """Headphones over the arm of a stand."""
    width, depth, height = size
    foot = 0.5 * depth
    band, cups, pads = _pair(width, 0.21, 0.088)
    lift = (0.0, 0.0, height - 0.21)
    hook = cylinder(0.02, 0.05, bevel=0.004, segments=20, base=(0.0, 0.0, -0.025))
    post = [
        cylinder(foot, 0.01, bevel=0.003, segments=30),
        cylinder(0.008, height - 0.05, segments=14, base=(0.0, 0.02, 0.0)),
        turned(hook, "x", 90.0).moved((0.0, 0.0, height - 0.035)),
    ]
    parts = {"band": band, "cup": joined(cups), "pad": joined(pads)}
    return {**{name: mesh.moved(lift) for name, mesh in parts.items()}, "stand": joined(post)}


CATEGORY: Final = BuiltCategory(
    description="headphones",
    size=(0.17, 0.19, 0.078),
    min_size=(0.1, 0.05, 0.03),
    max_size=(0.3, 0.3, 0.4),
    styles={
        "lying": Style(lying, lambda size: size[2] < size[1]),
        "stand": Style(stand, lambda size: size[2] > size[1], (0.17, 0.11, 0.27)),
    },
    size_variation=STANDARD,
    max_per_room=1,
    support="surface",
    mass_range=(0.12, 0.9),
    words="headphone headset earphones earphone",
    synsets=("03261776",),
    schemes=(
        scheme("black_plastic", membrane="pad", aluminium="stand", weight=2.0),
        scheme("plastic", grey="pad", wood="stand"),
    ),
    construction=(row("stand", solid(1500), "weight"), row(ANY, filled(800), "weight")),
    placements=(
        on("desk", weight=0.5, clutter=2, max_groups=1, styles="lying"),
        on("desk", weight=0.3, max_groups=1, styles="stand"),
        on(
            "bedside sofa_seat coffee_table",
            weight=0.2,
            clutter=2,
            max_groups=1,
            styles="lying",
            pose="flat",
        ),
    ),
)
