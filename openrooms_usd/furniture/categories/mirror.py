"""Mirrors: framed, round, as the doors of a cabinet."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import filled, row, walls
from openrooms_usd.furniture.joinery.assembly import Side
from openrooms_usd.furniture.joinery.boards import FRONT, board
from openrooms_usd.furniture.joinery.carcass import Carcass
from openrooms_usd.furniture.joinery.cells import BOARD, GAP, SEAT, columns
from openrooms_usd.furniture.joinery.fronts import leaf
from openrooms_usd.furniture.joinery.pieces import Furniture, Parts, Size, Style
from openrooms_usd.furniture.joinery.wall_board import mitred
from openrooms_usd.furniture.record import WIDE, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import METAL, scheme
from openrooms_usd.geometry.lofts import loft, ring, superellipse
from openrooms_usd.geometry.mesh import Mesh

# Of the glass, metres.
_GLASS_M: Final = 0.004


def framed(size: Size, rng: np.random.Generator) -> Parts:
    """A rectangle in a mitred frame."""
    width, depth, height = size
    bar = float(rng.uniform(0.012, 0.06)) * min(width, height) + 0.008
    front, back = -0.5 * depth, 0.5 * depth
    x, sunk = 0.5 * width, front + 0.3 * depth
    inset = bar - 0.004
    return {
        "frame": mitred((-x, x, 0.0, height), bar, front, back),
        "mirror": board(
            (inset - x, sunk, inset), (x - inset, sunk + _GLASS_M, height - inset), 0.0008
        ),
        "back": board(
            (inset - x, sunk + _GLASS_M, inset), (x - inset, back - 0.001, height - inset), 0.001
        ),
    }


def _disc(width: float, height: float, thick: float, edge: float) -> Mesh:
    """An oval plate, its back at y = 0."""
    flat = superellipse(width, height, 2.0, 64)
    rings = [
        ring(flat, 0.0, (0.0, 0.5 * height)),
        ring(flat, thick - edge, (0.0, 0.5 * height)),
        ring(flat * (1.0 - 2.0 * edge / width), thick, (0.0, 0.5 * height)),
    ]
    return loft(rings).transformed(FRONT)


def oval(size: Size, rng: np.random.Generator) -> Parts:
    """A round or oval glass in a thin hoop."""
    width, depth, height = size
    bar = float(rng.choice([0.008, 0.02]))
    outer = superellipse(width, height, 2.0, 64)
    inner = superellipse(width - 2 * bar, height - 2 * bar, 2.0, 64)
    middle = (0.0, 0.5 * height)
    hoop = loft(
        [
            ring(outer, 0.0, middle),
            ring(outer, depth, middle),
            ring(inner, depth, middle),
            ring(inner, 0.0, middle),
        ],
        closed=True,
    )
    back = 0.5 * depth
    glass = _disc(width - 2 * bar + 0.001, height - 2 * bar + 0.001, 0.7 * depth, 0.001)
    return {
        "frame": hoop.transformed(FRONT).moved((0.0, back, 0.0)),
        "mirror": glass.moved((0.0, back, bar - 0.0005)),
    }


def cabinet(size: Size, rng: np.random.Generator) -> Furniture:
    """A shallow cabinet behind doors of mirror glass."""
    width, depth, height = size
    unit = Carcass(width, -0.5 * depth + BOARD + SEAT, 0.5 * depth, 0.0, height).boards()
    cells = columns(unit.overlay, max(1, round(width / 0.45)))
    for i, cell in enumerate(cells):
        side: Side = "left" if i % 2 == 0 else "right"
        wide, x = cell[1] - cell[0] - GAP, 0.5 * (cell[0] + cell[1])
        glass = leaf(wide, height - GAP).moved((x, unit.face, 0.5 * GAP))
        names = unit.made.add("mirror", glass)
        edge = cell[0] + 0.5 * GAP if side == "left" else cell[1] - 0.5 * GAP
        unit.made.hinge("door", names, (edge, unit.face - BOARD, 0.0), side, 100.0)
    unit.shelves(unit.inside, 0.22, 0.01)
    return unit.made.furniture()


CATEGORY: Final = BuiltCategory(
    description="a mirror",
    size=(0.6, 0.03, 0.8),
    min_size=(0.15, 0.012, 0.15),
    max_size=(3.0, 0.3, 2.3),
    styles={
        "framed": Style(framed, lambda size: size[1] < 0.08),
        "oval": Style(
            oval,
            lambda size: size[1] < 0.08 and size[0] < 1.6 * size[2] < 2.6 * size[0],
            (0.6, 0.025, 0.6),
        ),
        "cabinet": Style(
            cabinet, lambda size: size[1] > 0.08, (0.8, 0.14, 0.68), mass_range=(9, 30)
        ),
    },
    size_variation=WIDE,
    support="wall",
    mount_height=1.12,
    mass_range=(2, 14),
    words="wall_mirror bathroom_mirror mirror_cabinet medicine_cabinet looking_glass vanity_mirror",
    classes=Classes(nyu40="mirror", ade20k="mirror"),
    schemes=(
        scheme("wood", weight=2.0),
        scheme(METAL, weight=2.0),
        scheme("white"),
        scheme("white", needs="shelf", weight=1000.0),
        scheme("wood", needs="shelf", weight=500.0),
    ),
    construction=(
        row("back", filled(200), "common"),
        # Both faces count.
        row("mirror", walls(2, 2500), "common"),
    ),
)
