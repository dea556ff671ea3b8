"""Hobs that are let into a worktop: a sheet of glass, or gas burners on steel."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, STEEL, filled, row, solid, walls
from openrooms_usd.furniture.joinery.appliance import dial
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.boards import FRONT
from openrooms_usd.furniture.joinery.cooker import gas_hob, glass_hob
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes, JointDamping
from openrooms_usd.furniture.schemes import scheme

SUNK_M: Final = 0.036
"""What hangs below the worktop, metres."""
BESIDE_M: Final = 0.016
"""How far its plate reaches over the worktop on each side of the hole, metres."""
# Thickness of the plate, and how deep a glass hob's rings are set into it, metres.
_PLATE_M: Final = 0.006
# The strip before gas burners where the knobs are, metres.
_KNOBS_M: Final = 0.075


def _body(made: Assembly, size: Size) -> None:
    x, y = 0.5 * size[0] - BESIDE_M - 0.004, 0.5 * size[1] - BESIDE_M - 0.004
    made.board("frame", (-x, -y, 0.0), (x, y, SUNK_M))


def glass(size: Size, rng: np.random.Generator) -> Furniture:
    """Black glass with printed rings."""
    width, depth, _ = size
    made, top = Assembly(), SUNK_M + _PLATE_M
    _body(made, size)
    x, y = 0.5 * width, 0.5 * depth
    made.board("cooktop", (-x, -y, SUNK_M), (x, y, top - 0.0012), 0.0015)
    glass_hob(made, width + 0.016, 0.0, depth + 0.016, top)
    return made.furniture()


def gas(size: Size, rng: np.random.Generator) -> Furniture:
    """Burners under cast grates, knobs before them."""
    width, depth, height = size
    made, level = Assembly(), SUNK_M + _PLATE_M
    _body(made, size)
    x, y = 0.5 * width, 0.5 * depth
    made.board("cooktop", (-x, -y, SUNK_M), (x, y, level))
    gas_hob(made, width, 0.5 * _KNOBS_M, depth - _KNOBS_M, height)
    up = dial(0.019, 0.022).transformed(np.linalg.inv(FRONT))
    count = 2 * max(2, round(width / 0.32))
    for a in np.linspace(-0.3, 0.3, count) * width:
        at = (float(a), -y + 0.5 * _KNOBS_M, level)
        names = made.add("knob", up.moved(at))
        made.turn("knob", names, at, (0.0, 0.0, 1.0), (0.0, 270.0))
    return made.furniture()


CATEGORY: Final = BuiltCategory(
    description="a hob let into a worktop",
    size=(0.59, 0.52, SUNK_M + _PLATE_M),
    min_size=(0.28, 0.4, 0.04),
    max_size=(1.2, 0.6, 0.2),
    styles={
        "glass": Style(glass, lambda size: size[2] < 0.06),
        "gas": Style(gas, lambda size: size[2] > 0.06, (0.6, 0.52, 0.078)),
    },
    size_variation=STANDARD,
    support="surface",
    fixed=True,
    mass_range=(6, 20),
    words="cooktop gas_hob induction_hob stovetop",
    classes=Classes("stove", "otherstructure", "stove"),
    schemes=(scheme("steel", black="frame"), scheme("screen", black="frame", steel="knob")),
    construction=(
        row("burner grate", solid(7200), "common"),
        row("glass cooktop", walls(1.0, STEEL), "sheet"),
        row("knob mark", filled(1000), "common"),
        row(ANY, filled(650), "weight"),
    ),
    joint_damping=JointDamping(0.05, 0.05),
    offers_surfaces=("hob",),
)
