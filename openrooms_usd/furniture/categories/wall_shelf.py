"""Shelves on walls: a board on brackets, a pane, an open box."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, STEEL, filled, row, solid, walls
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import MADE_TO_MEASURE, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.sweeps import tube

_THICK_M: Final = 0.024


def _bracket(depth: float, back: float, top: float) -> Mesh:
    """An angle of steel with a brace, its upper side at a height."""
    t, w = 0.004, 0.012
    reach = 0.86 * depth
    return joined(
        [
            board((-w, back - t, 0.0), (w, back, top)),
            board((-w, back - reach, top - t), (w, back, top)),
            tube(
                [(0.0, back - t, 0.12 * top), (0.0, back - 0.8 * reach, top - t)], 0.004, segments=8
            ),
        ]
    )


def on_brackets(size: Size, rng: np.random.Generator) -> Parts:
    """A board on two brackets."""
    width, depth, height = size
    x, y, top = 0.5 * width, 0.5 * depth, height - _THICK_M
    brackets = [
        _bracket(depth, y, top).moved((s * (x - 0.16 * width), 0.0, 0.0)) for s in (-1.0, 1.0)
    ]
    return {"shelf": board((-x, -y, top), (x, y, height)), **numbered("bracket", brackets)}


def glass(size: Size, rng: np.random.Generator) -> Parts:
    """A thick pane on two round holders."""
    width, depth, height = size
    x, y, top = 0.5 * width, 0.5 * depth, height - 0.008
    holders = [
        joined(
            [
                tube(
                    [(s * 0.36 * width, y, 0.5 * top), (s * 0.36 * width, y - 0.01, 0.5 * top)],
                    0.5 * top,
                    segments=20,
                ),
                tube(
                    [
                        (s * 0.36 * width, y, 0.5 * top),
                        (s * 0.36 * width, y - 0.6 * depth, 0.5 * top),
                    ],
                    0.5 * top - 0.0005,
                    segments=14,
                ),
            ]
        )
        for s in (-1.0, 1.0)
    ]
    pane = board((-x, -y, top), (x, y, height), 0.001)
    return {"pane": pane, **numbered("bracket", holders)}


def box(size: Size, rng: np.random.Generator) -> Parts:
    """An open box, with a partition where it is wide."""
    width, depth, height = size
    x, y, t = 0.5 * width, 0.5 * depth, 0.016
    boards = [
        board((-x, -y, 0.0), (x, y, t)),
        board((-x, -y, height - t), (x, y, height)),
        board((-x, -y, t), (t - x, y, height - t)),
        board((x - t, -y, t), (x, y, height - t)),
        board((t - x, y - 0.006, t), (x - t, y, height - t)),
    ]
    if width > 0.65:
        at = float(rng.uniform(-0.18, 0.18)) * width
        boards.append(board((at - 0.5 * t, -y + 0.002, t), (at + 0.5 * t, y - 0.006, height - t)))
    return numbered("shelf", boards)


CATEGORY: Final = BuiltCategory(
    description="a shelf on a wall",
    size=(0.7, 0.2, 0.14),
    min_size=(0.15, 0.08, 0.03),
    max_size=(1.8, 0.4, 1.0),
    styles={
        "brackets": Style(on_brackets, lambda size: size[2] < 0.25 and size[0] > 0.3),
        "glass": Style(
            glass,
            lambda size: size[2] < 0.07 and size[1] < 0.2,
            (0.52, 0.13, 0.036),
            mass_range=(0.4, 4),
        ),
        "box": Style(box, lambda size: size[2] > 0.2 and size[0] > 0.3, (0.6, 0.2, 0.27)),
    },
    size_variation=MADE_TO_MEASURE,
    one_variant_per_room=True,
    support="wall",
    mount_height=1.4,
    fixed=True,
    mass_range=(0.8, 12),
    words="wall_shelves floating_shelf ledge bathroom_shelf hanging_shelf",
    classes=Classes("bookshelf", "shelves", "shelf"),
    schemes=(scheme("wood", metal="bracket", weight=3.0), scheme("white", metal="bracket")),
    construction=(
        row("bracket", walls(2.0, STEEL), "sheet", "metal"),
        row("pane", solid(2500), "common"),
        row(ANY, filled(620), "common"),
    ),
    offers_surfaces=("shelf",),
)
