"""Books: one that lies, one that is open, and a magazine-like paperback."""

from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.construction import ANY, row, solid
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.books import Book
from openrooms_usd.furniture.joinery.linens import between
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.joinery.prints import printed_cover
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import WIDE, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import box


def lying(size: Size, rng: np.random.Generator) -> Parts:
    """A bound book on its back: its spine to its left."""
    width, depth, height = size
    volume = Book((height, width, depth), 0, np.eye(4))
    # From a book that stands with its spine to the front to one that lies with it to the left.
    lie = np.array(
        [
            [0.0, 1.0, 0.0, -0.5 * width],
            [0.0, 0.0, 1.0, -0.5 * depth],
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
    front = printed_cover(0.96 * width, depth, rng)
    up = np.eye(4)
    up[:3, 3] = (-0.46 * width, -0.5 * depth, height - 0.0002)
    parts = {"book": volume.cover().transformed(lie), "pages": volume.pages().transformed(lie)}
    return {**parts, **front.parts(up)}


def _leaf(width: float, depth: float, rise: float, side: float) -> Mesh:
    """Half of an open book: pages that arch up from the spine at x = 0 and fall to their edge."""
    u, top = np.linspace(0.0, 1.0, 9), _arch(rise)
    y = np.array([-0.5 * depth, 0.5 * depth])
    x = side * u * width
    upper = np.stack(np.broadcast_arrays(x[None, :], y[:, None], top[None, :]), axis=-1)
    lower = np.stack(np.broadcast_arrays(x[None, :], y[:, None], 0.0 * top[None, :] + 0.0026), -1)
    if side < 0.0:
        upper, lower = upper[:, ::-1], lower[:, ::-1]
    return between(upper, lower)


def opened(size: Size, rng: np.random.Generator) -> Parts:
    """A book that lies open, its lines to be seen."""
    width, depth, height = size
    half, rise = 0.5 * width - 0.004, 0.91 * height
    pages = [_leaf(half, depth - 0.008, rise, side) for side in (-1.0, 1.0)]
    boards = board((-0.5 * width, -0.5 * depth, 0.0), (0.5 * width, 0.5 * depth, 0.003), 0.0008)
    lines = []
    for side in (-1.0, 1.0):
        count = int(rng.integers(11, 15))
        for k, y in enumerate(np.linspace(0.36, -0.38, count).tolist()):
            long = half * (0.34 if k % 5 == 4 else 0.62)
            low = side * 0.53 * half - 0.31 * half
            # Where the pages are about level.
            bar = box((long, 0.0022, 0.0004), (low + 0.5 * long, y * depth, 0.0))
            x = np.abs(np.array([low, low + 0.5 * long, low + long])) / half
            z = np.interp(x, np.linspace(0, 1, 9), _arch(rise))
            slope = float(np.degrees(np.arctan2(z[2] - z[0], long)))
            tilted = turned(bar, "y", -slope, (low + 0.5 * long, y * depth, 0.0))
            lines.append(tilted.moved((0.0, 0.0, float(z[1]) - 0.0002)))
    return {"book": boards, "pages": joined(pages), "text": joined(lines)}


def _arch(rise: float) -> Array:
    """The heights of an open book's page at nine places from its spine to its edge."""
    u, thick = np.linspace(0.0, 1.0, 9), 0.45 * rise
    top = u**0.5 * (1.0 - u)
    return np.asarray(thick + (rise - thick) * (top - top.min()) / (top.max() - top.min()))


_stacked = partial(on, styles="lying", pose="stacked", max_variants=5)

CATEGORY: Final = BuiltCategory(
    description="a book",
    size=(0.155, 0.23, 0.028),
    min_size=(0.06, 0.08, 0.008),
    max_size=(0.6, 0.45, 0.12),
    styles={
        "lying": Style(lying, lambda size: size[0] < 1.2 * size[1]),
        "open": Style(opened, lambda size: size[0] > size[1], (0.32, 0.235, 0.022)),
    },
    size_variation=WIDE,
    support="surface",
    mass_range=(0.1, 3),
    words="books notebooks textbook",
    classes=Classes(nyu40="books", ade20k="book", coco="book"),
    schemes=(scheme("binding", package_field="field", package_ink="title text"),),
    construction=(row(ANY, solid(700), "common"),),
    placements=(
        _stacked("shelf low_shelf", "living_room office bedroom", count=(2, 5)),
        _stacked(
            "coffee_table side_table bedside desk", count=(1, 4), weight=0.8, cluster="reading"
        ),
        on(
            "coffee_table desk bedside sofa_seat bed_foot",
            styles="open",
            pose="flat",
            clutter=2,
            weight=0.3,
            max_groups=1,
            cluster="reading",
        ),
        _stacked("window_sill cabinet_top media_top on_stack", count=(1, 3), clutter=2, weight=0.4),
        _stacked(
            "floor_beside_bed floor_beside_sofa", count=(1, 4), clutter=3, weight=0.4, max_groups=1
        ),
        on("worktop", "kitchen", styles="lying", clutter=2, weight=0.2, max_groups=1),
    ),
)
