"""Wardrobes: hinged doors over drawers, built in, sliding on two tracks, an open frame."""

from itertools import pairwise
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import STORAGE_ROWS
from openrooms_usd.furniture.joinery.assembly import Assembly, Side
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.carcass import SETBACK, Carcass, closed
from openrooms_usd.furniture.joinery.cells import BOARD, GAP, Cell, columns, rows
from openrooms_usd.furniture.joinery.fronts import (
    FrontDesign,
    doors,
    drawer,
    drawn_look,
    hang_door,
    leaf,
)
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.record import MADE_TO_MEASURE, BuiltCategory, Classes, JointDamping
from openrooms_usd.furniture.schemes import STORAGE, scheme
from openrooms_usd.geometry.sweeps import tube

PLINTH: Final = 0.07
# Of the panels that slide, metres.
PANEL: Final = 0.022
# Of those that are built in: how wide a door is, from which height on there are two rows of them,
# and where they divide; metres.
_LEAF_M, _TOP_DOORS_FROM_M, _TOP_DOORS_AT_M = 0.5, 2.45, 2.15


def _clothes_rail(made: Assembly, cell: Cell, y: float, drop: float = 0.06) -> None:
    """A tube to hang clothes on, below the top of an opening."""
    z = cell[3] - drop
    made.add("tube", tube([(cell[0], y, z), (cell[1], y, z)], 0.0125))


def _interior(cabinet: Carcass, bay: Cell, shelved: bool) -> None:
    """Either shelves all the way, or a clothes rail below a hat shelf."""
    if shelved:
        cabinet.shelves(bay, 0.4, SETBACK)
        return
    hat = bay[3] - 0.3
    if hat - bay[2] > 0.9:
        cabinet.shelf(bay, hat)
        bay = (bay[0], bay[1], bay[2], hat)
    _clothes_rail(cabinet.made, bay, 0.5 * (cabinet.front + cabinet.back))


def hinged(size: Size, rng: np.random.Generator) -> Furniture:
    """Pairs of tall doors; often drawers below them."""
    cabinet = closed(size, PLINTH)
    cabinet.plinth()
    left, right, low, high = cabinet.overlay
    look = drawn_look(rng, 0.6)
    count = max(1, round(size[0] / 0.95))
    chest = 0.5 if size[2] > 1.5 and rng.uniform() < 0.5 else 0.0
    upper = low + chest
    doors(cabinet.made, (left, right, upper, high), cabinet.face, look, 0.475)
    if chest:
        cabinet.shelf(cabinet.inside, upper)
    for i, column in enumerate(columns(cabinet.overlay, count)):
        a, b = column[0] + 0.5 * BOARD, column[1] - 0.5 * BOARD
        if i:
            cabinet.divider(column[0], low + BOARD, high - BOARD)
        floor = upper + 0.5 * BOARD if chest else low + BOARD
        _interior(cabinet, (a, b, floor, high - BOARD), i % 2 == 1)
        if chest:
            for cell in rows((column[0], column[1], low, upper), [1.0, 1.0]):
                drawer(cabinet.made, cell, cabinet.face, cabinet.back - 0.03, look)
    return cabinet.made.furniture()


def built_in(size: Size, rng: np.random.Generator) -> Furniture:
    """Equal doors from wall to wall, a second row of them below a high ceiling; one is a mirror."""
    cabinet = closed(size, PLINTH)
    half = 0.5 * size[0]
    cabinet.made.board(
        "kickboard", (-half, cabinet.front + 0.035, 0.0), (half, cabinet.back, PLINTH)
    )
    left, right, low, high = cabinet.overlay
    look = FrontDesign("bar", 0.06 if rng.uniform() < 0.4 else 0.0)
    split = [low, high] if high < _TOP_DOORS_FROM_M else [low, _TOP_DOORS_AT_M, high]
    count = max(1, round(size[0] / _LEAF_M))
    mirrored = int(rng.integers(2 * count))
    for j, (a, b) in enumerate(pairwise(split)):
        for i, cell in enumerate(columns((left, right, a, b), count)):
            side: Side = "left" if i % 2 == 0 else "right"
            x = cell[1] - 0.04 if side == "left" else cell[0] + 0.04
            glass: tuple[str, ...] = ()
            if i == mirrored and not j:
                front, inset = cabinet.face - BOARD, 0.075
                glass = cabinet.made.board(
                    "mirror",
                    (cell[0] + 0.005, front - 0.004, a + 0.005),
                    (
                        cell[1] - inset if side == "left" else cell[1] - 0.005,
                        front + 0.001,
                        b - 0.005,
                    ),
                    0.001,
                )
            hang_door(
                cabinet.made,
                cell,
                cabinet.face,
                side,
                look,
                handle=(x, a + 0.14 if j else 1.05),
                riders=glass,
            )
        if j:
            cabinet.shelf(cabinet.inside, a)
    top = split[1] - 0.5 * BOARD if len(split) > 2 else high - BOARD
    for i, column in enumerate(columns(cabinet.overlay, max(1, round(size[0] / (2 * _LEAF_M))))):
        if i:
            cabinet.divider(column[0], low + BOARD, high - BOARD)
        cell = (column[0] + BOARD, column[1] - BOARD, low + BOARD, top)
        _interior(cabinet, cell, i % 2 == 1)
    return cabinet.made.furniture()


def sliding(size: Size, rng: np.random.Generator) -> Furniture:
    """Two or three wide panels that slide past each other on two tracks."""
    width, depth, height = size
    front = -0.5 * depth
    cabinet = Carcass(width, front, 0.5 * depth, PLINTH, height).boards()
    cabinet.plinth()
    left, right, low, high = cabinet.inside
    count = 2 if width < 2.2 else 3
    overlap = 0.04
    reach = (right - left + (count - 1) * overlap) / count
    step = reach - overlap
    # Of three, the outer ones share a track, where the far one is in the way.
    travel = step if count == 2 else step - overlap - GAP
    mirror = int(rng.integers(count + 1))
    for i in range(count):
        # Neighbours run on different tracks, so that each can pass the next one.
        y = front + 0.012 + (PANEL + 0.008) * (1 + i % 2)
        panel = leaf(reach - GAP, high - low - GAP, PANEL, frame=0.035, recess=0.004)
        x = left + 0.5 * reach + i * step
        part = "mirror" if i == mirror else "door"
        names = cabinet.made.add(part, panel.moved((x, y, low + 0.5 * GAP)))
        inwards = 1.0 if i < count - 1 else -1.0
        cabinet.made.rail("sliding_door", names, travel, (inwards, 0.0, 0.0))
    behind = front + 0.012 + 2 * (PANEL + 0.008) + 0.01
    shelved = Carcass(width, behind, 0.5 * depth, PLINTH, height, cabinet.made)
    for i, bay in enumerate(shelved.bays(count)):
        _interior(shelved, bay, i % 2 == int(mirror % 2))
    return cabinet.made.furniture()


def open_frame(size: Size, rng: np.random.Generator) -> Furniture:
    """An open carcass: a clothes rail over drawers on one side, shelves on the other."""
    width, depth, height = size
    cabinet = Carcass(width, 0.03 - 0.5 * depth + BOARD, 0.5 * depth, PLINTH, height).boards()
    cabinet.plinth()
    look = drawn_look(rng, 0.0)
    bays = cabinet.bays(max(1, round(width / 0.8)))
    shelved = int(rng.integers(len(bays))) if len(bays) > 1 else -1
    for i, (a, b, low, high) in enumerate(bays):
        if i == shelved:
            cabinet.shelves((a, b, low, high), 0.36)
            continue
        top = low + min(0.44, 0.25 * (high - low))
        cabinet.shelf((a, b, low, high), top, 0.0)
        for cell in rows((a, b, low, top - 0.5 * BOARD), [1.0, 1.0]):
            # Fronts set between the boards: nothing but runners beside their boxes.
            drawer(
                cabinet.made,
                cell,
                cabinet.front + BOARD + 0.002,
                cabinet.back - 0.03,
                look,
                margin=0.0,
            )
        _clothes_rail(cabinet.made, (a, b, top, high), 0.5 * (cabinet.front + cabinet.back))
    lip = board(
        (-0.5 * width, -0.5 * depth, height - 0.03), (0.5 * width, cabinet.front + 0.002, height)
    )
    cabinet.made.add("frame", lip)
    return cabinet.made.furniture()


CATEGORY: Final = BuiltCategory(
    description="a tall cabinet for clothes",
    size=(1.5, 0.6, 2.1),
    min_size=(0.4, 0.35, 0.9),
    max_size=(5.0, 1.0, 3.0),
    styles={
        "hinged": Style(hinged),
        "sliding": Style(sliding, lambda size: size[0] > 1.2 and size[1] > 0.45, (1.8, 0.62, 2.15)),
        "built_in": Style(
            built_in,
            lambda size: size[0] > 1.4 and size[2] > 2.25,
            (2.4, 0.62, 2.45),
            mass_range=(100, 320),
        ),
        "open": Style(open_frame, lambda size: size[0] > 0.7),
    },
    size_variation=MADE_TO_MEASURE,
    mass_range=(70, 190),
    words="closet armoire wardrobe_closet wardrobe_cabinet",
    classes=Classes("cabinet", "otherfurniture", "wardrobe"),
    schemes=(
        *STORAGE,
        # Built in, most are painted.
        scheme("white", needs="kickboard", weight=300.0),
        scheme("kitchen_lacquer", white="shelf", needs="kickboard", weight=100.0),
        scheme("wood", needs="kickboard", weight=60.0),
    ),
    construction=STORAGE_ROWS,
    joint_damping=JointDamping(0.3, 0.2),
    offers_surfaces=("wardrobe_shelf", "drawer"),
    view_importance=0.6,
)
