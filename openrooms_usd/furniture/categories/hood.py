"""Extractor hoods above stoves: a canopy with a chimney, and slim ones below a cabinet."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, STEEL, filled, row, walls
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import loft, ring, rounded_rectangle
from openrooms_usd.geometry.mesh import Mesh

# Of the lower edge, and of the chimney; metres.
_RIM_M: Final = 0.05
_CHIMNEY_M: Final = (0.26, 0.24)


def _outline(width: float, front: float, back: float, z: float) -> np.ndarray:
    flat = rounded_rectangle(width, back - front, 0.004, 2)
    return ring(flat, z, (0.0, 0.5 * (front + back)))


def _filters(made: Assembly, width: float, front: float, back: float, z: float) -> None:
    """Two filters of mesh that look down, a strip of keys before them."""
    x = 0.5 * width
    for a, b in ((-x, -0.004), (0.004, x)):
        made.board("panel", (a, front, z - 0.006), (b, back, z + 0.004), 0.001)


def _buttons(made: Assembly, front: float, z: float) -> None:
    for x in np.linspace(-0.05, 0.05, 5):
        least, most = (x - 0.007, front - 0.0015, z - 0.005), (x + 0.007, front + 0.002, z + 0.005)
        made.board("button", least, most, 0.0006)


def chimney(size: Size, rng: np.random.Generator) -> Furniture:
    """A canopy below a square chimney; flat, or rising as a pyramid."""
    width, depth, height = size
    made, front, back = Assembly(), -0.5 * depth, 0.5 * depth
    wide, deep = min(_CHIMNEY_M[0], 0.6 * width), min(_CHIMNEY_M[1], 0.7 * depth)
    rise = float(rng.choice([0.04, 0.22]))
    rise = min(rise, 0.4 * height)
    low = 0.006
    rings = [
        _outline(width, front, back, low),
        _outline(width, front, back, low + _RIM_M),
        _outline(wide + 0.02, back - deep - 0.01, back, low + _RIM_M + rise),
    ]
    made.add("frame", loft(rings))
    shaft = [_outline(wide, back - deep, back, z) for z in (low + _RIM_M + rise - 0.002, height)]
    made.add("frame", loft(shaft))
    _filters(made, width - 0.08, front + 0.06, back - 0.04, low)
    _buttons(made, front, low + 0.5 * _RIM_M)
    return made.furniture()


def slim(size: Size, rng: np.random.Generator) -> Furniture:
    """A shallow box with a glass visor, to be set below a cabinet."""
    width, depth, height = size
    made, front, back = Assembly(), -0.5 * depth, 0.5 * depth
    x, low, nose = 0.5 * width, 0.006, front + 0.05
    made.board("frame", (-x, nose, low), (x, back, height), 0.003)
    made.board("panel", (-x, front, low + 0.004), (x, nose, low + 0.024), 0.003)
    _filters(made, width - 0.06, nose + 0.03, back - 0.03, low)
    _buttons(made, front, low + 0.014)
    return made.furniture()


def angled(size: Size, rng: np.random.Generator) -> Furniture:
    """A slanted sheet of black glass before a narrow shaft: head height stays free."""
    width, depth, height = size
    made, front, back = Assembly(), -0.5 * depth, 0.5 * depth
    tall = min(0.5, 0.6 * height)
    made.add("glass", _slanted(width, front, back, tall))
    wide, deep = min(_CHIMNEY_M[0], 0.6 * width), min(_CHIMNEY_M[1], 0.6 * depth)
    shaft = [_outline(wide, back - deep, back, z) for z in (tall - 0.03, height)]
    made.add("frame", loft(shaft))
    _filters(made, 0.6 * width, back - 0.16, back - 0.03, 0.006)
    return made.furniture()


def _slanted(width: float, front: float, back: float, tall: float) -> Mesh:
    """A wedge whose front leans over the hob, its lower side narrow."""
    lower, upper = back - 0.2, back
    return loft(
        [
            _outline(width, lower, upper, 0.006),
            _outline(width, lower - 0.01, upper, 0.03),
            _outline(width, front, upper, tall - 0.03),
            _outline(width, front + 0.006, upper, tall),
        ]
    )


CATEGORY: Final = BuiltCategory(
    description="an extractor hood above a stove",
    size=(0.6, 0.48, 0.9),
    min_size=(0.4, 0.22, 0.04),
    max_size=(1.5, 0.7, 2.0),
    styles={
        "chimney": Style(chimney, lambda size: size[2] > 0.4),
        "angled": Style(angled, lambda size: size[2] > 0.5, (0.8, 0.4, 0.9)),
        "slim": Style(slim, lambda size: size[2] < 0.3, (0.6, 0.36, 0.07), mass_range=(3, 12)),
    },
    size_variation=STANDARD,
    support="wall",
    mount_height=1.58,
    fixed=True,
    mass_range=(5, 35),
    words="range_hood cooker_hood extractor_hood kitchen_hood extractor exhaust_hood oven_hood",
    classes=Classes(nyu40="otherstructure", ade20k="hood"),
    schemes=(
        scheme("steel", dark_plastic="button", weight=3.0),
        scheme("black", steel="panel"),
        scheme("white", steel="panel"),
    ),
    construction=(
        row("panel", walls(1.0, STEEL), "sheet"),
        row("button", filled(1000), "common"),
        row(ANY, filled(120), "weight"),
    ),
)
