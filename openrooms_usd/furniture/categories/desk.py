"""Desks: on drawers, on legs with shallow drawers, on two lifting columns, on trestles."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import STORAGE_ROWS, TABLE_ROWS
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.boards import SIDE, board, corners, square_leg
from openrooms_usd.furniture.joinery.cells import BOARD, HANDLE, SEAT, Cell, columns, rows
from openrooms_usd.furniture.joinery.fronts import FrontDesign, drawer, drawn_look
from openrooms_usd.furniture.joinery.pieces import Furniture, Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import seated
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import TABLES
from openrooms_usd.geometry.curves import filleted, rectangle
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.sweeps import extrude, tube

TOP: Final = 0.028


def _tabletop(size: Size, thickness: float = TOP, corner: float = 0.008) -> Mesh:
    width, depth, height = size
    outline = filleted(rectangle(width, depth), corner, closed=True)
    return extrude(outline, thickness, bevel=0.003, base=height - thickness)


def _pedestal(
    made: Assembly, cell: Cell, front: float, back: float, look: FrontDesign, shares: list[float]
) -> None:
    """A block of drawers: sides, bottom and back, and the drawers in it."""
    left, right, low, high = cell
    made.add(
        "frame",
        board((left, front, low), (left + BOARD, back, high)),
        board((right - BOARD, front, low), (right, back, high)),
        board((left + BOARD, front, low), (right - BOARD, back, low + BOARD)),
        board((left + BOARD, back - BOARD, low + BOARD), (right - BOARD, back, high)),
    )
    for part in rows(cell, shares):
        drawer(made, part, front - SEAT, back - BOARD - 0.002, look)


def pedestal(size: Size, rng: np.random.Generator) -> Furniture:
    """A top on one or two blocks of drawers, with a board at the back against kicks."""
    width, depth, height = size
    made, look = Assembly(), drawn_look(rng)
    made.add("tabletop", _tabletop(size))
    front, back = -0.5 * depth + 0.02 + HANDLE + BOARD, 0.5 * depth - 0.02
    block = float(np.clip(0.28 * width, 0.3, 0.45))
    half, under, low = 0.5 * width - 0.015, height - TOP, 0.04
    shares = [[2.0, 1.0], [1.1, 1.0, 0.9], [1.2, 1.1, 0.9, 0.5]][int(rng.integers(3))]
    both = width > 1.25 and bool(rng.integers(2))
    side = 1.0 if rng.integers(2) else -1.0
    for sign in (side, -side) if both else (side,):
        edges = sorted((sign * half, sign * (half - block)))
        _pedestal(made, (edges[0], edges[1], low, under), front, back, look, shares)
        made.board("base", (edges[0] + 0.015, front + 0.03, 0.0), (edges[1] - 0.015, back, low))
    if not both:
        edges = sorted((-side * half, -side * (half - 0.024)))
        made.board("leg", (edges[0], front - BOARD, 0.0), (edges[1], back, under))
    span = sorted((side * (half - block), -side * (half - (block if both else 0.024))))
    made.board("back", (span[0], back - 0.06, under - 0.38), (span[1], back - 0.042, under))
    return made.furniture()


def writing(size: Size, rng: np.random.Generator) -> Furniture:
    """Four tapered legs and a row of shallow drawers under the top."""
    width, depth, height = size
    made, look = Assembly(), drawn_look(rng, 0.0)
    made.add("tabletop", _tabletop(size, 0.024, 0.015))
    t, tall, under = 0.045, min(0.11, 0.16 * height), height - 0.024
    inset = 0.022 + HANDLE
    x, y = 0.5 * width - 0.5 * t - 0.02, 0.5 * depth - 0.5 * t
    front, back = -y + inset, y - 0.02
    leg = square_leg(t, t * float(rng.uniform(0.5, 0.75)), under)
    made.add("leg", *(leg.moved((a, front if b < 0 else back, 0.0)) for a, b in corners(x, y)))
    low = under - tall
    made.add(
        "frame",
        board((-x, back - 0.009, low), (x, back + 0.009, under)),
        *(board((s * x - 0.009, front, low), (s * x + 0.009, back, under)) for s in (-1.0, 1.0)),
        board((0.009 - x, front, low), (x - 0.009, back - 0.009, low + 0.008), 0.001),
    )
    face = front - 0.5 * t + BOARD + 0.001
    count = max(1, min(3, round((2.0 * x - t) / 0.5)))
    cells = columns((0.5 * t - x, x - 0.5 * t, low + 0.008, under), count)
    for cell in cells[1:]:
        made.board(
            "frame",
            (cell[0] - 0.006, face + 0.001, low + 0.008),
            (cell[0] + 0.006, back - 0.009, under),
        )
    for cell in cells:
        drawer(made, cell, face, back - 0.02, look, margin=0.008)
    return made.furniture()


def standing(size: Size, rng: np.random.Generator) -> Parts:
    """A plain top on two telescopic columns with long feet, and its switch."""
    width, depth, height = size
    thick = 0.025
    under = height - thick
    x = 0.5 * width - max(0.16, 0.16 * width)
    reach = 0.46 * depth
    rail = 0.035
    stages = int(rng.integers(2, 4))
    columns_, feet, bearers = [], [], []
    for s in (-1.0, 1.0):
        feet.append(_foot(reach).moved((s * x, 0.0, 0.0)))
        bearers.append(
            board(
                (s * x - 0.03, -0.42 * depth, under - 0.03),
                (s * x + 0.03, 0.42 * depth, under),
                0.003,
            )
        )
        columns_.append(_lift(0.03, under - 0.02, stages).moved((s * x, 0.0, 0.0)))
    beams = [
        board((-x, y - 0.02, under - rail), (x, y + 0.02, under - 0.004)) for y in (-0.07, 0.07)
    ]
    switch_x = float(rng.choice([-1.0, 1.0])) * (0.5 * width - 0.12)
    return {
        "tabletop": _tabletop(size, thick, 0.02),
        **numbered("leg", columns_),
        **numbered("foot_base", feet),
        **numbered("frame", [*bearers, *beams]),
        "switch": board(
            (switch_x - 0.05, -0.5 * depth + 0.004, under - 0.018),
            (switch_x + 0.05, -0.5 * depth + 0.06, under),
            0.004,
        ),
    }


def _lift(low: float, high: float, stages: int) -> Mesh:
    """Square tubes that slide in each other, the widest below."""
    share = np.linspace(0.0, 1.0, stages + 1) ** 0.9
    tubes = []
    for i in range(stages):
        half = 0.036 - 0.006 * i
        top = low + (high - low) * float(share[i + 1])
        tubes.append(board((-0.7 * half, -half, low), (0.7 * half, half, top), 0.004))
    return joined(tubes)


def _foot(reach: float) -> Mesh:
    """A flat foot that thins out towards both ends, on levellers."""
    outline = [
        (-reach, 0.008),
        (reach, 0.008),
        (reach, 0.02),
        (0.1, 0.038),
        (-0.1, 0.038),
        (-reach, 0.02),
    ]
    bar = extrude(outline, 0.075, bevel=0.004, base=-0.0375).transformed(SIDE)
    pads = [
        board((-0.02, y - 0.02, 0.0), (0.02, y + 0.02, 0.01), 0.003)
        for y in (0.03 - reach, reach - 0.03)
    ]
    return joined([bar, *pads])


def trestle(size: Size, rng: np.random.Generator) -> Parts:
    """A top laid on two trestles, with a shelf between their legs."""
    width, depth, height = size
    thick, t = 0.03, 0.03
    under = height - thick
    x = 0.5 * width - max(0.16, 0.18 * width)
    splay, y = min(0.17, 0.12 * width), 0.42 * depth
    legs, bars, shelves = [], [], []
    level = float(rng.uniform(0.3, 0.4)) * under
    at = splay * (1.0 - level / under)
    leg = square_leg(t, t, under - 0.02)
    for s in (-1.0, 1.0):
        for a, b in corners(splay, y):
            foot, head = (s * x + a, b), (s * x + 0.14 * a, 0.86 * b)
            shear = np.eye(4)
            shear[:2, 2] = (np.array(head) - foot) / (under - 0.02)
            shear[:2, 3] = foot
            legs.append(leg.transformed(shear))
        bars.append(board((s * x - 0.045, -y, under - 0.05), (s * x + 0.045, y, under), 0.004))
        shelves.append(
            board(
                (s * x - at - 0.01, 0.03 - y, level),
                (s * x + at + 0.01, y - 0.03, level + 0.016),
                0.003,
            )
        )
    return {
        "tabletop": _tabletop(size, thick, 0.006),
        **numbered("leg", legs),
        **numbered("frame", bars),
        **numbered("shelf", shelves),
    }


def framed(size: Size, rng: np.random.Generator) -> Furniture:
    """A steel frame with a raised shelf at the back and one hanging drawer."""
    width, depth, height = size
    made, look = Assembly(), drawn_look(rng, 0.0)
    thick, r = 0.024, 0.0125
    top = (width, depth, height)
    made.add("tabletop", _tabletop(top, thick, 0.006))
    under, y, x = height - thick, 0.5 * depth - r, 0.5 * width - r
    for s in (-1.0, 1.0):
        # It stands on a flat, not on an edge of the tube.
        foot = 0.93 * r
        path = [(s * x, -y, under - r), (s * x, -y, foot), (s * x, y, foot), (s * x, y, under - r)]
        rounded = filleted(path, 0.03, segments=4, closed=True)
        made.add("leg", seated(tube(rounded, r, segments=8, closed=True)))
    made.add(
        "frame",
        tube([(-x, y, 0.32 * height), (x, y, 0.32 * height)], r, segments=8),
        tube([(-x, y, under - r), (x, y, under - r)], r, segments=8),
    )
    wide = min(0.45, 0.4 * width)
    side = 1.0 if rng.integers(2) else -1.0
    edges = sorted((side * (x - r), side * (x - r - wide)))
    low, front = under - 0.13, -0.5 * depth + 0.05 + HANDLE + BOARD
    back = y - 0.06
    made.add(
        "frame",
        *(
            board(
                (e - (0.012 if e == edges[1] else 0.0), front, low),
                (e + (0.012 if e == edges[0] else 0.0), back, under),
            )
            for e in edges
        ),
        board((edges[0], front, low - 0.01), (edges[1], back, low)),
        board((edges[0] + 0.012, back - 0.012, low), (edges[1] - 0.012, back, under)),
    )
    drawer(made, (edges[0], edges[1], low, under), front - SEAT, back - 0.014, look, margin=0.012)
    return made.furniture()


def _sitting(size: Size) -> bool:
    return size[2] < 0.9


CATEGORY: Final = BuiltCategory(
    description="a table to work at",
    size=(1.4, 0.7, 0.74),
    min_size=(0.6, 0.4, 0.5),
    max_size=(2.8, 1.3, 1.35),
    styles={
        "pedestal": Style(pedestal, lambda size: size[0] > 1.0 and _sitting(size)),
        "writing": Style(writing, lambda size: _sitting(size) and size[0] > 0.7, (1.2, 0.6, 0.76)),
        "standing": Style(standing, lambda size: size[0] > 0.95),
        "trestle": Style(trestle, lambda size: size[0] > 1.1 and _sitting(size), (1.6, 0.75, 0.74)),
        "framed": Style(framed, lambda size: size[0] > 0.7 and _sitting(size), (1.2, 0.6, 0.75)),
    },
    mass_range=(14, 75),
    words="writing_desk office_desk computer_desk workbench dressing_table workstation",
    classes=Classes("desk", "desk", "desk"),
    schemes=TABLES,
    construction=(*STORAGE_ROWS, *TABLE_ROWS),
    offers_surfaces=("desk", "drawer", "shelf"),
    view_importance=3.0,
)
