"""Dumbbells: six-sided ones, and ones of plates on a bar."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import row, solid
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, lathe
from openrooms_usd.geometry.sweeps import extrude


def _laid(meshes: dict[str, Mesh], lift: float) -> Parts:
    return {name: turned(mesh, "y", 90.0).moved((0.0, 0.0, lift)) for name, mesh in meshes.items()}


def hexagonal(size: Size, rng: np.random.Generator) -> Parts:
    """Two six-sided heads of rubber on a handle of steel."""
    width, depth, height = size
    head = 0.3 * width
    around = np.pi / 3.0 * np.arange(6)
    # Flat sides below and above, corners to the front and the back.
    flat = np.stack(
        [0.5 * height / np.cos(np.pi / 6) * np.sin(around), 0.5 * depth * np.cos(around)], axis=1
    )
    heads = [extrude(flat, head, bevel=0.006, base=z) for z in (-0.5 * width, 0.5 * width - head)]
    grip = lathe(
        [
            (0.0, -0.22 * width),
            (0.012, -0.22 * width),
            (0.016, 0.0),
            (0.012, 0.22 * width),
            (0.0, 0.22 * width),
        ],
        segments=18,
    )
    return _laid({"weight": joined(heads), "handle": grip}, 0.5 * height)


def plated(size: Size, rng: np.random.Generator) -> Parts:
    """Plates on a bar, held by screwed collars."""
    width, _, height = size
    r = 0.5 * height
    plates = []
    for side in (-1.0, 1.0):
        for k, wide in enumerate((1.0, 0.8)):
            z = side * (0.2 * width + 0.03 * k + 0.015)
            plates.append(
                cylinder(wide * r, 0.027, bevel=0.004, segments=28, base=(0, 0, z - 0.0135))
            )
    bar = cylinder(0.0135, width, segments=16, base=(0.0, 0.0, -0.5 * width))
    at = [s * (0.2 * width + 0.07) - 0.009 for s in (-1, 1)]
    collars = [cylinder(0.028, 0.018, bevel=0.003, segments=12, base=(0, 0, z)) for z in at]
    return _laid({"weight": joined(plates), "handle": joined([bar, *collars])}, r)


CATEGORY: Final = BuiltCategory(
    description="a dumbbell",
    size=(0.27, 0.125, 0.11),
    min_size=(0.12, 0.05, 0.05),
    max_size=(0.6, 0.3, 0.3),
    styles={
        "hexagonal": Style(hexagonal, lambda size: size[0] < 0.34),
        "plated": Style(plated, lambda size: size[0] > 0.3, (0.37, 0.16, 0.16)),
    },
    size_variation=STANDARD,
    one_variant_per_room=True,
    mass_range=(1, 20),
    words="dumbbells weights free_weights kettlebell",
    schemes=(scheme("tyre", chrome="handle"), scheme("cast_iron", chrome="handle")),
    construction=(row("weight", solid(4500), "weight"), row("handle", solid(6000), "weight")),
    placements=(
        on(
            "floor_by_wall floor_corner",
            "bedroom gym living_room",
            pose="row",
            count=(2, 2),
            weight=0.25,
            clutter=2,
            max_groups=1,
        ),
    ),
)
