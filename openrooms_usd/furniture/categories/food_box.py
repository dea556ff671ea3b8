"""Packed food: a box of cereals, a carton of milk, a packet of tea, a bag of flour."""

from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.construction import ANY, filled, row, solid
from openrooms_usd.furniture.joinery.boards import SIDE, board, profiled
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.joinery.prints import Print, label_lines, printed_cover
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import loft, ring, rounded_rectangle
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.solids import cylinder
from openrooms_usd.geometry.uv import metric


def _printed(size: Size, rng: np.random.Generator, top: float) -> Parts:
    """Prints for the front and the right side of a box whose walls end at ``top``."""
    width, depth, _ = size
    front = printed_cover(width, top, rng)
    placed = front.parts(_against_front(width, depth))
    side = Print((depth, top))
    side.lines += label_lines(side, (0.12, 0.88, 0.12, 0.62), 9, rng)
    right = np.array(
        [
            [0.0, 0.0, 1.0, 0.5 * width],
            [1.0, 0.0, 0.0, -0.5 * depth],
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
    meshes = [mesh.transformed(right) for mesh in side.lines]
    placed["text"] = joined([placed["text"], *meshes])
    return placed


def _against_front(width: float, depth: float) -> Array:
    """What is drawn in the plane z = 0, brought upright to the front of a box."""
    return np.array(
        [
            [1.0, 0.0, 0.0, -0.5 * width],
            [0.0, 0.0, -1.0, -0.5 * depth],
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def cereal(size: Size, rng: np.random.Generator) -> Parts:
    """A box of card with flaps on its top, glued."""
    width, depth, height = size
    x, y = 0.5 * width - 0.0005, 0.5 * depth - 0.0005
    body = board((-x, -y, 0.0), (x, y, height - 0.0008), 0.0012)
    flap = board((-x, -y + 0.001, height - 0.002), (x, 0.25 * depth, height), 0.0004)
    return {"box": joined([body, flap]), **_printed((2 * x, 2 * y, height), rng, height)}


def carton(size: Size, rng: np.random.Generator) -> Parts:
    """A carton of milk: a gabled top with its seam, a screwed cap on the slope."""
    width, depth, height = size
    x, y = 0.5 * width - 0.0004, 0.5 * depth - 0.0004
    fin, roof = 0.018, 0.24 * height
    eave = height - roof
    outline = [
        (-y, 0.0),
        (y, 0.0),
        (y, eave),
        (0.0012, height - fin),
        (0.0012, height),
        (-0.0012, height),
        (-0.0012, height - fin),
        (-y, eave),
    ]
    body = profiled(outline, 2 * x, SIDE, 0.0008)
    slope = float(np.degrees(np.arctan2(roof - fin, y)))
    cap = cylinder(0.0145, 0.016, bevel=0.002, segments=24)
    at = (0.0, -0.52 * y, eave + 0.46 * (roof - fin))
    return {
        "carton": body,
        "lid": turned(cap.moved((0.0, 0.0, -0.002)), "x", slope).moved(at),
        **_printed((2 * x, 2 * y, height), rng, eave),
    }


def tea(size: Size, rng: np.random.Generator) -> Parts:
    """A low box with a lid of card."""
    width, depth, height = size
    x, y = 0.5 * width - 0.001, 0.5 * depth - 0.001
    split = 0.72 * height
    lower = board((-x, -y, 0.0), (x, y, split), 0.001)
    upper = board(
        (-x - 0.0004, -y - 0.0004, split + 0.0005), (x + 0.0004, y + 0.0004, height), 0.001
    )
    return {"box": joined([lower, upper]), **_printed((2 * x, 2 * y, height), rng, split)}


def flour(size: Size, rng: np.random.Generator) -> Parts:
    """A bag of paper, filled: its sides bulge, its top is folded down."""
    width, depth, height = size
    neck = 0.86 * height
    rows = [(0.94, 0.0), (1.0, 0.03), (1.0, 0.45), (0.99, 0.75), (0.97, 0.86)]
    rings = [ring(rounded_rectangle(a * width, a * depth, 0.012, 3), z * height) for a, z in rows]
    a, b = 0.485 * width, 0.36 * depth
    top = board((-a, -b, neck - 0.004), (a, b, height), 0.004)
    front = _against_front(0.82 * width, depth - 0.001)
    print_ = printed_cover(0.82 * width, neck, rng).parts(front)
    return {"bag": joined([metric(loft(rings, crease=50.0))[0], top]), **print_}


CATEGORY: Final = BuiltCategory(
    description="a box, a carton or a bag of food",
    size=(0.19, 0.065, 0.29),
    min_size=(0.04, 0.02, 0.04),
    max_size=(0.4, 0.25, 0.45),
    styles={
        "cereal": Style(cereal, lambda size: size[2] > 1.1 * size[0]),
        "carton": Style(
            carton,
            lambda size: size[2] > 1.8 * size[0],
            (0.072, 0.072, 0.235),
            mass_range=(0.3, 1.3),
        ),
        "tea": Style(tea, lambda size: size[2] < size[0], (0.15, 0.08, 0.085)),
        "flour": Style(
            flour, lambda size: size[2] > 1.1 * size[0], (0.105, 0.07, 0.16), mass_range=(0.4, 1.2)
        ),
    },
    support="surface",
    mass_range=(0.1, 0.9),
    words="cereal_box cereal milk_carton food_package packet groceries tea_box",
    classes=Classes(nyu40="box", ade20k="box"),
    schemes=(
        scheme(
            "package", package_field="field", package_ink="title text", plastic="lid", weight=2.0
        ),
        scheme("white_paper", package_field="field", print="title text", package="lid"),
    ),
    construction=(
        row("box", filled(160), "weight"),
        row("carton", filled(900), "weight"),
        row("bag", filled(620), "weight"),
        row(ANY, solid(700), "common"),
    ),
    placements=(
        on("cupboard shelf", "kitchen", pose="row", count=(2, 5), max_groups=4),
        on("worktop", "kitchen", weight=0.6, max_groups=3),
        on("appliance_top", "kitchen", styles="cereal", weight=0.5, count=(1, 2)),
        on("dining_table", styles="cereal carton", clutter=2, weight=0.3),
    ),
)
