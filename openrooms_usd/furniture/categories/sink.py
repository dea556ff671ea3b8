"""Sinks: on a pedestal, in a vanity, a bowl on a console, in a kitchen unit, a basin alone."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.categories import faucet
from openrooms_usd.furniture.construction import ANY, BRASS, CHINA, STEEL, row, walls
from openrooms_usd.furniture.joinery.appliance import pierced, square
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.basin import SEGMENTS, bowl, drain, sunk
from openrooms_usd.furniture.joinery.boards import corners
from openrooms_usd.furniture.joinery.carcass import Carcass
from openrooms_usd.furniture.joinery.cells import BOARD, GAP, HANDLE, SEAT, rows
from openrooms_usd.furniture.joinery.fronts import doors, drawers, drawn_look, leaf
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import DARK_TAP, TAP, scheme
from openrooms_usd.geometry.lofts import loft, ring, superellipse
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.sweeps import tube

# Thickness of the rim that lies on a worktop, metres.
RIM: Final = 0.004


def _rim(height: float, least: float, most: float) -> float:
    """Where the rim is: a faucet of ``least`` to ``most`` metres stands on it."""
    return height - float(np.clip(height - 0.8, min(least, 0.4 * height), most))


def _faucet(made: Assembly, kind: str, height: float, reach: float, back: float, z: float) -> None:
    """Stand a faucet on a rim, its back at ``back``."""
    wide = {"mixer": 0.046, "arc": 0.09, "bridge": 0.2}[kind]
    faucet.KINDS[kind](made, (wide, reach, height), (0.0, back - 0.5 * reach, z - 0.001))


def _pedestal(width: float, depth: float, height: float, y: float) -> Mesh:
    """A foot with a waist, its middle at ``y``, its upper end inside the basin."""
    profile = [
        (1.0, 0.0),
        (1.0, 0.02),
        (0.86, 0.06),
        (0.72, 0.3),
        (0.7, 0.62),
        (0.86, 0.88),
        (1.12, 1.0),
    ]
    outline = superellipse(width, depth, 2.6, SEGMENTS // 2)
    return loft([ring(outline * s, u * height, (0.0, y)) for s, u in profile], crease=60.0)


def pedestal(size: Size, rng: np.random.Generator) -> Furniture:
    """A washbasin on a ceramic foot."""
    width, depth, height = size
    made, rim = Assembly(), _rim(height, 0.09, 0.17)
    tall = min(0.2, 0.4 * rim)
    power = float(rng.choice([2.2, 3.0, 5.0]))
    basin = bowl(width, depth, tall, power=power, wall=0.03, ledge=0.09, foot=0.42)
    made.add("basin", basin.moved((0.0, 0.0, rim - tall)))
    made.add("base", _pedestal(0.22, 0.2, rim - tall + 0.03, 0.1 * depth))
    made.add("drain", drain().moved((0.0, -0.045, rim - tall + 0.019)))
    _faucet(
        made,
        str(rng.choice(["mixer", "bridge"])),
        height - rim + 0.001,
        0.13,
        0.5 * depth - 0.025,
        rim,
    )
    return made.furniture()


def vanity(size: Size, rng: np.random.Generator) -> Furniture:
    """A ceramic top with a basin in it over doors or drawers."""
    width, depth, height = size
    rim = _rim(height, 0.09, 0.17)
    front = -0.5 * depth + HANDLE + BOARD + SEAT
    unit = Carcass(width, front, 0.5 * depth, 0.09 if rng.uniform() < 0.6 else 0.28, rim - 0.02)
    unit.boards(top=False)
    if unit.low < 0.2:
        unit.plinth(0.04)
    else:
        unit.legs()
    look, deep = drawn_look(rng), min(0.13, 0.3 * (rim - unit.low))
    if rng.uniform() < 0.6:
        doors(unit.made, unit.overlay, unit.face, look)
    else:
        # A fixed front before the basin.
        fixed = max(0.14, deep + 0.03)
        lower, upper = rows(unit.overlay, [unit.high - unit.low - fixed, fixed])
        drawers(unit.made, lower, unit.face, 0.5 * depth - 0.1, look, 0.3)
        panel = leaf(width - GAP, fixed - GAP, frame=look.frame)
        unit.made.add("panel", panel.moved((0.0, unit.face, upper[2] + 0.5 * GAP)))
    top_front = front - BOARD - 0.012
    y = 0.5 * (top_front + 0.5 * depth)
    middle, wide, across = -0.03, min(width - 0.1, 0.56), depth - 0.2
    basin = sunk(
        width,
        0.5 * depth - top_front,
        0.02,
        (wide, across),
        deep,
        power=float(rng.choice([2.2, 4.0, 6.0])),
        center=(0.0, middle),
    )
    unit.made.add("basin", basin.moved((0.0, y, rim)))
    unit.made.add("drain", drain().moved((0.0, y + middle, rim - deep)))
    _faucet(unit.made, "mixer", height - rim + 0.001, 0.15, 0.5 * depth - 0.02, rim)
    return unit.made.furniture()


def vessel(size: Size, rng: np.random.Generator) -> Furniture:
    """A bowl standing on a console with steel legs and a lower shelf."""
    width, depth, height = size
    made, rim = Assembly(), _rim(height, 0.17, 0.2)
    tall, x, y, r = min(0.13, 0.25 * rim), 0.5 * width, 0.5 * depth, 0.012
    top = rim - tall
    made.board("countertop", (-x, -y, top - 0.035), (x, y, top), 0.004)
    for a, b in corners(x - 0.03, y - 0.03):
        made.add("leg", tube([(a, b, 0.0), (a, b, top - 0.03)], r))
    shelf = 0.22 * height
    made.board("shelf", (0.02 - x, 0.02 - y, shelf), (x - 0.02, y - 0.02, shelf + 0.02))
    across = min(depth - 0.13, 0.4)
    power = float(rng.choice([2.0, 5.0]))
    wide = across if power == 2.0 else min(0.55, width - 0.06)
    middle = 0.5 * across + 0.01 - y
    basin = bowl(wide, across, tall, power=power, wall=0.012, foot=0.55)
    made.add("basin", basin.moved((0.0, middle, top)))
    made.add("drain", drain().moved((0.0, middle, top + 0.019)))
    _faucet(made, "arc", height - top + 0.001, min(0.24, 0.42 * depth + 0.05), y - 0.02, top)
    return made.furniture()


def kitchen(size: Size, rng: np.random.Generator) -> Furniture:
    """One or two steel bowls in the worktop of a unit with doors."""
    width, depth, height = size
    rim = _rim(height, 0.2, 0.3)
    front = -0.5 * depth + HANDLE + BOARD + SEAT
    unit = Carcass(width, front, 0.5 * depth, 0.1, rim - 0.038).boards(top=False)
    unit.plinth(0.05)
    doors(unit.made, unit.overlay, unit.face, drawn_look(rng), 0.6)
    edge = unit.face - BOARD - 0.015
    y, deep = 0.5 * (edge + 0.5 * depth), min(0.17, 0.3 * rim)
    count = 2 if width > 0.95 and rng.uniform() < 0.6 else 1
    wide, across = min(width - 0.1, 0.42 * count + 0.02), depth - 0.2
    hole = square(wide - 0.012, across - 0.012)
    slab = square(width, 0.5 * depth - edge) + np.array([0.0, 0.01])
    plate = pierced(slab, hole, -0.038, 0.0)
    unit.made.add("countertop", plate.moved((0.0, y - 0.01, rim - 0.002)))
    each = wide / count
    for i in range(count):
        x = (i - 0.5 * (count - 1)) * each
        steel = sunk(
            each,
            across,
            0.002,
            (each - 0.05, across - 0.11),
            deep,
            power=7.0,
            center=(0.0, -0.03),
            wall=0.003,
        )
        unit.made.add("bowl", steel.moved((x, y - 0.01, rim)))
        unit.made.add("drain", drain(0.04).moved((x, y - 0.04, rim - deep)))
    back = y - 0.01 + 0.5 * across - 0.008
    _faucet(unit.made, str(rng.choice(["arc", "bridge"])), height - rim + 0.001, 0.2, back, rim)
    return unit.made.furniture()


def alone(size: Size, rng: np.random.Generator) -> Furniture:
    """A basin without anything below it, to hang on a wall or stand on a top."""
    width, depth, height = size
    made, rim = Assembly(), _rim(height, 0.09, 0.14)
    power = float(rng.choice([2.2, 4.0, 6.0]))
    ledge = min(0.09, 0.22 * depth)
    made.add("basin", bowl(width, depth, rim, power=power, wall=0.018, ledge=ledge, foot=0.5))
    made.add("drain", drain().moved((0.0, -0.5 * ledge, 0.019)))
    _faucet(made, "mixer", height - rim + 0.001, min(0.13, 0.35 * depth), 0.5 * depth - 0.02, rim)
    return made.furniture()


def inset_rim(height: float) -> float:
    """Height of the rim of a sink that is let into a worktop, where it is so high with its tap."""
    return 0.39 * height


def inset(size: Size, rng: np.random.Generator) -> Furniture:
    """One or two steel bowls with a flat rim, to be let into a worktop, and their faucet."""
    width, depth, height = size
    made, rim = Assembly(), inset_rim(height)
    count = 2 if width > 0.75 and rng.uniform() < 0.7 else 1
    each, wall = width / count, 0.003
    for i in range(count):
        x = (i - 0.5 * (count - 1)) * each
        steel = sunk(
            each,
            depth,
            RIM,
            (each - 0.07, depth - 0.13),
            rim - wall,
            power=7.0,
            center=(0.0, -0.025),
            wall=wall,
        )
        made.add("bowl", steel.moved((x, 0.0, rim)))
        made.add("drain", drain(0.04).moved((x, -0.025, wall)))
    _faucet(
        made,
        str(rng.choice(["arc", "arc", "bridge"])),
        height - rim + 0.001,
        0.19,
        0.5 * depth - 0.012,
        rim,
    )
    return made.furniture()


CATEGORY: Final = BuiltCategory(
    description="a washbasin or a kitchen sink with its faucet",
    size=(0.6, 0.48, 1.0),
    min_size=(0.3, 0.28, 0.16),
    max_size=(2.0, 0.8, 1.4),
    styles={
        "pedestal": Style(pedestal, lambda size: size[0] < 0.8 and size[2] > 0.6),
        "vanity": Style(vanity, lambda size: size[0] > 0.5 and size[2] > 0.6, (0.8, 0.5, 1.02)),
        "vessel": Style(vessel, lambda size: size[0] > 0.5 and size[2] > 0.6, (0.9, 0.5, 1.0)),
        "kitchen": Style(
            kitchen,
            lambda size: size[0] > 0.55 and size[1] > 0.52 and size[2] > 0.7,
            (1.0, 0.64, 1.2),
        ),
        "inset": Style(inset, lambda size: size[0] > 0.4 and 0.4 < size[2] < 0.6, (0.8, 0.5, 0.47)),
        "alone": Style(alone, lambda size: size[2] <= 0.6, (0.55, 0.45, 0.28)),
    },
    size_variation=STANDARD,
    alternative_supports=("wall",),
    fixed=True,
    words="washbasin wash_basin bathroom_sink kitchen_sink basin washstand",
    classes=Classes(nyu40="sink", ade20k="sink", coco="sink"),
    schemes=(
        scheme("sanitary", TAP),
        scheme("wood", TAP, sanitary="basin", needs="frame", weight=100.0),
        scheme("white", DARK_TAP, sanitary="basin", needs="frame", weight=100.0),
        scheme("wood", DARK_TAP, metal="leg", sanitary="basin", needs="countertop", weight=100.0),
        scheme(
            "white",
            TAP,
            steel="bowl",
            stone="countertop",
            black="base",
            needs="bowl",
            weight=50000.0,
        ),
        scheme(
            "white",
            TAP,
            steel="bowl",
            wood="countertop",
            black="base",
            needs="bowl",
            weight=10000.0,
        ),
    ),
    construction=(
        row(ANY, walls(10, CHINA), "china", "specular_stone"),
        row("bowl", walls(0.5, STEEL), "sheet"),
        row("body spout switch", walls(3, BRASS), "common"),
    ),
    offers_surfaces=("sink_edge", "low_shelf", "cupboard", "drawer"),
    view_importance=2.5,
)
