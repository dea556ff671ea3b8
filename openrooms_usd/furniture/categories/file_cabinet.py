"""File cabinets: a tall one with deep drawers, a wide lateral one, a pedestal on castors."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, STEEL, filled, row, walls
from openrooms_usd.furniture.joinery.boards import FRONT, SIDE, board, corners
from openrooms_usd.furniture.joinery.carcass import Carcass
from openrooms_usd.furniture.joinery.cells import HANDLE, SEAT, Cell, rows
from openrooms_usd.furniture.joinery.fronts import FrontDesign, drawer
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.solids import cylinder

_FRONT_M: Final = 0.02


def _case(size: Size, low: float) -> Carcass:
    """A steel case whose fronts sit between its sides."""
    width, depth, height = size
    return Carcass(width, -0.5 * depth + HANDLE, 0.5 * depth, low, height).boards()


def _file_drawer(case: Carcass, cell: Cell, look: FrontDesign, labelled: bool) -> None:
    """A drawer between the sides, with a card in a holder above its handle."""
    y = case.front + _FRONT_M
    riders: tuple[str, ...] = ()
    if labelled:
        x, z = 0.5 * (cell[0] + cell[1]), 0.5 * (cell[2] + cell[3]) + 0.055
        low, high = (x - 0.04, case.front - 0.002, z - 0.016), (x + 0.04, y - 0.01, z + 0.016)
        riders = case.made.board("label", low, high, 0.001)
    drawer(
        case.made,
        cell,
        y,
        case.back - 0.03,
        look,
        margin=0.0,
        thickness=_FRONT_M - SEAT,
        riders=riders,
    )


def _lock(case: Carcass) -> None:
    """A cylinder lock in the upper right corner of the case."""
    lock = cylinder(0.008, 0.012, bevel=0.002, segments=16)
    x, z = 0.5 * case.width - 0.045, case.high - 0.009
    case.made.add("lock", lock.transformed(FRONT).moved((x, case.front + 0.006, z)))


def upright(size: Size, rng: np.random.Generator) -> Furniture:
    """Two to five deep drawers above each other, each with a card for its content."""
    case = _case(size, 0.03)
    case.plinth(0.01)
    look = FrontDesign(str(rng.choice(["bar", "grip"])))
    count = max(1, round((size[2] - 0.05) / 0.32))
    for cell in rows(case.inside, [1.0] * count):
        _file_drawer(case, cell, look, True)
    _lock(case)
    return case.made.furniture()


def lateral(size: Size, rng: np.random.Generator) -> Furniture:
    """Wide drawers whose files stand sideways; two columns where it is very wide."""
    case = _case(size, 0.04)
    case.plinth(0.02)
    look = FrontDesign(str(rng.choice(["grip", "rod"])))
    count = max(1, round((size[2] - 0.06) / 0.34))
    bays = case.bays(max(1, round(size[0] / 1.1)))
    for bay in bays:
        for cell in rows(bay, [1.0] * count):
            _file_drawer(case, cell, look, False)
    _lock(case)
    return case.made.furniture()


def pedestal(size: Size, rng: np.random.Generator) -> Furniture:
    """A low one on castors: two shallow drawers above a deep one."""
    castor = 0.055
    case = _case(size, castor)
    look = FrontDesign(str(rng.choice(["bar", "knob", "rod"])))
    for cell in rows(case.inside, [2.0, 1.0, 1.0] if rng.uniform() < 0.7 else [1.0, 1.0, 1.0]):
        _file_drawer(case, cell, look, False)
    middle = 0.5 * (case.front + case.back)
    x, y = 0.5 * size[0] - 0.05, 0.5 * (case.back - case.front) - 0.05
    for a, b in corners(x, y):
        wheel = cylinder(0.024, 0.02, bevel=0.004, segments=20, base=(0.0, 0.0, -0.01))
        at = (a, middle + b, 0.0)
        case.made.add("wheel", wheel.transformed(SIDE).moved(at).moved((0.0, 0.0, 0.024)))
        fork = board((-0.015, -0.014, castor - 0.029), (0.015, 0.014, castor + 0.001))
        case.made.add("caster", fork.moved(at))
    return case.made.furniture()


CATEGORY: Final = BuiltCategory(
    description="steel drawers for files",
    size=(0.46, 0.6, 1.3),
    min_size=(0.3, 0.3, 0.4),
    max_size=(2.4, 0.9, 2.0),
    styles={
        "upright": Style(upright, lambda size: size[0] < 0.7 and size[2] > 0.6),
        "lateral": Style(lateral, lambda size: size[0] >= 0.7, (0.9, 0.48, 1.05)),
        "pedestal": Style(
            pedestal, lambda size: size[0] < 0.6 and size[2] <= 0.75, (0.42, 0.56, 0.58)
        ),
    },
    one_variant_per_room=True,
    mass_range=(15, 60),
    words="filing_cabinet file_cabinets",
    classes=Classes("file_cabinet", "cabinet", "cabinet"),
    synsets=("03337140",),
    schemes=(
        scheme("grey", chrome="handle", weight=2.0),
        scheme("white", chrome="handle", dark_plastic="wheel"),
        scheme("black", black="handle"),
    ),
    construction=(
        row("frame base door drawer_front drawer_box shelf", walls(0.45, STEEL), "sheet"),
        row("handle", walls(1.5), "sheet", "metal", "paint"),
        row(ANY, filled(115), "weight"),
    ),
    offers_surfaces=("cabinet_top", "drawer"),
    view_importance=0.3,
)
